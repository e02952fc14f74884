# SPDX-License-Identifier: Apache-2.0
"""Lanes and speeds of the extracts of foreign_osm.py beside what Debian's netconvert makes of the same files: by way of
OSM and direction, the number of lanes for cars and the limit of the most length.
"""

import collections
import os
import subprocess
import xml.etree.ElementTree as ET

from measuring.common import fixed, header, row

ENVIRONMENT = os.environ | {"SUMO_HOME": "/usr/share/sumo"}
KMH = 3.6
SAME_KMH = 1.0  # netconvert rounds to cm/s; a mile per hour is 1.6
# Why values differ, by the tags of the way; the first that fits is the reason. With what is right there.
LANE_REASONS = [
    (
        "lanes for both directions",
        lambda t: "lanes:both_ways" in t or "turn:lanes:both_ways" in t or t.get("centre_turn_lane") == "yes",
        "ours are of type `bidirectional`; netconvert gives them to one direction",
    ),
    (
        "`lanes=1` without `oneway`, `reversible`",
        lambda t: (t.get("lanes") == "1" and not is_one_way(t)) or t.get("oneway") in ("reversible", "alternating"),
        "ours are for both directions; netconvert builds one or the other",
    ),
    (
        "lanes of buses, taxis or bicycles",
        lambda t: any(k.startswith(LANE_USERS) for k in t),
        "ours: no lane for cars; netconvert without `--osm.lane-access` lets cars onto them",
    ),
    (
        "`lanes:forward`, `lanes:backward`",
        lambda t: "lanes:forward" in t or "lanes:backward" in t,
        "ours: the tags",
    ),
    (
        "arrows without a number of lanes",
        lambda t: "lanes" not in t and any(k.startswith("turn:lanes") for k in t),
        "ours: as many lanes as arrows; netconvert: as many as in the class",
    ),
    (
        "an odd number for two directions",
        lambda t: not is_one_way(t) and t.get("lanes", "0").isdigit() and int(t.get("lanes", "0")) % 2 == 1,
        "no tag tells: ours gives the additional one to the forward direction",
    ),
    (
        "no tag",
        lambda t: "lanes" not in t,
        "ours: by the width of the class and the room beside other roads; netconvert: by class",
    ),
]
NO_ROOM = (
    "no room beside another road",
    None,
    "netconvert: the tag. Ours: the ways lie too near to each other for it, `network.too_many_lanes` tells",
)
SPEED_REASONS = [
    (
        "limit of a direction or lane",
        lambda t: any(k.startswith(("maxspeed:forward", "maxspeed:backward", "maxspeed:lanes")) for k in t),
        "ours: the tags",
    ),
    (
        "no tag",
        lambda t: "maxspeed" not in t,
        "ours: the country's or state's law, in towns and outside; netconvert: by class, as in Germany",
    ),
    ("a word as limit", lambda t: not t["maxspeed"][:1].isdigit(), "ours: what the law calls so"),
]
ALONE_REASONS = [
    ("reversible lanes", lambda t: t.get("oneway") in ("reversible", "alternating"), "both directions use them"),
    ("service roads", lambda t: t["highway"] == "service", "netconvert leaves out driveways and what is private"),
    ("tracks", lambda t: t["highway"] == "track", "netconvert keeps cars off them"),
    (
        "private roads",
        lambda t: t.get("access", t.get("motor_vehicle", "yes")) not in ("yes", "permissive", "designated"),
        "netconvert keeps cars off them; ours are drivable unless the tag says `no`",
    ),
]
OTHER = ("other", None, "")
LANE_USERS = (
    "bus",
    "psv",
    "taxi",
    "lanes:bus",
    "lanes:psv",
    "lanes:taxi",
    "bicycle:lanes",
    "access:lanes",
    "vehicle:lanes",
    "motor_vehicle:lanes",
    "motorcar:lanes",
)


def is_one_way(tags):
    return tags.get("oneway") in ("yes", "true", "1", "-1", "reverse") or (
        "oneway" not in tags and (tags.get("junction") in ("roundabout", "circular") or tags["highway"] == "motorway")
    )


