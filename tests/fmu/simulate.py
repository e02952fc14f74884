#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""FMPy, a simulator of others, loads our FMUs: their descriptions are valid, and their answers are those of the
libraries.

Usage: simulate.py TOOL TRUTH NETWORK CAR FOLDER, with the Python of build/peers/fmi; tests/fmu/CMakeLists.txt runs it.
"""

import math
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

tool, truth, network, car, folder = sys.argv[1:]
folder = Path(folder)
STEP_S = 0.01
TOLERANCE = 1e-9


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def pack(name, *options):
    path = folder / name
    subprocess.run([tool, "-q", "fmu", "--network", network, "-o", path, *options], check=True)
    again = folder / ("again_" + name)
    subprocess.run([tool, "-q", "fmu", "--network", network, "-o", again, *options], check=True)
    check(path.read_bytes() == again.read_bytes(), f"{name}: the same input gives other bytes")
    problems = validate_fmu(str(path))
    check(not problems, f"{name}: {problems}")
    return path


def true_rows(arguments, rows):
    text = "\n".join(" ".join(repr(float(v)) for v in row) for row in rows) + "\n"
    out = subprocess.run([truth, *map(str, arguments)], input=text, capture_output=True, text=True, check=True).stdout
    return np.array([[float(v) for v in line.split()] for line in out.splitlines()])


def as_input(names, times, rows):
    """FMPy's input: a structured array with the column time."""
    table = np.zeros(len(times), dtype=[("time", float)] + [(n, float) for n in names])
    table["time"] = times
    for k, name in enumerate(names):
        table[name] = [row[k] for row in rows]
    return table


def simulate(path, names, outputs, times, rows, **start_values):
    description = read_model_description(str(path))
    result = simulate_fmu(
        str(path),
        start_time=0.0,
        stop_time=times[-1],
        step_size=STEP_S,
        output_interval=STEP_S,
        fmi_type="CoSimulation",
        input=as_input(names, times, rows),
        output=outputs,
        start_values=start_values,
        model_description=description,
    )
    check(len(result) == len(times), f"{path.name}: {len(result)} samples of {len(times)}")
    return np.array([[float(sample[o]) for o in outputs] for sample in result])


def compare(name, got, expected):
    worst = np.abs(got - expected) / np.maximum(1.0, np.abs(expected))
    check(
        worst.max() <= TOLERANCE,
        f"{name}: differs by {worst.max():.3g} at sample, column {np.unravel_index(worst.argmax(), worst.shape)}",
    )
    print(f"{name}: {got.shape[0]} samples of {got.shape[1]} outputs, largest difference {worst.max():.2g}")


def roads(path, **start_values):
    """Four tyres along the quarter circle; the last leaves the road."""
    times = [k * STEP_S for k in range(301)]
    names = [f"tyre[{i}].{c}" for i in range(1, 5) for c in ("x", "y", "z_guess")]
    outputs = [
        f"tyre[{i}].{c}" for i in range(1, 5) for c in ("z", "normal.x", "normal.y", "normal.z", "friction", "status")
    ]
    rows = []
    for t in times:
        row = []
        for i in range(4):
            angle, radius = 0.05 + 0.4 * t + 0.02 * i, 98.0 + 0.8 * i + (2.0 * t if i == 3 else 0.0)
            row += [radius * math.sin(angle), 100.0 - radius * math.cos(angle), 22.0]
        rows.append(row)
    got = simulate(path, names, outputs, times, rows, **start_values)
    expected = true_rows(["roads", network], rows)
    check(set(expected[:, 23]) == {0.0, 1.0}, "the fourth tyre does not leave the road")
    # A step takes the inputs of its start.
    compare(path.name, got, np.vstack([expected[:1], expected[:-1]]))


def drive(path, **more):
    """Throttle, a bend, braking on the quarter circle."""
    times = [k * STEP_S for k in range(401)]
    rows = [[0.027 + 0.004 * math.sin(3 * t), 0.5 if t < 2.0 else 0.0, 0.4 if t > 2.5 else 0.0] for t in times]
    start = {
        "start.x": 99.0 * math.sin(0.1),
        "start.y": 100.0 - 99.0 * math.cos(0.1),
        "start.z_guess": 20.0,
        "start.heading": 0.1,
        "start.speed": 12.0,
    }
    outputs = [
        "x",
        "y",
        "z",
        "heading",
        "pitch",
        "roll",
        "speed",
        "lateral_speed",
        "acceleration.y",
        "engine.speed",
        "gear",
        "fuel",
    ]
    outputs += [f"wheel[{i}].{c}" for i in range(1, 5) for c in ("load", "slip_angle", "spin", "travel")]
    got = simulate(path, ["steering", "throttle", "brake"], outputs, times, rows, **start, **more)
    arguments = ["car", network, car, *start.values(), round(STEP_S / 0.001)]
    expected = true_rows(arguments, rows)[:-1]
    check(expected[-1][6] < 12.0 < expected[200][6] and abs(expected[100][8]) > 1.0, "the car does not drive as meant")
    compare(path.name, got, expected)


def refusals(roads_fmu):
    """A road that is not there ends the simulation, with our line in the log."""
    lines = []
    try:
        simulate_fmu(
            str(roads_fmu),
            stop_time=0.1,
            step_size=STEP_S,
            start_values={"road_file": "/no/such.xodr"},
            logger=lambda *arguments: lines.append(arguments[-1]),
        )
        check(False, "a missing network is no error")
    except Exception:  # FMPy's own, of no fixed type
        pass
    check(any(b"/no/such.xodr: cannot be opened" in line for line in lines), f"the log says {lines}")


three = pack("roads.fmu")
check("resources/roads.xodr" in zipfile.ZipFile(three).namelist(), "the network is not packed")
roads(three)
roads(pack("roads_2.fmu", "--fmi", "2"))
drive(pack("car.fmu", "--car", car))
drive(pack("car_2.fmu", "--car", car, "--fmi", "2"))
empty = folder / "empty.fmu"
subprocess.run([tool, "-q", "fmu", "-o", empty], check=True)
roads(empty, road_file=network)
refusals(three)
