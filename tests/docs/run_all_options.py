#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Every option of every command changes something, or the tool says no.

    run_all_options.py TOOL SITES [COMMAND ...]     only those of COMMAND; SITES: what tests/faults/build_small leaves

The options are those that --help lists; all_options.txt has a line for each (its head says how to write one), runs of
the tool on small files. An option without a line is an error, so is a line whose option no longer exists.
"""

import dataclasses
import hashlib
import pathlib
import re
import shlex
import shutil
import sys
import tempfile

from osgeo import gdal, osr
from small_folder import ENVIRONMENT, ROOT, cpu_seconds, experiment, helps, make_folder, reference, run, write_area

TABLE = pathlib.Path(__file__).with_name("all_options.txt")
UNSTABLE = ("run.json", "log.csv", "training.html", "report.html", ".source.json")  # hold times; .orthodrive, too


@dataclasses.dataclass
class Line:
    """A line of the table: words with the option first, and what they are compared with or have to say."""

    kind: str  # changes, tells, refused, by design
    words: list
    beside: list
    text: str = ""


@dataclasses.dataclass
class Command:
    base: list
    lines: list


def parse_table(text):
    """The commands of the table by their words, "evaluate roads"."""
    commands, command = {}, None
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        if not line.startswith(" "):
            name, _, base = line.partition(":")
            command = commands.setdefault(name.strip() if name != "orthodrive" else "", Command(shlex.split(base), []))
            continue
        kind, _, rest = line.strip().partition(" ")
        if kind == "by-design":
            options, _, why = rest.partition(": ")
            command.lines += [Line("by design", [option], [], why) for option in options.split()]
        elif kind == "refused":
            command.lines.append(Line("refused", *words_and_beside(rest)))
        elif kind == "tells":
            said, _, words = rest.partition(": ")
            command.lines.append(Line("tells", *words_and_beside(words), said))
        else:
            command.lines.append(Line("changes", *words_and_beside(line.strip())))
    return commands


def words_and_beside(text):
    """ "--window 5 (--method moving-average)" -> what is tried, and what stands in both runs."""
    found = re.fullmatch(r"(.*?)(?:\((.*)\))?", text)
    return shlex.split(found[1]), shlex.split(found[2] or "")


def options_of_help(text):
    """The long name, or else the short one, of the options that a --help lists."""
    names = [re.match(r"  (-\S+)", line) for line in text.splitlines()]
    return [name[1].split(",")[-1] for name in names if name]


def is_option(word):
    return re.fullmatch(r"--?[a-z].*", word) is not None


def joined(base, words):
    """Words after those of the base; an option that has a value there gets the new one."""
    result = list(base)
    for word in dict.fromkeys(words):
        if is_option(word) and word in result:
            first = result.index(word)
            end = next((i for i in range(first + 1, len(result)) if is_option(result[i])), len(result))
            del result[first:end]
    return result + list(words)


def digest(folder):
    """Of all that a run wrote."""
    result = hashlib.sha256()
    for file in sorted(path for path in folder.rglob("*") if path.is_file()):
        if file.name.endswith(UNSTABLE) or ".orthodrive" in file.parts:
            continue
        result.update(f"{file.relative_to(folder)}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return result.hexdigest()


@dataclasses.dataclass
class Outcome:
    code: int
    out: str
    err: str
    files: str


class Runner:
    """Runs the tool in the folder. OUT is an empty one; COPY:NAME a copy of NAME in it."""

    def __init__(self, tool, folder):
        self.tool, self.folder, self.known = tool, folder, {}

    def outcome(self, words):
        key = tuple(words)
        if key not in self.known:
            self.known[key] = self.fresh_outcome(words)
        return self.known[key]

    def fresh_outcome(self, words):
        out = self.folder / "OUT"
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir()
        for word in words:
            if word.startswith("COPY:"):
                source = self.folder / word[5:]
                (shutil.copytree if source.is_dir() else shutil.copyfile)(source, out / source.name)
        words = [f"OUT/{pathlib.Path(word[5:]).name}" if word.startswith("COPY:") else word for word in words]
        done = run(self.tool, *words, cwd=self.folder, env=ENVIRONMENT)
        return Outcome(done.returncode, done.stdout, done.stderr, digest(out))


def words_without(words, base, line):
    """The run that an option is compared with."""
    if line.beside[:1] == ["="]:
        return [*words, *line.beside[1:]]
    return [*words, *joined(base, line.beside)]


def failure(runner, words, base, line):
    """What is wrong with an option, or nothing."""
    if line.kind == "by design":
        return None
    without = words_without(words, base, line)
    given = [*words, *joined(without[len(words) :], line.words)]
    if line.kind == "refused":
        done = runner.outcome(given)
        said = line.words[0] in done.err and ("changes nothing" in done.err or "not expected" in done.err)
        return None if done.code == 2 and said else f"is not refused: exit code {done.code}: {done.err.strip()}"
    before, after = runner.outcome(without), runner.outcome(given)
    if line.kind == "tells":
        told, told_before = after.out + after.err, before.out + before.err
        return None if line.text in told and line.text not in told_before else f"does not say '{line.text}': {told}"
    for done, what in ((before, without), (after, given)):
        if done.code != 0 and done.err:  # `cells missing` ends with 1 and says why on standard output
            return f"{shlex.join(what)}: exit code {done.code}: {done.err.strip()[-300:]}"
    if (before.out, before.files) == (after.out, after.files):
        return "changes neither files nor standard output"
    return None


def base_failure(runner, words):
    """A run whose outputs differ the next time would prove nothing."""
    first, again = runner.outcome(words), runner.fresh_outcome(words)
    if (first.out, first.files) == (again.out, again.files):
        return None
    return f"{shlex.join(words)}: two runs differ, so no option can be seen in them"


def failures_of(runner, name, text, command):
    """Of a command with its --help."""
    listed = [option for option in options_of_help(text) if option != "--help"]
    if command is None:
        return [f"{name}: the table has no such command"] if listed else []
    failures, words = [], name.split()
    named = {line.words[0] for line in command.lines if line.kind != "refused"}
    failures += [f"{name} {option}: has no line in {TABLE.name}" for option in listed if option not in named]
    gone = sorted(named - set(listed))
    failures += [f"{name} {option}: {TABLE.name} names it, the command has no such option" for option in gone]
    changes = [line for line in command.lines if line.kind == "changes"]
    if changes:
        failures += filter(None, [base_failure(runner, words_without(words, command.base, changes[0]))])
    for line in command.lines:
        begun = cpu_seconds()
        error = failure(runner, words, command.base, line)
        took = f"{cpu_seconds() - begun:4.1f} s"
        print(f"{'FAILED' if error else 'ok':6} {took}: {name} {shlex.join(line.words)} ({line.kind})", flush=True)
        if error:
            failures.append(f"{name} {shlex.join(line.words)}: {error}")
    return failures


def write_log(folder):
    """A drive log of the lap: what a receiver has of it."""
    to_degrees = osr.CoordinateTransformation(*(reference(code) for code in (32633, 4326)))
    rows = ["time_s,lat,lon,alt_m"]
    lines = (folder / "out/drive/lap.csv").read_text().splitlines()[1:]
    for line in lines[::5]:
        time_s, _, x, y, z, *_ = line.split(",")
        lon, lat, _ = to_degrees.TransformPoint(float(x), float(y))
        rows.append(f"{time_s},{lat:.8f},{lon:.8f},{float(z) + 0.5}")
    (folder / "log.csv").write_text("\n".join(rows) + "\n")


def write_things(folder):
    """A building, a tree and a wall where the photo `grass.tif` has neither road nor house."""
    to_degrees = osr.CoordinateTransformation(*(reference(code) for code in (32633, 4326)))
    corners = [(460180, 5270180), (460186, 5270180), (460186, 5270186), (460180, 5270186)]
    tags = {"building": (0, 1, 2, 3, 0), "barrier": (4, 5)}
    places = [to_degrees.TransformPoint(*map(float, p)) for p in [*corners, (460172, 5270176), (460194, 5270176)]]
    tree = '<tag k="natural" v="tree"/>'
    nodes = [f'<node id="{i + 1}" lon="{p[0]}" lat="{p[1]}"/>' for i, p in enumerate(places)]
    lon, lat, _ = to_degrees.TransformPoint(460192.0, 5270192.0)
    nodes.append(f'<node id="9" lon="{lon}" lat="{lat}">{tree}</node>')
    ways = [
        f'<way id="{100 + k}">{"".join(f"<nd ref={chr(34)}{i + 1}{chr(34)}/>" for i in refs)}'
        f'<tag k="{key}" v="{"yes" if key == "building" else "wall"}"/></way>'
        for k, (key, refs) in enumerate(tags.items())
    ]
    (folder / "things.osm").write_text(f'<osm version="0.6">{"".join(nodes + ways)}</osm>')


def write_places(folder):
    """Areas, relations and a catalogue for `new`, an area of the small site for `evaluate`."""
    write_area(folder / "large_box.geojson", 11.5, 48.1, 11.53, 48.12)
    write_area(folder / "small_box.geojson", 11.5, 48.1, 11.51, 48.11)
    write_area(folder / "small_area.geojson", 14.4684, 47.5825, 14.4693, 47.5834)
    for name, west in {"relations.osm": 11.5, "moved_relations.osm": 11.501}.items():
        nodes, ways, relations = "", "", ""
        for k, size in enumerate((0.01, 0.02)):
            for i, (x, y) in enumerate(((0, 0), (size, 0), (size, size), (0, size))):
                nodes += f'<node id="{10 * k + i + 1}" lon="{west + x}" lat="{48.1 + y}"/>'
            refs = "".join(f'<nd ref="{10 * k + i + 1}"/>' for i in (0, 1, 2, 3, 0))
            ways += f'<way id="{k + 1}">{refs}</way>'
            border = f'<member type="way" ref="{k + 1}" role="outer"/><tag k="type" v="boundary"/>'
            relations += f'<relation id="{7 + k}">{border}</relation>'
        (folder / name).write_text(f'<osm version="0.6">{nodes}{ways}{relations}</osm>')
    shutil.copytree(ROOT / "catalogue", folder / "small_catalogue")
    osm = folder / "small_catalogue/osm.toml"
    osm.write_text(osm.read_text().replace("overpass-api", "overpass-other"))


def write_rasters(folder):
    """Photos of parts of the small site, of another light; labels with a hole."""
    gdal.UseExceptions()
    for name, (x, y) in {"grass": (460170, 5270200), "road": (460000, 5270200), "wood": (460150, 5270030)}.items():
        gdal.Translate(f"{folder}/{name}.tif", f"{folder}/ortho.tif", projWin=[x, y, x + 30, y - 30])
    gdal.Translate(f"{folder}/dim.tif", f"{folder}/ortho.tif", scaleParams=[[0, 255, 30, 150]])
    shutil.copyfile(folder / "labels.tif", folder / "holes.tif")
    labels = gdal.Open(f"{folder}/holes.tif", gdal.GA_Update)
    labels.GetRasterBand(1).WriteRaster(0, 0, labels.RasterXSize, 200, bytes([255]) * labels.RasterXSize * 200)
    labels.FlushCache()


def write_texts(folder):
    sets = ("learned", "other", "more", "measured")
    text = experiment("networks/mobilenetv2-fpn.toml", "../site", names=sets)
    (folder / "models/tiny.toml").write_text(text.replace('"more"\n', '"more"\nheld_out = true\n'))
    (folder / "weights.toml").write_text("evidence = 100\n")
    (folder / "merge.toml").write_text('parking = "road"\n')
    roads = (folder / "roads.osm").read_text()
    (folder / "other_roads.osm").write_text(roads.replace('v="residential"', 'v="service"'))
    site = (folder / "site.toml").read_text()
    for name, to in {"fetched.toml": "OUT/fetched.osm", "there.toml": "there.osm"}.items():
        source = f'[[fetch]]\nto = "{to}"\nkind = "osm_extract"\nurl = "roads.osm"\n'
        (folder / name).write_text(site.replace(str(folder / "site/roads.osm"), to) + source)
    shutil.copytree(folder / "site/truth", folder / "other_truth")
    (folder / "other_truth/labels.tif").unlink()


def write_bare_road(folder):
    """OpenDRIVE of a road that is a reference line without lanes."""
    line = '<geometry s="0" x="0" y="0" hdg="0" length="60"><arc curvature="0.02"/></geometry>'
    lanes = '<laneSection s="0"><center><lane id="0" type="none" level="false"/></center></laneSection>'
    flat = '<elevation s="0" a="0" b="0" c="0" d="0"/>'
    road = f"<planView>{line}</planView><elevationProfile>{flat}</elevationProfile><lanes>{lanes}</lanes>"
    header = '<header revMajor="1" revMinor="6" name="" north="1" south="-1" east="60" west="0"/>'
    text = f'<OpenDRIVE>{header}<road name="" length="60" id="1" junction="-1">{road}</road></OpenDRIVE>'
    (folder / "bare.xodr").write_text(text)


def add_files(tool, folder):
    """What the table names besides the files of the examples."""
    for write in (write_texts, write_log, write_things, write_places, write_rasters, write_bare_road):
        write(folder)
    for words in (
        "fetch there.toml",
        "forests --photo ortho.tif --labels b_labels.tif --trees 3 -o other_forests.yml",
        "segment ortho.tif --osm town.osm -o alignment.tif --alignment alignment.csv",
        "scene --network roads.xodr --photo grass.tif --dtm dtm.tif -o grass_scene",
        "train models/tiny.toml -o trained",
        "elevate --roads roads.gpkg --dtm dtm.tif --method moving-average --window 1 -o rough.gpkg",
        "network --roads rough.gpkg -o rough.xodr",
    ):
        done = run(tool, "-q", *shlex.split(words), cwd=folder, env=ENVIRONMENT)
        if done.returncode != 0:
            sys.exit(f"{words}: {done.stderr}")


def main(tool, sites, *only):
    tool, sites = pathlib.Path(tool).resolve(), pathlib.Path(sites).resolve()
    commands, failures, seen = parse_table(TABLE.read_text()), [], set()
    with tempfile.TemporaryDirectory(prefix="orthodrive-options-") as name:
        folder = pathlib.Path(name)
        make_folder(folder, tool, sites)
        add_files(tool, folder)
        runner = Runner(tool, folder)
        for words, text in helps(tool):
            path = " ".join(words)
            seen.add(path)
            if not only or path in only:
                failures += failures_of(runner, path, text, commands.get(path))
    failures += [f"{TABLE.name} names '{path}', which is no command" for path in sorted(set(commands) - seen)]
    print(f"{len(failures)} failures")
    for error in failures:
        print(error)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
