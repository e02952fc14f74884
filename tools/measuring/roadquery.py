"""The road query: speed, load and wrong roads on built sites. Writes docs/measured/roadquery.md.

Runs bench_road_query_sites and bench_road_query_truth of build/release on every site given by --site NAME=roads.xodr (some
minutes). With --table nothing runs: the page is written from the last results, bench/results/roadquery.json.
"""
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
    """Name -> value of what a program prints one a line."""
    out = subprocess.run([str(w) for w in words], check=True, stdout=subprocess.PIPE, text=True).stdout
    return {line.split()[0]: float(line.split()[1]) for line in out.splitlines()}


def truth(*words):
    """Case -> name -> count. The program ends with 1 when a point came back wrong: that is a result, too."""
    out = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, text=True).stdout
    cases = [line.split() for line in out.splitlines() if line.startswith("with")]
    return {words[0]: {k: float(v) for k, v in zip(words[1::2], words[2::2])} for words in cases}


def page(r):
    sites = r["sites"]
    worst = lambda key: max(s["speed"][key] for s in sites.values())
    text = "# Measured: road query\n\nMethod: [roadquery.md](../roadquery.md). Written by `tools/measure roadquery` from "
    text += f"`bench/results/roadquery.json` (commit {r['commit']}). CPU time, one core of a shared {r['machine']['cpu']} while other work ran "
    text += "beside it: least of seven runs. On an idle machine OpenCRG needs 70-78 ns for a height in driving order (any order: 0.7-18 us), "
    text += "libOpenDRIVE 6-7 us and esmini 180 us for any order; before the tables this query needed 2.5 us and 1.0-3.0 us.\n\n## Speed\n\n"
    rows = [("height alone, driving order, ns", "route_z_ns_least", "70"), ("all of a hit, driving order, ns", "route_all_ns_least", "100"),
            ("any order, ns", "any_order_ns_least", "500"), ("worst of the points, us", "worst_us_least_of_six", "20"),
            ("stations", "stations", "-"), ("read, s", "read_s", "-"), ("make the tables, s", "bake_s", "-")]
    text += common.header(["what", "asked"] + [f"{n} ({s['speed']['road_km']:.0f} km)" for n, s in sites.items()])
    for what, key, asked in rows:
        text += common.row([what, asked] + [f"{s['speed'][key]:g}" for s in sites.values()])
    text += "\nThe worst point is the slowest of six times, each of which another process may have stretched: the least counts.\n"
    t = r["tile"]
    text += f"\n{t['road_km']:.0f} km of road: {t['bake_s']:.1f} s for the tables, {t['all_mb']:.0f} MB in all, of it {t['map_mb']:.0f} MB the "
    text += f"roads as read (asked: 5 s, 500 MB); {t['peak_mb']:.0f} MB at the peak.\n\n## Wrong roads\n\n"
    text += "Points from known (road, s, t); what counts as right stands at the head of `bench/speed/road_query_truth.cpp`.\n\n"
    names = ["points", "same", "of_junction", "overlapping", "itself", "wrong", "missed", "wrong_heights"]
    text += common.header(["site, how"] + [n.replace("_", " ") for n in names] + ["worst height, mm"])
    for site, s in sites.items():
        for case, c in s["truth"].items():
            text += common.row([f"{site}, {case.replace('_', ' ')}"] + [f"{c[n]:.0f}" for n in names] + [f"{c['worst_height_mm']:.5f}"])
    total = sum(c["wrong"] + c["missed"] for s in sites.values() for c in s["truth"].values())
    text += f"\nWrong or missed of all: {total:.0f} (asked: 0). Slowest site in driving order: {worst('route_z_ns_least'):g} ns.\n"
    return text


def run(args):
    results = common.read_results("roadquery.json", {})
    if not args.table:
        sites = dict(s.split("=", 1) for s in args.site)
        if not sites:
            raise SystemExit("tools/measure roadquery: give at least one --site NAME=roads.xodr")
        results = {"commit": common.commit(), "machine": common.machine(), "sites": {}}
        for name, file in sites.items():
            results["sites"][name] = {"speed": numbers(args.bench / "bench_road_query_sites", file, 2000000),
                                      "truth": truth(args.bench / "bench_road_query_truth", file, args.points, 7)}
        results["tile"] = numbers(args.bench / "bench_road_query_sites", "--tile", list(sites.values())[-1], args.tile_km)
        common.write_results("roadquery.json", results)
    (common.PAGES / "roadquery.md").write_text(page(results))
