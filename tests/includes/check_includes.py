#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The arrows between rooms hold in every #include, header-only ones too. Prints each break; exit code 1 when there is
one.

    tests/includes/check_includes.py [ROOT]       # ROOT: the source tree, this one where it is not given

A room is a folder of src/ or of lab/ with a target. What it may include stands in the DEPS of its
CMakeLists.txt, and in those of its DEPS; this script reads them and asks nine things:

1. A file includes its own room and the rooms behind its arrows, nothing else; there is no circle of rooms.
2. No stage reaches a stage or io, by an include or by DEPS.
3. No stage opens a file, nor does a room that a stage includes, but for the few files of core that do it for all.
4. No circle of includes between files.
5. Headers show third-party types only where THIRD_PARTY allows it, so that these libraries can be changed in one .cpp.
6. A room's own folders stand in its FOLDERS in the order of their arrows: a file includes its own folder and those
   before it; what lies in the room itself includes all of them, and is included by none.
7. A name of a file stands in one folder: who looks for it finds one place.
8. A folder has at most 40 files: a larger one gets folders of its own.
9. No room of src/ knows one of the laboratory (lab/), nor does the command line outside of lab/app.
"""

import collections
import pathlib
import re
import sys

STAGES = {"segment", "refine", "elevate", "network", "scene", "drive", "synth", "evaluate"}
# Rooms that read and write; roadquery, vehicle and fmu read the files they work on, and ship alone.
FILE_ROOMS = {"io", "remote", "pipeline", "lab", "app", "roadquery", "vehicle", "fmu"}
# core hashes files, writes them aside, looks for the models' folder, loads our libraries and asks the kernel for its
# memory: for every room.
FILE_ACCESS = {
    "orthodrive/core/atomic_file",
    "orthodrive/core/find_resource",
    "orthodrive/core/hash",
    "orthodrive/core/load_part",
    "orthodrive/core/memory",
}
# The command line parses options and calls the pipeline. Of the other rooms it sees what options and their errors need.
APP_ROOMS = {"pipeline", "model", "core", "app"}
APP_HEADERS = {
    "orthodrive/io/models/safetensors_stream.hpp",  # orthodrive-train reads packed data
}
# Standard C++ everywhere; these in headers too.
THIRD_PARTY = {
    "train": {"ATen", "c10"},  # networks in training are made of tensors; a part of the tool, for its own .cpp files
    "io": {"fmt", "gdal", "ogr", "osmium", "nlohmann"},  # *_support.hpp: for the .cpp files of io
    "remote": {"curl", "sqlite3", "pugixml"},  # http_transfer, sqlite, xml_text: for the .cpp files of remote
    "pipeline": {"fmt", "nlohmann", "toml++"},  # run.json, site.toml
    "lab": {"fmt", "nlohmann", "toml++"},  # experiments and their reports
    "report": {"nlohmann"},  # the record of a run, which the page shows
    "app": {"CLI", "fmt", "httplib", "posix"},
}
# An .inl is compiled once per family of processors, each time by a .cpp of its own; no header includes it. So it may
# show the intrinsics of that family.
INTRINSICS = {"immintrin", "arm_neon"}
MOST_FILES = 40
OPENS = re.compile(
    r"\b(?:[io]?fstream|filebuf|fopen|freopen|fdopen|mkstemp|opendir|popen|GDALOpen\w*|VSIF?Open\w*|GDALCreate\w*)\b"
    r"|\bfilesystem::(?:exists|create_director\w+|directory_iterator|recursive_directory_iterator|remove|remove_all|rename|"
    r"copy\w*|file_size|last_write_time|is_\w+|resize_file|canonical|temp_directory_path)\b|::open\("
)
OPENING_HEADERS = re.compile(
    r"fstream|cstdio|stdio\.h|fcntl\.h|sys/(?:stat|file)\.h|dirent\.h|gdal.*|ogr.*|cpl_.*|ogrsf_frmts\.h"
)
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)


def group_of(header):
    """The library of a third-party header, or None for the standard library's."""
    if re.fullmatch(r"[a-z_0-9]+|(std(int|def|io|lib)|string|math|limits|float|assert|errno|time)\.h", header):
        return None
    if header.startswith(("gdal", "cpl_")):
        return "gdal"
    if header.startswith("ogr"):
        return "ogr"
    if re.match(r"(unistd|fcntl|sys/\w+|netdb|arpa/\w+|netinet/\w+|poll|signal)(\.h)?$", header):
        return "posix"
    return header.split("/")[0].removesuffix(".h").removesuffix(".hpp")


