# SPDX-License-Identifier: Apache-2.0
"""A folder where small files stand for those that --help and the pages name, and what runs the tool in it."""

import json
import math
import os
import pathlib
import resource
import shutil
import subprocess

from osgeo import gdal, osr

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ENVIRONMENT = {**os.environ, "ORTHODRIVE_MODELS": str(ROOT / "models")}


def run(tool, *words, **options):
    return subprocess.run([str(tool), *words], capture_output=True, text=True, check=False, **options)


def cpu_seconds():
    """Of all programs that were run."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def helps(tool, words=()):
    """The words of each command and the text of its --help, with all commands below it."""
    text = run(tool, *words, "--help").stdout
    yield words, text
    below = False
    for line in text.splitlines():
        below = line.strip().lower() in ("subcommands:", "commands:") or (below and line.startswith("  "))
        if below and line.startswith("  ") and not line.startswith("   "):
            yield from helps(tool, (*words, line.split()[0]))


def make_labels_of_38_classes(classes, tool):
    (classes / "models").mkdir(parents=True)
    (classes / "models/classes").symlink_to(ROOT / "models/classes")
    more = ["--gsd", "2", "--classes", ROOT / "models/classes/reference-38.toml"]
    run(tool, "synth", "--preset", "circuit", "--size", "500", *map(str, more), "-o", str(classes / "made"))
    for name in ("labels.tif", "truth.tif"):
        shutil.copyfile(classes / "made/truth/labels.tif", classes / name)


def experiment(network, folder, more="", names=("learned", "measured"), crop_px=64):
    """A training of one step on a small site; the last set of data is held out."""
    text = f'network = "{network}"\n{more}[train]\nsteps = 1\ncrop_px = {crop_px}\nbatch = 1\nvalidate_every = -1\n'
    text += "[crf]\nsteps = 1\nsearch_crops = 1\niterations = 1\nbatch = 1\ntheta_alpha_px = [10]\ntheta_beta = [10]\n"
    text += "appearance_weight = [1]\ntheta_gamma_px = [1]\nsmoothness_weight = [1]\n"
    sets = "".join(f'[[raster]]\nname = "{name}"\nfolder = "{folder}"\n' for name in names)
    return f"{text}{sets}held_out = true\n"


def make_models(folder):
    """The models folder, with experiments of one step in place of those that take hours."""
    models, weights = folder / "models", 'weights = ["default.safetensors"]\n'
    (models / "experiments").mkdir(parents=True)
    for entry in (ROOT / "models").iterdir():
        if entry.name not in ("default.toml", "second_eye.toml", "experiments"):
            (models / entry.name).symlink_to(entry)
    see_map, no_map = "networks/mobilenetv2-fpn-map.toml", "../networks/mobilenetv2-fpn.toml"
    texts = {
        "models/default.toml": experiment(see_map, "../site", weights),
        "models/second_eye.toml": experiment(see_map, "../site", weights),
        "EXPERIMENT.toml": experiment(f"models/{see_map}", "site", weights.replace('["', '["models/')),
        "models/experiments/left_out.toml": experiment(no_map, "../../site", names=("estonia", "japan", "measured")),
        "models/experiments/reference_38_googlenet.toml": experiment(
            "../networks/googlenet-8s-38.toml", "../../classes/made", crop_px=66
        ),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)


def make_folder(folder, tool, sites):
    """What the examples name."""
    small_site, small = sites / "small_site", sites / "small"
    shutil.copytree(small_site, folder / "site")
    shutil.copytree(small, folder / "out")
    for name in ("kvarnbyn", "ring"):
        shutil.copytree(small, folder / "out" / name)
    make_models(folder)
    (folder / "sites").mkdir()
    make_track(folder)
    make_control_points(folder)
    text = (small_site / "site.toml").read_text()
    for name in ("ortho.tif", "roads.osm", "dtm_1m.tif", "dtm_10m.tif", "truth"):
        text = text.replace(f'"{name}"', f'"{folder / "site" / name}"')
    for name in ("site.toml", "sites/kvarnbyn.toml", "sites/ring.toml"):
        (folder / name).write_text(text)
    copies = {
        "site/ortho.tif": ["ortho.tif", "ortho.jpg", "photo.tif", "a.tif", "b.tif", "sites/ring/photo.mbtiles"],
        "site/roads.osm": ["roads.osm", "town.osm", "map.osm", "sites/ring/roads.osm"],
        "site/dtm_1m.tif": ["dtm.tif", "dtm_1m.tif", "sites/ring/dtm.tif"],
        "site/dtm_10m.tif": ["dtm_10m.tif"],
        "site/truth/labels.tif": ["b_labels.tif"],
        "out/labels.tif": ["labels.tif"],
        "out/confidence.tif": ["confidence.tif"],
        "out/road_probability.tif": ["road_probability.tif"],
        "out/roads.gpkg": ["roads.gpkg"],
        "out/roads.xodr": ["roads.xodr", "any.xodr", "ring.xodr", "town.xodr", "ring/roads.xodr"],
        "out/drive/lap.gpx": ["monday.gpx", "tuesday.gpx"],
        "site/truth/surface.geojson": ["carriageways.geojson"],
    }
    for source, names in copies.items():
        for name in names:
            (folder / name).parent.mkdir(exist_ok=True)
            shutil.copyfile(folder / source, folder / name)
    shutil.copytree(folder / "site", folder / "village")
    make_labels_of_38_classes(folder / "classes", tool)
    (folder / "out/train").mkdir()
    shutil.copyfile(ROOT / "models/default.safetensors", folder / "out/train/model.safetensors")
    make_drawn_truth(folder)
    make_rasters(folder)
    run(tool, "forests", "--photo=ortho.tif", "--labels=b_labels.tif", "--trees=2", "--output=forests.yml", cwd=folder)


def make_rasters(folder):
    """A terrain grid of simulators, textures."""
    gdal.UseExceptions()
    gdal.Translate(f"{folder}/terrain.asc", f"{folder}/dtm_10m.tif", format="AAIGrid")
    (folder / "out/textures").mkdir()
    gdal.Translate(f"{folder}/out/textures/grass.png", f"{folder}/ortho.tif", format="PNG", srcWin=[0, 0, 64, 64])
    (folder / "out/textures/textures.toml").write_text("gsd_m = 0.5\n")


def write_area(file, west, south, east, north):
    """A box in degrees."""
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    area = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    file.write_text(json.dumps({"type": "FeatureCollection", "features": [area]}))


def make_drawn_truth(folder):
    surface = json.loads((folder / "site/truth/surface.geojson").read_text())
    for feature in surface["features"]:
        feature["properties"]["class"] = "road"
    for name in ("truth.geojson", "a.geojson"):
        (folder / name).write_text(json.dumps(surface))
    write_area(folder / "box.geojson", 14.0, 47.0, 15.0, 48.0)
    write_area(folder / "lake.geojson", 15.43, 47.06, 15.46, 47.08)
    (folder / "sites.toml").write_text(
        "".join(
            f'[[site]]\nname = "{name}"\nlabels = "out/labels.tif"\nroad_probability = "out/road_probability.tif"\n'
            'osm = "site/roads.osm"\ntruth = "site/truth"\n\n'
            for name in ("one", "two")
        )
    )


def make_track(folder):
    """A round track of 150 m radius as a survey has it, and its OSM way."""
    to_degrees = osr.CoordinateTransformation(*(reference(code) for code in (32633, 4326)))
    rows, nodes = ["w_tr_right_m,w_tr_left_m,utm33_e,utm33_n"], []
    for i in range(90):
        angle = 2.0 * math.pi * i / 90
        east, north = 460300.0 + 150.0 * math.cos(angle), 5270300.0 + 150.0 * math.sin(angle)
        rows.append(f"5.5,5.5,{east},{north}")
        lon, lat, _ = to_degrees.TransformPoint(east, north)
        nodes.append(f'<node id="{i + 1}" lon="{lon}" lat="{lat}"/>')
    (folder / "track.csv").write_text("\n".join(rows) + "\n")
    heights = [
        f"{lon},{lat},{600 + 10 * i}" for i, (lon, lat) in enumerate(((14.47, 47.58), (14.48, 47.58), (14.47, 47.59)))
    ]
    (folder / "heights.csv").write_text("\n".join(["lon,lat,elev_m", *heights]) + "\n")
    refs = "".join(f'<nd ref="{i % 90 + 1}"/>' for i in range(91))
    way = f'<way id="7">{refs}<tag k="highway" v="raceway"/></way>'
    (folder / "track.osm").write_text(f'<osm version="0.6">{"".join(nodes)}{way}</osm>')


def make_control_points(folder):
    """A height on a road of the small site."""
    truth = json.loads((folder / "site/truth/centrelines.geojson").read_text())
    place = {"type": "Point", "coordinates": truth["features"][0]["geometry"]["coordinates"][0]}
    point = {"type": "Feature", "properties": {"z_m": 400.0}, "geometry": place}
    (folder / "heights.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [point]}))


def reference(code):
    system = osr.SpatialReference()
    system.ImportFromEPSG(code)
    system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return system
