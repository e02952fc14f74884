# SPDX-License-Identifier: Apache-2.0
"""Widths of wide and narrow roads against surfaces drawn by hand. Writes docs/measured/road_surface.md.

Motorway-like carriageways, roundabout rings, service ways and tracks by the widths in roads.gpkg; gores by the lanes
and junction areas of the network, all roads across them together, for a gore belongs to two, where a section leaves the
drawn piece by its long sides. Every piece is measured on the photo and the map 140 m around it, which takes two minutes
in all. `--as before` keeps the numbers of another build (--tool) to compare with.
"""

import bisect
import itertools
import json
import math
import xml.etree.ElementTree as ElementTree

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
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "road_surface.json", PAGES / "road_surface.md"
KINDS = ["motorway", "ring", "gore", "service", "track"]
TRUTH = ROOT / "models/truth/surfaces.geojson"
STEP_M, ACROSS_STEP_M, ACROSS_M = 2.0, 0.05, 20.0
CROP_M = 140.0  # around a piece; the shift of the map is estimated from the roads there


def add_arguments(parser):
    add_tool(parser, "out/wide_roads")
    add_only(parser, refine.PHOTOS)
    add_table(parser)


# ---- gores, by lanes


def metres_from(lon0, lat0):
    """East and north of a place near (lon0, lat0); a sphere is good to a thousandth over some hundred metres."""
    north = 111132.95 - 559.85 * math.cos(2 * math.radians(lat0))
    east = 111412.88 * math.cos(math.radians(lat0)) - 93.5 * math.cos(3 * math.radians(lat0))
    return lambda p: ((p[0] - lon0) * east, (p[1] - lat0) * north)


def contains(ring, p):
    inside = False
    for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1], strict=True):
        if (y0 > p[1]) != (y1 > p[1]) and p[0] < x0 + (p[1] - y0) * (x1 - x0) / (y1 - y0):
            inside = not inside
    return inside


def places_along(line):
    """(point, unit vector across) every STEP_M of a line."""
    s = [0.0]
    for a, b in itertools.pairwise(line):
        s.append(s[-1] + math.dist(a, b))
    for k in range(int(s[-1] / STEP_M) + 1):
        i = min(len(line) - 2, max(0, bisect.bisect_right(s, k * STEP_M) - 1))
        a, b = line[i], line[i + 1]
        share = (k * STEP_M - s[i]) / (s[i + 1] - s[i])
        length = math.dist(a, b)
        yield (
            (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])),
            ((a[1] - b[1]) / length, (b[0] - a[0]) / length),
        )


def reach_across(rings, p, across, side):
    """How far the area that contains p goes to one side without a gap of over a decimetre; 0 outside."""
    gap, reach = 0, 0.0
    for k in range(int(ACROSS_M / ACROSS_STEP_M)):
        t = side * (k + 0.5) * ACROSS_STEP_M
        gap = 0 if any(contains(ring, (p[0] + t * across[0], p[1] + t * across[1])) for ring in rings) else gap + 1
        if gap > 2:
            break
        reach += ACROSS_STEP_M if gap == 0 else 0.0
    return reach


