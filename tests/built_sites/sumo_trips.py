# SPDX-License-Identifier: Apache-2.0
"""Random trips on a SUMO net: sumo_trips.py NET.xml FOLDER --trips N --seed S. One vehicle sets out every three
seconds, from anywhere to anywhere at least 300 m away that it can reach (randomTrips.py of SUMO). Collisions count on
junctions, too. Prints what came of them as JSON.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
from xml.etree import ElementTree

SUMO = "/usr/share/sumo"
PERIOD_S = 3


def routes(net, folder, trips, seed):
    """The first `trips` of some more: randomTrips leaves out those without a route."""
    made = folder.resolve() / "routes.xml"
    subprocess.run(
        [
            sys.executable,
            f"{SUMO}/tools/randomTrips.py",
            "-n",
            net.resolve(),
            "-o",
            made.with_name("trips.xml"),
            "--route-file",
            made,
            "--validate",
            "-e",
            str(2 * PERIOD_S * trips),
            "-p",
            str(PERIOD_S),
            "--min-distance",
            "300",
            "--seed",
            str(seed),
        ],
        check=True,
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "SUMO_HOME": SUMO},
    )
    tree = ElementTree.parse(made)
    for vehicle in tree.getroot().findall("vehicle")[trips:]:
        tree.getroot().remove(vehicle)
    tree.write(made)
    return made, len(tree.getroot().findall("vehicle"))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("net", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--trips", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    made, trips = routes(args.net, args.folder, args.trips, args.seed)
    report = args.folder / "statistics.xml"
    run = subprocess.run(
        [
            "/usr/bin/sumo",
            "-n",
            args.net,
            "-r",
            made,
            "--no-step-log",
            "--end",
            "7200",
            "--collision.action",
            "warn",
            "--collision.check-junctions",
            "true",
            "--statistic-output",
            report,
        ],
        check=True,
        capture_output=True,
        text=True,
    )
    text = ElementTree.parse(report).getroot()
    vehicles = text.find("vehicles").attrib
    print(
        json.dumps(
            {
                "trips": trips,
                "arrived": int(vehicles["inserted"]) - int(vehicles["running"]),
                "collisions": int(text.find("safety").get("collisions")),
                "teleports": int(text.find("teleports").get("total")),
                "warnings": re.findall(r"Warning: .*(?:collision|eleport).*", run.stderr)[:10],
            }
        )
    )


main()
