# SPDX-License-Identifier: Apache-2.0
"""What a network gains that adapts to a site, and what that costs. Writes docs/measured/adapt.md.

    tools/measure adapt --model out/without_town/model.safetensors --only kvarnbyn      a model that has not seen the
                                                                                        town

Some forty minutes on two cores. What is not measured in this run keeps its last values from bench/results/adapt.json.
Needs ../shared/data for the towns; makes the synthetic sites.
"""

import os
import pathlib
import subprocess
import sys
import time

import numpy

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
    read_results,
    row,
    write_page,
    write_results,
)
from measuring.learning import second_eye

STORE, PAGE = "adapt.json", PAGES / "adapt.md"
VILLAGE = ["--preset", "village", "--seed", 99, "--size", 1000, "--gsd", 0.5]
OTHER = ["--preset", "village", "--seed", 98, "--size", 1000, "--gsd", 0.5]
SHIFT_M = 50
LOOKS = {  # of a photo whose values are 0 to 1
    "as made": lambda rgb: rgb,
    "grey": lambda rgb: numpy.repeat(rgb.mean(0, keepdims=True), 3, 0),
    "dusk": lambda rgb: rgb**1.6 * numpy.array([0.75, 0.7, 1.0])[:, None, None],
    "haze": lambda rgb: 0.4 * rgb + numpy.array([0.42, 0.45, 0.5])[:, None, None],
    "turned hue": lambda rgb: rgb[[1, 2, 0]],
}
WRONG_MAPS = {f"map {SHIFT_M} m off": "shifted", "map of another village": "other"}
TOWNS = ["kvarnbyn", "pardubice"]
VARIANTS = {"without": [], "with": ["--adapt"]}


def add_arguments(parser):
    add_tool(parser, "out/adapt_measured")
    add_only(parser, ["village", *TOWNS])
    add_table(parser)
    parser.add_argument(
        "--model", type=pathlib.Path, default=ROOT / "models/default.safetensors", help="the model that adapts"
    )


def recolour(source, target, look):
    from osgeo import gdal  # noqa: PLC0415 (Debian's python3-gdal; --table does without)

    photo = gdal.Open(str(source))
    rgb = numpy.clip(LOOKS[look](photo.ReadAsArray()[:3] / 255.0), 0, 1)
    made = gdal.GetDriverByName("GTiff").Create(
        str(target), photo.RasterXSize, photo.RasterYSize, 3, gdal.GDT_Byte, ["COMPRESS=DEFLATE"]
    )
    made.SetGeoTransform(photo.GetGeoTransform())
    made.SetProjection(photo.GetProjection())
    for band in range(3):
        made.GetRasterBand(band + 1).WriteArray((255 * rgb[band] + 0.5).astype(numpy.uint8))


