# SPDX-License-Identifier: Apache-2.0
"""Road refinement: all methods on synthetic and real sites. Writes docs/measured/refine.md.

With both MRF polygons and three NLO weight sets it takes three quarters of an hour on two cores; the default alone
three minutes. What is not measured in this run keeps its last values from bench/results/refinement.json.
"""

import json
import math
import os
import re

from measuring.common import (
    DATA,
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    percent,
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)
from measuring.learning import forests

STORE, PAGE = "refinement.json", PAGES / "refine.md"
TRACK = DATA / "spielberg"
SYNTHETIC = {
    "village": ["--preset", "village", "--seed", "99"],
    "circuit": ["--preset", "circuit"],
    "junction": ["--preset", "junction"],
    "ring": [
        "--from-track",
        TRACK / "spielberg_utm33.csv",
        "--track-osm",
        TRACK / "osm_way_red_bull_ring.osm",
        "--track-heights",
        TRACK / "elevation_zaggyai.csv",
    ],
}
PHOTOS = {"kvarnbyn": DATA / "kvarnbyn/ortho.jpg", "pardubice": DATA / "pardubice/ortho.tif"}
METHODS = {
    "none": "raw OSM",
    "mrf-dp": "MRF, Douglas-Peucker",
    "mrf-smooth": "MRF, smooth",
    "nlo-1": "NLO set 1",
    "nlo-2": "NLO set 2",
    "nlo-1+2": "NLO set 1+2",
    "default": "**default**",
}
CLASSES = ["ground", "road", "parking", "building", "vegetation", "grass", "water", "rail"]


def add_arguments(parser):
    add_tool(parser, "out/refinement")
    add_only(parser, [*SYNTHETIC, *PHOTOS, "speed"])
    add_table(parser)
    parser.add_argument(
        "--methods",
        type=lambda text: text.split(","),
        default=list(METHODS),
        metavar="NAME,...",
        help=f"of {','.join(METHODS)}",
    )


def disturb(source, target):
    """OSM moved by a smooth field of 1 to 4 m whose direction turns once in 1.7 km."""
    text = source.read_text()
    nodes = [(float(lat), float(lon)) for lat, lon in re.findall(r'<node [^>]*lat="([-\d.]+)" lon="([-\d.]+)"', text)]
    lat0, lon0 = (sum(n[k] for n in nodes) / len(nodes) for k in (0, 1))
    north, east = 111320, 111320 * math.cos(math.radians(lat0))

    def moved(match):
        lat, lon = map(float, match.groups())
        x, y = (lon - lon0) * east, (lat - lat0) * north
        size, direction = (
            2.5 + 1.5 * math.sin(x / 230 + y / 310 + 1),
            2 * math.pi * (x / 1700 + 0.3 * math.sin(y / 500)),
        )
        return (
            f'lat="{lat + size * math.sin(direction) / north:.8f}" lon="{lon + size * math.cos(direction) / east:.8f}"'
        )

    target.write_text(re.sub(r'lat="([-\d.]+)" lon="([-\d.]+)"', moved, text))


def segment(tool, photo, folder):
    labels, probability = folder / "labels.tif", folder / "road_probability.tif"
    if not probability.exists():
        tool("segment", photo, "-o", labels, "--road-probability", probability)
    return {"labels": labels, "probability": probability}


