# SPDX-License-Identifier: Apache-2.0
"""The thesis' segmentation experiment on its 38 classes: tables 2.1, 2.2, C.1. Writes docs/notes/reference_38.md.

    tools/measure reference-38 make                    the sites, synthetic, into out/reference-38
    tools/measure reference-38 train [googlenet ...]   hours on two cores; goes on where it was stopped
    tools/measure reference-38 measure [NETWORK ...]   what is trained, on the circuit and the village held out
    tools/measure reference-38 write                   only the note, from the last results

A note, because it needs trainings. NETWORK is one of googlenet-32s ... vgg16-8s.
"""

import subprocess

from measuring.common import (
    NOTES,
    ROOT,
    Tool,
    add_tool,
    commit,
    fixed,
    header,
    percent,
    read_results,
    row,
    write_between,
    write_results,
)

OUT = ROOT / "out/reference-38"
CLASSES = ROOT / "models/classes/reference-38.toml"
STORE, NOTE = "reference_38.json", NOTES / "reference_38.md"
SEEDS = {
    "circuit": [11, 12, 13, 14, 15, 16, 99],
    "village": [11, 12, 13, 14, 99],
    "junction": [11, 12],
    "grid": [11, 12],
}
HELD_OUT = ["circuit-99", "village-99"]
PUBLISHED = {  # table 2.1: accuracy %, seconds an image of 256 x 256 px; mean IoU % of table C.1
    "googlenet-32s": ("83.02", "0.169", ""),
    "googlenet-16s": ("86.04", "0.157", ""),
    "googlenet-8s": ("87.40", "0.156", "61.20"),
    "vgg16-32s": ("82.82", "0.411", ""),
    "vgg16-16s": ("87.56", "0.412", ""),
    "vgg16-8s": ("89.41", "0.410", "64.66"),
}
CRF_SETS = {"none": "89.41", "kraehenbuehl": "88.73", "zheng": "90.51", "thesis": "90.51"}  # table 2.2, on VGG16-8s
# Table C.1: class, IoU % of GoogLeNet-8s, VGG16-8s, VGG16-8s with CRF
PER_CLASS = """snow 96.11 96.89 97.51|grassland 74.49 80.32 81.51|lawn 40.50 57.95 59.75|shrub 39.51 41.49 42.20
tree 92.39 92.53 92.74|orchard 1.14 2.14 2.46|field 91.89 94.93 95.63|dirt 58.80 59.37 61.83|debris 73.55 75.73 78.56
rock 88.93 91.43 92.10|paved 43.67 56.29 58.66|parking 81.68 83.35 83.42|pool 28.70 25.92 24.86|river 80.79 80.67 80.52
water 0.00 0.00 -|shed 20.44 16.95 16.55|detached 41.54 35.57 35.85|residential 81.06 82.54 84.51
highrise 87.14 78.73 84.78|agricultural 30.62 38.31 40.77|industrial 43.27 58.91 62.43|railroad 87.50 93.48 94.40
cartway 27.42 42.88 45.88|sidewalk 43.44 52.91 56.36|macadam 34.19 34.83 40.40|driveway 35.44 48.13 54.49
secondary 59.17 60.85 63.32|avenue 85.99 88.72 91.59|highway 76.73 78.81 81.05|freeway 89.33 93.68 93.22
ramp 76.99 86.47 85.42|curbs 49.03 57.08 51.98|pitlane 64.48 74.55 73.47|track 83.94 85.00 86.17
barrier 52.44 64.49 67.54|apron 71.44 56.77 56.29|grandstand 94.34 91.05 88.47|gravel 97.56 97.29 98.52"""


def add_arguments(parser):
    add_tool(parser)
    parser.add_argument("action", choices=["make", "train", "measure", "write"])
    parser.add_argument("names", nargs="*", help="trunks to train, networks to measure; all where none is given")


def make(tool):
    for preset, seeds in SEEDS.items():
        for seed in seeds:
            options = ["--preset", preset, "--seed", seed, "--gsd", "0.4", "--classes", CLASSES]
            tool.synth(OUT / f"{preset}-{seed}", *options)


