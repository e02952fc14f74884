#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A site is the same bytes on every processor: its files as this one makes them, and with the kernels of older families
and with a C library and a JPEG library that believe themselves on an older processor.

same_bytes_test.py ROOT TOOL BUILT OUT     BUILT: where build_village and build_kvarnbyn have left their sites

The plain kernels build all anew. Kernels are used by `segment` alone (nets, crf), so with those of AVX2 only its files
are made anew: later stages run again where they differ. What this processor cannot run is said and left out. Oldest
processor: x86-64 with AVX2 and fused multiply-add (2013); without them the C library rounds exp, sin and pow otherwise,
and so do results.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT, TOOL, BUILT, OUT = (pathlib.Path(word) for word in sys.argv[1:])
# The C library chooses its functions by what these name; AVX2 and FMA are what every processor has.
OLDER_LIBC = "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW,-ERMS,-AVX_Fast_Unaligned_Load"
OLDER = {
    "plain": {"ORTHODRIVE_KERNELS": "plain", "GLIBC_TUNABLES": OLDER_LIBC, "JSIMD_FORCENONE": "1"},
    "avx2": {"ORTHODRIVE_KERNELS": "avx2", "GLIBC_TUNABLES": OLDER_LIBC, "JSIMD_FORCESSE2": "1"},
}
SEGMENTED = ("labels.tif", "confidence.tif", "road_probability.tif", ".orthodrive/alignment.csv")
NEEDED = {"plain": set(), "avx2": {"avx2", "fma"}, "avx512": {"avx512f", "avx512vl", "avx512dq"}}


def features():
    """What this processor can, as Linux names it."""
    lines = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return {word for line in lines if line.startswith("flags") for word in line.split()}


def run(environment, *words):
    subprocess.run([TOOL, "-q", *map(str, words)], env=environment, check=True, stdout=subprocess.DEVNULL)


def write_crg(environment, site, folder):
    """OpenCRG surfaces of a built site, which its build does not write."""
    run(environment, "network", "--roads", site / "roads.gpkg", "--crg", "all-of-route", "-o", folder / "roads.xodr")


def build(environment, folder, towns):
    """As build_village and build_kvarnbyn do."""
    run(environment, "synth", "--preset", "village", "--seed", "7", "-o", folder / "village_site")
    run(environment, "build", folder / "village_site/site.toml", "-o", folder / "village")
    for town in towns:
        run(environment, "build", ROOT / f"sites/{town}.toml", "-o", folder / town)


def segment_again(environment, folder, sites):
    """Copies of the built sites without what segment writes, built."""
    for site, file in sites.items():
        shutil.copytree(BUILT / site, folder / site, ignore=shutil.ignore_patterns("viewer_*.png", "cesium_*.png"))
        for segmented in SEGMENTED:
            (folder / site / segmented).unlink()
        run(environment, "build", file, "-o", folder / site)
        stages = json.loads((folder / site / "run.json").read_text(encoding="utf-8"))["stages"]
        if any(stage["skipped"] for stage in stages if stage["stage"] == "segment"):
            raise SystemExit(f"{site}: segment was taken over, nothing is compared")


def differ(name, pairs):
    """Names of the pairs of folders whose files differ."""
    different = []
    for here, there in pairs:
        print(f"{name}, {there.name}: ", end="", flush=True)
        if subprocess.run([ROOT / "tools/same_bytes", "compare", here, there], check=False).returncode != 0:
            different.append(f"{name}, {there.name}")
    return different


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    sites = {"village": BUILT / "village_site/site.toml"}
    if (BUILT / "kvarnbyn/run.json").exists():
        sites["kvarnbyn"] = ROOT / "sites/kvarnbyn.toml"
    else:
        print("SKIPPED: Kvarnbyn is not built here")
    if not NEEDED["avx512"] <= features():
        print("SKIPPED: this processor cannot run the kernels 'avx512'")
    here, plain, avx2 = (OUT / name for name in ("here", "plain", "avx2"))
    environment = {**os.environ, **OLDER["plain"]}
    build(environment, plain, [site for site in sites if site != "village"])
    crg_of = ((os.environ, BUILT / "village", here), (environment, plain / "village", plain))
    for environment_of, site, folder in crg_of:
        (folder / "crg").mkdir(parents=True)
        write_crg(environment_of, site, folder / "crg")
    pairs = [(BUILT / site, plain / site) for site in ("village_site", *sites)]
    different = differ("plain", [*pairs, (here / "crg", plain / "crg")])
    if NEEDED["avx2"] <= features():
        segment_again({**os.environ, **OLDER["avx2"]}, avx2, sites)
        different += differ("avx2", [(BUILT / site, avx2 / site) for site in sites])
    else:
        print("SKIPPED: this processor cannot run the kernels 'avx2'")
    print("different: " + ("; ".join(different) or "none"))
    return int(bool(different))


sys.exit(main())
