"""Regions x models: road IoU on held-out data, and on regions left out of the training. Writes docs/measured/regions.md.

    tools/measure regions --model shipped=models/default.safetensors --model candidate=mixed.safetensors
    tools/measure regions --before models/default.safetensors --left-out japan=out/without_japan/model.safetensors    trained by models/experiments/without_japan.toml

`before` and `mixed` of a left-out region: the model given by --before, and the mean of 0.4 of it and 0.6 of the left-out one, as
the candidate was mixed (tools/average). What is not given keeps its last values from bench/results/regions.json. Needs
../shared/data; makes the synthetic site and renders the painted pieces.
"""
import tempfile

from measuring.common import *
from measuring.painted import render_painted

STORE, PAGE = "regions.json", PAGES / "regions.md"
SHARE_BEFORE = 0.4


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


def scores(tool, experiment, model, sets=()):
    words = [word for name in sets for word in ("--set", name)]
    return {name: {k: s[k] for k in ("road_iou", "mean_iou", "pixel_accuracy")}
            for name, s in tool.json("train", experiment, "--measure", model, *words).items()}


def table(numbers):
    models = numbers["models"]
    sets = sorted({name for by_set in models.values() for name in by_set})
    text = header(["held out", *models])
    text += "".join(row([name, *(f"{percent(m[name]['road_iou'])} / {percent(m[name]['mean_iou'])} / {percent(m[name]['pixel_accuracy'])}"
                                 if name in m else "-" for m in models.values())]) for name in sets)
    kinds = ["before", "left out", "mixed"]
    text += "\n" + header(["region left out, all of it", *kinds])
    left = numbers["left_out"]
    text += "".join(row([name, *(percent(left[name][kind]["road_iou"]) for kind in kinds)]) for name in sorted(left))
    mean = [sum(by[kind]["road_iou"] for by in left.values()) / len(left) for kind in kinds] if left else [None] * 3
    return text + row(["mean", *map(percent, mean)])


def run(args):
    numbers = read_results(STORE, {"models": {}, "left_out": {}})
    if not args.table:
        tool = Tool(args.tool)
        tool.synth(ROOT / "out/synth/village-99", "--preset", "village", "--seed", 99)
        render_painted()
        for name, model in args.model:
            numbers["models"][name] = scores(tool, ROOT / "models/regions.toml", model)
        if args.left_out and not args.before:
            sys.exit("regions: --left-out needs --before, the model that it started from")
        for region, model in args.left_out:
            experiment = ROOT / f"models/experiments/without_{region}.toml"
            with tempfile.TemporaryDirectory() as work:
                mixed = pathlib.Path(work) / "mixed.safetensors"
                run_program(ROOT / "tools/average", f"{args.before}={SHARE_BEFORE}", f"{model}={1.0 - SHARE_BEFORE}", "-o", mixed)
                numbers["left_out"][region] = {kind: scores(tool, experiment, file, [region])[region]
                                               for kind, file in (("before", args.before), ("left out", model), ("mixed", mixed))}
        numbers["commit"] = commit()
        write_results(STORE, numbers)
    write_between(PAGE, "regions", table(numbers))
