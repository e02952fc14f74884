#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Prediction and the CRF give the same bits on a 64-bit Arm processor: built by a cross compiler, run in an emulator.

arm_test.py ROOT PRINT_BITS BUILD [ARCHITECTURE ...]

PRINT_BITS is the program for this processor. Networks besides the default one, by hand: an emulator takes its time.

Skipped where the compiler or the emulator is missing (tools/setup --peers).
"""

import pathlib
import shutil
import subprocess
import sys

NETWORKS = ["mobilenetv2-s32-fpn2-map"]
ARM = [
    "-DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++",
    "-DCMAKE_SYSTEM_NAME=Linux",
    "-DCMAKE_SYSTEM_PROCESSOR=aarch64",
]


def build(source, folder):
    words = ["cmake", "-S", source, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "--log-level=ERROR", *ARM]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--", "--quiet"], check=True)
    return folder / "print_bits"


def main():
    root, here, folder = map(pathlib.Path, sys.argv[1:4])
    networks = NETWORKS + sys.argv[4:]
    for program in ("aarch64-linux-gnu-g++", "qemu-aarch64"):
        if not shutil.which(program):
            print(f"SKIPPED: no {program}")
            return 77
    arm = build(root / "tests/processors/arm", folder)
    said = [
        subprocess.run([*words, *networks], check=True, capture_output=True, text=True).stdout
        for words in ([here], ["qemu-aarch64", arm])
    ]
    print(f"this processor:\n{said[0]}64-bit Arm:\n{said[1]}", end="")
    if len(said[0].splitlines()) != 2 * len(networks) + 1:
        return 1
    return int(said[0] != said[1])


sys.exit(main())
