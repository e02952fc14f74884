# SPDX-License-Identifier: Apache-2.0
"""Banking: synthetic sites against their truth, and how Kvarnbyn's bends lie. Writes docs/measured/banking.md and a
picture.

Estimates banking on the true lines of the folders village-11 to -14, village-99, circuit and junction (made where they
lack), and on Kvarnbyn's refined roads, which `tools/measure refine` leaves in out/refinement/roads. Needs gdal-bin; a
minute.
"""

import math
import pathlib
import re
import sqlite3
import sys
from array import array
from collections import defaultdict

from measuring.common import (
    DATA,
    IMAGES,
    PAGES,
    RESULTS,
    ROOT,
    Tool,
    add_table,
    add_tool,
    children_seconds,
    commit,
    point_of,
    read_results,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "banking.json", PAGES / "banking.md"
KVARNBYN = DATA / "kvarnbyn"
TUNED = {"village-11", "village-12", "village-13", "village-14"}
SITES = {**{f"village-{n}": [2] for n in (11, 12, 13, 14)}, "village-99": [2, 1], "circuit": [2, 1], "junction": [2, 1]}


def add_arguments(parser):
    add_tool(parser, "out/banking")
    add_table(parser)
    parser.add_argument("--sites", type=pathlib.Path, default=ROOT / "out/synth", help="synthetic sites (out/synth)")
    parser.add_argument(
        "--roads",
        type=pathlib.Path,
        default=ROOT / "out/refinement/roads/kvarnbyn drawn.default.gpkg",
        help="Kvarnbyn's refined roads",
    )


def read_paths(file):
    """Nodes of each (osm_id, part) as dicts, and the highway of each."""
    base = sqlite3.connect(file)
    held = {row[1] for row in base.execute("pragma table_info(nodes)")}  # older files have no crown
    names = ["osm_node", "s_m", "width_m", "z_m", "gradient", "banking", "crown", "banking_source"]
    paths = defaultdict(list)
    for geometry, way, part, *values in base.execute(
        f"select geom, osm_id, part, {', '.join(n if n in held else '0' for n in names)} from nodes order by fid"
    ):
        x, y = point_of(geometry)
        paths[way, part].append(dict(zip(names, values, strict=False), x=x, y=y))
    return paths, {(w, p): h for w, p, h in base.execute("select osm_id, part, highway from centrelines")}


def mean(values):
    values = list(values)
    return sum(values) / max(1, len(values))


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


def on_bed_of_another(truth):
    """Nodes at the end of a road that lie on the carriageway or shoulder (1 m) of one that goes on: the site's ground
    is that one's.
    """
    at_node = defaultdict(list)
    for key, nodes in truth.items():
        for i, node in enumerate(nodes):
            if node["osm_node"] > 0:
                at_node[node["osm_node"]].append((key, i, 0 < i < len(nodes) - 1))
    found = set()
    for places in at_node.values():
        reach = max((truth[k][i]["width_m"] / 2 + 1.0 for k, i, inside in places if inside), default=0.0)
        for key, i, inside in places:
            if not inside:
                found |= {
                    (key, n) for n, node in enumerate(truth[key]) if abs(node["s_m"] - truth[key][i]["s_m"]) <= reach
                }
    return found


def measure_site(tool, args, site, grid_m):
    preset, _, seed = site.partition("-")
    folder = tool.synth(args.sites / site, "--preset", preset, *(["--seed", seed] if seed else []))
    result = args.out / f"{site}.{grid_m}m.gpkg"
    dtm = folder / "dtm_1m.tif"
    if grid_m == 2:
        dtm = args.out / f"{site}.2m.tif"  # means of 2 x 2 pixels
        run_program("gdal_translate", "-q", "-r", "average", "-outsize", "50%", "50%", folder / "dtm_1m.tif", dtm)
    tool("elevate", "--roads", folder / "truth/roads.gpkg", "--dtm", dtm, "-o", result)
    ours, truth = read_paths(result)[0], read_paths(folder / "truth/roads.gpkg")[0]
    beds = on_bed_of_another(truth)
    errors = [
        (abs(a["banking"] - b["banking"]), (key, i) in beds)
        for key in truth
        for i, (a, b) in enumerate(zip(ours[key], truth[key], strict=False))
    ]
    heights = tool.json("evaluate", "heights", result, folder / "truth/roads.gpkg", "--json")
    return {
        "site": site,
        "grid_m": grid_m,
        "mean": mean(e for e, _ in errors),
        "p95": percentile([e for e, _ in errors], 0.95),
        "mean_off_beds": mean(e for e, bed in errors if not bed),
        "bed_share": mean(bed for _, bed in errors),
        "crowned": mean(node["crown"] > 0.005 for nodes in ours.values() for node in nodes),
        "z_mean": heights["z_m"]["mean_abs"],
    }


class Ground:
    """The 2 m grid of western Kvarnbyn, bilinear, in the roads' CRS."""

    def __init__(self, out):
        file = out / "kvarnbyn_2m.bin"
        run_program(
            "gdalwarp",
            "-q",
            "-overwrite",
            "-t_srs",
            "EPSG:32633",
            "-tr",
            "2",
            "2",
            "-r",
            "bilinear",
            "-of",
            "ENVI",
            "-ot",
            "Float32",
            "-dstnodata",
            "-9999",
            KVARNBYN / "dtm_2m_west.tif",
            file,
        )
        header = file.with_suffix(".hdr").read_text()
        self.width = int(re.search(r"samples = (\d+)", header)[1])
        info = re.search(r"map info = \{([^}]*)\}", header)[1].split(",")
        self.west, self.north, self.gsd_m = float(info[3]), float(info[4]), float(info[5])
        self.z = array("f")
        self.z.frombytes(file.read_bytes())

    def at(self, x, y):
        column, row = (x - self.west) / self.gsd_m - 0.5, (self.north - y) / self.gsd_m - 0.5
        i, k = math.floor(column), math.floor(row)
        if i < 0 or k < 0 or i + 1 >= self.width or (k + 2) * self.width > len(self.z):
            return None
        a, b, c, d = (
            self.z[n]
            for n in (
                k * self.width + i,
                k * self.width + i + 1,
                (k + 1) * self.width + i,
                (k + 1) * self.width + i + 1,
            )
        )
        if min(a, b, c, d) < -1000:
            return None
        u, v = column - i, row - k
        return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v


def correlation(a, b):
    ma, mb = mean(a), mean(b)
    return sum((x - ma) * (y - mb) for x, y in zip(a, b, strict=True)) / math.sqrt(
        sum((x - ma) ** 2 for x in a) * sum((y - mb) ** 2 for y in b)
    )


def bends_of(paths, highways, ground):
    """Measured nodes in curves of less than 120 m radius: banking beside the grid's own slopes over the carriageway and
    over 20 m.
    """
    reach, bends = 8, []  # nodes to each side
    for key, nodes in paths.items():
        for i in range(reach, len(nodes) - reach):
            a, b, c = nodes[i - reach], nodes[i], nodes[i + reach]
            run = c["s_m"] - a["s_m"]
            if b["banking_source"] != "dtm" or run <= 0:
                continue
            turn = math.remainder(
                math.atan2(c["y"] - b["y"], c["x"] - b["x"]) - math.atan2(b["y"] - a["y"], b["x"] - a["x"]), 2 * math.pi
            )
            curvature, span = 2 * turn / run, math.hypot(c["x"] - a["x"], c["y"] - a["y"])
            if abs(curvature) < 1 / 120 or span == 0:
                continue
            left = (-(c["y"] - a["y"]) / span, (c["x"] - a["x"]) / span)

            def at(t):
                return ground.at(b["x"] + left[0] * t, b["y"] + left[1] * t)

            inner = max(1.0, b["width_m"] / 2 - 1)
            heights = [at(inner), at(-inner), at(10), at(-10)]
            if None in heights:
                continue
            bends.append(
                {
                    "key": key,
                    "i": i,
                    "highway": highways[key],
                    "curvature": curvature,
                    "left": left,
                    "node": b,
                    "slope": math.tan(b["banking"]),
                    "grid": (heights[0] - heights[1]) / (2 * inner),
                    "hill": (heights[2] - heights[3]) / 20,
                }
            )
    return bends


PANEL_WIDE, PANEL_TALL = 300, 250  # px
HALF_M = 16  # of what is shown across


def bends_to_draw(bends):
    """Three bends that fall to the outside, of three ways: the longest runs. (middle, run)"""
    runs = []
    for r in bends:
        if r["slope"] * r["curvature"] <= 0 or abs(r["slope"]) < 0.015:
            continue
        if runs and runs[-1][-1]["key"] == r["key"] and runs[-1][-1]["i"] == r["i"] - 1:
            runs[-1].append(r)
        else:
            runs.append([r])
    runs.sort(key=lambda run: -sum(abs(r["slope"]) for r in run))
    shown = []
    for run in runs:
        if (
            len(shown) < 3
            and all(run[0]["key"] != r["key"] for r, _ in shown)
            and run[0]["highway"] not in [r["highway"] for r, _ in shown]
        ):
            shown.append((run[len(run) // 2], run))
    return shown


def draw_bend(n, r, run, ground, out):
    x0, node = n * PANEL_WIDE, r["node"]
    sections = [
        [
            (t / 2, ground.at(q["node"]["x"] + q["left"][0] * t / 2, q["node"]["y"] + q["left"][1] * t / 2))
            for t in range(-2 * HALF_M, 2 * HALF_M + 1)
        ]
        for q in run
    ]
    sections = [
        ([(t, z - q["node"]["z_m"]) for t, z in s if z is not None]) for s, q in zip(sections, run, strict=True)
    ]
    size = 3.0
    out.append(
        f'<clipPath id="panel{n}"><rect x="{x0 + 10}" y="40" width="{PANEL_WIDE - 20}" height="{PANEL_TALL - 60}"/>'
        "</clipPath>"
    )

    def px(t):
        return x0 + PANEL_WIDE / 2 - t * (PANEL_WIDE / 2 - 20) / HALF_M  # seen along the road: left is left

    def py(z):
        return PANEL_TALL / 2 + 10 - z * 90 / size

    def line(points, style):
        return out.append(
            f'<polyline clip-path="url(#panel{n})" fill="none" {style} points="'
            + " ".join(f"{px(t):.1f},{py(z):.1f}" for t, z in points)
            + '"/>'
        )

    w = node["width_m"] / 2
    out.append(f'<rect x="{px(w):.1f}" y="40" width="{px(-w) - px(w):.1f}" height="{PANEL_TALL - 60}" fill="#eee"/>')
    for s in sections[::2]:
        line(s, 'stroke="#9ab" stroke-width="0.6"')
    line(sections[len(run) // 2], 'stroke="#245" stroke-width="1.6"')
    roof = math.tan(node["crown"])
    line(
        [(w, w * r["slope"] - w * roof), (0, 0), (-w, -w * r["slope"] - w * roof)],
        'stroke="#d33" stroke-width="2.2"',
    )
    side = "left" if r["curvature"] > 0 else "right"
    out.append(
        f'<text x="{x0 + 12}" y="16">{r["highway"]}, bends to the {side}, R {abs(1 / r["curvature"]):.0f} m</text>'
    )
    out.append(
        f'<text x="{x0 + 12}" y="31" fill="#555">banking {100 * r["slope"]:.1f} %, hill over 20 m '
        f"{100 * r['hill']:.0f} %</text>"
    )


def draw(bends, ground):
    out = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {3 * PANEL_WIDE} {PANEL_TALL}" '
            'font-family="sans-serif" '
            'font-size="11">'
        ),
        f'<rect width="{3 * PANEL_WIDE}" height="{PANEL_TALL}" fill="white"/>',
    ]
    for n, (r, run) in enumerate(bends_to_draw(bends)):
        draw_bend(n, r, run, ground, out)
    out.append(
        f'<text x="12" y="{PANEL_TALL - 6}" fill="#555">Red: carriageway as measured; dark: 2 m grid across the '
        "middle of "
        f"the bend; light: the rest of it. Seen along the way; ± {HALF_M} m across, ± 3 m high (times 3).</text></svg>"
    )
    (IMAGES / "banking_bends.svg").write_text("\n".join(out) + "\n")


def plane_spread(paths):
    """How far the surfaces of the roads of a junction are apart in slope at its node: the largest difference of two
    gradients, a node.
    """
    at_node = defaultdict(list)
    for nodes in paths.values():
        for i, node in enumerate(nodes):
            a, b = nodes[max(0, i - 1)], nodes[min(len(nodes) - 1, i + 1)]
            span = math.hypot(b["x"] - a["x"], b["y"] - a["y"])
            if node["osm_node"] > 0 and span > 0:
                d, across = ((b["x"] - a["x"]) / span, (b["y"] - a["y"]) / span), math.tan(node["banking"])
                at_node[node["osm_node"]].append(
                    (node["gradient"] * d[0] - across * d[1], node["gradient"] * d[1] + across * d[0])
                )
    return [max(math.dist(p, q) for p in ends for q in ends) for ends in at_node.values() if len(ends) > 1]


def bend_rows(bends):
    rows = []
    for name in ["all", *sorted({r["highway"] for r in bends})]:
        of = [r for r in bends if name in ("all", r["highway"])]
        clear = [r for r in of if abs(r["slope"]) > 0.01]
        out = [r for r in clear if r["slope"] * r["curvature"] > 0]
        if len(clear) < 30:
            continue
        rows.append(
            {
                "highway": name,
                "nodes": len(of),
                "outwards": len(out) / len(clear),
                "as_hill": mean(r["slope"] * r["hill"] > 0 for r in out),
                "as_grid": mean(r["slope"] * r["grid"] > 0 for r in clear),
                "with_hill": correlation([r["slope"] for r in of], [r["hill"] for r in of]),
                "with_curvature": correlation([r["slope"] for r in of], [-r["curvature"] for r in of]),
            }
        )
    return rows


def measure_kvarnbyn(tool, args):
    file, begin = args.out / "kvarnbyn.gpkg", children_seconds()
    tool(
        "elevate",
        "--roads",
        args.roads,
        "--dtm",
        KVARNBYN / "dtm_2m_west.tif",
        "--dtm",
        KVARNBYN / "dtm_10m_utm33.tif",
        "-o",
        file,
    )
    seconds = children_seconds() - begin
    paths, highways = read_paths(file)
    ground = Ground(args.out)
    bends = bends_of(paths, highways, ground)
    draw(bends, ground)
    spread = plane_spread(paths)
    return {
        "bends": bend_rows(bends),
        "spread_mean": mean(spread),
        "spread_p95": percentile(spread, 0.95),
        "spread_max": max(spread),
        "seconds": seconds,
        "measured": mean(n["banking_source"] == "dtm" for path in paths.values() for n in path),
    }


def tables(numbers):
    k = numbers["kvarnbyn"]
    text = "\n| site | grid | mean | p95 | mean off other roads' beds | asked: mean |\n|---|---|---|---|---|---|\n"
    for r in numbers["sites"]:
        name = r["site"].replace("-", " ") + (" (weights found on it)" if r["site"] in TUNED else "")
        text += (
            f"| {name} | {r['grid_m']} m | {r['mean']:.4f} | {r['p95']:.4f} | {r['mean_off_beds']:.4f} | "
            f"{'0.0030' if 'village' in r['site'] and r['grid_m'] == 2 else '-'} |\n"
        )
    text += (
        f"\nCrown where there is none: at {100 * max(r['crowned'] for r in numbers['sites']):.1f} % of the nodes "
        "at most. "
    )
    text += (
        "z of village 99 from the 2 m grid: "
        f"{next(r['z_mean'] for r in numbers['sites'] if r['site'] == 'village-99'):.3f} m in the mean (asked: "
        "0.05 m).\n\n"
    )
    text += (
        f"Kvarnbyn, refined lines: measured at {100 * k['measured']:.0f} % of the nodes (all of the west); all of "
        f"`elevate` takes {k['seconds']:.1f} s of processor time for 73 km. "
    )
    text += (
        f"Surfaces of roads that share a node differ in slope there by {k['spread_mean']:.4f} in the mean, "
        f"{k['spread_p95']:.4f} (p95), {k['spread_max']:.3f} at most.\n\n"
    )
    text += (
        "| Kvarnbyn, bends under 120 m | nodes | fall outwards | of these with the hill | sign as in the grid | "
        "correlation with hill | with bend |\n|---|---|---|---|---|---|---|\n"
    )
    for r in k["bends"]:
        text += (
            f"| {r['highway']} | {r['nodes']} | {100 * r['outwards']:.0f} % | {100 * r['as_hill']:.0f} % | "
            f"{100 * r['as_grid']:.0f} % | {r['with_hill']:.2f} | {r['with_curvature']:.2f} |\n"
        )
    return text


def run(args):
    if args.table:
        numbers = read_results(STORE, None) or sys.exit(f"{RESULTS / STORE}: not measured yet")
    else:
        tool = Tool(args.tool)
        args.out.mkdir(parents=True, exist_ok=True)
        numbers = {
            "sites": [measure_site(tool, args, site, grid_m) for site, grids in SITES.items() for grid_m in grids],
            "commit": commit(),
            "kvarnbyn": measure_kvarnbyn(tool, args),
        }
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"banking": tables(numbers)})
