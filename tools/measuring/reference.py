# SPDX-License-Identifier: Apache-2.0
"""Published numbers of the thesis beside ours, into docs/reference.md.

Measures nothing: ours are those that the other sub-commands left in bench/results, and constants of the code. Run it
after any of them. What no result holds is said to be not measured.
"""

import re
import sys
import tomllib

from measuring import nlo, virtual_ring
from measuring.common import ROOT, fixed, header, percent, read_results, row, write_between
from measuring.learning import reference_38

PAGE = ROOT / "docs/reference.md"
NOT_MEASURED = "not measured"
SITES = list(nlo.SITES)
BY_SITE = "village / circuit / junction / ring / Kvarnbyn / Pardubice"
DRAWN = {"kvarnbyn": "drawn", "pardubice": "drawn"}  # truth of the real towns; elsewhere labels of the network
METHODS = {  # of table 3.6: key of heights.json, published E_RG, E_h to the terrain, to the corrected terrain
    "bilinear": {
        "none": ("none", "36.208; 0.000; 0.120"),
        "moving average 11": ("ma11", "28.371; 0.009; 0.088"),
        "moving average 35": ("ma35", "23.765; 0.089; 0.047"),
        "moving average 67": ("ma67", "23.322; 0.203; 0.109"),
        "NLO": ("reference", "22.447; 0.121; 0.001"),
    },
    "cubic": {
        "none": ("none", "39.542; 0.000; 0.136"),
        "moving average 11": ("ma11", "29.641; 0.012; 0.096"),
        "moving average 35": ("ma35", "23.798; 0.112; 0.051"),
        "moving average 67": ("ma67", "23.289; 0.229; 0.113"),
        "NLO": ("reference", "22.814; 0.093; 0.028"),
    },
}
TRAINING = {  # of table 2.1: seconds an image in training, best iteration
    "googlenet-32s": ("0.476", "100000"),
    "googlenet-16s": ("0.335", "50000"),
    "googlenet-8s": ("0.319", "69000"),
    "vgg16-32s": ("1.483", "30000"),
    "vgg16-16s": ("1.484", "30000"),
    "vgg16-8s": ("1.483", "50000"),
}


def add_arguments(parser):
    del parser  # there is nothing to choose


def table(ours, rows):
    """`rows`: number, published, ours or None."""
    return header(["number", "published", f"ours: {ours}"]) + "".join(
        row([number, published, NOT_MEASURED if value is None else value]) for number, published, value in rows
    )


def in_code(file, pattern):
    """Groups of the one place of a constant in the code."""
    found = re.findall(pattern, (ROOT / file).read_text())
    if len(found) != 1:
        sys.exit(f"{file}: {len(found)} places of {pattern}, 1 is needed; mend tools/measuring/reference.py")
    return found[0]


def by_site(value, digits):
    """Of every site, a dash where there is none; None where there is none at all."""
    values = [value(site) for site in SITES]
    return None if all(v is None for v in values) else " / ".join(fixed(v, digits) for v in values)


def part(value, *keys):
    """value[key][key] ..., None where one lacks."""
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def times(factor, value):
    return None if value is None else factor * value


# ---- chapter 2


def classes():
    names = [c["name"] for c in tomllib.loads((ROOT / "models/classes/reference-38.toml").read_text())["class"]]
    sites = [f"{preset}-{seed}" for preset, seeds in reference_38.SEEDS.items() for seed in seeds]
    held_out = [site for site in sites if site in reference_38.HELD_OUT]
    return table(
        "`models/classes/reference-38.toml`, `tools/measuring/learning/reference_38.py`",
        [
            ("classes of pixels", "38", len(names)),
            (
                "painted images of 1024 x 1024 px for training and validation",
                "16",
                f"{len(sites) - len(held_out)} synthetic sites for training, {len(held_out)} others held out",
            ),
            ("tiles of 256 x 256 px in training, in validation, with mirrored and turned ones", "1536; 512", None),
            ("share of grassland, of tree, of pool in training, %", "26.35; 14.75; 0.02", None),
        ],
    )