def ways_of(extract):
    """Tags of the roads, by id."""
    ways = {}
    for way in ET.parse(extract).getroot().iter("way"):
        tags = {tag.get("k"): tag.get("v").strip() for tag in way.iter("tag")}
        if "highway" in tags:
            ways[way.get("id")] = tags
    return ways


class Lengths:
    """How many metres of a way and direction have which value."""

    def __init__(self):
        self.of = collections.defaultdict(lambda: collections.defaultdict(float))

    def add(self, way, along, value, length_m):
        self.of[way, along][value] += length_m

    def usual(self):
        """The value of the most length, and all metres; by way and whether along it."""
        return {
            key: (max(sorted(metres), key=metres.get), sum(metres.values())) for key, metres in sorted(self.of.items())
        }


def carries_cars(lane):
    if lane.get("allow") is not None:
        return "passenger" in lane.get("allow").split() or lane.get("allow") == "all"
    return "passenger" not in (lane.get("disallow") or "").split() and lane.get("disallow") != "all"


def of_netconvert(extract, folder):
    """Lanes for cars and their highest limit in km/h, as netconvert imports the file."""
    net = folder / "netconvert.net.xml"
    words = ["/usr/bin/netconvert", "--osm-files", extract, "--xml-validation", "never", "--geometry.remove", "false"]
    subprocess.run([*words, "-o", net], check=True, env=ENVIRONMENT, capture_output=True)
    lanes, speeds = Lengths(), Lengths()
    for _, edge in ET.iterparse(net):
        if edge.tag != "edge" or edge.get("function") == "internal":
            continue
        cars = [lane for lane in edge.iter("lane") if carries_cars(lane)]
        if cars:
            name, length_m = edge.get("id"), float(cars[0].get("length"))
            way, along = name.lstrip("-").split("#")[0], not name.startswith("-")
            lanes.add(way, along, len(cars), length_m)
            speeds.add(way, along, round(max(float(lane.get("speed")) for lane in cars) * KMH, 1), length_m)
    return lanes.usual(), speeds.usual()


def speed_kmh(element, otherwise=0.0):
    """Of a <speed> of OpenDRIVE."""
    if element is None or not element.get("max")[:1].isdigit():
        return otherwise
    return float(element.get("max")) * {"mph": 1.609344, "km/h": 1.0}.get(element.get("unit"), KMH)


def of_opendrive(xodr, ways):
    """The same of a file of ours. A lane for both directions counts in each."""
    lanes, speeds = Lengths(), Lengths()
    for _, road in ET.iterparse(xodr):
        if road.tag != "road" or road.get("junction") != "-1":
            continue
        data = {d.get("code"): d.get("value") for d in road.iter("userData")}
        way, length_m = data.get("osm_id"), float(road.get("length"))
        turned = ways.get(way, {}).get("oneway") in ("-1", "reverse")
        limit = speed_kmh(road.find("type/speed"))
        section, left_hand = road.find("lanes/laneSection"), road.get("rule") == "LHT"
        for side in ("left", "right"):
            along = (side == "left") == left_hand
            cars = [lane for lane in section.iterfind(f"{side}/lane") if lane.get("type") == "driving"]
            shared = [lane for lane in section.iter("lane") if lane.get("type") == "bidirectional"]
            if cars or (shared and not list(section.iterfind("*/lane[@type='driving']"))):
                lanes.add(way, along != turned, len(cars) or len(shared), length_m)
                limits = [speed_kmh(lane.find("speed"), limit) for lane in cars or shared]
                speeds.add(way, along != turned, round(max(limits), 1), length_m)
        road.clear()
    return lanes.usual(), speeds.usual()


def reason_of(tags, reasons):
    return next((name for name, fits, _ in reasons if fits(tags)), None)


def lane_reason(tags, own, other):
    return reason_of(tags, LANE_REASONS) or (NO_ROOM if own < other else OTHER)[0]


def speed_reason(tags, _own, _other):
    return reason_of(tags, SPEED_REASONS) or OTHER[0]


def add_to(different, reason, length_m, pair):
    entry = different.setdefault(reason, {"km": 0.0, "pairs": {}})
    entry["km"] += length_m / 1000
    entry["pairs"][pair] = entry["pairs"].get(pair, 0.0) + length_m / 1000


