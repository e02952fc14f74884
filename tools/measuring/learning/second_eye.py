# SPDX-License-Identifier: Apache-2.0
"""What a network that sees the map adds: labels, alignment of the map's roads, refined roads. Writes
docs/measured/second_eye.md.

    tools/measure second-eye --eye out/second_eye/model.safetensors

Some twenty minutes on two cores. What is not measured in this run keeps its last values from
bench/results/second_eye.json. Needs ../shared/data; makes the synthetic sites and renders the painted pieces. Regions
left out: tools/measure regions.
"""

import bisect
import csv
import itertools
import json
import math
import pathlib
import re
import sqlite3

from measuring import refine
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
    point_of,
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)
from measuring.learning.painted import render_painted
from measuring.learning.segment import timed

STORE, PAGE = "second_eye.json", PAGES / "second_eye.md"
SITES = {
    "village-99": ["--preset", "village", "--seed", 99],
    "circuit-7": ["--preset", "circuit"],
    "junction-7": ["--preset", "junction"],
}
TOWNS = ["kvarnbyn", "pardubice"]
SHIFT_M = 50  # of a map that lies wrong altogether
# Whether the labels have seen the map, and whether the alignment is evidence.
VARIANTS = {"photo alone": (False, False), "labels see the map": (True, False), "and alignment": (True, True)}


def add_arguments(parser):
    add_tool(parser, "out/second_eye_measured")
    add_only(parser, ["labels", "speed", *SITES, *TOWNS])
    add_table(parser)
    parser.add_argument(
        "--eye", type=pathlib.Path, default=ROOT / "models/default.safetensors", help="a model that sees the map"
    )


def shift(source, target, metres):
    """OSM moved to the east as a whole."""
    text = source.read_text()
    latitude = float(re.search(r'<node [^>]*lat="([-\d.]+)"', text)[1])
    east = metres / (111320 * math.cos(math.radians(latitude)))
    target.write_text(re.sub(r'lon="([-\d.]+)"', lambda match: f'lon="{float(match[1]) + east:.8f}"', text))


def nodes_of(file):
    """Of each path its nodes: x, y."""
    lines = {}
    for osm_id, part, blob in sqlite3.connect(file).execute(
        "select osm_id, part, geom from nodes order by osm_id, part, s_m"
    ):
        lines.setdefault((osm_id, part), []).append(point_of(blob))
    return lines