def distance_to(edge, p):
    (ax, ay), (bx, by) = edge
    share = ((p[0] - ax) * (bx - ax) + (p[1] - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
    share = min(1.0, max(0.0, share))
    return math.dist(p, (ax + share * (bx - ax), ay + share * (by - ay)))


def true_width(ring, line, p, across):
    """Of a drawn piece across its middle line at p; None where the section leaves the piece by one of its two ends."""
    edges = list(zip(ring, ring[1:] + ring[:1], strict=True))
    edges = [e for e in edges if e[0] != e[1]]
    ends = [min(edges, key=lambda e: distance_to(e, q)) for q in (line[0], line[-1])]
    width = 0.0
    for side in (1, -1):
        reach = reach_across([ring], p, across, side)
        leaves = (p[0] + side * reach * across[0], p[1] + side * reach * across[1])
        if min(edges, key=lambda e: distance_to(e, leaves)) in ends:
            return None
        width += reach
    return width


def gore_errors(truth, paved):
    """Error of the width of all carriageways at places on the gores' middle lines, m. `paved`: polygons, outer rings
    first.
    """
    errors = []
    surfaces = {
        f["properties"]["id"]: f["geometry"]["coordinates"] for f in truth if f["geometry"]["type"] == "Polygon"
    }
    for f in truth:
        if f["geometry"]["type"] != "LineString" or f["properties"]["kind"] != "gore":
            continue
        line = f["geometry"]["coordinates"]
        to_m = metres_from(*line[0])

        def is_near(ring):
            return any(abs(x) < 80 and abs(y) < 80 for x, y in ring)

        ours = [ring for polygon in paved if is_near(ring := [to_m(p) for p in polygon[0]])]
        drawn = [to_m(p) for p in surfaces[f["properties"]["of"]][0]]
        middle = [to_m(q) for q in line]
        for p, across in places_along(middle):
            true_m = true_width(drawn, middle, p, across)
            if true_m is not None:
                errors.append(reach_across(ours, p, across, 1) + reach_across(ours, p, across, -1) - true_m)
    return errors


# ---- measuring


def summary_of(errors):
    return (
        {"n": len(errors), "bias": sum(errors) / len(errors), "mean_abs": sum(map(abs, errors)) / len(errors)}
        if errors
        else None
    )


def cut_photo(name, line, file):
    """The photo around a piece, CROP_M to each side. Photos are in degrees."""
    if file.exists():
        return
    to_m = metres_from(*line[0])
    east, north = (1 / to_m((line[0][0] + 1, line[0][1]))[0], 1 / to_m((line[0][0], line[0][1] + 1))[1])
    lon, lat = zip(*line, strict=True)
    run_program(
        "gdal_translate",
        "-q",
        "-projwin",
        min(lon) - CROP_M * east,
        max(lat) + CROP_M * north,
        max(lon) + CROP_M * east,
        min(lat) - CROP_M * north,
        refine.PHOTOS[name],
        file,
    )


def cut_map(name, line, file):
    """Whole ways with a node within CROP_M of a piece, and their nodes."""
    to_m = metres_from(*line[0])
    points = [to_m(p) for p in line]
    root = ElementTree.parse(DATA / name / "roads.osm").getroot()
    places = {n.get("id"): to_m((float(n.get("lon")), float(n.get("lat")))) for n in root.iter("node")}
    near = {i for i, p in places.items() if any(math.dist(p, q) < CROP_M for q in points)}
    ways = [w for w in root.iter("way") if any(nd.get("ref") in near for nd in w.iter("nd"))]
    used = {nd.get("ref") for w in ways for nd in w.iter("nd")}
    kept = ElementTree.Element("osm", root.attrib)
    kept.extend([n for n in root.iter("node") if n.get("id") in used])
    kept.extend(ways)
    ElementTree.ElementTree(kept).write(file)


def measure_piece(args, name, identifier, features):
    """Error sums of one piece. Labels and roads are made of the photo and the map around it alone."""
    tool, folder = Tool(args.tool), args.out / identifier
    folder.mkdir(parents=True, exist_ok=True)
    photo, osm, truth, roads, network, layers = (
        folder / f for f in ("photo.tif", "roads.osm", "truth.geojson", "now.gpkg", "now.xodr", "now.geojson")
    )
    line = next(f for f in features if f["geometry"]["type"] == "LineString")["geometry"]["coordinates"]
    cut_photo(name, line, photo)
    cut_map(name, line, osm)
    labels, probability, alignment = folder / "labels.tif", folder / "road_probability.tif", folder / "alignment.csv"
    tool("segment", photo, "--osm", osm, "-o", labels, "--road-probability", probability, "--alignment", alignment)
    tool(
        "refine",
        "--osm",
        osm,
        "--labels",
        labels,
        "--road-probability",
        probability,
        "--alignment",
        alignment,
        "-o",
        roads,
    )
    if features[0]["properties"]["kind"] == "gore":
        tool("network", "--roads", roads, "-o", network, "--geojson", layers)
        paved = [
            f["geometry"]["coordinates"]
            for f in json.loads(layers.read_text())["features"]
            if f["properties"]["layer_name"] == "junctions"
            or (f["properties"]["layer_name"] == "lanes" and f["properties"]["type"] != "sidewalk")
        ]
        return summary_of(gore_errors(features, paved))
    truth.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    width = tool.json("evaluate", "roads", roads, truth, "--json")["width_m"]
    return {"n": width["n"], "bias": width["bias"], "mean_abs": width["mean_abs"]}


def measure_town(args, name):
    """Errors by kind and piece."""
    by_piece, found = {}, {}
    for f in json.loads(TRUTH.read_text())["features"]:
        if f["properties"]["town"] == name:
            by_piece.setdefault(f["properties"].get("id") or f["properties"]["of"], []).append(f)
    for identifier, features in by_piece.items():
        errors = found.setdefault(features[0]["properties"]["kind"], {})[identifier] = measure_piece(
            args, name, identifier, features
        )
        print(identifier, errors, flush=True)
    return found


def mean_of(pieces):
    """Every piece counts once."""
    pieces = [p for p in pieces if p and p["n"]]
    if not pieces:
        return None
    return {"pieces": len(pieces), **{key: sum(p[key] for p in pieces) / len(pieces) for key in ("bias", "mean_abs")}}


def table(numbers):
    def said(m):
        return "-" if not m or not m.get("n", m.get("pieces")) else f"{fixed(m['bias'])} / {fixed(m['mean_abs'])}"

    text = header(["kind", "pieces", "bias / mean error of the width, m"])
    for kind in KINDS:
        mean = mean_of([piece for town in numbers["towns"].values() for piece in town.get(kind, {}).values()])
        text += row([kind, mean["pieces"] if mean else 0, said(mean)])
    text += "\n" + header(["piece", "kind", "bias / mean error, m"])
    for town in numbers["towns"].values():
        text += "".join(
            row([piece, kind, said(town[kind][piece])]) for kind in KINDS for piece in sorted(town.get(kind, {}))
        )
    return text + "\nMeans are over the pieces, each once.\n"


def run(args):
    numbers = read_results(STORE, {"towns": {}, "commits": {}})
    if not args.table:
        for name in refine.PHOTOS:
            if name in args.only:
                numbers["towns"][name] = measure_town(args, name)
                numbers["commits"][name] = commit()
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"road_surface": table(numbers)})