def paint(name, site, given):
    """The network's labels with the hand-made test pieces of models/truth as their painters see them: what a network
    without errors would leave to do.
    """
    labels, probability, polygons = (
        site / "painted_labels.tif",
        site / "painted_road_probability.tif",
        site / "painted.gpkg",
    )
    if labels.exists() and probability.exists():
        return {"labels": labels, "probability": probability}
    crs = json.loads(run_program("gdalinfo", "-json", given["labels"]))["coordinateSystem"]["wkt"]
    polygons.unlink(missing_ok=True)
    run_program(
        "ogr2ogr",
        polygons,
        ROOT / "models/truth/handmade.geojson",
        "-nln",
        "pieces",
        "-t_srs",
        crs,
        "-where",
        f"piece LIKE '{name[0]}%'",
    )

    def draw(source, target, value):  # in the order of the file
        run_program("gdal_translate", "-q", source, target)
        run_program(
            "gdal_rasterize",
            "-q",
            "-dialect",
            "sqlite",
            "-sql",
            f"SELECT {value} AS v, geom FROM pieces WHERE class <> 'unknown' ORDER BY fid",
            "-a",
            "v",
            polygons,
            target,
        )

    draw(
        given["labels"],
        labels,
        "CASE class " + " ".join(f"WHEN '{c}' THEN {i}" for i, c in enumerate(CLASSES)) + " END",
    )
    draw(given["probability"], probability, "CASE class WHEN 'road' THEN 255 ELSE 0 END")
    return {"labels": labels, "probability": probability}


def drawn_truth(name, folder):
    """The drawn carriageways of a town, where they were drawn, and what the map lacks there: GeoJSON files by part."""
    drawn = {}
    for part in ("", "_area", "_unmapped"):
        features = json.loads((ROOT / f"models/truth/carriageways{part}.geojson").read_text())["features"]

        def of(p):
            return next(p[k] for k in ("piece", "id", "of") if p.get(k) is not None)

        drawn[part] = folder / f"carriageways{part}.geojson"
        drawn[part].write_text(
            json.dumps(
                {
                    "type": "FeatureCollection",
                    "features": [f for f in features if of(f["properties"]).startswith(name[0])],
                },
                ensure_ascii=False,
            )
        )
    return drawn


class Sites:
    """What is refined and what it is compared with, made where it is not there yet."""

    def __init__(self, args):
        self.tool, self.out, self.made = Tool(args.tool), args.out, {}

    def of(self, name):
        """Photo, osm, labels and probability of the network; the truth; options of `evaluate roads`."""
        if name not in self.made:
            self.made[name] = self.synthetic(name) if name in SYNTHETIC else self.town(name)
        return self.made[name]

    def synthetic(self, name):
        site = self.tool.synth(self.out / name, *SYNTHETIC[name], "--gsd", "0.2")
        given = {"photo": site / "ortho.tif", "osm": site / "roads.osm"}
        return {**given, **segment(self.tool, given["photo"], site)}, site / "truth", []

    def town(self, name):
        site = self.out / name
        site.mkdir(parents=True, exist_ok=True)
        drawn = drawn_truth(name, site)
        given = {"photo": PHOTOS[name], **segment(self.tool, PHOTOS[name], site), "osm": DATA / name / "roads.osm"}
        return given, drawn[""], ["--area", drawn["_area"], "--ignore", drawn["_unmapped"]]


