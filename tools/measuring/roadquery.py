# SPDX-License-Identifier: Apache-2.0
"""The road query: speed, load and wrong roads on built sites. Writes docs/measured/roadquery.md, c_interface.md,
opencrg.md.

Runs bench_road_query, bench_road_query_truth and bench_c_interface of build/release on every site given by --site
NAME=roads.xodr, and bench_crg (some minutes). With --table nothing runs: the pages are written from the last results,
bench/results/roadquery.json.
"""

import json
import os
import pathlib
import subprocess

from measuring import common

BENCH = common.ROOT / "build/release/bench/speed"


def add_arguments(parser):
    common.add_table(parser)
    parser.add_argument("--site", action="append", default=[], metavar="NAME=FILE", help="roads of a built site")
    parser.add_argument("--bench", type=pathlib.Path, default=BENCH, help="folder of the built programs")
    parser.add_argument("--points", type=int, default=2500000, help="points with known (road, s, t) on each site")
    parser.add_argument("--tile-km", type=float, default=1000.0, help="length of road made of the last site, km")


def numbers(*words):
    """Name -> value of what a program prints one per line."""
    out = subprocess.run([str(w) for w in words], check=True, stdout=subprocess.PIPE, text=True).stdout
    return {line.split()[0]: float(line.split()[1]) for line in out.splitlines()}


def truth(*words):
    """Case -> name -> count. The program ends with 1 when a point came back wrong: that is a result, too."""
    out = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, text=True, check=False).stdout
    cases = [line.split() for line in out.splitlines() if line.startswith("with")]
    return {words[0]: {k: float(v) for k, v in zip(words[1::2], words[2::2], strict=False)} for words in cases}


def crg_ns(program):
    """Case of bench_crg -> CPU time of one, the least of seven runs."""
    runs = json.loads(
        common.run_program(program, "--benchmark_format=json", "--benchmark_repetitions=7", "--benchmark_min_time=0.1")
    )
    least = {}
    for run in runs["benchmarks"]:
        if run["run_type"] == "iteration":
            least[run["run_name"]] = min(least.get(run["run_name"], 1e30), run["cpu_time"])
    return least


def circumstances(r):
    text = (
        f"`bench/results/roadquery.json`. CPU time, one core of {r['machine']['cpu']} with {r['machine']['cores']} "
        "cores "
    )
    return text + f"(load {r['load'][0]:.1f} before, {r['load'][1]:.1f} after)"


def c_interface_page(r):
    text = (
        "# Measured: C interface\n\nMethod: [c_interface.md](../c_interface.md). Written by `tools/measure "
        "roadquery` from "
    )
    text += (
        circumstances(r)
        + ": least of nine rounds.\n`bench_c_interface roads.xodr` asks `libroadquery.so` as a simulator does, not "
    )
    text += (
        "inlined. Driving order: a point each 3 cm along the roads, with a cursor. Any order: the same points "
        "shuffled, each with a new "
    )
    text += "cursor.\n\n"
    text += common.header(["ns a query", "points", "z", "z, normal, friction", "all", "missed"])
    for site, s in r["sites"].items():
        c = s["c_interface"]
        for order, words in (("driving", "driving order"), ("any", "any order")):
            missed = sum(c[f"{order}_{what}_missed"] for what in ("z", "normal", "all"))
            text += common.row(
                [f"{site}, {words}", f"{c['points']:.0f}"]
                + [f"{c[f'{order}_{what}_ns']:.0f}" for what in ("z", "normal", "all")]
                + [f"{missed:.0f}"]
            )
    return text + "\nAsked, in driving order: z 70 ns, with normal and friction 100 ns.\n"


def opencrg_page(r):
    c = r["crg"]
    text = (
        "# Measured: OpenCRG\n\nMethod: [opencrg.md](../opencrg.md). Written by `tools/measure roadquery` from "
        + circumstances(r)
    )
    text += ": least of seven runs of `bench_crg`.\n\n" + common.header(["case", "ns a query"])
    for words, case in (
        ("height and slopes at (u, v), a point moving along 1001 x 341 values", "crg_height_at_uv/in_order"),
        ("the same, points anywhere on them", "crg_height_at_uv/anywhere"),
        ("height and slopes at (x, y) with the last u as hint", "crg_height_at_xy"),
        ("all of a hit of the road query, no file", "road_query/without_file"),
        ("the same with an `attached` file", "road_query/attached"),
        ("the same with a `genuine` file", "road_query/genuine"),
    ):
        text += common.row([words, f"{c[case]:.0f}"])
    text += "\nA grid of 341,000 "
    return text + f"values is made ready in {1e-6 * c['crg_make_ready']:.1f} ms.\n"


