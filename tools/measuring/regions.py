# SPDX-License-Identifier: Apache-2.0
"""Regions x models: road IoU of the shipped models on held-out data. Writes docs/measured/regions.md.

    tools/measure regions tools/measure regions --left-out japan=out/left_out/japan_map/model.safetensors --before
    models/training/two_towns.safetensors

The second form prints and writes nothing. A left-out model is trained by models/experiments/left_out.toml, a branch for
the map by left_out_map.toml, both with --leave-out REGION (or several), and measured on all of that region: by the
photo alone, or with the map. `before`: the model given by --before, which they started from. Such trainings are told in
docs/notes/regions.md. Needs ../shared/data; makes the synthetic site and renders the painted pieces.
"""

import pathlib

from measuring.common import (
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    header,
    percent,
    read_results,
    row,
    write_page,
    write_results,
)
from measuring.learning.painted import render_painted

STORE, PAGE = "regions.json", PAGES / "regions.md"
MODELS = {
    "first training": ROOT / "models/training/two_towns.safetensors",
    "default": ROOT / "models/default.safetensors",
}
WITH_MAP = " with map"


def named_file(text):
    name, _, file = text.partition("=")
    if not pathlib.Path(file).is_file():
        raise ValueError
    return name, pathlib.Path(file).resolve()


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    add_only(parser, MODELS)
    parser.add_argument("--before", type=pathlib.Path, help="the model that the left-out trainings started from")
    parser.add_argument(
        "--left-out",
        type=named_file,
        action="append",
        default=[],
        metavar="REGION=FILE",
        help="trained without that region, measured on all of it",
    )


def scores(tool, experiment, model, *words):
    return {
        name: {k: s[k] for k in ("road_iou", "mean_iou", "pixel_accuracy", "road_stated", "road_right")}
        for name, s in tool.json("train", experiment, "--measure", model, *words).items()
    }


def table(numbers):
    models = {name: numbers["models"][name] for name in MODELS if name in numbers["models"]}
    sets = sorted({name for by_set in models.values() for name in by_set})
    text = header(["held out", *models])
    return text + "".join(
        row(
            [
                name,
                *(
                    (
                        f"{percent(m[name]['road_iou'])} / {percent(m[name]['mean_iou'])} / "
                        f"{percent(m[name]['pixel_accuracy'])}"
                    )
                    if name in m
                    else "-"
                    for m in models.values()
                ),
            ]
        )
        for name in sets
    )


def left_out(tool, args):
    """Rows of a table for docs/notes/regions.md."""
    text = header(
        [
            "region left out, all of it: road IoU",
            "before",
            "left out, photo alone",
            "left out, with map",
            "stated of road with map",
            "right",
        ]
    )
    for region, model in args.left_out:
        experiment, words = ROOT / "models/experiments/left_out_map.toml", ("--leave-out", region, "--set", region)
        after, seen = scores(tool, experiment, model, *words), region + WITH_MAP
        before = percent(scores(tool, experiment, args.before, *words)[region]["road_iou"]) if args.before else "-"
        with_map = (
            [percent(after[seen][k]) for k in ("road_iou", "road_stated", "road_right")] if seen in after else ["-"] * 3
        )
        text += row([region, before, percent(after[region]["road_iou"]), *with_map])
    return text


def run(args):
    numbers = read_results(STORE, {"models": {}, "commits": {}})
    if args.table:
        write_page(PAGE, [STORE], {"regions": table(numbers)})
        return
    tool = Tool(args.tool)
    tool.synth(ROOT / "out/synth/village-99", "--preset", "village", "--seed", 99)
    render_painted()
    if args.left_out:
        print(left_out(tool, args))
        return
    for name in args.only:
        numbers["models"][name] = scores(tool, ROOT / "models/regions.toml", MODELS[name])
        numbers["commits"][name] = commit()
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"regions": table(numbers)})
