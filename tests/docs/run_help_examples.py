#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every example that the tool's --help prints, as a reader would type it, in a folder where the files that they
name stand for small ones.

    run_help_examples.py TOOL SITES [TEXT]     only those with TEXT; SITES: what tests/faults/build_small leaves

Words of an example are changed by CHANGED alone, and MORE adds options that make a long one short. NOT_RUN names those
that need what no folder has, with the reason. Any other one that fails, or a rule that no example needs, is an error.
"""

import json
import math
import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

from osgeo import osr

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
NOT_RUN = {  # part of the example: why
    "new --relation": "a relation of a country's extract",
    "fetch site.toml": "asks servers; tests/fetch runs it against one",
    "new --place": "asks servers; tests/app/new_command_test runs it with a stand-in",
    "--log comma2k19": "a segment of that data set",
    "--resume": "goes on with a training; tests/app/train_test does",
    "town.osm.pbf": "an extract in that format; tests/io does",
}
CHANGED = {  # places lie elsewhere on the small site
    "529900,5542300": "460040,5270070",
    "530400,5542800": "460150,5270140",
    "322000 6394000 322500 6394500": "460020 5270020 460120 5270120",
    "way/26182390": "way/FIRST_WAY",
}
MORE = {  # part of the example: what is added to it
    "--preset region": ["--size", "2000", "--gsd", "2"],
    "--preset lanes": ["--size", "400", "--gsd", "1"],
    "--preset circuit": ["--size", "500", "--gsd", "1"],
    "synth --seed 7": ["--size", "200", "--gsd", "1"],
    "synth --preset junction": ["--gsd", "1"],
    "tune sites.toml -o tuned --trials 200": ["--trials", "2"],
    "tune sites.toml -o tuned": ["--trials", "2"],
}
FAILS = {"--strict": "the verdict is fail"}  # part of the example: what it says of the small site


def run(tool, *words, **options):
    return subprocess.run([str(tool), *words], capture_output=True, text=True, check=False, **options)


def helps(tool, words=()):
    """The text of --help of a command and of all below it."""
    text = run(tool, *words, "--help").stdout
    yield text
    below = False
    for line in text.splitlines():
        below = line.strip().lower() in ("subcommands:", "commands:") or (below and line.startswith("  "))
        if below and line.startswith("  ") and not line.startswith("   "):
            yield from helps(tool, (*words, line.split()[0]))


def examples(tool):
    found = {}
    for text in helps(tool):
        for line in text.splitlines():
            if line.startswith("  orthodrive "):
                found.setdefault(line.strip().split("  #")[0].strip(), None)
    return list(found)


def make_labels_of_38_classes(classes, tool):
    (classes / "models").mkdir(parents=True)
    (classes / "models/classes").symlink_to(ROOT / "models/classes")
    more = ["--gsd", "2", "--classes", ROOT / "models/classes/reference-38.toml"]
    run(tool, "synth", "--preset", "circuit", "--size", "500", *map(str, more), "-o", str(classes / "made"))
    for name in ("labels.tif", "truth.tif"):
        shutil.copyfile(classes / "made/truth/labels.tif", classes / name)


def make_folder(folder, tool, sites):
    """What the examples name."""
    small_site, small = sites / "small_site", sites / "small"
    shutil.copytree(small_site, folder / "site")
    shutil.copytree(small, folder / "out")
    shutil.copytree(small, folder / "out/kvarnbyn")
    (folder / "models").mkdir()
    for entry in (ROOT / "models").iterdir():
        if entry.name != "default.toml":
            (folder / "models" / entry.name).symlink_to(entry)
    (folder / "models/default.toml").write_text(
        'network = "networks/mobilenetv2-fpn-map.toml"\nweights = ["default.safetensors"]\n[train]\nsteps = 1\n'
        '[[raster]]\nname = "learned"\nfolder = "../site"\n'
        '[[raster]]\nname = "measured"\nfolder = "../site"\nheld_out = true\n'
    )
    (folder / "sites").mkdir()
    make_track(folder)
    text = (small_site / "site.toml").read_text()
    for name in ("ortho.tif", "roads.osm", "dtm_1m.tif", "dtm_10m.tif", "truth"):
        text = text.replace(f'"{name}"', f'"{folder / "site" / name}"')
    for name in ("site.toml", "sites/kvarnbyn.toml"):
        (folder / name).write_text(text)
    copies = {
        "site/ortho.tif": ["ortho.tif", "ortho.jpg", "a.tif", "b.tif"],
        "site/roads.osm": ["roads.osm", "town.osm", "map.osm"],
        "site/dtm_1m.tif": ["dtm.tif", "dtm_1m.tif"],
        "site/dtm_10m.tif": ["dtm_10m.tif"],
        "out/labels.tif": ["labels.tif"],
        "out/confidence.tif": ["confidence.tif"],
        "out/road_probability.tif": ["road_probability.tif"],
        "out/roads.gpkg": ["roads.gpkg"],
        "out/roads.xodr": ["roads.xodr", "any.xodr", "ring/roads.xodr"],
        "out/drive/lap.gpx": ["monday.gpx", "tuesday.gpx"],
        "site/truth/surface.geojson": ["carriageways.geojson"],
    }
    for source, names in copies.items():
        for name in names:
            (folder / name).parent.mkdir(exist_ok=True)
            shutil.copyfile(folder / source, folder / name)
    shutil.copytree(folder / "site", folder / "village")
    shutil.copyfile(folder / "site/truth/labels.tif", folder / "b_labels.tif")
    make_labels_of_38_classes(folder / "classes", tool)
    (folder / "out/train").mkdir()
    shutil.copyfile(ROOT / "models/default.safetensors", folder / "out/train/model.safetensors")
    surface = json.loads((folder / "site/truth/surface.geojson").read_text())
    for feature in surface["features"]:
        feature["properties"]["class"] = "road"
    for name in ("truth.geojson", "a.geojson"):
        (folder / name).write_text(json.dumps(surface))
    box = [[15.0, 47.0], [16.0, 47.0], [16.0, 48.0], [15.0, 48.0], [15.0, 47.0]]
    area = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [box]}}
    (folder / "box.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [area]}))
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
    refs = "".join(f'<nd ref="{i % 90 + 1}"/>' for i in range(91))
    way = f'<way id="7">{refs}<tag k="highway" v="raceway"/></way>'
    (folder / "track.osm").write_text(f'<osm version="0.6">{"".join(nodes)}{way}</osm>')


def reference(code):
    system = osr.SpatialReference()
    system.ImportFromEPSG(code)
    system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return system


def first_way(folder):
    """The id of a way that is a road of the small site."""
    text = (folder / "site/truth/centrelines.geojson").read_text()
    return json.loads(text)["features"][0]["properties"]["osm_id"]


def words_of(example, folder):
    for old, new in CHANGED.items():
        example = example.replace(old, new.replace("FIRST_WAY", str(first_way(folder))))
    words = shlex.split(example)[1:]
    for part, more in MORE.items():
        if part not in example:
            continue
        for name, value in zip(more[::2], more[1::2], strict=True):
            if name in words:
                words[words.index(name) + 1] = value
            else:
                words += [name, value]
        break
    return words


def run_example(tool, example, folder):
    """An error, or nothing."""
    command, _, otherwise = example.partition(" || ")
    words = words_of(command, folder)
    environment = {**os.environ, "ORTHODRIVE_MODELS": str(ROOT / "models")}
    if words[0] == "view":  # serves until it is stopped
        server = subprocess.Popen(
            [str(tool), *words, "--no-open"] if "--no-open" not in words else [str(tool), *words],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
        )
        first = server.stdout.readline()
        server.send_signal(signal.SIGINT)
        return None if server.wait() == 0 and first else f"said '{first}', then {server.returncode}"
    if "merge_38_to_32" in example:  # of maps with the classes that it merges
        folder = folder / "classes"
    done = run(tool, *words, cwd=folder, env=environment)
    saying = next((text for part, text in FAILS.items() if part in example), None)
    if saying:
        return None if done.returncode == 1 and saying in done.stderr else f"does not say '{saying}': {done.stderr}"
    if done.returncode == 0 or (otherwise and done.returncode == 3):
        return None
    return f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"


def main(tool, sites, text=""):
    tool, sites = pathlib.Path(tool).resolve(), pathlib.Path(sites).resolve()
    failures, ran, reasons, folder = [], 0, set(), None
    with tempfile.TemporaryDirectory(prefix="orthodrive-examples-") as name:
        folder = pathlib.Path(name)
        make_folder(folder, tool, sites)
        for example in examples(tool):
            reason = next((part for part in NOT_RUN if part in example), None)
            if reason:
                reasons.add(reason)
                continue
            if text not in example:
                continue
            ran += 1
            error = run_example(tool, example, folder)
            print(f"{'FAILED' if error else 'ok'}: {example}", flush=True)
            if error:
                failures.append(f"{example}\n    {error}")
    for part in sorted(set(NOT_RUN) - reasons):
        failures.append(f"NOT_RUN names '{part}', which no example has")
    print(f"{ran} examples, {len(failures)} failures")
    for failure in failures:
        print(failure)
    return 1 if failures or ran == 0 else 0


sys.exit(main(*sys.argv[1:]))
