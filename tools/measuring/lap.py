# SPDX-License-Identifier: Apache-2.0
"""Laps of the Red Bull Ring: the cars on the real track, on its heights and flat. Writes docs/measured/lap.md.

Makes the site of ../shared/data/spielberg (real edges and heights), writes its true roads as OpenDRIVE and drives them:
a few minutes. The pictures are those of the GT3-like car's report. With --table nothing runs: the page is written from
the last results, bench/results/lap.json.
"""

import csv
import html
import re

from measuring.common import (
    DATA,
    IMAGES,
    PAGES,
    Tool,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "lap.json", PAGES / "lap.md"
CARS = {"gt3": "GT3-like", "sports": "sports car", "family": "family car"}
ASKED = {"gt3": "85 to 93", "sports": "98 to 115", "family": "-"}
REAL = {"gt3": "89.3 (GT3)", "sports": "92.2 (Porsche Cup), 97.4 (touring car)", "family": "-"}
PICTURES = {
    "The lap": "lap_map.svg",
    "Speed": "lap_speed.svg",
    "Lateral acceleration (left +)": "lap_lateral.svg",
    "g-g diagram": "lap_gg.svg",
}


def add_arguments(parser):
    add_tool(parser, "out/lap")
    add_table(parser)


def ring(tool, out):
    """The true roads of the track as OpenDRIVE. The photo does not matter: its pixels are a metre."""
    data, site, file = DATA / "spielberg", out / "site", out / "ring.xodr"
    tool.synth(
        site,
        "--from-track",
        data / "spielberg_utm33.csv",
        "--track-osm",
        data / "osm_way_red_bull_ring.osm",
        "--track-heights",
        data / "elevation_zaggyai.csv",
        "--gsd",
        "1",
    )
    tool("network", "--roads", site / "truth/roads.gpkg", "-o", file)
    return file


def drive(tool, network, folder, *options):
    """The numbers of a lap, from its page and its table."""
    tool("drive", "--network", network, "-o", folder, *options)
    page = (folder / "report.html").read_text()
    shown = {
        html.unescape(a): html.unescape(b) for a, b in re.findall(r"<tr><td>([^<]*)</td><td>([^<]*)</td></tr>", page)
    }

    def seconds(text):
        return int(text.split(":")[0]) * 60 + float(text.split(":")[1])

    lap, planned = re.findall(r"\d+:\d+\.\d+", shown["Lap time"])[:2]
    rows = list(csv.DictReader((folder / "lap.csv").open()))

    def column(name):
        return [float(r[name]) for r in rows]

    return {
        "lap_s": seconds(lap),
        "planned_s": seconds(planned),
        "top_kmh": 3.6 * max(column("speed_mps")),
        "lateral_mps2": max(map(abs, column("a_lat_mps2"))),
        "braking_mps2": -min(column("a_lon_mps2")),
        "line_m": float(shown["Largest distance from the line"].split()[0]),
        "off_road_percent": float(shown["Tyre contacts off the road"].split()[0]),
        "times_real_time": float(shown["Simulation"].split()[0]),
    }


def outermost_svgs(page):
    """Pictures may hold others."""
    depth, begin = 0, 0
    for mark in re.finditer(r"<svg\b|</svg>", page):
        if mark[0] == "</svg>":
            depth -= 1
            if depth == 0:
                yield page[begin : mark.end()]
            continue
        if depth == 0:
            begin = mark.start()
        depth += 1


def keep_pictures(folder):
    for svg in outermost_svgs((folder / "report.html").read_text()):
        for title, name in PICTURES.items():
            if f">{title}<" in svg:
                (IMAGES / name).write_text(
                    (svg if "xmlns" in svg else svg.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1))
                    + "\n"
                )


def measure(tool, out):
    network = ring(tool, out)
    laps = {}
    for car in CARS:
        style = ["--vehicle", car, "--style", "racing"]
        laps[car] = {
            "road": drive(tool, network, out / car, *style),
            "flat": drive(tool, network, out / f"{car}_flat", "--flat", *style),
            "half_step": drive(tool, network, out / f"{car}_half", "--step", "0.5", *style),
        }
    keep_pictures(out / "gt3")
    return {"commit": commit(), "machine": machine(), "laps": laps}


def page(results):
    laps = results["laps"]
    text = (
        "# Measured: laps of the Red Bull Ring\n\nMethod: [drive.md](../drive.md), the car: "
        "[vehicle.md](../vehicle.md), the track: [synth.md](../synth.md). "
    )
    text += "Written by `tools/measure lap` from `bench/results/lap.json`.\n\n"
    text += (
        "The track lies between its surveyed edges on real heights; banking, and the ground beside it, are made up. "
    )
    text += "A flying lap each; no car was tuned to a lap time. Flat: the same track without heights and banking.\n\n"
    rows = [
        ["lap, s", *(fixed(laps[c]["road"]["lap_s"]) for c in CARS)],
        ["asked, s", *(ASKED[c] for c in CARS)],
        ["real classes, s", *(REAL[c] for c in CARS)],
        ["lap on the flat road, s", *(fixed(laps[c]["flat"]["lap_s"]) for c in CARS)],
        ["planned, s", *(fixed(laps[c]["road"]["planned_s"]) for c in CARS)],
        ["top speed, km/h", *(fixed(laps[c]["road"]["top_kmh"], 1) for c in CARS)],
        ["largest lateral acceleration, m/s2", *(fixed(laps[c]["road"]["lateral_mps2"]) for c in CARS)],
        ["largest braking, m/s2", *(fixed(laps[c]["road"]["braking_mps2"]) for c in CARS)],
        ["largest distance from the line, m", *(fixed(laps[c]["road"]["line_m"]) for c in CARS)],
        [
            "tyre contacts off the road, % (3D, flat)",
            *(
                f"{fixed(laps[c]['road']['off_road_percent'], 3)}, {fixed(laps[c]['flat']['off_road_percent'], 3)}"
                for c in CARS
            ),
        ],
        ["lap with steps of 0.5 ms, s", *(fixed(laps[c]["half_step"]["lap_s"], 3) for c in CARS)],
        [
            "changed by halving the step, % (asked: below 0.1)",
            *(fixed(100 * abs(laps[c]["half_step"]["lap_s"] / laps[c]["road"]["lap_s"] - 1), 3) for c in CARS),
        ],
        ["times real time, whole loop (asked: 300)", *(fixed(laps[c]["road"]["times_real_time"], 0) for c in CARS)],
    ]
    text += header(["", *CARS.values()]).replace("|  |", "| |", 1) + "".join(map(row, rows))
    text += f"\nTimes real time: one core of {results['machine']['cpu']}.\n\n## The GT3-like car's lap\n\n"
    text += "Speed and lateral acceleration over distance, as figure 4.4 of the thesis; dashed: planned.\n\n"
    for alt, name in [
        ("speed over distance", "lap_speed.svg"),
        ("lateral acceleration over distance", "lap_lateral.svg"),
        ("g-g diagram", "lap_gg.svg"),
        ("map of the lap, coloured by speed", "lap_map.svg"),
    ]:
        text += f"![{alt}](../images/{name})\n\n"
    return text.rstrip("\n") + "\n"


def run(args):
    results = read_results(STORE, {})
    if not args.table:
        results = measure(Tool(args.tool), args.out)
        write_results(STORE, results)
    write_page(PAGE, [STORE], page(results))