class Measuring:
    """Runs methods and scores them, keeping each result as it comes."""

    def __init__(self, args):
        self.sites, self.tool, self.out, self.commit = Sites(args), Tool(args.tool), args.out, commit()
        self.numbers = read_results(STORE, {"rows": {}})

    def measure(self, name, method, given, truth, *more):
        """`given`: photo, osm, labels, probability (of the default, where there is one)."""
        folder = self.out / "roads"
        folder.mkdir(parents=True, exist_ok=True)

        def file(m):
            return folder / f"{name}.{m}.gpkg"

        forest = ROOT / f"out/forests/forests_{'real' if name.split(' ')[0] in PHOTOS else 'villages'}.yml"
        if method.startswith("mrf") and not forest.exists():
            forests.learn(self.tool, ROOT / "out/forests", ["villages", "real"])
        mrf = ["--method", "mrf", "--photo", given["photo"], "--forests", forest, "--polygons"]
        options = {
            "none": ["--method", "none"],
            "mrf-dp": [*mrf, "dp"],
            "mrf-smooth": [*mrf, "smooth"],
            **{f"nlo-{w}": ["--method", "nlo", "--weights", w] for w in ("1", "2", "1+2")},
            "default": ["--road-probability", given["probability"]] if given.get("probability") else [],
        }

        def labels(m):
            return [] if m.startswith("mrf") else ["--labels", given["labels"]]

        def refine(m):
            return self.tool.timed("refine", "--osm", given["osm"], *labels(m), "-o", file(m), *options[m])

        if not file("none").exists():
            refine("none")
        seconds = refine(method)
        scores = self.tool.json("evaluate", "roads", file(method), truth, "--before", file("none"), *more, "--json")
        self.numbers["rows"][f"{name} {method}"] = {
            "name": name,
            "method": method,
            "seconds": round(seconds, 3),
            "commit": self.commit,
            "cores": os.cpu_count(),
            **scores,
        }
        write_results(STORE, self.numbers)
        away = (scores.get("moved_away") or {}).get("share_by_more_than_0_3_m")
        print(
            f"{name} {method}: IoU {fixed(scores['surface_iou'], 3)} offset "
            f"{fixed(scores['offset_m']['mean_abs'], 3)} / {fixed(scores['offset_m']['p95'], 3)}"
            f" width {fixed(scores['width_m']['mean_abs'], 3)} sigma {fixed(scores['sigma_coverage']['1'], 3)} away "
            f"{fixed(away, 3)} {seconds:.1f} s",
            flush=True,
        )

    def synthetic(self, name, methods):
        given, truth, _ = self.sites.of(name)
        for method in methods:
            if not method.startswith("mrf"):  # it reads the photo
                true_labels = {"photo": given["photo"], "osm": given["osm"], "labels": truth / "labels.tif"}
                self.measure(f"{name} true", method, true_labels, truth)
            self.measure(f"{name} predicted", method, given, truth)

    def town(self, name, methods):
        given, truth, region = self.sites.of(name)
        site = self.out / name
        moved = site / "disturbed.osm"
        disturb(given["osm"], moved)
        for method in methods:
            self.measure(f"{name} drawn", method, given, truth, *region)
            if method == "default":
                self.measure(f"{name} painted", method, {**given, **paint(name, site, given)}, truth, *region)
            self.measure(
                f"{name} disturbed", method, {**given, "osm": moved}, self.out / "roads" / f"{name} drawn.none.gpkg"
            )

    def speed(self):
        lines = run_program(self.tool.file.parent / "bench/speed/bench_refine").strip().split("\n")[1:]
        cases = [[float(v) for v in re.findall(r"[\d.]+", line)] for line in lines]
        self.numbers["speed"] = {
            "commit": self.commit,
            "cores": os.cpu_count(),
            "cases": [{"nodes": int(c[0]), "km": c[1], "seconds": c[2], "gb": c[4]} for c in cases],
        }
        write_results(STORE, self.numbers)


# ---- the page


def table(rows, name, known=False):
    shown = [r for m in METHODS if (r := rows.get(f"{name} {m}"))]
    painted = rows.get(f"{name.replace('drawn', 'painted')} default")
    if known and painted:
        shown.append({**painted, "method": "painted"})
    if not shown:
        return "Not measured.\n"
    titles = {**METHODS, "painted": "default, the pieces' labels painted by hand"}
    text = header(
        [
            "method",
            "surface IoU %",
            *(["of known ways %"] if known else []),
            "offset bias / mean / p95 m",
            "width bias / mean / p95 m",
            "width variance m2",
            "largest jump of curvature 1/m",
            "within 1 / 2 sigma: offset, width %",
            "moved away by > 0.3 m %",
            "s",
        ]
    )

    def triple(x):
        return f"{fixed(x['bias'])} / {fixed(x['mean_abs'])} / {fixed(x['p95'])}"

    for r in shown:
        s = r["sigma_coverage"]
        w = s.get("width") or {}
        sigma = (
            "-"
            if s["1"] is None
            else f"{percent(s['1'])} / {percent(s['2'])}, {percent(w.get('1'))} / {percent(w.get('2'))}"
        )
        away = "-" if r["method"] == "none" else percent((r.get("moved_away") or {}).get("share_by_more_than_0_3_m"))
        text += row(
            [
                titles[r["method"]],
                percent(r["surface_iou"]),
                *([percent(r.get("surface_iou_of_known_ways"))] if known else []),
                triple(r["offset_m"]),
                triple(r["width_m"]),
                fixed(r["width_variance_m2"]),
                fixed(r["largest_curvature_jump"]["per_m"]),
                sigma,
                away,
                fixed(r["seconds"], 1),
            ]
        )
    return text


