# SPDX-License-Identifier: Apache-2.0
"""Draws lanes, markings and connecting roads of places of an OpenDRIVE file as SVG.

Several places become panels beside each other, three in a row.

Roads outside junctions are grey, darker the higher their layer, sidewalks and shoulders light; connecting roads are
drawn by their lanes' middle lines; lane borders as they are marked. Bridges have a blue edge, tunnels a dashed one.
"""

import math
import xml.etree.ElementTree as ElementTree

STEP_M = 1.0


def pose(g, ds):
    x, y, hdg, kind = float(g.get("x")), float(g.get("y")), float(g.get("hdg")), g[0]
    length = float(g.get("length"))
    if kind.tag == "line":
        return x + ds * math.cos(hdg), y + ds * math.sin(hdg), hdg
    if kind.tag in ("arc", "spiral"):
        k0 = float(kind.get("curvature") or kind.get("curvStart"))
        rate = 0.0 if kind.tag == "arc" else (float(kind.get("curvEnd")) - k0) / length
        n = max(2, 2 * math.ceil(ds))  # Simpson's rule over half metres
        h = ds / n

        def heading(s):
            return hdg + s * (k0 + 0.5 * rate * s)

        for i in range(n + 1):
            weight = h / 3 * (1 if i in (0, n) else 4 if i % 2 else 2)
            x += weight * math.cos(heading(i * h))
            y += weight * math.sin(heading(i * h))
        return x, y, heading(ds)
    c = {k: float(v) for k, v in kind.attrib.items() if k != "pRange"}
    p = ds if kind.get("pRange") == "arcLength" else ds / length
    u = c["aU"] + p * (c["bU"] + p * (c["cU"] + p * c["dU"]))
    v = c["aV"] + p * (c["bV"] + p * (c["cV"] + p * c["dV"]))
    turn = math.atan2(c["bV"] + p * (2 * c["cV"] + 3 * p * c["dV"]), c["bU"] + p * (2 * c["cU"] + 3 * p * c["dU"]))
    return x + u * math.cos(hdg) - v * math.sin(hdg), y + u * math.sin(hdg) + v * math.cos(hdg), hdg + turn


def cubic(elements, s, name="s"):
    found = None
    for e in elements:
        if float(e.get(name)) <= s + 1e-9:
            found = e
    if found is None:
        return 0.0
    ds = s - float(found.get(name))
    a, b, c, d = (float(found.get(k)) for k in "abcd")
    return a + ds * (b + ds * (c + ds * d))


def borders(road):
    """[(lane, [(inner x, y)], [(outer x, y)])] of the first section of a road."""
    geometry = road.findall("planView/geometry")
    length = float(road.get("length"))
    section = road.find("lanes/laneSection")
    offset = road.findall("lanes/laneOffset")
    lanes = {
        side: sorted(section.findall(f"{side}/lane"), key=lambda lane: abs(int(lane.get("id"))))
        for side in ("left", "right")
    }
    result = [(lane, [], []) for side in lanes for lane in lanes[side]]
    steps = max(1, math.ceil(length / STEP_M))
    for i in range(steps + 1):
        s = length * i / steps
        g = [e for e in geometry if float(e.get("s")) <= s + 1e-9][-1]
        x, y, hdg = pose(g, min(s - float(g.get("s")), float(g.get("length"))))

        def at(t):
            return (x - t * math.sin(hdg), y + t * math.cos(hdg))

        k = 0
        for side, sign in (("left", 1), ("right", -1)):
            t = cubic(offset, s)
            for lane in lanes[side]:
                inner, t = t, t + sign * cubic(lane.findall("width"), s, "sOffset")
                result[k][1].append(at(inner))
                result[k][2].append(at(t))
                k += 1
    return result, section.find("center/lane")


def outer_edges(lanes):
    """Of the outermost lanes; a one-way road's inner edge is that of its first lane."""
    sides = {
        sign: [(inner, outer) for lane, inner, outer in lanes if int(lane.get("id")) * sign > 0] for sign in (1, -1)
    }
    edges = [side[-1][1] for side in sides.values() if side]
    return edges if len(edges) > 1 else [*edges, lanes[0][1]]