def train(tool, trunks):
    for trunk in trunks or ["googlenet", "vgg16"]:
        for name in (f"{trunk}-start", trunk):
            experiment = ROOT / f"models/experiments/reference_38_{name.replace('-', '_')}.toml"
            if experiment.exists():
                train_one(tool, experiment, OUT / name)


def train_one(tool, experiment, folder):
    more = ["--resume"] if (folder / "checkpoint.safetensors").exists() else []
    subprocess.run([str(tool.file), "train", str(experiment), "-o", str(folder), "--threads", "2", *more], check=True)


def score(tool, model, site, crf):
    labels, truth = OUT / f"{model.stem}.{site}.tif", OUT / site / "truth/labels.tif"
    options = [] if crf == "none" else ["--crf", "--crf-set", crf]
    seconds = tool.timed("segment", OUT / site / "ortho.tif", "-o", labels, "--model", model, *options)
    found = tool.json("evaluate", "labels", labels, truth, "--json")
    merged = tool.json(
        "evaluate", "labels", labels, truth, "--merge", ROOT / "models/classes/merge_38_to_32.toml", "--json"
    )
    return {
        "commit": commit(),
        "accuracy": found["pixel_accuracy"],
        "mean_iou": found["mean_iou_of_truth_classes"],
        "merged": [merged["pixel_accuracy"], merged["mean_iou_of_truth_classes"]],
        "iou": found["iou"],
        "seconds_a_tile": seconds / (found["pixels"] / 256**2),
    }


def measure(tool, networks):
    results = read_results(STORE, {})
    for network in networks or PUBLISHED:
        model = OUT / network.split("-")[0] / f"{network}.safetensors"
        if not model.exists():
            continue
        for crf in CRF_SETS if network.endswith("-8s") else ["none"]:
            for site in HELD_OUT:
                results[f"{network}, {crf}, {site}"] = score(tool, model, site, crf)
                write_results(STORE, results)


def stages_table(results):
    text = header(["accuracy %, mean IoU %; s a tile", "thesis", *HELD_OUT, "merged to 32 classes"])
    for network, (accuracy, seconds, mean_iou) in PUBLISHED.items():
        found = [results.get(f"{network}, none, {site}") for site in HELD_OUT]
        cells = [f"{percent(r['accuracy'])}, {percent(r['mean_iou'])}" if r else "-" for r in found]
        speed = f"; {fixed(found[0]['seconds_a_tile'], 3)}" if found[0] else ""
        merged = ", ".join(percent(v) for v in found[0]["merged"]) if found[0] else "-"
        text += row([network, f"{accuracy}, {mean_iou or '-'}; {seconds}", cells[0] + speed, cells[1], merged])
    return text


def sets_table(results):
    text = header(
        ["accuracy %, mean IoU % with the CRF", "thesis, VGG16-8s", *(n for n in PUBLISHED if n[-3:] == "-8s")]
    )
    for crf, published in CRF_SETS.items():
        found = [results.get(f"{n}, {crf}, {HELD_OUT[0]}") for n in PUBLISHED if n.endswith("-8s")]
        cells = [f"{percent(r['accuracy'])}, {percent(r['mean_iou'])}" if r else "-" for r in found]
        text += row([crf, published, *cells])
    return text


def classes_table(results):
    columns = [f"{n}-8s" for n in ("googlenet", "vgg16")]
    text = header(["IoU %", *(f"{c}: thesis, {', '.join(HELD_OUT)}" for c in columns)])
    for line in PER_CLASS.replace("\n", "|").split("|"):
        name, *published = line.split()
        cells = [name]
        for column, value in zip(columns, published, strict=False):
            found = [results.get(f"{column}, none, {site}", {}).get("iou", {}).get(name) for site in HELD_OUT]
            cells.append(", ".join([value, *(percent(v) if v is not None else "-" for v in found)]))
        text += row(cells)
    return text


def run(args):
    tool = Tool(args.tool)
    if args.action == "make":
        make(tool)
    elif args.action == "train":
        make(tool)
        train(tool, args.names)
    else:
        if args.action == "measure":
            measure(tool, args.names)
        results = read_results(STORE, {})
        write_between(NOTE, "stages", stages_table(results))
        write_between(NOTE, "sets", sets_table(results))
        write_between(NOTE, "classes", classes_table(results))
