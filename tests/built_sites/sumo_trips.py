# SPDX-License-Identifier: Apache-2.0
"""Random trips on a SUMO net: sumo_trips.py NET.xml FOLDER --trips N --seed S. One vehicle sets out every three
seconds, from anywhere to anywhere at least 300 m away that it can reach (randomTrips.py of SUMO). Collisions count on
junctions, too. Prints what came of them as JSON; `events` says where each collision, teleport and emergency braking
was: its lane and the metre on it.
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
ENVIRONMENT = {**os.environ, "SUMO_HOME": SUMO}  # else SUMO asks the network for its schemas
PERIOD_S = 3
# What SUMO 1.15 says of a vehicle that brakes as hard as it can, or does not come to a stop before the end of its lane.
BRAKING = re.compile(
    r"Warning: Vehicle '(?P<vehicle>.*?)' performs emergency (?:braking|stop).*? lane '(?P<lane>.*?)'.*"
)
TELEPORT = re.compile(r"Warning: Teleporting vehicle '(?P<vehicle>.*?)'.*lane='(?P<lane>.*?)'.*")


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
        env=ENVIRONMENT,
    )
    tree = ElementTree.parse(made)
    for vehicle in tree.getroot().findall("vehicle")[trips:]:
        tree.getroot().remove(vehicle)
    tree.write(made)
    return made, len(tree.getroot().findall("vehicle"))


def events_of(collisions, warnings):
    """A collision once, though SUMO tells it every second; of the others it says the lane only: they count at its
    begin.
    """
    events = {}
    for c in collisions:
        what = f"{c.get('type')}: {c.get('colliderSpeed')} m/s into {c.get('victimSpeed')} m/s at {c.get('time')} s"
        vehicles = sorted([c.get("collider"), c.get("victim")])
        events.setdefault(
            (*vehicles, c.get("lane")),
            {
                "kind": "collision",
                "lane": c.get("lane"),
                "pos_m": float(c.get("pos")),
                "what": what,
                "vehicles": vehicles,
            },
        )
    for kind, pattern in (("emergency braking", BRAKING), ("teleport", TELEPORT)):
        for found in pattern.finditer(warnings):
            events[found.start()] = {
                "kind": kind,
                "lane": found["lane"],
                "pos_m": 0.0,
                "what": found[0].split("; ")[-1].rstrip("."),
                "vehicles": [found["vehicle"]],
            }
    return list(events.values())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("net", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--trips", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    made, trips = routes(args.net, args.folder, args.trips, args.seed)
    report, collisions = args.folder / "statistics.xml", args.folder / "collisions.xml"
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
            "--collision-output",
            collisions,
        ],
        check=True,
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    text = ElementTree.parse(report).getroot()
    vehicles = text.find("vehicles").attrib
    events = events_of(ElementTree.parse(collisions).getroot(), run.stderr)
    print(
        json.dumps(
            {
                "trips": trips,
                "arrived": int(vehicles["inserted"]) - int(vehicles["running"]),
                "collisions": int(text.find("safety").get("collisions")),
                "teleports": int(text.find("teleports").get("total")),
                "emergency_brakings": sum(event["kind"] == "emergency braking" for event in events),
                "events": events,
            }
        )
    )


main()