def rooms_of_ours(root):
    """The CMakeLists.txt of each room of the product and of the laboratory."""
    return sorted(file for base in ("src", "lab") for file in (root / base / "orthodrive").glob("*/CMakeLists.txt"))


def read_arrows(root):
    """{room: rooms it links}: the DEPS of orthodrive_library, and what target_link_libraries adds of ours in PUBLIC."""
    arrows = {"roadquery": set(), "vehicle": {"roadquery"}, "fmu": {"vehicle", "roadquery"}}
    for file in rooms_of_ours(root):
        text = re.sub(r"#[^\n]*", "", file.read_text())
        for name, words in re.findall(r"orthodrive_library\((\w+)([^)]*)\)", text):
            deps, inside = set(), False
            for word in words.split():
                inside = word == "DEPS" or (inside and word != "LIBS")
                if inside and word != "DEPS":
                    deps.add(word)
            arrows[name] = deps
        for name, words in re.findall(r"target_link_libraries\(orthodrive_(\w+)\s+PUBLIC([^)]*)\)", text):
            if name in arrows:
                arrows[name] |= {
                    w.removeprefix("orthodrive::")
                    for w in words.split()
                    if w in ("roadquery", "vehicle", "fmu") or w.startswith("orthodrive::")
                }
    return arrows


def read_folders(root):
    """{room: its own folders in the order of their arrows}: FOLDERS of orthodrive_library, or of a room beside."""
    folders = {}
    for file in sorted((root / "src").glob("*/CMakeLists.txt")):
        for words in re.findall(r"set\(FOLDERS ([a-z ]+)\)", file.read_text()):
            folders[file.parent.name] = words.split()
    for file in rooms_of_ours(root):
        for name, words in re.findall(r"orthodrive_library\((\w+)(?: COLD)? FOLDERS ([a-z ]+)", file.read_text()):
            folders[name] = words.split()
    return folders


def reach_of(room, arrows):
    found, stack = set(), [room]
    while stack:
        for other in arrows.get(stack.pop(), ()):
            if other not in found:
                found.add(other)
                stack.append(other)
    return found


def circles_of(includes):
    """One circle of every strongly connected part, as a list of files."""
    done, circles, path, place = set(), [], [], {}

    def visit(file):
        place[file] = len(path)
        path.append(file)
        for other in sorted(includes[file]):
            if other in place:
                circles.append([*path[place[other] :], other])
            elif other not in done:
                visit(other)
        done.add(file)
        del place[path.pop()]

    for file in sorted(includes):
        if file not in done:
            visit(file)
    return circles


def room_of(name):
    return name.split("/")[1] if name.startswith("orthodrive/") else name.split("/")[0]


def folder_of(name):
    """The folder of its room that a file lies in; empty: in the room itself."""
    parts = name.removeprefix("orthodrive/").split("/")
    return parts[1] if len(parts) == 3 and parts[0] != "app" else ""


def is_upward(name, target, folders):
    """Whether an include leads to a later folder of the same room, or out of a folder to the room itself."""
    own, other = folder_of(name), folder_of(target)
    order = [*folders.get(room_of(name), []), ""]
    return own in order and other in order and order.index(other) > order.index(own)