def stages():
    results, rows = read_results(reference_38.STORE, {}), []
    for network, (accuracy, seconds, _) in reference_38.PUBLISHED.items():
        found = [results.get(f"{network}, none, {site}") for site in reference_38.HELD_OUT]
        ours = None
        if any(found):
            ours = " / ".join(percent(part(r, "accuracy"), 2) for r in found)
            ours += f"; {fixed(part(found[0], 'seconds_a_tile'), 3)}; {NOT_MEASURED}"
        rows.append((network, f"{accuracy}; {seconds}; {'; '.join(TRAINING[network])}", ours))
    return (
        "Accuracy %; seconds a tile of 256 x 256 px predicted, trained; best iteration (table 2.1). Ours: circuit / "
        "village, both held out.\n\n" + table("38 classes, [notes](notes/reference_38.md)", rows)
    )


def solver():
    rate, momentum, decay = (
        in_code("lab/orthodrive/train/train_options.cpp", rf"\.{name} = ([-.\de]+),")
        for name in ("learning_rate", "momentum", "weight_decay")
    )
    ours = f"{rate}; {momentum}; {float(decay):.4f}"
    return table("`reference_train_options`", [("learning rate; momentum; weight decay", "1e-10; 0.99; 0.0005", ours)])


def at_held_out(network, crf, *keys):
    results = read_results(reference_38.STORE, {})
    found = [part(results.get(f"{network}, {crf}, {site}"), *keys) for site in reference_38.HELD_OUT]
    return None if all(v is None for v in found) else found


def merged(network):
    results = read_results(reference_38.STORE, {})
    found = [results.get(f"{network}, thesis, {site}") for site in reference_38.HELD_OUT]
    return None if not any(found) else ["; ".join(percent(v, 2) for v in r["merged"]) if r else "-" for r in found]


def shown(values, digits=2):
    return None if values is None else " / ".join(v if isinstance(v, str) else percent(v, digits) for v in values)


def good_classes(network):
    found = at_held_out(network, "none", "iou")
    if found is None:
        return None
    values = [[v for v in site.values() if v is not None] if site else [] for site in found]
    return " / ".join(f"{sum(v >= 0.75 for v in of_site)} of {len(of_site)}" if of_site else "-" for of_site in values)


def millions(trunk):
    """Weights, as the page of the stage says them; tests/nets counts them."""
    return float(in_code("docs/segment.md", rf"`{trunk}-32s`.* \| (\d+) million \|"))


def means():
    shipped = part(read_results("segmentation.json", {}), "default", "trained", "handmade")
    rows = [
        ("GoogLeNet-8s: mean IoU %", "61.20", shown(at_held_out("googlenet-8s", "none", "mean_iou"))),
        ("VGG16-8s: mean IoU %", "64.66", shown(at_held_out("vgg16-8s", "none", "mean_iou"))),
        ("VGG16-8s + CRF: mean IoU %", "67.71", shown(at_held_out("vgg16-8s", "thesis", "mean_iou"))),
        (
            "VGG16-8s + CRF, 38 classes merged to 32: accuracy %; mean IoU %",
            "92.16; 73.60",
            shown(merged("vgg16-8s")),
        ),
        ("GoogLeNet-8s: classes with an IoU of 75 % and more", "about half of 38", good_classes("googlenet-8s")),
        ("VGG16-8s: classes with an IoU of 75 % and more", "about half of 38", good_classes("vgg16-8s")),
        (
            "weights of GoogLeNet-8s, of those of VGG16-8s",
            "about 5%",
            f"{fixed(100 * millions('googlenet') / millions('vgg16'), 1)} % (both for 8 classes)",
        ),
        ("GoogLeNet-8s: sheds taken for houses, houses for sheds, %", "20.29; 21.60", None),
        (
            "real photos painted by hand, 8 classes ([notes](notes/networks.md)): accuracy %; mean IoU %",
            "90.51; 67.71",
            f"{percent(shipped['pixel_accuracy'], 2)}; {percent(shipped['mean_iou'], 2)}" if shipped else None,
        ),
    ]
    return table("38 classes, circuit / village held out, [notes](notes/reference_38.md)", rows)


