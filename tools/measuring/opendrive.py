# SPDX-License-Identifier: Apache-2.0
"""OpenDRIVE files of two versions: bytes by kind of element, entries, and how far their surfaces lie apart. Writes a part of docs/measured/network.md.

    tools/measure opendrive pardubice before.xodr after.xodr

Heights are compared on every road of both files at its ends and every metre between, at nine places across.
"""
import bisect
import collections
import math
import re
import xml.etree.ElementTree as xml

from measuring.common import *

STORE, PAGE = "opendrive.json", PAGES / "network.md"
PLACES = 8
KINDS = {"crowns": ["shape"], "superelevation": ["superelevation", "lateralProfile"], "heights": ["elevation", "elevationProfile"],
         "reference lines": ["geometry", "line", "arc", "spiral", "paramPoly3", "planView"], "widths, lane offsets": ["width", "laneOffset"],
         "markings": ["roadMark"], "speeds": ["speed", "type"], "links": ["link", "predecessor", "successor"],
         "junctions": ["junction", "connection", "laneLink", "priority"], "materials": ["material"], "our own data": ["userData"]}


def add_arguments(parser):
    parser.add_argument("site", nargs="?", help="its name in the table")
    parser.add_argument("before", nargs="?", type=pathlib.Path)
    parser.add_argument("after", nargs="?", type=pathlib.Path)
    add_table(parser)


def bytes_by_kind(file):
    """Tags with the white space after them, {"crowns": [elements, bytes]}."""
    kind_of = {tag: kind for kind, tags in KINDS.items() for tag in tags}
    elements, size = collections.Counter(), collections.Counter()
    for tag in re.finditer(r"<(/?)(\??\w+)[^>]*>\s*", file.read_text(encoding="utf-8")):
        kind = kind_of.get(tag[2], "others")
        elements[kind] += not tag[1]
        size[kind] += len(tag[0].encode())
    return {kind: [elements[kind], size[kind]] for kind in [*KINDS, "others"]}


class Pieces:
    """Cubics of s, each from its start."""

    def __init__(self, nodes, s="s"):
        self.rows = [[float(node.get(name)) for name in (s, *"abcd")] for node in nodes]
        self.starts = [row[0] for row in self.rows]

    def __call__(self, s):
        k = bisect.bisect_right(self.starts, s) - 1
        if k < 0:
            return 0.0
        start, a, b, c, d = self.rows[k]
        ds = s - start
        return a + ds * (b + ds * (c + ds * d))


class Surface:
    """Heights and edges of a road over s and t; one lane section, as our files have."""

    def __init__(self, road):
        self.length = float(road.get("length"))
        self.z = Pieces(road.findall("elevationProfile/elevation"))
        self.banking = Pieces(road.findall("lateralProfile/superelevation"))
        self.offset = Pieces(road.findall("lanes/laneOffset"))
        self.sides = [[Pieces(lane.findall("width"), "sOffset") for lane in road.findall(f"lanes/laneSection/{side}/lane")] for side in ("left", "right")]
        shapes = collections.defaultdict(list)
        for node in road.findall("lateralProfile/shape"):
            shapes[float(node.get("s"))].append([float(node.get(name)) for name in "tabcd"])
        self.shapes = sorted(shapes.items())

    def edges(self, s):
        middle = self.offset(s)
        return middle - sum(width(s) for width in self.sides[1]), middle + sum(width(s) for width in self.sides[0])

    def shape(self, s, t):
        if not self.shapes:
            return 0.0
        k = bisect.bisect_right(self.shapes, s, key=lambda shape: shape[0]) - 1
        if k < 0:
            return 0.0

        def at(cubics):
            start, a, b, c, d = next((cubic for cubic in reversed(cubics) if cubic[0] <= t), cubics[0])
            dt = t - start
            return a + dt * (b + dt * (c + dt * d))

        here = at(self.shapes[k][1])
        if k + 1 == len(self.shapes):
            return here
        (s0, _), (s1, after) = self.shapes[k:k + 2]
        return here + (at(after) - here) * (s - s0) / (s1 - s0)

    def height(self, s, t):
        banking = self.banking(s)
        return self.z(s) + t * math.sin(banking) + self.shape(s, t) * math.cos(banking)


def largest_difference(before, after):
    """Metres, the points compared, and the roads that only one file has or that are of another length."""
    surfaces = [{node.get("id"): Surface(node) for node in xml.parse(file).getroot().findall("road")} for file in (before, after)]
    worst, points = 0.0, 0
    missing = len(surfaces[0].keys() ^ surfaces[1].keys())
    for name in surfaces[0].keys() & surfaces[1].keys():
        a, b = surfaces[0][name], surfaces[1][name]
        if abs(a.length - b.length) > 1e-3:
            missing += 1
            continue
        steps = max(1, math.ceil(a.length))
        for i in range(steps + 1):
            s = a.length * i / steps
            right, left = a.edges(s)
            for k in range(PLACES + 1):
                t = right + (left - right) * k / PLACES
                worst = max(worst, abs(a.height(s, t) - b.height(s, t)))
            points += PLACES + 1
    return worst, points, missing


def measure(before, after):
    worst, points, missing = largest_difference(before, after)
    return {"commit": commit(), "before": bytes_by_kind(before), "after": bytes_by_kind(after), "bytes": [before.stat().st_size, after.stat().st_size],
            "max_dz_m": worst, "points": points, "missing_roads": missing}


def table(numbers):
    mb = lambda value: fixed(value / 1e6, 2)
    text = header(["", *(f"{site.capitalize()}: {what}" for site in numbers for what in ("before, MB", "now, MB", "elements before", "now"))])
    for kind in [*KINDS, "others"]:
        cells = [kind]
        for n in numbers.values():
            (count_a, size_a), (count_b, size_b) = n["before"][kind], n["after"][kind]
            cells += [mb(size_a), mb(size_b), count_a, count_b]
        text += row(cells)
    text += row(["**file**", *(cell for n in numbers.values() for cell in (f"**{mb(n['bytes'][0])}**", f"**{mb(n['bytes'][1])}**", "", ""))])
    return text + row(["largest difference of height, mm", *(cell for n in numbers.values() for cell in ("", fixed(1000 * n["max_dz_m"], 2), "", f"{n['points']} points"))])


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        if not args.after:
            sys.exit("tools/measure opendrive SITE BEFORE.xodr AFTER.xodr, or --table")
        numbers[args.site] = measure(args.before, args.after)
        write_results(STORE, numbers)
    write_between(PAGE, "opendrive", table(numbers))
