#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Manual pages and completions that the tool writes of its command table, against what its --help says, read by groff,
bash, zsh and fish.

Usage: help_test.py ORTHODRIVE. Prints one line a fault; exit code 1 if there is any, 77 where a reader is missing and
the rest is right.
"""

import functools
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOOL = Path(sys.argv[1]).resolve()
faults, missing = [], []


def check(right, fault):
    if not right:
        faults.append(fault)


def run(*command, **kwargs):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=300, check=False, **kwargs)


@functools.cache
def help_of(*words):
    return run(TOOL, *words, "--help").stdout


def commands_of(help_text):
    section = help_text.partition("Subcommands:\n")[2].partition("\n\n")[0]
    return re.findall(r"^  (\w[\w-]*)", section, re.MULTILINE)


def options_of(help_text):
    return [name for line in re.findall(r"^  (-\S+)", help_text, re.MULTILINE) for name in line.split(",")]


def check_pages(folder):
    tool_help = help_of()
    commands = commands_of(tool_help)
    check(len(commands) > 10, f"--help lists {len(commands)} commands")
    pages = {p.name for p in folder.glob("*.1")}
    check(
        pages == {"orthodrive.1"} | {f"orthodrive-{c}.1" for c in commands},
        f"pages {sorted(pages)} for commands {commands}",
    )
    if not shutil.which("groff"):
        missing.append("groff")
        return
    for page in sorted(folder.glob("*.1")):
        made = run("groff", "-ww", "-man", "-Tutf8", "-P-cbou", "-rLL=150n", page)
        check(made.returncode == 0 and not made.stderr, f"{page.name}: groff says {made.stderr}")
        text = made.stdout.replace("\N{HYPHEN}", "-").replace("\N{MINUS SIGN}", "-")
        check("NAME" in text and "SYNOPSIS" in text and "EXIT STATUS" in text, f"{page.name} lacks a section")
        command = page.stem.removeprefix("orthodrive").strip("-")
        kinds = commands_of(help_of(command)) if command else []
        for words in [[command], *([command, kind] for kind in kinds)] if command else [[]]:
            for option in options_of(help_of(*words)):
                check(re.search(rf"(?<!\S){option}(?![\w-])", text), f"{page.name} does not name {option} of {words}")
        if command:
            example = re.search(r"^  (orthodrive .*)$", help_of(command), re.MULTILINE)[1]
            check(" ".join(example.split()) in " ".join(text.split()), f"{page.name} lacks the example {example}")


def complete_in_bash(file, line):
    """What the function answers for a line whose last word is being typed; None: bash completes files."""
    words = line.split(" ")
    quoted = " ".join(f"'{w}'" for w in words)
    script = f"""source {file}
compopt() {{ echo "compopt $*"; }}
COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; COMPREPLY=(); _orthodrive; printf '%s\\n' "${{COMPREPLY[@]}}" """
    made = run("bash", "--norc", "-c", script)
    check(not made.stderr, f"bash says {made.stderr} for {line}")
    return made.stdout.split()


def check_bash(file):
    def expect(line, *words):
        got = complete_in_bash(file, line)
        check(got == list(words), f"bash completes '{line}' with {got}, not {list(words)}")

    commands = commands_of(help_of())
    expect("orthodrive ", *commands)
    expect("orthodrive bui", "build")
    expect("orthodrive evaluate ", *commands_of(help_of("evaluate")))
    expect("orthodrive synth --preset vil", "village")
    expect("orthodrive synth --preset = vil", "village")
    expect("orthodrive synth --seed ", "compopt", "+o", "default")
    expect("orthodrive build -o ")  # files
    expect("orthodrive build ")
    expect("orthodrive view --no", "--no-open")
    expect("orthodrive evaluate roads --bef", "--before")
    expect("orthodrive evaluate roads --js", "--json")
    for command in commands:
        own = set(options_of(help_of(command)))
        got = set(complete_in_bash(file, f"orthodrive {command} -"))
        check(own <= got, f"bash lacks {own - got} of {command}")


def check_files_in_bash(file, folder):
    """A real interactive bash: Tab completes the name of a file, a blank in it included."""
    (folder / "my site.toml").write_text("")
    master, slave = pty.openpty()
    shell = subprocess.Popen(
        ["bash", "--norc", "--noprofile", "-i"],
        stdin=slave,
        stdout=slave,
        stderr=slave,
        cwd=folder,
        start_new_session=True,
        env={**os.environ, "PS1": "$ ", "TERM": "dumb", "INPUTRC": "/dev/null", "HISTFILE": ""},
    )
    os.close(slave)
    os.write(master, f"source {file}; orthodrive() {{ printf 'GOT<%s>' \"$@\"; }}\n".encode())
    time.sleep(0.5)
    os.write(master, b"orthodrive build my\t\n")
    seen, end = "", time.time() + 20
    while "GOT<my" not in seen and time.time() < end:
        if select.select([master], [], [], 0.2)[0]:
            seen += os.read(master, 4096).decode(errors="replace")
    shell.kill()
    shell.wait()
    os.close(master)
    check("GOT<my site.toml>" in seen, f"Tab in bash completes no file: {seen!r}")


def check_other_shells(folder):
    if shutil.which("zsh"):
        made = run("zsh", "-n", folder / "orthodrive.zsh")
        check(made.returncode == 0 and not made.stderr, f"zsh says {made.stderr}")
    else:
        missing.append("zsh")
    if not shutil.which("fish"):
        missing.append("fish")
        return

    def fish(line):
        made = run(
            "fish",
            "--no-config",
            "-c",
            f"source {folder}/orthodrive.fish; complete -C '{line}'",
            env={**os.environ, "HOME": str(folder)},
        )
        check(not made.stderr, f"fish says {made.stderr}")
        return [answer.split("\t")[0] for answer in made.stdout.splitlines()]

    check(fish("orthodrive bui") == ["build"], f"fish completes bui with {fish('orthodrive bui')}")
    check(
        fish("orthodrive synth --preset v") == ["village"],
        f"fish completes --preset v with {fish('orthodrive synth --preset v')}",
    )
    check("--before" in fish("orthodrive evaluate roads --be"), "fish lacks --before of evaluate roads")
    check("labels" in fish("orthodrive evaluate la"), "fish lacks evaluate labels")


with tempfile.TemporaryDirectory() as name:
    folder = Path(name) / "help"
    written = run(TOOL, "help-files", folder)
    check(written.returncode == 0 and not written.stderr, f"help-files says {written.stderr}")
    check("help-files" not in help_of(), "--help lists help-files")
    check_pages(folder)
    check_bash(folder / "orthodrive.bash")
    check_files_in_bash(folder / "orthodrive.bash", Path(name))
    check_other_shells(folder)
print("\n".join(faults))
if missing:
    print(f"help_test: SKIPPED what asks {', '.join(missing)} (tools/setup --peers)", file=sys.stderr)
sys.exit(1 if faults else 77 if missing else 0)
