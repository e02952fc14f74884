# SPDX-License-Identifier: Apache-2.0
"""The pictures of docs/measured/elevate.md, as the reference's figures 3.9 and 3.10."""

import math

from measuring.common import IMAGES

COLORS = {
    "none": "#8a8f98",
    "ma11": "#c7a008",
    "ma35": "#d9820f",
    "ma67": "#b34a1f",
    "reference": "#2f6fde",
    "residual": "#8fb0ea",
    "default": "#0f9d58",
    "truth": "#111111",
}
TITLES = {
    "none": "terrain as sampled",
    "ma11": "moving average (11)",
    "ma35": "moving average (35)",
    "ma67": "moving average (67)",
    "reference": "NLO (reference)",
    "residual": "NLO, loss of 2.5 m",
    "default": "default",
    "truth": "true road",
}


def ticks(low, high, count):
    raw = (high - low) / count or 1
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * next(m for m in (1, 2, 5, 10) if m * power >= raw)
    first = math.ceil(low / step - 1e-9)
    return [f"{k * step:.12g}" for k in range(first, math.floor(high / step + 1e-9) + 1)]


def plot(x, y, w, h, x_range, y_range, x_label, y_label, body):
    def px(v):
        return x + (v - x_range[0]) / (x_range[1] - x_range[0]) * w

    def py(v):
        return y + h - (v - y_range[0]) / (y_range[1] - y_range[0]) * h

    svg = f'<rect x="{x}" y="{y}" width="{w}" height="{h}" fill="none" stroke="#999"/>'
    for v in ticks(*x_range, 6):
        at = f"{px(float(v)):.1f}"
        svg += (
            f'<path d="M{at} {y + h}v4" stroke="#999"/><text x="{at}" y="{y + h + 16}" text-anchor="middle">{v}</text>'
        )
    for v in ticks(*y_range, 5):
        svg += (
            f'<path d="M{x - 4} {py(float(v)):.1f}h{w + 4}" stroke="#ddd"/><text x="{x - 7}" '
            f'y="{py(float(v)) + 4:.1f}" text-anchor="end">{v}</text>'
        )
    svg += f'<text x="{x + w / 2:g}" y="{y + h + 33}" text-anchor="middle">{x_label}</text>'
    svg += f'<text transform="translate({x - 48} {y + h / 2:g}) rotate(-90)" text-anchor="middle">{y_label}</text>'
    return svg + body(px, py)


def svg_page(w, h, body):
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" '
        'font-family="sans-serif" font-size="12">'
        f'<rect width="100%" height="100%" fill="white"/>{body}</svg>\n'
    )


def range_of(values, share=0.06):
    low, high = min(values), max(values)
    more = (high - low or 1) * share
    return low - more, high + more


def energies(rows, samplings, methods):
    """E_RG against E_h to the truth, a panel a site (10 m grid), bilinear as rings and cubic as discs."""
    shown = [
        name
        for name in ("kvarnbyn 10 m", "village 10 m", "circuit 10 m", "junction 10 m")
        if f"{name} cubic default" in rows
    ]
    body = ""
    for i, name in enumerate(shown):
        points = [
            (s, m, rows[f"{name} {s} {m}"]["truth"]) for s in samplings for m in methods if f"{name} {s} {m}" in rows
        ]
        xs, top = (
            [1e4 * t["gradient_energy"] for _, _, t in points],
            1.08 * max(t["height_error_energy"] for _, _, t in points),
        )
        truth = 1e4 * points[0][2]["true_gradient_energy"]

        def draw_points(px, py):
            line = f'<path d="M{px(truth):.1f} {py(0):.1f}V{py(top):.1f}" stroke="#111" stroke-dasharray="4 3"/>'
            return line + "".join(
                f'<circle cx="{px(x):.1f}" cy="{py(t["height_error_energy"]):.1f}" r="5" stroke="{COLORS[m]}" '
                'stroke-width="2" '
                f'fill="{COLORS[m] if s == "cubic" else "white"}"/>'
                for x, (s, m, t) in zip(xs, points, strict=True)
            )

        left, above = 70 + i % 2 * 440, i // 2 * 330
        body += f'<text x="{left}" y="{24 + above}" font-weight="bold">{name.replace(" 10 m", "")}, 10 m grid</text>'
        body += plot(
            left,
            34 + above,
            340,
            230,
            range_of([*xs, truth]),
            (0, top),
            "E_RG, 1e-4 (dashed: of the truth)",
            "E_h against the truth, m2",
            draw_points,
        )
    legend = "".join(
        (
            f'<circle cx="{70 + k * 148}" cy="690" r="5" fill="{COLORS[m]}"/><text x="{80 + k * 148}" y="694">'
            f"{TITLES[m]}</text>"
        )
        for k, m in enumerate(methods)
    )
    return svg_page(900, 710, body + legend)


def profile(name, p):
    """Height and gradient over the distance along one way."""
    kinds = [k for k in ("none", "ma35", "reference", "default", "truth") if p.get(k)]
    values = [v for k in kinds for v in p[k]]
    length = max(v[0] for v in values)
    steep = range_of([100 * v[2] for k in kinds if k != "none" for v in p[k]], 0.3)

    def line(kind, column, px, py):
        style = 'stroke-width="1" stroke-dasharray="5 3"' if kind == "truth" else 'stroke-width="1.6"'
        places = " ".join(f"{px(v[0]):.1f},{py(100 * v[2] if column == 2 else v[column]):.1f}" for v in p[kind])
        return f'<polyline fill="none" stroke="{COLORS[kind]}" {style} points="{places}"/>'

    def lines(column):
        return lambda px, py: "".join(line(k, column, px, py) for k in kinds)

    body = f'<text x="70" y="22" font-weight="bold">{name}: way {p["way"]}, bilinear sampling</text>'
    body += plot(70, 34, 800, 220, (0, length), range_of([v[1] for v in values]), "", "height, m", lines(1))
    body += '<clipPath id="c"><rect x="70" y="300" width="800" height="220"/></clipPath>'
    body += plot(
        70,
        300,
        800,
        220,
        (0, length),
        steep,
        "distance along the way, m",
        "gradient, %",
        lambda px, py: f'<g clip-path="url(#c)">{lines(2)(px, py)}</g>',
    )
    body += "".join(
        (
            f'<path d="M{70 + i * 170} 572h24" stroke="{COLORS[k]}" stroke-width="2"/>'
            f'<text x="{100 + i * 170}" y="576">'
            f"{TITLES[k]}</text>"
        )
        for i, k in enumerate(kinds)
    )
    return svg_page(900, 590, body)


def draw(numbers, samplings, methods):
    if numbers["rows"]:
        (IMAGES / "heights_energies.svg").write_text(energies(numbers["rows"], samplings, methods))
    for name, p in numbers["profiles"].items():
        (IMAGES / f"heights_profile_{name.split(' ')[0]}.svg").write_text(profile(name, p))