def page(r):
    sites = r["sites"]

    def worst(key):
        return max(s["speed"][key] for s in sites.values())

    text = (
        "# Measured: road query\n\nMethod: [roadquery.md](../roadquery.md). Written by `tools/measure roadquery` from "
    )
    text += circumstances(r) + ": least of seven runs.\n\n## Speed\n\n"
    rows = [
        ("height alone, driving order, ns", "route_z_ns_least", "70"),
        ("with normal and friction, ns", "route_normal_ns_least", "100"),
        ("all of a hit, ns", "route_all_ns_least", "-"),
        ("any order, ns", "any_order_ns_least", "500"),
        ("worst of the points, us", "worst_us_least_of_six", "20"),
        ("stations", "stations", "-"),
        ("read, s", "read_s", "-"),
        ("make the tables, s", "bake_s", "-"),
    ]
    text += common.header(["what", "asked"] + [f"{n} ({s['speed']['road_km']:.0f} km)" for n, s in sites.items()])
    for what, key, asked in rows:
        text += common.row([what, asked] + [f"{s['speed'][key]:g}" for s in sites.values()])
    text += (
        "\nThe worst point is the slowest of six times, each of which another process may have stretched: the "
        "least counts.\n"
    )
    o = r["overlap"]
    text += (
        "\nWhere twelve connecting roads that turn overlap without a surface of the junction's own: "
        f"{o['overlap_z_ns_least']:.0f} ns for the height, "
    )
    text += (
        f"{o['overlap_normal_ns_least']:.0f} with normal and friction, {o['overlap_all_ns_least']:.0f} for all "
        "(asked: 500).\n"
    )
    t = r["tile"]
    text += (
        f"\n{t['road_km']:.0f} km of road: {t['bake_s']:.1f} s for the tables, {t['all_mb']:.0f} MB in all, of it "
        f"{t['map_mb']:.0f} MB the "
    )
    text += f"roads as read (asked: 5 s, 500 MB); {t['peak_mb']:.0f} MB at the peak.\n\n## Wrong roads\n\n"
    text += (
        "Points from known (road, s, t); what counts as right stands at the head of "
        "`bench/speed/road_query_truth.cpp`.\n\n"
    )
    names = ["points", "same", "of_junction", "overlapping", "itself", "wrong", "missed", "wrong_heights"]
    text += common.header(["site, how"] + [n.replace("_", " ") for n in names] + ["worst height, mm"])
    for site, s in sites.items():
        for case, c in s["truth"].items():
            text += common.row(
                [f"{site}, {case.replace('_', ' ')}"] + [f"{c[n]:.0f}" for n in names] + [f"{c['worst_height_mm']:.5f}"]
            )
    total = sum(c["wrong"] + c["missed"] for s in sites.values() for c in s["truth"].values())
    text += (
        f"\nWrong or missed of all: {total:.0f} (asked: 0). Slowest site in driving order: "
        f"{worst('route_z_ns_least'):g} ns.\n"
    )
    return text


def run(args):
    results = common.read_results("roadquery.json", {})
    if not args.table:
        sites = dict(s.split("=", 1) for s in args.site)
        if not sites:
            raise SystemExit("tools/measure roadquery: give at least one --site NAME=roads.xodr")
        results = {"commit": common.commit(), "machine": common.machine(), "load": [os.getloadavg()[1]], "sites": {}}
        for name, file in sites.items():
            results["sites"][name] = {
                "speed": numbers(args.bench / "bench_road_query", file, 2000000),
                "truth": truth(args.bench / "bench_road_query_truth", file, args.points, 7),
                "c_interface": numbers(args.bench / "bench_c_interface", file),
            }
        results["tile"] = numbers(args.bench / "bench_road_query", "--tile", list(sites.values())[-1], args.tile_km)
        results["overlap"] = numbers(args.bench / "bench_road_query", "--overlap")
        results["crg"] = crg_ns(args.bench / "bench_crg")
        results["load"].append(os.getloadavg()[1])
        common.write_results("roadquery.json", results)
    common.write_page(common.PAGES / "roadquery.md", ["roadquery.json"], page(results))
    common.write_page(common.PAGES / "c_interface.md", ["roadquery.json"], c_interface_page(results))
    common.write_page(common.PAGES / "opencrg.md", ["roadquery.json"], opencrg_page(results))