def disturbed_table(rows, name):
    return header(["method", "distance to the undisturbed line: mean / p95 m", "matched %", "s"]) + "".join(
        row(
            [
                METHODS[m],
                f"{fixed(r['offset_m']['mean_abs'])} / {fixed(r['offset_m']['p95'])}",
                percent(r["matched_share"]),
                fixed(r["seconds"], 1),
            ]
        )
        for m in METHODS
        if (r := rows.get(f"{name} {m}"))
    )


def summary(numbers):  # long: a list of what was asked, an entry each
    rows, lines = numbers["rows"], []

    def add(what, asked, value, good):
        return lines.append(row([what, asked, value + ("" if good else " **missed**")]))

    def sigma(name, r):
        both = [r["sigma_coverage"]["1"], r["sigma_coverage"]["width"]["1"]]
        add(
            f"{name}: within one sigma (offset, width)",
            "55-80 %",
            f"{percent(both[0])}, {percent(both[1])} %",
            all(0.55 <= x <= 0.8 for x in both),
        )

    for name in ("village", "circuit", "junction"):
        d, n = rows.get(f"{name} predicted default"), rows.get(f"{name} predicted nlo-1+2")
        if not d:
            continue
        iou, o, w = d["surface_iou"], d["offset_m"], d["width_m"]
        add(f"{name}, predicted labels: surface IoU", ">= 90 %", f"{percent(iou)} %", iou >= 0.9)
        if n:
            add(
                f"{name}: above NLO 1+2",
                ">= 3 points",
                f"{percent(iou - n['surface_iou'])} points",
                iou - n["surface_iou"] >= 0.03,
            )
        mrf = [r["surface_iou"] for m in ("mrf-dp", "mrf-smooth") if (r := rows.get(f"{name} predicted {m}"))]
        if mrf:
            add(
                f"{name}: above MRF, the better of both polygons",
                "> 0",
                f"{percent(iou - max(mrf))} points",
                iou > max(mrf),
            )
        add(
            f"{name}: offset mean, p95",
            "<= 0.20, 0.60 m",
            f"{fixed(o['mean_abs'])}, {fixed(o['p95'])} m",
            o["mean_abs"] <= 0.2 and o["p95"] <= 0.6,
        )
        add(f"{name}: width mean error", "<= 0.35 m", f"{fixed(w['mean_abs'])} m", w["mean_abs"] <= 0.35)
        sigma(name, d)
    for name in ("kvarnbyn", "pardubice"):
        d, h = rows.get(f"{name} disturbed default"), rows.get(f"{name} drawn default")
        if d:
            add(
                f"{name} disturbed by 1-4 m: mean distance to the undisturbed line",
                "<= 0.9 m",
                f"{fixed(d['offset_m']['mean_abs'])} m",
                d["offset_m"]["mean_abs"] <= 0.9,
            )
        if not h:
            continue
        away = h["moved_away"]["share_by_more_than_0_3_m"]
        add(
            f"{name}, drawn carriageways: surface IoU (of ways the painters know)",
            ">= 80 %",
            f"{percent(h['surface_iou'])} ({percent(h['surface_iou_of_known_ways'])}) %",
            h["surface_iou"] >= 0.8,
        )
        add(
            f"{name}: offset mean",
            "<= 0.5 m",
            f"{fixed(h['offset_m']['mean_abs'])} m",
            h["offset_m"]["mean_abs"] <= 0.5,
        )
        add(
            f"{name}: width mean error",
            "<= 0.8 m",
            f"{fixed(h['width_m']['mean_abs'])} m",
            h["width_m"]["mean_abs"] <= 0.8,
        )
        add(f"{name}: moved away by more than 0.3 m", "<= 10 %", f"{percent(away)} %", away <= 0.1)
        sigma(name, h)
        if name == "pardubice":
            add("Pardubice, 245 km: time of `refine`", "<= 60 s", f"{fixed(h['seconds'], 0)} s", h["seconds"] <= 60)
    ring = rows.get("ring predicted default")
    if ring:
        too_long = ring["length_m"] / 4318 - 1
        add(
            "Red Bull Ring, predicted labels: lap length",
            "4318 m +- 0.2 %",
            f"{fixed(ring['length_m'], 0)} m ({percent(too_long)} %)",
            abs(too_long) <= 0.002,
        )
        add(
            "Red Bull Ring: edges, mean",
            "<= 0.5 m",
            f"{fixed(ring['edge_m']['mean_abs'])} m",
            ring["edge_m"]["mean_abs"] <= 0.5,
        )
    speed = next((c for c in (numbers.get("speed") or {"cases": []})["cases"] if c["nodes"] >= 17714), None)
    if speed:
        add(
            f"{speed['nodes']} nodes over 400 Mpx",
            "<= 20 s, 3 GB",
            f"{fixed(speed['seconds'], 1)} s, {fixed(speed['gb'], 1)} GB",
            speed["seconds"] <= 20 and speed["gb"] <= 3,
        )
    return header(["number", "asked", "reached"]) + "".join(lines)


