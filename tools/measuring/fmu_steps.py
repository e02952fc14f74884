# SPDX-License-Identifier: Apache-2.0
"""FMPy checks a car's FMU and drives it for a second. Usage, with the Python of build/peers/fmi:

fmu_steps.py FMU X Y Z HEADING
"""

import math
import sys

from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

fmu, pose = sys.argv[1], [float(word) for word in sys.argv[2:]]
problems = validate_fmu(fmu)
if problems:
    sys.exit(f"not valid: {problems}")
start = dict(zip(("start.x", "start.y", "start.z_guess", "start.heading"), pose, strict=True))
outputs = ["x", "y", "z", "speed", *(f"wheel[{i}].on_road" for i in range(1, 5))]
last = simulate_fmu(
    fmu,
    stop_time=1.0,
    step_size=0.01,
    fmi_type="CoSimulation",
    start_values={**start, "start.speed": 5.0, "throttle": 0.2},
    output=outputs,
)[-1]
driven_m = math.hypot(last["x"] - pose[0], last["y"] - pose[1])
if not (3.0 < driven_m < 8.0 and abs(last["z"] - pose[2]) < 2.0):
    sys.exit(f"after a second at 5 m/s the car is {driven_m:.2f} m on and {last['z'] - pose[2]:.2f} m higher")