def crf_sets():
    rows = [("no CRF: accuracy %", "89.41", shown(at_held_out("vgg16-8s", "none", "accuracy")))]
    for name, (values, accuracy) in {
        "kraehenbuehl": ("10.0, 80.00, 13.00, 3.00, 3.00", "88.73"),
        "zheng": ("5.00, 160.00, 3.00, 3.00, 3.00", "90.51"),
        "thesis": ("5.20, 13.50, 11.00, 1.50, 1.75", "90.51"),
    }.items():
        in_model = in_code("src/orthodrive/crf/crf_model.hpp", rf'CrfSet{{"{name}", ([^}}]+)}}').replace("F", "")
        found = shown(at_held_out("vgg16-8s", name, "accuracy")) or NOT_MEASURED
        rows.append(
            (f"{name}: w1, alpha, beta, w2, gamma; accuracy %", f"{values}; {accuracy}", f"{in_model}; {found}")
        )
    return table("VGG16-8s, circuit / village held out, [notes](notes/reference_38.md)", rows)


def mean_field():
    bench = part(read_results("dense_crf.json", {}), "bench", "dense_crf/two_windows/classes:38/widths:0/real_time")
    tiles = 2 * 1024**2 / 256**2
    ten = f"{fixed(bench['real_time'] / 1000 / tiles, 3)} (the CRF alone)" if bench else None
    return table(
        "[dense_crf](measured/dense_crf.md)",
        [
            ("VGG16-8s + CRF, 10 iterations: seconds a tile of 256 x 256 px", "2.169", ten),
            ("VGG16-8s + CRF, 5 iterations: seconds a tile", "1.215", None),
            ("VGG16-8s + CRF, 5 iterations: seconds a tile in training", "2.943", None),
            ("VGG16-8s + CRF: accuracy %, 5 and 10 iterations", "90.4967; 90.5078", None),
            ("VGG16-8s: mean IoU % without water", "66.41", None),
        ],
    )


# ---- chapter 3


def refined(site, method, *keys):
    rows = read_results("refinement.json", {"rows": {}})["rows"]
    return part(rows, f"{site} {DRAWN.get(site, 'predicted')} {method}", *keys)


def inference():
    def iou(method):
        return by_site(lambda site: times(100, refined(site, method, "surface_iou")), 2)

    truth_km = by_site(lambda site: times(0.001, refined(site, "none", "truth_length_m")), 1)
    angle = in_code("lab/orthodrive/baselines/mrf_roads.hpp", r"no_overlap_angle_deg = ([.\d]+);")
    return table(
        f"{BY_SITE}, [refine](measured/refine.md)",
        [
            ("compared: km2 at 0.13 m a pixel; here km of road", "0.28", truth_km),
            ("roads within so many degrees must not overlap", "20", f"{angle} (`baselines/mrf_roads`)"),
            ("Canny, Douglas-Peucker: IoU %", "76.7887", iou("mrf-dp")),
            ("Canny, smooth roads: IoU %", "77.2340", iou("mrf-smooth")),
            ("edges of Dollár and Zitnick: Douglas-Peucker, smooth: IoU %", "76.5161; 76.8237", "left out: licence"),
            (
                "centre lines of OSM, mean offset, m",
                "0.847",
                by_site(lambda site: refined(site, "none", "offset_m", "mean_abs"), 3),
            ),
        ],
    )