def page(numbers):
    rows = numbers["rows"]
    text = f"\n### Asked and reached\n\n{summary(numbers)}"
    for name, title in (
        ("village", "Village (seed 99, unseen by the network)"),
        ("circuit", "Circuit"),
        ("junction", "Motorway junction"),
        ("ring", "Red Bull Ring"),
    ):
        for labels in ("predicted", "true"):
            if f"{name} {labels} default" in rows:
                text += f"\n### {title}, {labels} labels\n\n{table(rows, f'{name} {labels}')}"
    for name in PHOTOS:
        if f"{name} drawn default" in rows:
            text += f"\n### {name.capitalize()}, hand-drawn carriageways\n\n{table(rows, f'{name} drawn', known=True)}"
        if f"{name} disturbed default" in rows:
            text += (
                f"\n### {name.capitalize()}, OSM disturbed by a smooth field of 1 to 4 m\n\n"
                f"{disturbed_table(rows, f'{name} disturbed')}"
            )
    if numbers.get("speed"):
        text += "\n### Cost against road length (400 Mpx of labels, `bench_refine`)\n\n" + header(
            ["nodes", "km", "s", "nodes a second", "peak GB"]
        )
        text += "".join(
            row(
                [
                    c["nodes"],
                    fixed(c["km"], 1),
                    fixed(c["seconds"], 2),
                    fixed(c["nodes"] / c["seconds"], 0),
                    fixed(c["gb"], 2),
                ]
            )
            for c in numbers["speed"]["cases"]
        )
    return text


def run(args):
    if args.table:
        write_page(PAGE, [STORE], {"refine": page(read_results(STORE, {"rows": {}}))})
        return
    args.out.mkdir(parents=True, exist_ok=True)
    measuring = Measuring(args)
    for name in args.only:
        if name in SYNTHETIC:
            measuring.synthetic(name, args.methods)
        elif name in PHOTOS:
            measuring.town(name, args.methods)
        else:
            measuring.speed()
    write_page(PAGE, [STORE], {"refine": page(measuring.numbers)})