class NearestLine:
    """Distances to lines whose nodes lie some metres apart."""

    CELL_M = 20

    def __init__(self, lines):
        self.cells = {}
        for line in lines:
            for segment in itertools.pairwise(line):
                self.cells.setdefault(self.cell(segment[0]), []).append(segment)

    def cell(self, p):
        return int(p[0] // self.CELL_M), int(p[1] // self.CELL_M)

    def distance(self, p):
        """Infinite where nothing is within a cell."""
        col, row_ = self.cell(p)
        near = (
            s for c in range(col - 1, col + 2) for r in range(row_ - 1, row_ + 2) for s in self.cells.get((c, r), ())
        )
        return min((self.to_segment(p, *segment) for segment in near), default=math.inf)

    @staticmethod
    def to_segment(p, a, b):
        along = b[0] - a[0], b[1] - a[1]
        square = along[0] ** 2 + along[1] ** 2
        t = min(1, max(0, ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / square)) if square else 0
        return math.hypot(a[0] + t * along[0] - p[0], a[1] + t * along[1] - p[1])


def place_errors(alignment, osm, truth):
    """Of every place: how far its line is from the nearest true centre line, before and after, m; and the sigma
    stated.
    """
    true, lines, errors = NearestLine(nodes_of(truth).values()), nodes_of(osm), []
    at = {key: [0] for key in lines}
    for key, line in lines.items():
        for a, b in itertools.pairwise(line):
            at[key].append(at[key][-1] + math.dist(a, b))
    for place in csv.DictReader(alignment.open()):
        key, s = (int(place["osm_id"]), int(place["part"])), float(place["s_m"])
        i = min(max(bisect.bisect_right(at[key], s) - 1, 0), len(lines[key]) - 2)
        a, b = lines[key][i], lines[key][i + 1]
        length = math.dist(a, b)
        tangent = (b[0] - a[0]) / length, (b[1] - a[1]) / length
        p = a[0] + tangent[0] * (s - at[key][i]), a[1] + tangent[1] * (s - at[key][i])
        across = float(place["north_m"]) * tangent[0] - float(place["east_m"]) * tangent[1]
        moved = p[0] - across * tangent[1], p[1] + across * tangent[0]
        errors.append((true.distance(p), true.distance(moved), float(place["sigma_m"])))
    return [e for e in errors if e[0] < math.inf and e[1] < math.inf]


EMPTY = {"places": {}, "roads": {}, "labels": {}, "speed": {}, "commits": {}}


class Measuring:
    def __init__(self, args):
        self.args, self.tool, self.out = args, Tool(args.tool), args.out
        self.numbers = EMPTY | read_results(STORE, EMPTY)

    def keep(self, part):
        self.numbers["commits"][part] = commit()
        write_results(STORE, self.numbers)

    def labels(self):
        """Labels of held-out data."""
        self.tool.synth(ROOT / "out/synth/village-99", *SITES["village-99"])
        render_painted()
        self.numbers["labels"] = self.tool.json("train", ROOT / "models/regions.toml", "--measure", self.args.eye)
        self.keep("labels")

    def speed(self):
        village = self.tool.synth(ROOT / "out/synth/village-99", *SITES["village-99"])
        for name, photo, osm in (
            ("Pardubice, 0.5 m", DATA / "pardubice/ortho.tif", DATA / "pardubice/roads.osm"),
            ("village-99, 0.2 m", village / "ortho.tif", village / "roads.osm"),
        ):
            megapixels = math.prod(json.loads(run_program("gdalinfo", "-json", photo))["size"]) / 1e6
            for variant, words in {
                "photo alone": [],
                "with the map": ["--osm", osm, "--alignment", self.out / "alignment.csv"],
            }.items():
                seconds, gigabytes = timed(
                    self.tool, "segment", photo, "--model", self.args.eye, "-o", self.out / "labels.tif", *words
                )
                self.numbers["speed"].setdefault(name, {})[variant] = {
                    "megapixels": megapixels,
                    "seconds": seconds,
                    "megabytes": 1000 * gigabytes,
                }
        self.keep("speed")

    def roads(self, name, photo, osm, truth, *more):
        folder = self.out / name.replace(" ", "_")
        folder.mkdir(parents=True, exist_ok=True)
        alignment, none = folder / "alignment.csv", folder / "none.gpkg"
        files = {
            seen: (folder / f"labels{tail}.tif", folder / f"road_probability{tail}.tif")
            for seen, tail in ((False, ""), (True, "_with_map"))
        }
        for seen, (labels, probability) in files.items():
            self.tool(
                "segment",
                photo,
                "--model",
                self.args.eye,
                "-o",
                labels,
                "--road-probability",
                probability,
                *(["--osm", osm, "--alignment", alignment] if seen else []),
            )
        self.tool("refine", "--osm", osm, "--labels", files[False][0], "-o", none, "--method", "none")
        self.numbers["roads"][name] = {}
        for variant, (seen, aligned) in VARIANTS.items():
            file = folder / f"{variant.replace(' ', '_')}.gpkg"
            labels, probability = files[seen]
            self.tool(
                "refine",
                "--osm",
                osm,
                "--labels",
                labels,
                "--road-probability",
                probability,
                "-o",
                file,
                *(["--alignment", alignment] if aligned else []),
            )
            scores = self.tool.json("evaluate", "roads", file, truth or none, "--before", none, *more, "--json")
            self.numbers["roads"][name][variant] = scores
            print(
                name,
                variant,
                fixed(scores["surface_iou"], 3),
                fixed(scores["offset_m"]["mean_abs"], 3),
                fixed(scores["width_m"]["mean_abs"], 3),
                flush=True,
            )
        self.keep(name)
        return alignment, none

    def site(self, name):
        site = self.tool.synth(ROOT / "out/synth" / name, *SITES[name])
        alignment, none = self.roads(name, site / "ortho.tif", site / "roads.osm", site / "truth")
        before, after, sigma = zip(*place_errors(alignment, none, site / "truth/roads.gpkg"), strict=True)
        count = len(before)
        self.numbers["places"][name] = {
            "places": count,
            "before_m": sum(before) / count,
            "after_m": sum(after) / count,
            "after_p95_m": sorted(after)[int(0.95 * count)],
            "sigma_m": sorted(sigma)[count // 2],
            "within_sigma": sum(a <= s for a, s in zip(after, sigma, strict=True)) / count,
        }
        self.keep(name)

    def town(self, name):
        folder = self.out / name
        folder.mkdir(parents=True, exist_ok=True)
        drawn = refine.drawn_truth(name, folder)
        osm, moved = DATA / name / "roads.osm", folder / "disturbed.osm"
        refine.disturb(osm, moved)
        _, none = self.roads(
            f"{name} drawn",
            refine.PHOTOS[name],
            osm,
            drawn[""],
            "--area",
            drawn["_area"],
            "--ignore",
            drawn["_unmapped"],
        )
        self.roads(f"{name} disturbed", refine.PHOTOS[name], moved, none)
        shift(osm, moved, SHIFT_M)
        self.roads(
            f"{name} map {SHIFT_M} m off",
            refine.PHOTOS[name],
            moved,
            drawn[""],
            "--area",
            drawn["_area"],
            "--ignore",
            drawn["_unmapped"],
        )


def label_rows(scores):
    """A row a set: road IoU of the photo alone and with the map; what is stated of pixels labelled road, and what is
    right.
    """
    text = header(["road IoU, %", "photo alone", "with the map", "stated of road with the map, %", "right, %"])
    suffix = " with map"
    for name, alone in scores.items():
        if name.endswith(suffix) or name + suffix not in scores:
            continue
        seen = scores[name + suffix]
        text += row(
            [
                name,
                percent(alone["road_iou"]),
                percent(seen["road_iou"]),
                percent(seen["road_stated"]),
                percent(seen["road_right"]),
            ]
        )
    return text


def table(numbers):
    text = label_rows(numbers["labels"])
    text += "\n" + header(["segment", "photo", "s", "Mpx/s", "MB"])
    for name, variants in numbers["speed"].items():
        for variant, s in variants.items():
            text += row(
                [
                    variant,
                    f"{name}, {s['megapixels']:.0f} Mpx",
                    fixed(s["seconds"], 1),
                    fixed(s["megapixels"] / s["seconds"]),
                    fixed(s["megabytes"], 0),
                ]
            )
    return text + "\n" + place_rows(numbers["places"]) + "\n" + road_rows(numbers["roads"])


def place_rows(places):
    text = header(
        [
            "map's roads on synthetic sites",
            "places",
            "off the truth before, m",
            "after, m",
            "p95, m",
            "stated sigma, m",
            "within it, %",
        ]
    )
    for name, p in places.items():
        text += row(
            [
                name,
                p["places"],
                fixed(p["before_m"]),
                fixed(p["after_m"]),
                fixed(p["after_p95_m"]),
                fixed(p["sigma_m"]),
                percent(p["within_sigma"]),
            ]
        )
    return text


def road_rows(roads):
    text = header(
        [
            "refined roads",
            "evidence",
            "surface IoU",
            "of known ways",
            "offset, m",
            "p95, m",
            "width error, m",
            "within sigma, %",
            "moved away, %",
        ]
    )
    for name, variants in roads.items():
        for variant, s in variants.items():
            away = (s.get("moved_away") or {}).get("share_by_more_than_0_3_m")
            text += row(
                [
                    name,
                    variant,
                    fixed(s["surface_iou"], 3),
                    fixed(s.get("surface_iou_of_known_ways"), 3),
                    fixed(s["offset_m"]["mean_abs"]),
                    fixed(s["offset_m"]["p95"]),
                    fixed(s["width_m"]["mean_abs"]),
                    percent(s["sigma_coverage"]["1"]),
                    percent(away),
                ]
            )
    return text


def run(args):
    if not args.table:
        measuring = Measuring(args)
        measuring.out.mkdir(parents=True, exist_ok=True)
        if "labels" in args.only:
            measuring.labels()
        if "speed" in args.only:
            measuring.speed()
        for name in SITES:
            if name in args.only:
                measuring.site(name)
        for name in TOWNS:
            if name in args.only:
                measuring.town(name)
    write_page(PAGE, [STORE], {"second_eye": table(EMPTY | read_results(STORE, EMPTY))})
