# SPDX-License-Identifier: Apache-2.0
"""Whole sites: seconds, memory, and the village against its exact truth. Writes docs/measured/site.md.

Builds every site from nothing: half an hour on two cores. What is not measured in this run keeps its last values from
bench/results/numbers.json.
"""

import hashlib
import json
import shutil
import time

from measuring.common import (
    DATA,
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    exponential,
    fixed,
    header,
    machine,
    percent,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "numbers.json", PAGES / "site.md"
SITES = ["village", "kvarnbyn", "pardubice"]


def add_arguments(parser):
    add_tool(parser, "out/numbers")
    add_only(parser, SITES)
    add_table(parser)
    parser.add_argument("--print", action="store_true", help="print the page's tables, write neither page nor results")


def build(tool, out, site, name, *more):
    folder = out / name
    shutil.rmtree(folder, ignore_errors=True)
    start = time.monotonic()
    tool("build", site, "-o", folder, *more)
    seconds = time.monotonic() - start
    stages = json.loads((folder / "run.json").read_text())["stages"]
    return {
        "commit": commit(),
        **machine(),
        "seconds": round(seconds, 3),
        "peak_gb": max(s["peak_memory_bytes"] for s in stages) / 1e9,
        "stages": [
            {"stage": s["stage"], "seconds": s["seconds"], "peak_mb": s["peak_memory_bytes"] / 1e6} for s in stages
        ],
    }


def hashes(folder):
    """Of the files whose content must not depend on the run: all but the timings."""
    return {
        str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest()
        for f in sorted(folder.rglob("*"))
        if f.is_file()
        and f.name not in ("run.json", "report.html")
        and ".orthodrive" not in f.relative_to(folder).parts
    }


def measure_village(tool, out):
    site = out / "village_site"
    shutil.rmtree(site, ignore_errors=True)
    tool("synth", "--preset", "village", "--seed", "7", "-o", site)
    built = build(tool, out, site / "site.toml", "village", "--threads", 2)
    build(tool, out, site / "site.toml", "village_again", "--threads", 2)
    build(tool, out, site / "site.toml", "village_1_thread", "--threads", 1)
    reference = hashes(out / "village")

    def differ(name):
        other = hashes(out / name)
        return sorted(f for f in reference | other if reference.get(f) != other.get(f))

    return {
        **built,
        "files": len(reference),
        "differ_again": differ("village_again"),
        "differ_1_thread": differ("village_1_thread"),
        "input": tool.json("evaluate", "roads", site / "roads.osm", site / "truth", "--json"),
        "result": tool.json("evaluate", "site", out / "village", "--truth", site / "truth", "--json"),
    }


def asked_and_reached(numbers):
    lines = []

    def add(what, asked, reached, good):
        return lines.append(row([what, asked, reached, "yes" if good else "**no**"]))

    for name, title, seconds, gb in (
        ("kvarnbyn", "Kvarnbyn (2.1 x 1.5 km)", 300, 4),
        ("pardubice", "Pardubice (23 km2)", 1800, 8),
    ):
        if name in numbers:
            n = numbers[name]
            add(f"{title}: seconds to build", f"<= {seconds}", fixed(n["seconds"], 0), n["seconds"] <= seconds)
            add(f"{title.split(' (')[0]}: peak memory (GB)", f"<= {gb}", fixed(n["peak_gb"]), n["peak_gb"] <= gb)
    if "village" in numbers:
        n = numbers["village"]
        before, after = 100 * n["input"]["surface_iou"], 100 * n["result"]["roads"]["surface_iou"]
        add(
            "Village: road surface IoU, points above the input",
            ">= 10",
            f"{fixed(after - before, 1)} ({fixed(before, 1)} -> {fixed(after, 1)})",
            after - before >= 10,
        )
        e0, e1 = n["input"]["offset_m"]["mean_abs"], n["result"]["roads"]["offset_m"]["mean_abs"]
        add(
            "Village: mean centre-line error, share of the input's",
            "<= 0.5",
            f"{fixed(e1 / e0)} ({fixed(e0)} m -> {fixed(e1)} m)",
            e1 <= 0.5 * e0,
        )
        for key, what in (("differ_again", "same seed twice"), ("differ_1_thread", "1 and 2 threads")):
            add(f"Village: files that differ, {what}", "0", f"{len(n[key])} of {n['files']}", not n[key])
    return "| | asked | reached | |\n|---|---|---|---|\n" + "".join(lines)


def village_tables(n):
    roads, heights, labels = (n["result"][k] for k in ("roads", "heights", "labels"))
    text = (
        "## Village (synthetic, seed 7, 1 km2 at 0.2 m/px): against exact truth\n\n| | unit | input OSM | result "
        "|\n|---|---|---|---|\n"
    )
    text += row(
        ["road surface IoU", "%", fixed(100 * n["input"]["surface_iou"], 1), fixed(100 * roads["surface_iou"], 1)]
    )
    for what, key in (("centre line offset", "offset_m"), ("width", "width_m")):
        for k in ("bias", "mean_abs", "p95"):
            text += row([f"{what}, {k}", "m", fixed(n["input"][key][k]), fixed(roads[key][k])])
    z = heights["z_m"]
    return text + (
        f"\nHeights of the result: bias {fixed(z['bias'])} m, mean {fixed(z['mean_abs'])} m, 95 % {fixed(z['p95'])} m. "
        f"Labels: road IoU {percent(labels['road_iou'])} %, mean IoU {percent(labels['mean_iou'])} %, pixel accuracy "
        f"{percent(labels['pixel_accuracy'])} %.\n"
    )


def stages_table(title, n):
    text = f"## {title}: seconds and peak memory a stage\n\n{n['cores']} cores ({n['cpu']}), {n['memory_gb']} GB.\n\n"
    text += header(["stage", "seconds", "peak MB"]) + "".join(
        row([s["stage"], fixed(s["seconds"], 1), fixed(s["peak_mb"], 0)]) for s in n["stages"]
    )
    text += row(["all", fixed(n["seconds"], 1), fixed(1000 * n["peak_gb"], 0)])
    if "heights" in n:
        z = n["heights"]["z_m"]
        text += (
            f"\nHeights, built from 10 m terrain, against the 2 m terrain of the western part ({z['n']} nodes): bias "
            f"{fixed(z['bias'])} m, "
            f"mean {fixed(z['mean_abs'])} m, 95 % {fixed(z['p95'])} m.\n"
        )
    if "network" in n:
        w = n["network"]
        text += (
            f"\nNetwork: {w['roads']} roads, {w['junctions']} junctions, {fixed(w['length_m'] / 1000, 1)} km, largest "
            f"joint gap {exponential(w['max_joint_gap_m'])} m, "
            f"largest gradient kink {exponential(w['max_gradient_kink'])}, {percent(w['connected_share'])} % of the "
            "length connected.\n"
        )
    return text


def tables(numbers):
    parts = [asked_and_reached(numbers)]
    if "village" in numbers:
        parts.append(village_tables(numbers["village"]))
    parts += [
        stages_table(title, numbers[title.lower()])
        for title in ("Kvarnbyn", "Pardubice", "Village")
        if title.lower() in numbers
    ]
    return "\n".join(parts)


def run(args):
    tool, numbers = Tool(args.tool), {} if args.print else read_results(STORE, {})
    if not args.table:
        args.out.mkdir(parents=True, exist_ok=True)
        for name in args.only:
            if name == "village":
                numbers[name] = measure_village(tool, args.out)
                continue
            numbers[name] = build(tool, args.out, ROOT / f"sites/{name}.toml", name)
            numbers[name]["network"] = tool.json("evaluate", "network", args.out / name / "roads.xodr", "--json")
            if name == "kvarnbyn":  # built from the 10 m terrain; the 2 m terrain of the west is the truth
                numbers[name]["heights"] = tool.json(
                    "evaluate", "heights", args.out / name / "roads.gpkg", DATA / "kvarnbyn/dtm_2m_west.tif", "--json"
                )
    if args.print:
        print(tables(numbers))
        return
    if not args.table:
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"site": tables(numbers)})
