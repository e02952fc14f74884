# SPDX-License-Identifier: Apache-2.0
"""How a build grows with its area: seconds, memory and disk of each stage. Writes docs/measured/scaling.md and its
curve.

By hand, on a machine that does nothing else: 100 km2 take a quarter of an hour, to make the site as long again (25
minutes where it is a conurbation). --only 1,10 measures less; a site that is there is not made again.
"""

import json
import math
import os
import shutil
import time

from measuring.common import (
    IMAGES,
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    children_seconds,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE, CURVE = "scaling.json", PAGES / "scaling.md", IMAGES / "scaling.svg"
SITES = {
    "1": ["--preset", "village", "--seed", "7", "--size", "1000", "--gsd", "0.5"],
    "4": ["--preset", "region", "--seed", "7", "--size", "2000"],
    "10": ["--preset", "region", "--seed", "7", "--size", "3160"],
    "100": ["--preset", "region", "--seed", "7", "--size", "10000"],
}
CITIES = {
    "10c": ["--preset", "conurbation", "--seed", "7", "--size", "3160"],
    "100c": ["--preset", "conurbation", "--seed", "7", "--size", "10000"],
}
REAL = {"3": ROOT / "sites/kvarnbyn.toml", "23": ROOT / "sites/pardubice.toml"}
STAGES = ["segment", "refine", "elevate", "network", "scene", "drive", "report"]


def add_arguments(parser):
    add_tool(parser, "out/scaling")
    add_only(parser, [*SITES, *REAL, *CITIES])
    add_table(parser)
    parser.add_argument(
        "--fit",
        action="store_true",
        help="ask `orthodrive plan` again; print what its costs should be, by the last results",
    )


def measure(tool, site, out):
    shutil.rmtree(out, ignore_errors=True)
    load, start, cpu = os.getloadavg()[0], time.monotonic(), children_seconds()
    tool("build", site, "-o", out)
    seconds, cpu = time.monotonic() - start, children_seconds() - cpu
    run = json.loads((out / "run.json").read_text())
    stages = {s["stage"]: {"seconds": s["seconds"], "memory_mb": s["peak_memory_bytes"] / 1e6} for s in run["stages"]}
    numbers = {s["stage"]: s["numbers"] for s in run["stages"]}
    of_stages = sum(s["seconds"] for s in stages.values())
    return {
        "plan": tool.json("plan", site, "--json"),
        "commit": commit(),
        "load": round(load, 1),
        "seconds": of_stages,
        "beside_s": seconds - of_stages,
        "core_seconds": cpu,
        "stages": stages,
        "road_km": numbers["network"]["length_m"] / 1e3,
        "disk_mb": sum(f.stat().st_size for f in out.rglob("*") if f.is_file()) / 1e6,
        "memory_mb": max(s["memory_mb"] for s in stages.values()),
    }


def km2(name):
    return float(name.rstrip("c"))


def title(name):
    return f"{km2(name):g} km2" + (
        f" ({REAL[name].stem})" if name in REAL else ", a conurbation" if name in CITIES else ""
    )


def slope(numbers, value):
    """Of value over km2 between the two largest of these areas, with what is left at none: (base, per km2)."""
    a, b = sorted(numbers, key=km2)[-2:]
    per_km2 = (value(numbers[b]) - value(numbers[a])) / (km2(b) - km2(a))
    return value(numbers[b]) - per_km2 * km2(b), per_km2


def table(numbers):
    areas = sorted(numbers, key=lambda name: (name in CITIES, km2(name)))
    text = header(["", *map(title, areas), "asked"])

    def of(value, digits=1):
        return [fixed(value(numbers[a]), digits) for a in areas]

    text += row(["seconds of all stages", *of(lambda n: n["seconds"], 0), ""])
    text += row(["seconds a km2", *[fixed(numbers[a]["seconds"] / km2(a), 2) for a in areas], "6 at 100 km2"])
    text += row(
        [
            "seconds beside the stages: content of the sources, scores against the truth",
            *of(lambda n: n["beside_s"], 0),
            "",
        ]
    )
    text += row(
        ["processor seconds a km2, with those", *[fixed(numbers[a]["core_seconds"] / km2(a), 2) for a in areas], ""]
    )
    text += row(["most memory, GB", *of(lambda n: n["memory_mb"] / 1e3, 2), "4 at 100 km2"])
    text += row(["result, MB", *of(lambda n: n["disk_mb"], 0), ""])
    text += row(["roads in the result, km", *of(lambda n: n["road_km"], 0), ""])
    text += row(["roads, km a km2", *[fixed(numbers[a]["road_km"] / km2(a), 1) for a in areas], "as Pardubice"])
    for stage in STAGES:
        text += row(
            [
                f"{stage}: seconds a km2 (memory, GB)",
                *[
                    (
                        f"{fixed(numbers[a]['stages'][stage]['seconds'] / km2(a), 2)} "
                        f"({fixed(numbers[a]['stages'][stage]['memory_mb'] / 1e3, 2)})"
                    )
                    for a in areas
                ],
                "",
            ]
        )
    text += row(["load of others at the start", *of(lambda n: n["load"]), ""])
    return text


def planned(numbers):
    """What `orthodrive plan` says for the machine of its costs, over what a build took."""
    text = header(["", "seconds, said", "taken", "memory, GB, said", "taken", "disk, MB, said", "taken"])
    for name in sorted(numbers, key=lambda name: (name in CITIES, km2(name))):
        n = numbers[name]
        text += row(
            [
                title(name),
                fixed(n["plan"]["speed"] * n["plan"]["seconds"], 0),
                fixed(n["seconds"], 0),
                fixed(n["plan"]["memory_mb"] / 1e3, 2),
                fixed(n["memory_mb"] / 1e3, 2),
                fixed(n["plan"]["disk_mb"], 0),
                fixed(n["disk_mb"], 0),
            ]
        )
    return text


def fit(numbers):
    """Costs for pipeline/build/plan_build.cpp: base, a km2, a megapixel, a km of road, none below zero, by the least
    sum of squared relative errors.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 (Debian's python3-scipy; only --fit asks)

    sizes = [[1.0, *(n["plan"][key] for key in ("area_km2", "megapixels", "road_km"))] for n in numbers.values()]
    for stage in STAGES:
        costs = []
        for key in ("seconds", "memory_mb"):
            values = [n["stages"][stage][key] for n in numbers.values()]
            x, _ = nnls(
                [[size / value for size in row] for row, value in zip(sizes, values, strict=True)], [1.0] * len(values)
            )
            worst = max(
                abs(sum(a * b for a, b in zip(x, row, strict=True)) / value - 1)
                for row, value in zip(sizes, values, strict=True)
            )
            costs.append("{" + ", ".join(f"{v:.3g}" for v in x) + f"}} (at worst {100 * worst:.0f} % off)")
        print(stage, *costs)


def model(numbers):
    """Cost = base + per km2, by the two largest areas; what a country would take by it."""
    text = header(["", "base", "a km2", "1000 km2", "80 000 km2"])
    base, per = slope(numbers, lambda n: n["core_seconds"])
    text += row(
        [
            "processor seconds",
            fixed(base, 0),
            fixed(per, 2),
            f"{fixed((base + 1e3 * per) / 3600, 1)} h of a core",
            f"{fixed((base + 8e4 * per) / 86400, 0)} days of a core",
        ]
    )
    for stage in STAGES:
        base, per = slope(numbers, lambda n: n["stages"][stage]["memory_mb"] / 1e3)
        text += row([f"memory of {stage}, GB", fixed(base, 2), fixed(per, 4), fixed(base + 1e3 * per, 1), ""])
    base, per = slope(numbers, lambda n: n["disk_mb"] / 1e3)
    return text + row(
        ["disk, GB", fixed(base, 2), fixed(per, 4), fixed(base + 1e3 * per, 0), fixed(base + 8e4 * per, 0)]
    )


def curve(numbers):
    """Seconds a km2 of each stage over the area, stacked, as an SVG."""
    areas = sorted(numbers.keys() & SITES.keys(), key=km2)
    width, height, left, bottom, right = 640, 360, 60, 40, 110
    top = 1.1 * max(
        sum(s["seconds"] for s in n["stages"].values()) / float(a) for a, n in numbers.items() if a in SITES
    )

    def x(a):
        return left + (width - left - right) * (math.log10(float(a)) - math.log10(float(areas[0]))) / (
            math.log10(float(areas[-1])) - math.log10(float(areas[0]))
        )

    def y(v):
        return height - bottom - (height - bottom - 20) * v / top

    colors = ["#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377", "#bbbbbb"]
    parts = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            'font-size="12">'
        ),
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    below = [0.0] * len(areas)
    for stage, color in zip(STAGES, colors, strict=False):
        above = [b + numbers[a]["stages"][stage]["seconds"] / float(a) for a, b in zip(areas, below, strict=True)]
        points = [f"{x(a):.1f},{y(v):.1f}" for a, v in zip(areas, above, strict=True)] + [
            f"{x(a):.1f},{y(v):.1f}" for a, v in reversed(list(zip(areas, below, strict=True)))
        ]
        parts.append(f'<polygon points="{" ".join(points)}" fill="{color}"/>')
        at = height - bottom - 20 * STAGES.index(stage)
        parts.append(
            f'<rect x="{width - right + 12}" y="{at - 10}" width="12" height="12" fill="{color}"/><text '
            f'x="{width - right + 30}" y="{at}">{stage}</text>'
        )
        below = above
    step = 2 if top > 8 else 1
    for v in range(0, int(top) + 1, step):
        parts.append(
            f'<text x="{left - 8}" y="{y(v) + 4:.1f}" text-anchor="end">{v}</text><line x1="{left - 4}" x2="{left}" '
            f'y1="{y(v):.1f}" y2="{y(v):.1f}" stroke="black"/>'
        )
    parts.append(
        f'<line x1="{left}" x2="{width - right}" y1="{y(6):.1f}" y2="{y(6):.1f}" stroke="black" stroke-dasharray="4"/>'
        f'<text x="{left + 6}" y="{y(6) - 5:.1f}">asked: 6</text>'
    )
    for a in areas:
        parts.append(f'<text x="{x(a):.1f}" y="{height - bottom + 16}" text-anchor="middle">{a}</text>')
    parts.append(f'<text x="{left}" y="14">seconds a km2, stages from nothing, over the area in km2</text></svg>')
    return "\n".join(parts) + "\n"


def run(args):
    numbers = read_results(STORE, {})
    if not args.table and not args.fit:
        tool = Tool(args.tool)
        for name in args.only:
            site = REAL.get(name) or tool.synth(args.out / name / "site", *(SITES | CITIES)[name]) / "site.toml"
            numbers[name] = measure(tool, site, args.out / name / "out")
            print(name, {k: v for k, v in numbers[name].items() if k != "stages"}, flush=True)
            numbers["machine"] = machine()
            write_results(STORE, numbers)
    sites = {name: n for name, n in numbers.items() if name in SITES | REAL | CITIES}
    if args.fit:
        for name, site in sites.items():
            site["plan"] = Tool(args.tool).json("plan", REAL.get(name, args.out / name / "site/site.toml"), "--json")
        write_results(STORE, numbers)
        fit(sites)
    m = numbers["machine"]
    CURVE.write_text(curve(sites))
    parts = {
        "scaling": table(sites) + f"\nMeasured on {m['cores']} cores ({m['cpu']}), {m['memory_gb']} GB.\n",
        "planned": planned(sites),
    }
    for mark, kind in [("model", SITES), ("model_city", CITIES)]:
        if len(sites.keys() & kind.keys()) >= 2:
            parts[mark] = model({name: n for name, n in sites.items() if name in kind})
    write_page(PAGE, [STORE], parts)