def table_3_4():
    runs = read_results(nlo.STORE, {"runs": {}})["runs"]

    def run(name, key, factor, digits):
        return by_site(lambda site: times(factor, part(runs, f"{site}, {name}", key)), digits)

    rows = []
    for name, (_, iou, variance) in nlo.ROWS.items():
        rows.append((f"{name}: IoU %", iou, run(name, "surface_iou", 100, 2)))
        if variance != "-":
            rows.append((f"{name}: variance of the width, m2", variance, run(name, "width_variance_m2", 1, 3)))
    best = max(iou for _, iou, _ in nlo.ROWS.values())
    rows += [
        ("our default, the thesis' best beside it: IoU %", best, run("default", "surface_iou", 100, 2)),
        ("our default: variance of the width, m2", "0.179", run("default", "width_variance_m2", 1, 3)),
    ]
    return table(f"{BY_SITE}, [nlo](measured/nlo.md)", rows)


def weights():
    file, number = "lab/orthodrive/baselines/nlo_roads.hpp", r"([-.\d]+)"
    sets = [in_code(file, rf"nlo_set_{i}{{([^}}]+), \d+}}") for i in (1, 2)]
    costs = {
        c["name"]: f"{100 * c['cost_false_positive']:.1f}, {100 * c['cost_false_negative']:.1f}"
        for c in tomllib.loads((ROOT / "models/classes/reference-38.toml").read_text())["class"]
    }
    groups = {
        "cartway, road, racetrack, pitlane": (["cartway", "highway", "track", "pitlane"], "100.0, 0.0"),
        "apron": (["apron"], "0.0, 0.0"),
        "paved, parking": (["paved", "parking"], "0.0, 20.0"),
        "buildings, vegetation, other": (["detached", "tree", "field"], "0.0, 100.0"),
    }
    rows = [
        (f"cost of {name}: false positive, negative, %", published, " or ".join(sorted({costs[m] for m in members})))
        for name, (members, published) in groups.items()
    ]
    return table(
        "`models/classes/reference-38.toml`, `baselines/nlo_roads`",
        [
            *rows,
            ("width of a strip, m", "1.25", in_code(file, rf"strip_m = {number};")),
            ("distance of nodes, m", "2", in_code(file, rf"spacing_m = {number};")),
            ("set 1: w_c, w_a, w_w, w_o", "10.0, 1.0, 0.2, 0.2", sets[0]),
            ("set 2: w_c, w_a, w_w, w_o", "10.0, 20.0, 10.0, 0.0", sets[1]),
        ],
    )


def run_time():
    cases = part(read_results("refinement.json", {}), "speed", "cases") or []
    case = min(cases, key=lambda c: abs(c["nodes"] - 17714), default=None)
    ours = f"{case['nodes']} nodes, 400 Mpx: {fixed(case['seconds'], 1)} s, the default" if case else None

    def ratio(site):
        mrf, both = (refined(site, method, "seconds") for method in ("mrf-smooth", "nlo-1+2"))
        return None if mrf is None or both is None else mrf / both

    return table(
        f"[refine](measured/refine.md); ratios: {BY_SITE}",
        [
            ("time over 7.81 km2", "17714 nodes, 400 Mpx: 37 minutes", ours),
            ("time of the MRF, of that of the NLO", "less than 1/3", by_site(ratio, 1)),
            ("gain of speed by atan2 in eq. 3.8", "more than 25%", None),
        ],
    )


def height_weights():
    file = "lab/orthodrive/baselines/reference_heights.cpp"
    values = in_code(file, r"weight_gradient = ([.\d]+), weight_gradient_change = ([.\d]+), weight_height = ([.\d]+);")
    loss_m = in_code(file.replace(".cpp", ".hpp"), r"loss_m = ([.\d]+);")
    return table(
        "`baselines/reference_heights`",
        [("w_g, w_v, w_e; scale of the Cauchy loss", "1.2, 12.0, 0.2; 0.5", f"{', '.join(values)}; {loss_m}")],
    )