class Measuring:
    def __init__(self, args):
        self.args, self.tool, self.out = args, Tool(args.tool), args.out
        self.numbers = {"commits": {}} | read_results(STORE, {"rows": {}})
        self.out.mkdir(parents=True, exist_ok=True)

    def labels(self, folder, variant, photo, osm, maps):
        """Labels, probability of road, seconds, peak memory in GB, and what became of the adaptation."""
        labels, probability = folder / f"labels_{variant}.tif", folder / f"probability_{variant}.tif"
        adapt = [*VARIANTS[variant], *maps] if VARIANTS[variant] else []
        words = [
            "segment",
            photo,
            "--model",
            self.args.model,
            "--osm",
            osm,
            "-o",
            labels,
            "--road-probability",
            probability,
            *adapt,
        ]
        said = folder / "said.txt"
        start = time.monotonic()
        with said.open("w") as stderr:
            pid = subprocess.Popen([str(self.tool.file), *map(str, words)], stderr=stderr).pid
            _, status, usage = os.wait4(pid, 0)
        if status != 0:
            sys.exit(said.read_text())
        became = "-" if not adapt else "kept" if "the network adapted to the site" in said.read_text() else "dropped"
        return {"labels": labels, "probability": probability}, {
            "seconds": time.monotonic() - start,
            "gb": usage.ru_maxrss * 1024 / 1e9,
            "became": became,
        }

    def measure(self, name, photo, osm, truth, true_labels=None, maps=(), more=(), map_for_roads=None):
        """Both variants. The roads that are refined are those of `map_for_roads`, else of the map that is learned
        from.
        """
        folder = self.out / name.replace(" ", "_").replace(",", "")
        folder.mkdir(parents=True, exist_ok=True)
        roads, none = map_for_roads or osm, folder / "none.gpkg"
        for variant in VARIANTS:
            files, row_ = self.labels(folder, variant, photo, osm, maps)
            self.tool("refine", "--osm", roads, "--labels", files["labels"], "-o", none, "--method", "none")
            self.tool(
                "refine",
                "--osm",
                roads,
                "--labels",
                files["labels"],
                "--road-probability",
                files["probability"],
                "-o",
                folder / f"{variant}.gpkg",
            )
            scores = self.tool.json(
                "evaluate", "roads", folder / f"{variant}.gpkg", truth or none, "--before", none, *more, "--json"
            )
            row_.update(
                {
                    "surface_iou": scores["surface_iou"],
                    "offset_m": scores["offset_m"]["mean_abs"],
                    "width_m": scores["width_m"]["mean_abs"],
                    "moved_away": (scores.get("moved_away") or {}).get("share_by_more_than_0_3_m"),
                }
            )
            if true_labels:
                of_labels = self.tool.json("evaluate", "labels", files["labels"], true_labels, "--json")
                row_.update({"road_iou": of_labels["road_iou"], "accuracy": of_labels["pixel_accuracy"]})
            self.numbers["rows"].setdefault(name, {})[variant] = row_
            print(name, variant, row_, flush=True)
        write_results(STORE, self.numbers)

    def village(self):
        site, other = self.tool.synth(self.out / "village", *VILLAGE), self.tool.synth(self.out / "other", *OTHER)
        truth, true_labels = site / "truth", site / "truth/labels.tif"
        for look in LOOKS:
            photo = site / f"{look.replace(' ', '_')}.tif"
            recolour(site / "ortho.tif", photo, look)
            self.measure(f"village, {look}", photo, site / "roads.osm", truth, true_labels)
        shifted = site / "shifted.osm"
        second_eye.shift(site / "roads.osm", shifted, SHIFT_M)
        for name, osm in zip(
            WRONG_MAPS, (shifted, other / "roads.osm"), strict=False
        ):  # the same place, so its map lies there, too
            self.measure(
                f"village, {name}", site / "dusk.tif", osm, truth, true_labels, map_for_roads=site / "roads.osm"
            )

    def town(self, name):
        folder = self.out / name
        folder.mkdir(parents=True, exist_ok=True)
        drawn, osm = refine.drawn_truth(name, folder), DATA / name / "roads.osm"
        maps = [
            "--buildings",
            DATA / name / "osm_buildings.geojson",
            "--surroundings",
            DATA / name / "osm_water.geojson",
        ]
        region = ["--area", drawn["_area"], "--ignore", drawn["_unmapped"]]
        self.measure(f"{name}, drawn", refine.PHOTOS[name], osm, drawn[""], maps=maps, more=region)
        moved = folder / "moved.osm"
        refine.disturb(osm, moved)
        none = self.out / f"{name}_drawn" / "none.gpkg"
        self.measure(f"{name}, map disturbed", refine.PHOTOS[name], moved, none, maps=maps)
        second_eye.shift(osm, moved, SHIFT_M)
        self.measure(
            f"{name}, map {SHIFT_M} m off",
            refine.PHOTOS[name],
            moved,
            drawn[""],
            maps=maps,
            more=region,
            map_for_roads=osm,
        )


def table(numbers):
    text = header(
        [
            "photo and map",
            "adapting",
            "labels: road IoU, %",
            "accuracy, %",
            "refined roads: surface IoU, %",
            "offset, m",
            "width error, m",
            "moved away, %",
            "s",
            "GB",
        ]
    )
    for name, variants in numbers["rows"].items():
        for variant, r in variants.items():
            text += row(
                [
                    name,
                    variant if r["became"] == "-" else f"{variant}: {r['became']}",
                    percent(r.get("road_iou")),
                    percent(r.get("accuracy")),
                    percent(r["surface_iou"]),
                    fixed(r["offset_m"]),
                    fixed(r["width_m"]),
                    percent(r["moved_away"]),
                    fixed(r["seconds"], 0),
                    fixed(r["gb"]),
                ]
            )
    return text


def run(args):
    if not args.table:
        measuring = Measuring(args)
        for name in args.only:
            measuring.numbers["commits"][name] = commit()
            measuring.village() if name == "village" else measuring.town(name)
    write_page(PAGE, [STORE], {"adapt": table(read_results(STORE, {"rows": {}}))})
