#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the pages: docs/**/*.md, README.md and its neighbours.

- Every path in back quotes exists: `tests/roads`, `src/roadquery`, and with the name of a room `refine/fit_chain` (the
  extension may be left out). Pages that are named in code exist.
- Links between pages, and to pictures and headings, resolve.
- docs/reference.md: every row names a file and a test that exist, nothing that is "Open" exists or has a test, the
  words that it offers for a search lead to a place. Every published number has ours beside it, or says that it is not
  measured or left out, and is in the reference itself, rounded at most. Every numbered heading of chapters 2 to 4, and
  every table and figure of them and of the appendices, stands there.
- Every term of the glossary has a file that exists; no term stands twice.
- Names that the glossary retires are on no other page.
- Names in the tables of options are in the code, and numbers beside them are its defaults.
- Method pages are short. Measured pages name the command that makes them and one commit, at their top; what was tried,
  and why, is in docs/notes, with dates.

Usage: check_docs.py ROOT. Prints one line a fault; exit code 1 if there is any. Where the reference is not
beside the repository (../shared/reference), its headings, tables, figures and numbers are not asked, which is said.
"""

import re
import sys
from pathlib import Path

METHOD_LINES = 120  # two screens beyond formulas: lines of indented blocks do not count
LINE_WIDTH = 160  # of prose, so that a page is not made short by long lines
FREE = {
    "architecture.md",
    "conventions.md",
    "glossary.md",
    "reference.md",
    "versions.md",
}  # lists and advice, not methods
REFERENCE = "shared/reference/thesis.txt"  # beside the repository
FEWEST_HEADINGS = 30  # of chapters 2 to 4; fewer were not read right
TEMPLATE_LINES = 24  # of a measured page outside its marks
STAMP = re.compile(r"^Measured on commit (.+)\.$", re.MULTILINE)
# Pages that were not measured anew since pages have one commit: theirs are several, or of a tree with changes.
# `tools/measure all` measures them; a page that is on one commit is taken off here.
NOT_MEASURED_ANEW = {
    "cluster",
    "dense_crf",
    "drive_logs",
    "elevate",
    "every_road",
    "fuzz",
    "lap",
    "network",
    "nlo",
    "refine",
    "scaling",
    "scene",
    "segment",
    "synth",
    "verdict",
    "virtual_ring",
}
NOTES_IN_MEASURED = [
    "tried and left",
    "what was chosen",
    "what is known of it",
    "what was wrong",
    "what mended it",
    "why numbers are missed",
]
TOP = {
    "app",
    "bench",
    "catalogue",
    "cmake",
    "docs",
    "examples",
    "lab",
    "models",
    "sites",
    "src",
    "tests",
    "tools",
    "viewer",
}
SUFFIXES = ["", ".hpp", ".cpp", ".h", ".inl", ".toml", ".md", ".py", ".mjs"]
# What a build or a synthetic site leaves behind; some folders have the names of rooms.
OUTPUTS = {"scene/tileset.json", "scene/*.glb", "drive/lap.csv", "drive/report.html", "crf/..."}


def rooms(root):
    """Folders whose names begin a path in the pages: refine -> src/orthodrive/refine."""
    bases = [root / "src/orthodrive", root / "lab/orthodrive"]
    found = {p.name: p for base in bases if base.is_dir() for p in base.iterdir() if p.is_dir()}
    found["roadquery"] = root / "src/roadquery"
    found["vehicle"] = root / "src/vehicle"
    found["fmu"] = root / "src/fmu"
    return found


def exists(path):
    return any(path.with_name(path.name + suffix).exists() for suffix in SUFFIXES)


def path_exists(root, room_of, text):
    """None: does not look like a file of the repository."""
    first = text.split("/")[0]
    if text in OUTPUTS or "/" not in text or text.endswith("/") or "<" in text or "*" in text:
        return None
    if first in TOP and exists(root / text):
        return True
    if first in TOP and first not in room_of:
        return False
    if first in room_of:
        return exists(room_of[first] / text.split("/", 1)[1])
    return None


def code_spans(page):
    """Back-quoted texts, with their lines; indented blocks are commands and formulas."""
    for number, line in enumerate(page.split("\n"), 1):
        if not line.startswith("    "):
            for span in re.findall(r"`([^`]+)`", line):
                yield number, span


def check_paths(root, pages, faults):
    room_of = rooms(root)
    for page in pages:
        text = page.read_text()
        if page == root / "docs/reference.md":  # what is open is not there yet
            text = re.sub(r"^\|.*\*\*Open\*\*.*$", "", text, flags=re.MULTILINE)
        for number, span in code_spans(text):
            word = span.split()[0] if span.split() else ""
            if re.fullmatch(r"[A-Za-z0-9_.+*<>/-]+", word) and path_exists(root, room_of, word) is False:
                faults.append(f"{page.relative_to(root)}:{number}: {word} does not exist")


def check_pages_named_in_code(root, faults):
    code = ["src", "lab", "app", "tests", "tools", "bench", "examples", "cmake"]
    for file in [p for top in code for p in (root / top).rglob("*")]:
        if not file.is_file() or file.suffix in {".md", ".png", ".csv"} or file.parent == root / "tests/docs":
            continue
        try:
            text = file.read_text()
        except UnicodeDecodeError:
            continue
        for name in set(re.findall(r"docs/[A-Za-z0-9_/]+\.md", text)):
            if not (root / name).exists():
                faults.append(f"{file.relative_to(root)}: names {name}, which does not exist")


def anchor(heading):
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def check_links(root, pages, faults):
    for page in pages:
        for number, line in enumerate(page.read_text().split("\n"), 1):
            for target in re.findall(r"\]\(([^)\s]+)\)", line) if not line.startswith("    ") else []:
                if re.match(r"[a-z]+:", target):
                    continue
                name, _, part = target.partition("#")
                file = (page.parent / name).resolve() if name else page
                if not file.exists():
                    faults.append(f"{page.relative_to(root)}:{number}: link to {target} leads nowhere")
                elif part and part not in {anchor(h) for h in re.findall(r"^#+ (.*)$", file.read_text(), re.MULTILINE)}:
                    faults.append(f"{page.relative_to(root)}:{number}: no heading {target}")


def reference_rows(text):
    """(line number, cells of a row), of tables whose header is thesis, code, test."""
    inside = False
    for number, line in enumerate(text.split("\n"), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else []
        if cells == ["thesis", "code", "test"]:
            inside = True
        elif not cells:
            inside = False
        elif inside and not set(line) <= set("|-"):
            yield number, cells


def check_reference_rows(root, faults):
    room_of = rooms(root)

    def paths(cell):
        return {
            span: path_exists(root, room_of, span)
            for _, span in code_spans(cell)
            if path_exists(root, room_of, span) is not None
        }

    count = 0
    for number, cells in reference_rows((root / "docs/reference.md").read_text()):
        count += 1

        def say(what, place=f"docs/reference.md:{number}: {cells[0]}"):
            return faults.append(f"{place}: {what}")

        if len(cells) != 3:
            say("a row has three cells")
            continue
        code, tests = (
            paths(cells[1]),
            {p: there for p, there in paths(cells[2]).items() if p.startswith(("tests/", "viewer/test"))},
        )
        if "**Open**" in cells[1]:
            if not code:
                say("what is open names the file that will have it")
            for path in (p for p, there in code.items() if there):
                say(f"is said to be open, but {path} exists")
            if cells[2]:
                say("is said to be open, but has a test")
        elif cells[1].startswith("**Left out**"):
            if cells[2]:
                say("is said to be left out, but has a test")
        else:  # whether each path exists is asked of all pages
            if not any(code.values()):
                say("names no file that exists")
            if not any(tests.values()):
                say("names no test that exists")
    if not count:
        faults.append("docs/reference.md: has no rows")


def number_rows(text):
    """(line number, cells of a row), of tables whose header is number, published, ours: where from."""
    inside = False
    for number, line in enumerate(text.split("\n"), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else []
        if cells[:2] == ["number", "published"]:
            inside = True
        elif not cells:
            inside = False
        elif inside and not set(line) <= set("|-"):
            yield number, cells


def numbers_in(text):
    """(decimals, value) of every number; 1e^{-10} is one, too."""
    plain = re.sub(r"e\^\{-(\d+)\}", r"e-\1", text)
    for word in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e-\d+)?", plain):
        yield len(word.partition(".")[2]) if "e" not in word else 12, float(word)


def check_published_numbers(root, faults):
    """Each has ours, and those of a reference that is there are in it."""
    file = root.parent / REFERENCE
    known = {v for _, v in numbers_in(file.read_text())} if file.exists() else None
    for number, cells in number_rows((root / "docs/reference.md").read_text()):

        def say(what, place=f"docs/reference.md:{number}: {cells[0]}"):
            return faults.append(f"{place}: {what}")

        if len(cells) != 3 or not all(cells):
            say("a number has three cells: what, published, ours")
            continue
        if not re.search(r"\d|not measured|left out", cells[2]):
            say("has neither a number of ours nor says that it is not measured or left out")
        for digits, value in numbers_in(cells[1]) if known is not None else ():
            if not any(abs(value - v) <= 0.5000001 * 10**-digits for v in known):
                say(f"{value:g} is not in the reference")


def check_captions(root, faults):
    """Tables and figures of the reference from chapter 2 on: "table 2.1", "figures 3.9, 3.10", "tables A.1 to A.4"."""
    file = root.parent / REFERENCE
    if not file.exists():
        return
    named, page = set(), (root / "docs/reference.md").read_text().lower()
    one = r"[2-4a-c]\.\d+"
    for kind, listed in re.findall(rf"\b(table|figure)s? ({one}[a-d]?(?:(?:, | and | to ){one}[a-d]?)*)", page):
        parts = re.findall(rf"( to )?({one})", listed)
        for i, (to, word) in enumerate(parts):
            chapter, last = word.split(".")
            first = int(parts[i - 1][1].split(".")[1]) if to else int(last)
            named |= {(kind, chapter, n) for n in range(first, int(last) + 1)}
    captions = re.findall(r"^(Table|Figure) ([2-4A-C])\.(\d+):", file.read_text(), re.MULTILINE)
    faults += [
        f"docs/reference.md: does not have the reference's {kind.lower()} {chapter}.{n}"
        for kind, chapter, n in captions
        if (kind.lower(), chapter.lower(), int(n)) not in named
    ]


def check_search_words(root, faults):
    """In '"words" leads to `path`' the words are in that file."""
    room_of = rooms(root)
    found = re.findall(r'"([^"]+)"\s+(?:leads\s+)?to\s+`([^`]+)`', (root / "docs/reference.md").read_text())
    for words, path in found:
        room, name = path.split("/", 1)
        files = (
            sorted(room_of[room].glob(f"{name}.*")) if room in room_of else [f for f in [root / path] if f.is_file()]
        )
        texts = [re.sub(r"[\s*/]+", " ", f.read_text()).lower() for f in files]
        if not any(re.sub(r"\s+", " ", words).lower() in text for text in texts):
            faults.append(f"docs/reference.md: '{words}' is not in {path}")


def headings_of_reference(text):
    """Numbers and titles of the numbered headings of chapters 2 to 4."""
    return re.findall(r"^ ?([2-4]\.\d(?:\.\d)?) +([A-Z].*?)\s*$", text, re.MULTILINE)


def check_headings(root, faults):
    file = root.parent / REFERENCE
    if not file.exists():
        what = "headings, tables, figures and numbers of the reference are not asked"
        print(f"check_docs: SKIPPED: {what}: {file} is missing", file=sys.stderr)
        return
    headings = headings_of_reference(file.read_text())
    if len(headings) < FEWEST_HEADINGS:
        faults.append(f"{REFERENCE}: only {len(headings)} numbered headings of chapters 2 to 4 were found")
    page = (root / "docs/reference.md").read_text().lower()
    faults += [
        f"docs/reference.md: does not have the reference's heading '{n} {title}'"
        for n, title in headings
        if f"{n} {title}".lower() not in page
    ]


def check_glossary(root, faults):
    terms = set()
    for line in (root / "docs/glossary.md").read_text().split("\n"):
        if not line.startswith("| **"):
            continue
        cells = [c.strip() for c in line.strip("|").split("|")]
        for term in re.findall(r"\*\*([^*]+)\*\*", cells[0]):
            if term in terms:
                faults.append(f"docs/glossary.md: {term} stands twice")
            terms.add(term)
        if len(cells) != 3 or not re.search(r"`[^`]+/[^`]+`|\]\(", cells[-1]):
            faults.append(f"docs/glossary.md: {cells[0]} has no file where it is computed")
    if len(terms) < 30:
        faults.append(f"docs/glossary.md: only {len(terms)} terms")


def check_retired_names(root, pages, faults):
    """The left column of "Retired names" in the glossary is on no other page."""
    section = (root / "docs/glossary.md").read_text().partition("## Retired names")[2]
    cells = [row.strip("|").split("|")[0] for row in section.split("\n") if row.startswith("| ")][1:]
    retired = [re.sub(r"\(.*?\)", "", name).strip() for cell in cells for name in cell.split(",")]
    for page in pages:
        if page != root / "docs/glossary.md":
            text = re.sub(r"\s+", " ", page.read_text()).lower()
            faults += [f"{page.relative_to(root)}: '{n}' is retired (docs/glossary.md)" for n in retired if n in text]


def number_of(text):
    try:
        return float(text)
    except ValueError:
        return None


def check_options(root, faults):
    """Tables under "## Options" whose header begins with "name": the names are members of structs. Where a row has as
    many defaults as names, numbers are compared; other texts are not."""
    text = "\n".join(p.read_text() for top in ("src", "lab") for p in (root / top).rglob("*.hpp"))
    members = set(re.findall(r"\w+", text))
    defaults = {}
    for name, value in re.findall(r"\b(\w+) = ([-+0-9.e]+)[,;]", text):
        defaults.setdefault(name, set()).add(number_of(value))
    for page in sorted((root / "docs").glob("*.md")):
        section = re.search(r"^## Options\n(.*?)(?=^## |\Z)", page.read_text(), re.MULTILINE | re.DOTALL)
        rows = [line for line in (section[1] if section else "").split("\n") if line.startswith("|")]
        if not rows or not rows[0].startswith("| name"):
            continue
        for row in rows[2:]:
            cells = [c.strip() for c in row.strip("|").split("|")]
            names = [n.split("::")[-1] for n in re.findall(r"`([\w:]+)`", cells[0])]
            faults += [f"docs/{page.name}: option {n} is not in the code" for n in names if n not in members]
            values = [re.sub(r"\(.*?\)|\+-.*", "", v).strip() for v in cells[2].split(",")]
            if len(values) == len(names):
                for name, value in zip(names, map(number_of, values), strict=True):
                    if value is not None and name in defaults and value not in defaults[name]:
                        known = ", ".join(str(d) for d in sorted(d for d in defaults[name] if d is not None))
                        faults.append(f"docs/{page.name}: {name} is {value:g} there and {known} in the code")


def check_lengths(root, faults):
    for page in sorted((root / "docs").glob("*.md")):
        lines = [line for line in page.read_text().splitlines() if not line.startswith("    ")]
        if page.name not in FREE and len(lines) > METHOD_LINES:
            faults.append(f"docs/{page.name}: {len(lines)} lines beyond formulas, at most {METHOD_LINES}")
        for number, line in enumerate(page.read_text().split("\n"), 1):
            if page.name not in FREE and len(line) > LINE_WIDTH and not line.startswith(("|", "    ", "![")):
                faults.append(f"docs/{page.name}:{number}: {len(line)} characters, at most {LINE_WIDTH}")
        if "**missed**" in page.read_text():
            faults.append(f"docs/{page.name}: a missed number belongs to docs/measured")
    for page in sorted((root / "docs/decisions").glob("*.md")):
        if len(page.read_text().split()) > 350:
            faults.append(f"docs/decisions/{page.name}: more than half a page")


def check_measured(root, faults):
    commands = set(re.findall(r'"([\w-]+)": "[\w.]+"', (root / "tools/measure").read_text()))
    for page in sorted((root / "docs/measured").glob("*.md")):
        text, say = page.read_text(), lambda what, page=page: faults.append(f"docs/measured/{page.name}: {what}")
        if not commands & set(re.findall(r"`tools/measure ([\w-]+)", text)):
            say("does not name the sub-command of tools/measure that makes it")
        stamps = STAMP.findall(text)
        top = re.match(r"# .+\n\n((?:Measured on commit .+\.\n)+)\n", text)
        if not top or len(STAMP.findall(top[1])) != len(stamps):
            say('"Measured on commit ..." stands in a line of its own below the title, and nowhere else')
        clean = len(stamps) == 1 and re.fullmatch("[0-9a-f]{7,40}", stamps[0]) is not None
        if not clean and page.stem not in NOT_MEASURED_ANEW:
            say(f"was measured on {', '.join(stamps) or 'no commit'}: one commit without changes is asked")
        if clean and page.stem in NOT_MEASURED_ANEW:
            say("is on one commit: take it off NOT_MEASURED_ANEW in tests/docs/check_docs.py")
        others = set(re.findall(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*\d)[0-9a-f]{7,40}\b", STAMP.sub("", text)))
        if others:
            say(f"names a commit that is not at its top: {', '.join(sorted(others))}")
        template = re.sub(r"<!-- measured: .*? -->\n.*?<!-- /measured -->\n?", "", text, flags=re.DOTALL)
        if template != text and len(template.strip().split("\n")) > TEMPLATE_LINES:
            say(f"{len(template.strip().splitlines())} lines outside of what is measured, at most {TEMPLATE_LINES}")
        for words in NOTES_IN_MEASURED:
            if words in text.lower():
                say(f"'{words}' belongs to docs/notes")


def check_notes(root, faults):
    for page in sorted((root / "docs/notes").glob("*.md")):
        for heading in re.findall(r"^## (.*)$", page.read_text(), re.MULTILINE):
            if not re.match(r"20\d\d-\d\d-\d\d: \S", heading):
                faults.append(f"docs/notes/{page.name}: '{heading}' has no date")


def check(root):
    faults = []
    pages = sorted((root / "docs").rglob("*.md")) + sorted(root.glob("*.md"))
    check_paths(root, pages, faults)
    check_pages_named_in_code(root, faults)
    check_links(root, pages, faults)
    check_reference_rows(root, faults)
    check_search_words(root, faults)
    check_published_numbers(root, faults)
    check_headings(root, faults)
    check_captions(root, faults)
    check_glossary(root, faults)
    check_retired_names(root, pages, faults)
    check_options(root, faults)
    check_lengths(root, faults)
    check_measured(root, faults)
    check_notes(root, faults)
    return faults


if __name__ == "__main__":
    found = check(Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve())
    print("\n".join(found))
    sys.exit(1 if found else 0)
