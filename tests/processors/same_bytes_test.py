#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A site is the same bytes on every processor: its files with the kernels of each family, and with a C library and a
JPEG library that believe themselves on an older processor.

same_bytes_test.py ROOT TOOL OUT SITE [SITE ...]     sites of tools/same_bytes: village, circuit, kvarnbyn, pardubice

What this processor cannot run is said and left out. Oldest processor: x86-64 with AVX2 and fused multiply-add (2013);
without them the C library's exp, sin and pow round differently, and so do results.
"""

import os
import pathlib
import shutil
import subprocess
import sys

# The C library chooses its functions by what these name; AVX2 and FMA are what every processor has.
OLDER_LIBC = "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW,-ERMS,-AVX_Fast_Unaligned_Load"
PROCESSORS = {
    "plain": {"ORTHODRIVE_KERNELS": "plain", "GLIBC_TUNABLES": OLDER_LIBC, "JSIMD_FORCENONE": "1"},
    "avx2": {"ORTHODRIVE_KERNELS": "avx2", "GLIBC_TUNABLES": OLDER_LIBC, "JSIMD_FORCESSE2": "1"},
    "avx512": {"ORTHODRIVE_KERNELS": "avx512"},
}


NEEDED = {"plain": set(), "avx2": {"avx2", "fma"}, "avx512": {"avx512f", "avx512vl", "avx512dq"}}


def features():
    """What this processor can, as Linux names it."""
    lines = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return {word for line in lines if line.startswith("flags") for word in line.split()}


def main():
    root, tool, out, sites = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]), sys.argv[4:]
    compare = pathlib.Path(root) / "tools/same_bytes"
    shutil.rmtree(out, ignore_errors=True)
    first, compared, different = None, 0, 0
    for name, variables in PROCESSORS.items():
        environment = {**os.environ, **variables}
        if not NEEDED[name] <= features():
            print(f"SKIPPED: this processor cannot run the kernels '{name}'")
            continue
        build = [compare, "build", "--tool", tool, "--sites", ",".join(sites), out / name]
        subprocess.run(build, env=environment, check=True)
        if first is None:
            first = out / name
            continue
        compared += 1
        different += subprocess.run([compare, "compare", first, out / name], check=False).returncode != 0
    print(f"same bytes: {compared} builds compared with that of '{first.name}', {different} different")
    return 77 if compared == 0 else int(different > 0)


sys.exit(main())
