# SPDX-License-Identifier: Apache-2.0
"""`orthodrive fetch` from loopback: tiles a second, tiles under injected faults, kills. Writes docs/measured/fetch.md.

Needs fetch_tile_server of the tests (cmake --build build/release --target fetch_tile_server), Debian's python3-numpy
and python3-pil.
"""

import json
import os
import pathlib
import random
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile

from measuring.common import (
    PAGES,
    ROOT,
    Tool,
    add_table,
    add_tool,
    children_seconds,
    commit,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "fetch.json", PAGES / "fetch.md"
WEST, SOUTH = 15.70, 50.03


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument(
        "--server", type=pathlib.Path, default=ROOT / "build/release/tests/fetch/fetch_tile_server", help="serves tiles"
    )
    parser.add_argument("--kills", type=int, default=20, help="random kills (20)")


def write_site(folder, url, degrees, resolution_m):
    (folder / "site.toml").write_text(
        f"[area]\nbbox_wgs84 = [{WEST}, {SOUTH}, {WEST + degrees}, {SOUTH + 0.65 * degrees}]\n[sources]\nphoto = "
        '"p.mbtiles"\nosm = ["a.osm"]\ndtm = ["a.tif"]\n'
        f'[[fetch]]\nto = "p.mbtiles"\nkind = "xyz"\nurl = "{url}"\nresolution_m = {resolution_m}\n'
    )
    return folder / "site.toml"


def stored_tiles(file):
    with sqlite3.connect(file) as db:
        return [
            ((z, x, 2**z - 1 - y), data)
            for z, x, y, data in db.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles")
        ]


def clear(folder):
    for file in folder.glob("*p.mbtiles*"):
        file.unlink()


def speed(tool, server, servers, folder, connections):
    """Tiles a second as the tool says it (requests, checks, store); best and worst of three, and by its processor time,
    all included.
    """
    (folder / "tile.jpg").write_bytes(servers.encoded(servers.tile_pixels(18, 142484, 88736)))
    process = subprocess.Popen([server, folder / "tile.jpg", str(connections + 2)], stdout=subprocess.PIPE, text=True)
    try:
        site = write_site(folder, f"http://127.0.0.1:{int(process.stdout.readline())}/{{z}}/{{x}}/{{y}}", 0.035, 0.3)
        rates, before = [], children_seconds()
        for _ in range(3):
            clear(folder)
            said = subprocess.run(
                [tool.file, "fetch", site, "--connections", str(connections)],
                check=True,
                capture_output=True,
                text=True,
            ).stderr
            rates.append(float(re.search(r"asked in [\d.]+ s \((\d+)/s\)", said)[1]))
        busy = children_seconds() - before
        return {
            "by_processor": sum(len(stored_tiles(folder / "p.mbtiles")) for _ in rates) / busy,
            "tiles": len(stored_tiles(folder / "p.mbtiles")),
            "tile_bytes": (folder / "tile.jpg").stat().st_size,
            "best": max(rates),
            "worst": min(rates),
        }
    finally:
        process.kill()
        process.wait()


def faults(tool, servers, folder):
    origin = servers.tile_origin()
    proxy = servers.FaultProxy(origin, share=0.1, seed=42)
    site = write_site(folder, proxy.url + "/t/{z}/{x}/{y}.jpg", 0.015, 0.3)
    clear(folder)
    seconds = tool.timed("fetch", site, "--pause", "0.05")
    tiles = stored_tiles(folder / "p.mbtiles")
    record = json.loads((folder / "p.mbtiles.source.json").read_text())
    result = {
        "asked": record["tiles"],
        "arrived": len(dict(tiles)),
        "twice": len(tiles) - len(dict(tiles)),
        "missing": record["missing_tiles"],
        "corrupt": sum(data != servers.encoded(servers.tile_pixels(*key)) for key, data in tiles),
        "faults": sum(proxy.done.values()),
        "kinds": len(proxy.done),
        "delivered_twice": sum(n > 1 for n in proxy.delivered.values()),
        "seconds": seconds,
    }
    proxy.close(), origin.close()
    return result


def kills(tool, servers, folder, count):
    """Kills at random times of one run after the other until one ends; then anew, until there were so many."""
    origin = servers.tile_origin(delay_s=0.01)
    site = write_site(folder, origin.url + "/t/{z}/{x}/{y}.jpg", 0.012, 0.3)
    clear(folder)
    tool("fetch", site)
    whole = (folder / "p.mbtiles").read_bytes()
    draw, done, ends, same = random.Random(5), 0, 0, 0
    while done < count:
        clear(folder)
        while True:
            run = subprocess.Popen([tool.file, "-q", "fetch", site, "--connections", "2"])
            try:
                run.wait(draw.uniform(0.5, 5.0) if done < count else None)
                break
            except subprocess.TimeoutExpired:
                run.send_signal(signal.SIGKILL)
                run.wait()
                done += 1
        ends += 1
        same += (folder / "p.mbtiles").read_bytes() == whole
    origin.close()
    return {"kills": done, "ends": ends, "same": same}


def table(n):
    text = header(["", "asked", "reached"])
    for connections, s in n["speed"].items():
        asked = "500" if connections == "6" else ""
        text += row(
            [
                (
                    f"tiles a second, {connections} connection{'s' if connections != '1' else ''} ("
                    f"{s['tiles']} tiles of "
                    f"{s['tile_bytes'] / 1000:.0f} kB; best, worst of 3)"
                ),
                asked,
                f"{s['best']:.0f}, {s['worst']:.0f}",
            ]
        )
        text += row(["... a second of the tool's processor time, its start included", "", f"{s['by_processor']:.0f}"])
    f, k = n["faults"], n["kills"]
    text += row(
        [
            f"a tenth of faults ({f['faults']} of {f['kinds']} kinds): tiles that arrived",
            f"{f['asked']} of {f['asked']}",
            f"{f['arrived']} of {f['asked']}",
        ]
    )
    text += (
        row(["... corrupt", "0", f["corrupt"]])
        + row(["... stored twice", "0", f["twice"]])
        + row(["... good answers asked for again", "0", f["delivered_twice"]])
    )
    text += row(
        [
            f"fetches that ended in the same bytes after {k['kills']} random kills in all",
            f"{k['ends']} of {k['ends']}",
            f"{k['same']} of {k['ends']}",
        ]
    )
    return text + row(["others' load of the machine", "", n["load"]])


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        sys.path.insert(0, str(ROOT / "tests/fetch"))
        import servers  # noqa: PLC0415 (of the tests; its folder is named in the line above)

        tool = Tool(args.tool)
        numbers = {"commit": commit(), "machine": machine(), "load": round(os.getloadavg()[0], 1)}
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            numbers["speed"] = {str(c): speed(tool, args.server, servers, folder, c) for c in (6,)}
            numbers["faults"] = faults(tool, servers, folder)
            numbers["kills"] = kills(tool, servers, folder, args.kills)
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"fetch": table(numbers)})
    print(table(numbers))
    return 0
