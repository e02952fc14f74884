# SPDX-License-Identifier: Apache-2.0
"""Learns the forests that `orthodrive refine --method mrf` needs: too large to be kept in the repository.

villages: from six synthetic villages of 0.2 m/px, made where missing -> OUT/forests_villages.yml
real:     from the pieces of Kvarnbyn and Pardubice (0.5 m/px) that were painted by hand to learn from,
          models/training/painted_*.geojson; the test pieces are none of them -> OUT/forests_real.yml
Some minutes and 2 GB.
"""

from measuring.common import DATA, ROOT, Tool, add_tool

SEEDS = (12, 13, 21, 24, 25, 26)  # weights were searched on 22 and 23, numbers are from 11 and 99
SETS = ["villages", "real"]


def add_arguments(parser):
    add_tool(parser, "out/forests")
    parser.add_argument(
        "sets", nargs="*", choices=[[], *SETS], metavar="villages|real", help="both where none is given"
    )


def learn(tool, out, sets):
    out.mkdir(parents=True, exist_ok=True)

    def forests(name, pairs, *options):
        tool(
            "forests",
            *(part for photo, labels in pairs for part in ("--photo", photo, "--labels", labels)),
            *options,
            "-o",
            out / name,
        )

    if "villages" in sets:
        sites = [
            tool.synth(ROOT / f"out/synth/village-{seed}", "--preset", "village", "--seed", seed) for seed in SEEDS
        ]
        forests(
            "forests_villages.yml",
            [(site / "ortho.tif", site / "truth/labels.tif") for site in sites],
            "--samples",
            "40000",
        )
    if "real" in sets:
        painted = ROOT / "models/training"
        forests(
            "forests_real.yml",
            [
                (DATA / "kvarnbyn/ortho.jpg", painted / "painted_kvarnbyn.geojson"),
                (DATA / "pardubice/ortho.tif", painted / "painted_pardubice.geojson"),
            ],
        )


def run(args):
    learn(Tool(args.tool), args.out, args.sets or SETS)