def check_file(name, text, reach, known, folders):
    """What is wrong in one file, and which files of ours it includes."""
    room, wrong, ours = room_of(name), [], set()
    is_header = name.endswith((".hpp", ".h", ".inl"))
    opens_files = room in FILE_ROOMS or name.rsplit(".", 1)[0] in FILE_ACCESS
    for quoted, angled in INCLUDE.findall(text):
        if quoted:
            beside = f"{name.rsplit('/', 1)[0]}/{quoted}"
            places = [quoted, beside, *([f"app/{quoted}"] if room == "app" else [])]
            target = next((place for place in places if place in known), beside)
            if target not in known:
                if not re.search(r"\.pb\.h$", quoted):
                    wrong.append(f"includes {quoted}, which is not in src/, lab/ or app/")
                continue
            ours.add(target)
            if is_header and target.endswith(".inl") and not name.endswith(".inl"):
                wrong.append(f"includes {quoted}: code for one family of processors goes into .cpp files only")
            other = room_of(target)
            if room == "app":
                rooms = APP_ROOMS | ({"lab"} if name.startswith("app/lab/") else set())
                if other not in rooms and target not in APP_HEADERS:
                    wrong.append(f"includes {quoted}: the command line sees {', '.join(sorted(rooms - {'app'}))} only")
            elif other != room and other not in reach[room]:
                wrong.append(f"includes {quoted}: no arrow leads from {room} to {other}")
            elif other == room and is_upward(name, target, folders):
                own = folder_of(name)
                wrong.append(
                    f"includes {quoted}: {own} comes before {folder_of(target) or room + ' itself'} in FOLDERS"
                )
            continue
        if not opens_files and OPENING_HEADERS.fullmatch(angled):
            wrong.append(f"includes <{angled}>: {room} opens no file")
        library = group_of(angled)
        allowed = THIRD_PARTY.get(room, set()) | (INTRINSICS if name.endswith(".inl") else set())
        if is_header and library and library not in allowed:
            wrong.append(f"includes <{angled}> in a header: {room} keeps {library} in its .cpp files")
    if not opens_files:
        for word in sorted({m[0] for m in OPENS.finditer(NOISE.sub(" ", INCLUDE.sub(" ", text)))}):
            wrong.append(f"uses {word}: {room} opens no file")
    if (
        re.search(r"\b(?:at|torch)::\w", NOISE.sub(" ", text))
        and not re.search(r"#include <(ATen|torch|c10)/", text)
        and is_header
    ):
        wrong.append("names at:: without including it: a precompiled header hides that")
    return wrong, ours


def check(root):
    arrows = read_arrows(root)
    reach = {room: reach_of(room, arrows) for room in arrows}
    of_lab = {file.parent.name for file in rooms_of_ours(root) if root / "lab" in file.parents}
    findings = []
    for room in sorted(arrows):
        if room in reach[room]:
            findings.append(f"{room}: a circle of DEPS")
        if room in STAGES:
            for other in sorted(reach[room] & (STAGES | {"io"})):
                findings.append(f"{room}: a stage reaches {other} by its DEPS")
        if room not in of_lab:
            for other in sorted(reach[room] & of_lab):
                findings.append(f"{room}: a room of the product reaches {other} of the laboratory by its DEPS")
        for other in sorted(arrows[room] - arrows.keys()):
            findings.append(f"{room}: DEPS name {other}, which is no room")
    known = {}
    for base, prefix in (
        (root / "src", ""),
        (root / "lab", ""),
        (root / "app", "app/"),
        (root / "lab/app", "app/lab/"),
    ):
        for file in sorted(base.rglob("*")):
            if prefix == "" and base / "app" in file.parents:
                continue  # lab/app is of the command line
            if file.suffix in (".cpp", ".hpp", ".h", ".inl", ".c"):
                known[prefix + file.relative_to(base).as_posix()] = file.read_text()
    includes, folders = {}, read_folders(root)
    used = {(room_of(name), folder_of(name)) for name in known if folder_of(name)}
    listed = {(room, folder) for room, own in folders.items() for folder in own}
    findings += [f"{room}: FOLDERS and the folder {folder} do not agree" for room, folder in sorted(used ^ listed)]
    places, count = {}, collections.Counter(name.rsplit("/", 1)[0] for name in known)
    findings += [
        f"{folder}: {files} files, at most {MOST_FILES}"
        for folder, files in sorted(count.items())
        if files > MOST_FILES
    ]
    for name in known:
        folder, file = name.rsplit("/", 1)
        places.setdefault(file.split(".")[0], set()).add(folder)
    for name, own in sorted(places.items()):
        if len(own) > 1:
            findings.append(f"{name}: stands in {' and '.join(sorted(own))}")
    for name, text in known.items():
        if room_of(name) not in arrows and room_of(name) != "app":
            findings.append(f"{name}: no target {room_of(name)}")
            continue
        wrong, includes[name] = check_file(name, text, reach, known, folders)
        findings += [f"{name}: {w}" for w in wrong]
    findings += [
        "a circle of includes: " + " -> ".join(circle)
        for circle in circles_of({n: o & includes.keys() for n, o in includes.items()})
    ]
    return findings, len(known)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    findings, files = check(root)
    print("\n".join(findings))
    print(f"{files} files, {len(findings)} findings")
    return 1 if findings or not files else 0


if __name__ == "__main__":
    sys.exit(main())