def compared(ours, theirs, ways, reason, is_same):
    """km of what both have: equal, and by reason different, with the pairs of values."""
    equal_m, different = 0.0, {}
    for key in sorted(ours.keys() & theirs.keys()):
        (own, length_m), (other, _), tags = ours[key], theirs[key], ways[key[0]]
        if is_same(own, other):
            equal_m += length_m
        else:
            add_to(different, reason(tags, own, other), length_m, f"{tags['highway']} {own:g}, {other:g}")
    return {"equal_km": equal_m / 1000, "different": different}


def alone(ours, theirs, ways):
    """Directions of ways that the one has alone. Ways without a road of ours lie in a junction."""
    different = {"ours": {}, "netconvert's": {}}
    for key in sorted(ours.keys() - theirs.keys()):
        if tags := ways.get(key[0]):  # the ring of a mini-roundabout is no way
            add_to(different["ours"], reason_of(tags, ALONE_REASONS) or OTHER[0], ours[key][1], tags["highway"])
    built = {way for way, _ in ours}
    for key in sorted(theirs.keys() - ours.keys()):
        if key[0] in built:
            tags, name = ways[key[0]], "netconvert's"
            add_to(different[name], reason_of(tags, LANE_REASONS) or OTHER[0], theirs[key][1], tags["highway"])
    return different


def measure_lanes(extract, xodr, folder):
    ways = ways_of(extract)
    (lanes, speeds), (their_lanes, their_speeds) = of_opendrive(xodr, ways), of_netconvert(extract, folder)
    return {
        "lanes": compared(lanes, their_lanes, ways, lane_reason, lambda a, b: a == b),
        "speeds": compared(speeds, their_speeds, ways, speed_reason, lambda a, b: abs(a - b) < SAME_KMH),
        "alone": alone(lanes, their_lanes, ways),
    }


ABOUT = """## Lanes and limits beside netconvert's

The same files, imported by Debian's netconvert (SUMO 1.15) with its defaults. By way of OSM and direction: lanes for
cars, and their highest limit, of the most length. A lane for both directions counts in each where a road has no others.
km are those of our roads; what lies inside a junction of ours is not compared.

"""


def merged(parts):
    total = {}
    for part in parts:
        for reason, entry in part.items():
            for pair, km in entry["pairs"].items():
                add_to(total, reason, km * 1000, pair)
    return total


def reasons_table(title, different, reasons):
    text = header([title, "km", "most of it: ours, netconvert's", ""])
    right = {name: why for name, _, why in [*reasons, NO_ROOM, OTHER]}
    for reason, entry in sorted(different.items(), key=lambda item: -item[1]["km"]):
        pair = max(sorted(entry["pairs"]), key=entry["pairs"].get)
        text += row([reason, fixed(entry["km"], 1), pair, right[reason]])
    return text + "\n"


def lanes_part(extracts):
    def km(numbers, what):
        different = sum(entry["km"] for entry in numbers[what]["different"].values())
        return numbers[what]["equal_km"] + different, different

    def equal(what):
        return fixed(sum(numbers[what]["equal_km"] for numbers in extracts.values()), 1)

    total = fixed(sum(km(numbers, "lanes")[0] for numbers in extracts.values()), 1)
    text = f"{ABOUT}**Of {total} km lanes are equal on {equal('lanes')} km, limits on {equal('speeds')} km.**\n\n"
    text += header(["extract", "km", "other lanes, km", "other limits, km", "ours alone, km"])
    for name, numbers in extracts.items():
        own = sum(entry["km"] for entry in numbers["alone"]["ours"].values())
        values = [km(numbers, "lanes")[0], km(numbers, "lanes")[1], km(numbers, "speeds")[1], own]
        text += row([name, *(fixed(value, 1) for value in values)])
    text += "\n"
    for title, what, reasons in (
        ("other lanes where", "lanes", LANE_REASONS),
        ("other limits where", "speeds", SPEED_REASONS),
    ):
        text += reasons_table(title, merged(n[what]["different"] for n in extracts.values()), reasons)
    for title, whose, reasons in (
        ("directions that ours has alone", "ours", ALONE_REASONS),
        ("directions that netconvert has alone, of ways that have roads of ours", "netconvert's", LANE_REASONS),
    ):
        if found := merged(n["alone"][whose] for n in extracts.values()):
            text += reasons_table(title, found, reasons)
    return text
