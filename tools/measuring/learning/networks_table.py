# SPDX-License-Identifier: Apache-2.0
"""The comparison of networks: trains and measures them. Writes the tables of docs/notes/networks.md.

    tools/measure networks train [NAME ...]      what is not trained yet; hours on two cores
    tools/measure networks measure [NETWORK ...] what is trained: bench/results/segmentation.json and the tables
    tools/measure networks write                 only the tables, from the last results

Models go to out/compare/NAME (git-ignored); `default` is the shipped one. Needs ../shared/data; makes the synthetic
sites.
"""

import csv
import subprocess

from measuring.common import NOTES, ROOT, Tool, add_tool, read_results, write_between, write_results

OUT = ROOT / "out/compare"
STORE, PAGE = "segmentation.json", NOTES / "networks.md"
# network -> its experiments: on the data of the shipped model, and on Mumbai
NETWORKS = {
    "VGG16-8s": {"mix": "vgg16", "mumbai": "mumbai_vgg16"},
    "GoogLeNet-8s": {"mix": "googlenet", "mumbai": "mumbai_googlenet"},
    "default": {"mix": "default", "mumbai": "mumbai_mobilenetv2"},
}
SETS = {"dubai": "mix", "mumbai-val": "mumbai", "handmade": "mix", "village-99": "mix"}
CRFS = ["none", "untrained", "trained"]


def experiment_of(name):
    return ROOT / "models" / ("default.toml" if name == "default" else f"experiments/{name}.toml")


def make_sites(tool):
    for seed in (11, 12, 13, 14, 99):
        tool.synth(ROOT / f"out/synth/village-{seed}", "--preset", "village", "--seed", seed)


def train(tool, names):
    for name in names:
        for crf in ([], ["--crf"]):
            folder = OUT / name
            finished = folder / "crf/model.safetensors" if crf else folder / "finished"
            if finished.exists():
                continue
            resume = (
                ["--resume"]
                if (folder / ("crf/checkpoint.safetensors" if crf else "checkpoint.safetensors")).exists()
                else []
            )
            print(f"training {name} {' '.join(crf + resume)}", flush=True)
            subprocess.run(
                [str(tool.file), "train", str(experiment_of(name)), "-o", str(folder), "--threads", "2", *crf, *resume],
                check=True,
            )
            if not crf:
                finished.write_text("")


def model_of(name, crf):
    """The file and whether its CRF runs; the shipped model is one file, network and CRF."""
    folder = OUT / name
    if crf == "trained":
        return folder / "crf/model.safetensors", True
    if crf == "untrained":
        return folder / "crf/searched.safetensors", True
    return folder / "model.safetensors", False


def trained(name):
    steps, seconds = {}, {}
    for part, log in (("network", OUT / name / "log.csv"), ("crf", OUT / name / "crf/log.csv")):
        if log.exists():
            last = list(csv.DictReader(log.open()))[-1]
            steps[part], seconds[part] = int(last["step"]), float(last["seconds"])
    return steps, seconds


def measure(tool, networks):
    """Of those named; the others keep their last results."""
    results = read_results(STORE, {})
    for network in networks or NETWORKS:
        experiments = NETWORKS[network]
        steps, seconds = {}, {}
        for part, name in experiments.items():
            steps[part], seconds[part] = trained(name)
        results[network] = {"training": {"steps": steps, "seconds": seconds}}
        for crf in reversed(CRFS):  # what matters most first: VGG16 takes a quarter of an hour each time
            for name in experiments.values():
                model, with_crf = model_of(name, crf)
                if not model.exists() or not (OUT / name / "finished").exists():
                    continue
                sets = [part for s in SETS if experiments[SETS[s]] == name for part in ("--set", s)]
                scores = tool.json(
                    "train", experiment_of(name), "--measure", model, *sets, *(["--crf"] if with_crf else [])
                )
                results.setdefault(network, {}).setdefault(crf, {}).update(
                    {k: v for k, v in scores.items() if k in SETS}
                )
                print(network, crf, name, {k: v["mean_iou"] for k, v in scores.items()}, flush=True)
                write_results(STORE, results)


def cell(value):
    return "-" if value is None else f"{100 * value:.1f}"


def tables(results):
    lines = [
        "| network | CRF | " + " | ".join(f"{s}: mean IoU / road IoU / accuracy" for s in SETS) + " | Mpx/s |",
        "|---|---|" + "---:|" * (len(SETS) + 1),
    ]
    results = {network: results[network] for network in NETWORKS if network in results}
    for network, by_crf in results.items():
        for crf in CRFS:
            scores = by_crf.get(crf, {})
            cells = []
            for s in SETS:
                v = scores.get(s)
                cells.append(
                    "-" if v is None else f"{cell(v['mean_iou'])} / {cell(v['road_iou'])} / {cell(v['pixel_accuracy'])}"
                )
            speed = scores.get("village-99")
            cells.append("-" if speed is None else f"{speed['megapixels'] / speed['seconds']:.3g}")
            lines.append(f"| {network} | {crf} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "| network | trained on | network: steps, seconds | CRF and network: steps, seconds |",
        "|---|---|---:|---:|",
    ]
    for network, by_crf in results.items():
        for part in ("mix", "mumbai"):
            told = {}
            for stage in ("network", "crf"):
                steps = by_crf["training"]["steps"].get(part, {}).get(stage)
                told[stage] = "-" if steps is None else f"{steps}, {by_crf['training']['seconds'][part][stage]:.0f}"
            lines.append(f"| {network} | {part} | {told['network']} | {told['crf']} |")
    return "\n".join(lines)


def add_arguments(parser):
    add_tool(parser)
    parser.add_argument("action", choices=["train", "measure", "write"])
    parser.add_argument("names", nargs="*", help="experiments to train, networks to measure; all where none is given")


def run(args):
    tool = Tool(args.tool)
    if args.action != "write":
        make_sites(tool)
    if args.action == "train":
        train(tool, args.names or [e for n in NETWORKS.values() for e in n.values()])
        return
    if args.action == "measure":
        measure(tool, args.names)
    write_between(PAGE, "comparison", tables(read_results(STORE, {})))