def draw(root, cx, cy, half):
    """SVG shapes of the place, from below upwards; what lies outside it is left out."""
    shapes = []  # (order, svg)
    offset = root.find("header/offset")
    if offset is not None:
        cx, cy = cx - float(offset.get("x")), cy - float(offset.get("y"))

    def seen(points):
        return any(abs(x - cx) < half + 5 and abs(y - cy) < half + 5 for x, y in points)

    def path(points):
        return " ".join(f"{x - cx + half:.1f},{half - (y - cy):.1f}" for x, y in points)

    def add(order, kind, points, style):
        if seen(points):
            shapes.append((order, f'<{kind} points="{path(points)}" {style}/>'))

    for road in root.iter("road"):
        if not any(
            abs(float(g.get("x")) - cx) < half + 250 and abs(float(g.get("y")) - cy) < half + 250
            for g in road.iter("geometry")
        ):
            continue
        layer = next((int(u.get("value")) for u in road.iter("userData") if u.get("code") == "layer"), 0)
        lanes, centre = borders(road)
        if road.get("junction") != "-1":
            for _, inner, outer in lanes:
                middle = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(inner, outer, strict=True)]
                add(layer * 10, "polygon", inner + outer[::-1], 'fill="#b9bec4"')
                add(layer * 10 + 3, "polyline", middle, f'fill="none" stroke="#c2571a" stroke-width="{half / 200:g}"')
            continue
        grey = 150 - 25 * max(-1, min(layer, 2))
        for lane, inner, outer in lanes:
            fill = f"rgb({grey},{grey},{grey + 6})" if lane.get("type") == "driving" else "#ddd8c8"
            add(layer * 10 + 1, "polygon", inner + outer[::-1], f'fill="{fill}"')
        marked = [(centre.find("roadMark"), lanes[0][1])] + [(lane.find("roadMark"), outer) for lane, _, outer in lanes]
        for mark, line in marked:
            if mark is not None and mark.get("type") != "none":
                dash = ' stroke-dasharray="3 3"' if mark.get("type") == "broken" else ""
                add(
                    layer * 10 + 2,
                    "polyline",
                    line,
                    f'fill="none" stroke="#fff" stroke-width="{max(0.2, float(mark.get("width")))}"{dash}',
                )
        for kind, dash in (("bridge", ""), ("tunnel", ' stroke-dasharray="2 2"')):
            if road.find(f"objects/{kind}") is not None:
                for line in outer_edges(lanes):
                    add(
                        layer * 10 + 2,
                        "polyline",
                        line,
                        f'fill="none" stroke="#1f5fae" stroke-width="{half / 60:g}"{dash}',
                    )
    return "\n".join(svg for _, svg in sorted(shapes, key=lambda shape: shape[0]))


def add_arguments(parser):
    parser.add_argument("source", metavar="FILE.xodr")
    parser.add_argument("target", metavar="OUT.svg")
    parser.add_argument(
        "numbers",
        type=float,
        nargs="+",
        metavar="X Y HALF_WIDTH_M",
        help="places, in the coordinates of the geoReference",
    )


def run(args):
    source, target, numbers = args.source, args.target, args.numbers
    places = [numbers[i : i + 3] for i in range(0, len(numbers), 3)]
    root = ElementTree.parse(source).getroot()
    columns, panel, gap = min(3, len(places)), 900 if len(places) == 1 else 450, 6
    panels = []
    for k, (cx, cy, half) in enumerate(places):
        x, y, size = k % columns * (panel + gap), k // columns * (panel + gap), 2 * half
        panels.append(
            f'<svg x="{x}" y="{y}" width="{panel}" height="{panel}" viewBox="0 0 {size:g} {size:g}">\n'
            f'<rect width="{size:g}" height="{size:g}" fill="#eef0ea"/>\n{draw(root, cx, cy, half)}\n</svg>'
        )
    width, height = columns * (panel + gap) - gap, -(-len(places) // columns) * (panel + gap) - gap
    with open(target, "w", encoding="utf-8") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">\n'
            + "\n".join(panels)
            + "\n</svg>\n"
        )
