# SPDX-License-Identifier: Apache-2.0
"""Which files have changed: since a branch left main, or, on main itself, in its last commits."""

import subprocess

from .common import ROOT, SkippedError

LAST_COMMITS = 20  # on main: more than a day's work, and minutes of clang-tidy
UPSTREAMS = ["origin/main", "main"]


def git(*words):
    run = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True, check=False)
    return run.stdout.strip() if run.returncode == 0 else ""


def default_base():
    """The commit that changes count from. A clone without history has none: its first commit changes every file."""
    head = git("rev-parse", "HEAD")
    for upstream in UPSTREAMS:
        left = git("merge-base", "HEAD", upstream)
        if left and left != head:
            return left
    if git("rev-parse", "--is-shallow-repository") == "true":
        raise SkippedError(
            f"a shallow clone does not say what has changed: fetch {LAST_COMMITS} commits, or give --since"
        )
    return (
        git("rev-parse", "--verify", f"HEAD~{LAST_COMMITS}")
        or git("rev-list", "--max-parents=0", "HEAD").splitlines()[0]
    )


def changed_since(base):
    """Names of changed files, the newest change first. A line that names the licence changes nothing."""
    commit = git("rev-parse", "--verify", f"{base}^{{commit}}")
    if not commit:
        raise SkippedError(f"no commit {base} in this repository")
    words = ["--numstat", "--no-renames", "--ignore-matching-lines=SPDX-License-Identifier"]
    rows = git("diff", *words, "HEAD").splitlines() + git("log", "--format=", *words, f"{commit}..HEAD").splitlines()
    return list(dict.fromkeys(row.split("\t")[2] for row in rows if row.count("\t") == 2))
