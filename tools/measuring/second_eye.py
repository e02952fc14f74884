"""What a network that sees the map adds: alignment of the map's roads, refined roads. Writes docs/measured/second_eye.md.

    tools/measure second_eye --eye out/second_eye/model.safetensors

Some six minutes on two cores. What is not measured in this run keeps its last values from bench/results/second_eye.json. Needs
../shared/data; makes the synthetic sites.
"""
import csv

import numpy

from measuring import refine
from measuring.common import *

STORE, PAGE = "second_eye.json", PAGES / "second_eye.md"
SITES = {"village-99": ["--preset", "village", "--seed", 99], "circuit-7": ["--preset", "circuit"], "junction-7": ["--preset", "junction"]}
TOWNS = ["kvarnbyn", "pardubice"]
SHIFT_M = 50  # of a map that lies wrong altogether
VARIANTS = {"without": False, "with": True}  # the alignment


def add_arguments(parser):
    add_tool(parser, "out/second_eye_measured")
    add_only(parser, [*SITES, *TOWNS])
    add_table(parser)
    parser.add_argument("--eye", type=pathlib.Path, default=ROOT / "models/second_eye.safetensors", help="a model that sees the map")


def shift(source, target, metres):
    """OSM moved to the east as a whole."""
    text = source.read_text()
    latitude = float(re.search(r'<node [^>]*lat="([-\d.]+)"', text)[1])
    east = metres / (111320 * math.cos(math.radians(latitude)))
    target.write_text(re.sub(r'lon="([-\d.]+)"', lambda match: f'lon="{float(match[1]) + east:.8f}"', text))


def nodes_of(file):
    """Of each path its nodes, as an array of x, y."""
    lines = {}
    for osm_id, part, blob in sqlite3.connect(file).execute("select osm_id, part, geom from nodes order by osm_id, part, s_m"):
        lines.setdefault((osm_id, part), []).append(point_of(blob))
    return {key: numpy.array(points) for key, points in lines.items()}


def place_errors(alignment, osm, truth):
    """Of every place: how far its line is from the nearest true centre line, before and after, m; and the sigma stated."""
    segments = numpy.concatenate([numpy.hstack([p[:-1], p[1:]]) for p in nodes_of(truth).values()])
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    square = numpy.maximum((along * along).sum(1), 1e-12)

    def distance(p):
        t = numpy.clip(((p - start) * along).sum(1) / square, 0, 1)
        return numpy.hypot(*(start + along * t[:, None] - p).T).min()

    lines, errors = nodes_of(osm), []
    for place in csv.DictReader(alignment.open()):
        line = lines[int(place["osm_id"]), int(place["part"])]
        at = numpy.concatenate([[0], numpy.cumsum(numpy.hypot(*numpy.diff(line, axis=0).T))])
        s = float(place["s_m"])
        i = min(max(int(numpy.searchsorted(at, s)) - 1, 0), len(line) - 2)
        p = numpy.array([numpy.interp(s, at, line[:, 0]), numpy.interp(s, at, line[:, 1])])
        tangent = (line[i + 1] - line[i]) / numpy.hypot(*(line[i + 1] - line[i]))
        normal = numpy.array([-tangent[1], tangent[0]])
        moved = p + normal * (float(place["east_m"]) * normal[0] + float(place["north_m"]) * normal[1])
        errors.append((distance(p), distance(moved), float(place["sigma_m"])))
    return numpy.array(errors)


class Measuring:
    def __init__(self, args):
        self.args, self.tool, self.out = args, Tool(args.tool), args.out
        self.numbers = read_results(STORE, {"places": {}, "roads": {}})
        self.numbers["commit"] = commit()

    def keep(self):
        write_results(STORE, self.numbers)

    def roads(self, name, photo, osm, truth, *more):
        folder = self.out / name.replace(" ", "_")
        folder.mkdir(parents=True, exist_ok=True)
        labels, probability, alignment, none = (folder / f for f in ("labels.tif", "road_probability.tif", "alignment.csv", "none.gpkg"))
        self.tool("segment", photo, "--model", self.args.eye, "-o", labels, "--road-probability", probability, "--osm", osm, "--alignment", alignment)
        self.tool("refine", "--osm", osm, "--labels", labels, "-o", none, "--method", "none")
        for variant, aligned in VARIANTS.items():
            file = folder / f"{variant}.gpkg"
            self.tool("refine", "--osm", osm, "--labels", labels, "--road-probability", probability, "-o", file, *(["--alignment", alignment] if aligned else []))
            scores = self.tool.json("evaluate", "roads", file, truth or none, "--before", none, *more, "--json")
            self.numbers["roads"].setdefault(name, {})[variant] = scores
            print(name, variant, fixed(scores["surface_iou"], 3), fixed(scores["offset_m"]["mean_abs"], 3), fixed(scores["width_m"]["mean_abs"], 3), flush=True)
        self.keep()
        return alignment, none

    def site(self, name):
        site = self.tool.synth(ROOT / "out/synth" / name, *SITES[name])
        alignment, none = self.roads(name, site / "ortho.tif", site / "roads.osm", site / "truth")
        before, after, sigma = place_errors(alignment, none, site / "truth/roads.gpkg").T
        self.numbers["places"][name] = {"places": len(before), "before_m": before.mean(), "after_m": after.mean(), "after_p95_m": numpy.percentile(after, 95),
                                        "sigma_m": float(numpy.median(sigma)), "within_sigma": float((after <= sigma).mean())}
        self.keep()

    def town(self, name):
        folder = self.out / name
        folder.mkdir(parents=True, exist_ok=True)
        drawn = refine.drawn_truth(name, folder)
        osm, moved = DATA / name / "roads.osm", folder / "disturbed.osm"
        refine.disturb(osm, moved)
        _, none = self.roads(f"{name} drawn", refine.PHOTOS[name], osm, drawn[""], "--area", drawn["_area"], "--ignore", drawn["_unmapped"])
        self.roads(f"{name} disturbed", refine.PHOTOS[name], moved, none)
        shift(osm, moved, SHIFT_M)
        self.roads(f"{name} map {SHIFT_M} m off", refine.PHOTOS[name], moved, drawn[""], "--area", drawn["_area"], "--ignore", drawn["_unmapped"])


def table(numbers):
    text = header(["map's roads on synthetic sites", "places", "off the truth before, m", "after, m", "p95, m", "stated sigma, m", "within it, %"])
    for name, p in numbers["places"].items():
        text += row([name, p["places"], fixed(p["before_m"]), fixed(p["after_m"]), fixed(p["after_p95_m"]), fixed(p["sigma_m"]), percent(p["within_sigma"])])
    text += "\n" + header(["refined roads", "alignment", "surface IoU", "offset, m", "p95, m", "width error, m", "within sigma, %", "moved away, %"])
    for name, variants in numbers["roads"].items():
        for variant, s in variants.items():
            away = (s.get("moved_away") or {}).get("share_by_more_than_0_3_m")
            text += row([name, variant, fixed(s["surface_iou"], 3), fixed(s["offset_m"]["mean_abs"]), fixed(s["offset_m"]["p95"]), fixed(s["width_m"]["mean_abs"]),
                         percent(s["sigma_coverage"]["1"]), percent(away)])
    return text


def run(args):
    if not args.table:
        measuring = Measuring(args)
        for name in SITES:
            if name in args.only:
                measuring.site(name)
        for name in TOWNS:
            if name in args.only:
                measuring.town(name)
    write_between(PAGE, "second_eye", table(read_results(STORE, {"places": {}, "roads": {}})))
