# SPDX-License-Identifier: Apache-2.0
"""Regions x models: road IoU on held-out data, and on regions left out of the training. Writes docs/measured/regions.md.

    tools/measure regions --model default=models/default.safetensors --model third=out/worlds/model.safetensors
    tools/measure regions --before models/training/two_towns.safetensors --left-out japan=out/left_out/japan_map/model.safetensors

A left-out model is trained by models/experiments/left_out.toml, a branch for the map by left_out_map.toml, both with --leave-out REGION
(or several), and measured on all of that region: by the photo alone, or with the map. `before`: the model given by --before, which they
started from, by the photo alone; none for a training that started without one. What is not given keeps its last values from bench/results/regions.json. Needs ../shared/data; makes
the synthetic site and renders the painted pieces.
"""
from measuring.common import *
from measuring.painted import render_painted

STORE, PAGE = "regions.json", PAGES / "regions.md"
WITH_MAP = " with map"


def named_file(text):
    name, _, file = text.partition("=")
    if not pathlib.Path(file).is_file():
        raise ValueError
    return name, pathlib.Path(file).resolve()


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument("--model", type=named_file, action="append", default=[], metavar="NAME=FILE", help="measured on all held-out data")
    parser.add_argument("--before", type=pathlib.Path, help="the model that the left-out trainings started from")
    parser.add_argument("--left-out", type=named_file, action="append", default=[], metavar="REGION=FILE",
                        help="trained without that region, measured on all of it")


def scores(tool, experiment, model, *words):
    return {name: {k: s[k] for k in ("road_iou", "mean_iou", "pixel_accuracy", "road_stated", "road_right")}
            for name, s in tool.json("train", experiment, "--measure", model, *words).items()}


def table(numbers):
    models = numbers["models"]
    sets = sorted({name for by_set in models.values() for name in by_set})
    text = header(["held out", *models])
    text += "".join(row([name, *(f"{percent(m[name]['road_iou'])} / {percent(m[name]['mean_iou'])} / {percent(m[name]['pixel_accuracy'])}"
                                 if name in m else "-" for m in models.values())]) for name in sets)
    kinds = ["before", "left out", "with map"]
    text += "\n" + header(["region left out, all of it: road IoU", "before", "left out, photo alone", "left out, with map", "stated of road with map", "right"])
    left = numbers["left_out"]
    for name in sorted(left):
        text += row([name, *(percent(left[name][kind]["road_iou"]) if kind in left[name] else "-" for kind in kinds),
                     *(percent(left[name]["with map"][k]) for k in ("road_stated", "road_right"))])
    means = ["-" if not left or any(kind not in by for by in left.values()) else percent(sum(by[kind]["road_iou"] for by in left.values()) / len(left))
             for kind in kinds]
    return text + row(["mean", *means, "", ""])


def run(args):
    numbers = read_results(STORE, {"models": {}, "left_out": {}})
    if not args.table:
        tool = Tool(args.tool)
        tool.synth(ROOT / "out/synth/village-99", "--preset", "village", "--seed", 99)
        render_painted()
        for name, model in args.model:
            numbers["models"][name] = scores(tool, ROOT / "models/regions.toml", model)
            write_results(STORE, numbers)
        for region, model in args.left_out:
            experiment, words = ROOT / "models/experiments/left_out_map.toml", ("--leave-out", region, "--set", region)
            after, of_region = scores(tool, experiment, model, *words), numbers["left_out"].setdefault(region, {})
            if args.before:
                of_region["before"] = scores(tool, experiment, args.before, *words)[region]
            seen = region + WITH_MAP
            of_region["left out"] = after[region]
            if seen in after:
                of_region["with map"] = after[seen]
            write_results(STORE, numbers)
        numbers["commit"] = commit()
        write_results(STORE, numbers)
    write_between(PAGE, "regions", table(numbers))