def table_3_6():
    rows, kept = [], read_results("heights.json", {}).get("dent", {})

    def ours(sampling, method):
        one = part(kept, method, sampling)
        return "; ".join([fixed(one[0], 2), fixed(one[1], 3), fixed(one[2], 3)]) if one else None

    for sampling, methods in METHODS.items():
        for name, (method, published) in methods.items():
            rows.append((f"{sampling}, {name}", published, ours(sampling, method)))
        rows.append((f"{sampling}, our default, the NLO beside it", methods["NLO"][1], ours(sampling, "default")))
    return "E_RG 1e-4; E_h to the terrain, to the corrected one, m2.\n\n" + table(
        "Red Bull Ring, 10 m terrain with one error, [elevate](measured/elevate.md)", rows
    )


# ---- chapters 1, 4, 5


def real_time():
    nanoseconds = part(read_results("roadquery.json", {}), "sites", "ring", "speed", "route_all_ns_least")
    ours = f"{fixed(1e9 / nanoseconds / 1e6, 1)} million ({fixed(nanoseconds, 1)} ns each)" if nanoseconds else None
    return table(
        "Red Bull Ring, [roadquery](measured/roadquery.md)",
        [("evaluations of the road a second and tyre, at least", "1000", ours)],
    )


def meshes():
    options, address = (f"src/orthodrive/scene/plan/{name}.hpp" for name in ("scene_input", "tile_address"))
    sizes = [
        ("side of a tile, m", "480", address, r"scene_tile_m = ([\d.]+);"),
        ("side of its texture, px", "2048", options, r"max_texture_px = (\d+);"),
        ("raster of the terrain, m", "10", options, r"terrain_step_m = ([\d.]+);"),
    ]
    return table("`scene/plan`", [(name, value, in_code(file, pattern)) for name, value, file, pattern in sizes])


def scene_times():
    parts, rows = read_results("scene_parts.json", {}), []

    def seconds(of_textures):
        found = []
        for site in ("village", "Pardubice"):
            one = parts.get(site)
            if one:
                spent = [s for name, s in one["processor_s"].items() if name.startswith("textures") == of_textures]
                found.append(fixed(sum(spent) / one["ground_km2"], 2))
        return " / ".join(found) or None

    rows = [
        ("projection of the textures, s/km2", "up to 40", seconds(True)),
        ("all else of the mesh generation, s/km2", "less than 20", seconds(False)),
    ]
    return table("processor time of village / Pardubice, [scene](measured/scene.md)", rows)


def example():
    crop, label = (
        in_code("lab/orthodrive/train/train_options.cpp", rf"\.{name}_px = (\d+),") for name in ("crop", "label")
    )
    margin = f"{(int(crop) - int(label)) // 2} in training; else the receptive field"
    rows = [("margin of a tile, px of its neighbours", "97", margin), *virtual_ring.published_rows()]
    return table("[virtual ring](measured/virtual_ring.md)", rows)


def large():
    one = read_results("scaling.json", {}).get("100")
    ours = f"{fixed(one['plan']['area_km2'], 0)} km2, built in {fixed(one['seconds'], 0)} s" if one else None
    return table(
        "[scaling](measured/scaling.md)", [("a landscape that can be shown", "hundreds of square kilometers", ours)]
    )


TABLES = {
    "real time": real_time,
    "classes": classes,
    "table 2.1": stages,
    "solver": solver,
    "table C.1": means,
    "table 2.2": crf_sets,
    "table 2.3": mean_field,
    "table 3.1": inference,
    "tables 3.2, 3.3": weights,
    "table 3.4": table_3_4,
    "run time": run_time,
    "table 3.5": height_weights,
    "table 3.6": table_3_6,
    "tiles": meshes,
    "seconds": scene_times,
    "example": example,
    "large": large,
}


def run(args):
    del args
    for name, make in TABLES.items():
        write_between(PAGE, name, make())
