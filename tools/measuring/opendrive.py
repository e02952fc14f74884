# SPDX-License-Identifier: Apache-2.0
"""OpenDRIVE files: bytes and elements by kind. Writes a part of docs/measured/network.md.

Give files as NAME=FILE, for example  --files kvarnbyn=out/kvarnbyn/roads.xodr pardubice=out/pardubice/roads.xodr
"""

import collections
import pathlib
import re

from measuring.common import PAGES, add_table, commit, fixed, header, read_results, row, write_page, write_results
from measuring.network import STORES

STORE, PAGE = "opendrive.json", PAGES / "network.md"
KINDS = {
    "crowns": ["shape"],
    "superelevation": ["superelevation", "lateralProfile"],
    "heights": ["elevation", "elevationProfile"],
    "reference lines": ["geometry", "line", "arc", "spiral", "paramPoly3", "planView"],
    "widths, lane offsets": ["width", "laneOffset"],
    "markings": ["roadMark"],
    "speeds": ["speed", "type"],
    "links": ["link", "predecessor", "successor"],
    "junctions": ["junction", "connection", "laneLink", "priority"],
    "materials": ["material"],
    "our own data": ["userData"],
}


def add_arguments(parser):
    add_table(parser)
    parser.add_argument(
        "--files", nargs="+", default=[], metavar="NAME=FILE", help="networks; the others keep their last values"
    )


def bytes_by_kind(file):
    """Tags with the white space after them, {"crowns": [elements, bytes]}."""
    kind_of = {tag: kind for kind, tags in KINDS.items() for tag in tags}
    elements, size = collections.Counter(), collections.Counter()
    for tag in re.finditer(r"<(/?)(\??\w+)[^>]*>\s*", file.read_text(encoding="utf-8")):
        kind = kind_of.get(tag[2], "others")
        elements[kind] += not tag[1]
        size[kind] += len(tag[0].encode())
    return {kind: [elements[kind], size[kind]] for kind in [*KINDS, "others"]}


def table(numbers):
    text = header(["", *(f"{site.capitalize()}: {what}" for site in numbers for what in ("MB", "elements"))])
    for kind in [*KINDS, "others"]:
        cells = [(fixed(n["kinds"][kind][1] / 1e6), n["kinds"][kind][0]) for n in numbers.values()]
        text += row([kind, *(cell for pair in cells for cell in pair)])
    text += row(["**file**", *(cell for n in numbers.values() for cell in (f"**{fixed(n['bytes'] / 1e6)}**", ""))])
    return text + "\nAsked: 30 MB for Pardubice, a town of 23 km2.\n"


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for pair in args.files:
            name, file = pair.split("=", 1)
            file = pathlib.Path(file)
            numbers[name] = {"commit": commit(), "kinds": bytes_by_kind(file), "bytes": file.stat().st_size}
            write_results(STORE, numbers)
    write_page(PAGE, STORES, {"opendrive": table(numbers)})
