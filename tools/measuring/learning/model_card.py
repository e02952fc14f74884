# SPDX-License-Identifier: Apache-2.0
"""Measures a model and writes the numbers into its card, between its marks.

Needs the data in ../shared/data, the painted pieces (tools/measure painted) and the synthetic sites that
models/regions.toml names (made here when missing).
"""

import pathlib
import re

from measuring.common import ROOT, Tool, add_tool, write_between


def add_arguments(parser):
    add_tool(parser)
    parser.add_argument("card", type=pathlib.Path, nargs="?", default=ROOT / "models/default.md")


def cell(value):
    return "-" if value is None else f"{100 * value:.1f}"


def run(args):
    tool, card = Tool(args.tool), args.card
    experiment, model = ROOT / "models/regions.toml", card.with_suffix(".safetensors")
    # The synthetic sites of the experiment: folders are named PRESET-SEED.
    for folder in re.findall(r'^folder = "(.*)"', experiment.read_text(), re.MULTILINE):
        site = (experiment.parent / folder).resolve()
        preset, seed = site.name.rsplit("-", 1)
        tool.synth(site, "--preset", preset, "--seed", seed)
    scores = tool.json("train", experiment, "--measure", model)
    classes = list(next(iter(scores.values()))["iou"])
    lines = [
        "| held out | road IoU | mean IoU | pixel accuracy | " + " | ".join(classes) + " |",
        "|---|" + "---:|" * (3 + len(classes)),
    ]
    for name, s in scores.items():
        values = [s["road_iou"], s["mean_iou"], s["pixel_accuracy"]] + [s["iou"][c] for c in classes]
        lines.append(f"| {name} | " + " | ".join(cell(v) for v in values) + " |")
    write_between(card, "scores", "\n".join(lines))
