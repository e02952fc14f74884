#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each check of check_docs.py finds the fault that it is for, in a small tree made here, and finds none without it."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import check_docs

ROWS = "| thesis | code | test |\n|---|---|---|\n"
ROW = "| curvature | `refine/fit_chain` | `tests/refine/fit_test` |\n"
MEASURED = "# Measured: refine\n\nMeasured on commit 0123abc.\n\nBy `tools/measure refine`: **missed**\n"
THESIS = "2.1 Background and Methodology\n\n3.1.1 Map Projections\n\n4.2 Mesh Generation\n\n"
THESIS += "Figure 2.1: Neuron.\n\nTable 3.1: IoU.\n\nIoU 76.7887 and 1e^{-10} and 1.000 times\n\n"
THESIS += "1.2 Requirements\n\n2.1 percent of it\n"  # asked for neither
HEADINGS = "Table 3.1 and figure 2.1.\n\n"
HEADINGS += "### 2.1 Background and Methodology\n\n### 3.1.1 Map projections\n\n### 4.2 Mesh Generation\n\n"


def tree(root, **changes):
    """A repository that has no fault, with `changes`: path -> text."""
    files = {
        "README.md": "See [the method](docs/refine.md#formulas).\n",
        "src/orthodrive/refine/fit_chain.hpp": "// docs/refine.md\n",
        "src/roadquery/road_map.hpp": "",
        "tools/measure": '{"refine": "refine"}',
        "tests/refine/fit_test.cpp": "",
        "docs/refine.md": "# Refine\n\n`refine/fit_chain` and `scene/tileset.json`\n\n## Formulas\n\n",
        "docs/reference.md": HEADINGS + ROWS + ROW,
        "../shared/reference/thesis.txt": THESIS,
        "docs/glossary.md": "".join(f"| **term {i}** | m | `refine/fit_chain` |\n" for i in range(30)),
        "docs/measured/refine.md": MEASURED,
        **changes,
    }
    for name, text in files.items():
        if text is None:
            continue
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class CheckDocs(unittest.TestCase):
    not_anew = set()

    def faults(self, **changes):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve() / "repository"
            tree(root, **changes)
            with (
                mock.patch.multiple(check_docs, FEWEST_HEADINGS=3, NOT_MEASURED_ANEW=self.not_anew),
                contextlib.redirect_stderr(io.StringIO()) as said,
            ):
                faults = check_docs.check(root)
            self.said = said.getvalue()
            return faults

    def finds(self, what, **changes):
        self.assertTrue(any(what in fault for fault in self.faults(**changes)), self.faults(**changes))

    def test_nothing_wrong(self):
        self.assertEqual(self.faults(), [])

    def test_paths(self):
        self.finds("refine/gone does not exist", **{"README.md": "`refine/gone`"})
        self.finds("src/gone does not exist", **{"README.md": "`src/gone --help`"})
        self.assertEqual(self.faults(**{"README.md": "`out/gone`, `a/b`\n\n    `refine/gone`\n"}), [])

    def test_pages_named_in_code(self):
        self.finds("names docs/gone.md", **{"src/orthodrive/refine/fit_chain.hpp": "// docs/gone.md"})

    def test_links(self):
        self.finds("leads nowhere", **{"README.md": "[x](docs/gone.md)"})
        self.finds("leads nowhere", **{"README.md": "![x](docs/images/gone.png)"})
        self.finds("no heading", **{"README.md": "[x](docs/refine.md#gone)"})

    def reference(self, row):
        return {"docs/reference.md": HEADINGS + ROWS + row}

    def test_rows_of_the_reference(self):
        self.finds("names no file that exists", **self.reference("| x | in general | `tests/refine/fit_test` |\n"))
        self.finds("refine/gone does not exist", **self.reference("| x | `refine/gone` | `tests/refine/fit_test` |\n"))
        self.finds("names no test that exists", **self.reference("| x | `refine/fit_chain` | |\n"))
        self.finds("names no test that exists", **self.reference("| x | `refine/fit_chain` | `refine/fit_chain` |\n"))
        self.finds("has three cells", **self.reference("| x | `refine/fit_chain` |\n"))
        self.finds("has no rows", **{"docs/reference.md": HEADINGS})

    def test_what_is_open_is_not_there(self):
        self.assertEqual(self.faults(**self.reference("| x | **Open**: `refine/gone` | |\n")), [])
        self.finds("open, but refine/fit_chain exists", **self.reference("| x | **Open**: `refine/fit_chain` | |\n"))
        self.finds(
            "open, but has a test", **self.reference("| x | **Open**: `refine/gone` | `tests/refine/fit_test` |\n")
        )
        self.finds("names the file that will have it", **self.reference("| x | **Open**: objects of the scene | |\n"))

    def test_what_is_left_out(self):
        self.assertEqual(self.faults(**self.reference("| x | **Left out**: its licence | |\n" + ROW)), [])
        self.finds(
            "left out, but has a test",
            **self.reference("| x | **Left out**: its licence | `tests/refine/fit_test` |\n"),
        )

    def numbers(self, row):
        return {
            "docs/reference.md": HEADINGS + ROWS + ROW + "\n| number | published | ours: x |\n|---|---|---|\n" + row
        }

    def test_published_numbers(self):
        for good in ("76.79 | 86", "76.7887; 1e-10; 1 | not measured", "37 | left out: licence"):
            thesis = {"../shared/reference/thesis.txt": THESIS + "37 minutes\n"}
            self.assertEqual(self.faults(**self.numbers(f"| IoU | {good} |\n"), **thesis), [])
        self.finds("76.78 is not in the reference", **self.numbers("| IoU | 76.78 | 86 |\n"))
        self.finds("1e-09 is not in the reference", **self.numbers("| rate | 1e-9 | 86 |\n"))
        self.finds("neither a number of ours", **self.numbers("| IoU | 76.79 | - / - |\n"))
        self.finds("a number has three cells", **self.numbers("| IoU | 76.79 | |\n"))
        self.finds("a number has three cells", **self.numbers("| IoU | | 86 |\n"))
        self.assertEqual(
            self.faults(**self.numbers("| IoU | 76.78 | 86 |\n"), **{"../shared/reference/thesis.txt": None}), []
        )

    def test_tables_and_figures_of_the_reference(self):
        captions = "Figure 2.1: a\nFigure 2.2: b\nFigure 2.3: c\nTable A.2: d\nTable 3.1: e\n"
        thesis = {"../shared/reference/thesis.txt": THESIS + captions}
        for good in ("figures 2.1 to 2.3, tables A.2, 3.1", "Figure 2.1, figures 2.2, 2.3b; tables 3.1 and A.2"):
            self.assertEqual(self.faults(**self.reference(ROW + good), **thesis), [], good)
        self.finds("reference's figure 2.2", **self.reference(ROW + "tables 3.1, A.2; figures 2.1 and 2.3"), **thesis)
        self.finds("reference's table A.2", **self.reference(ROW + "figures 2.1 to 2.3"), **thesis)

    def test_words_to_search_for(self):
        page = HEADINGS + '"angle\nvariation" leads to `refine/fit_chain`.\n\n' + ROWS + ROW
        chain = "src/orthodrive/refine/fit_chain.hpp"
        self.assertEqual(
            self.faults(**{"docs/reference.md": page, chain: "// the angle\n// variation of docs/refine.md"}), []
        )
        self.finds("is not in refine/fit_chain", **{"docs/reference.md": page})

    def test_headings_of_the_reference(self):
        for number in ("2.1 ", "3.1.1 ", "4.2 "):
            self.finds(
                f"heading '{number}", **{"docs/reference.md": HEADINGS.replace("### " + number, "### ") + ROWS + ROW}
            )
        self.finds("only 2 numbered headings", **{"../shared/reference/thesis.txt": THESIS.replace("4.2 Mesh", "Mesh")})

    def test_a_missing_reference_is_said(self):
        self.assertEqual(self.faults(**{"../shared/reference/thesis.txt": None}), [])
        self.assertIn("SKIPPED: headings, tables, figures and numbers of the reference", self.said)
        self.faults()
        self.assertEqual(self.said, "")

    def test_glossary(self):
        good = "".join(f"| **term {i}** | m | `refine/fit_chain` |\n" for i in range(30))
        self.finds("refine/gone does not exist", **{"docs/glossary.md": good + "| **x** | m | `refine/gone` |\n"})
        self.finds("no file where", **{"docs/glossary.md": good + "| **x** | m | |\n"})
        self.finds("stands twice", **{"docs/glossary.md": good + "| **term 1** | m | `refine/fit_chain` |\n"})
        self.finds("only 0 terms", **{"docs/glossary.md": "\n"})

    def test_retired_names(self):
        glossary = "".join(f"| **term {i}** | m | `refine/fit_chain` |\n" for i in range(30))
        glossary += "\n## Retired names\n\n| do not write | write |\n|---|---|\n| old name, older (one) | new |\n"
        self.assertEqual(self.faults(**{"docs/glossary.md": glossary}), [])
        self.finds("'old name' is retired", **{"docs/glossary.md": glossary, "README.md": "an old\nname"})
        self.finds("'older' is retired", **{"docs/glossary.md": glossary, "README.md": "Older"})

    def test_options(self):
        page = "## Formulas\n" + "## Options\n\n| name (`X`) | unit | default | |\n|---|---|---|---|\n"
        code = {"src/orthodrive/refine/fit_chain.hpp": "double step_m = 2.0, strip_m = 1.5;  bool clip = false;"}
        for row in ["| `step_m`, `X::strip_m` | m | 2, 1.5 | |", "| `clip` | | false | |"]:
            self.assertEqual(self.faults(**code, **{"docs/refine.md": page + row}), [])
        self.finds("strip_m is 1.6 there and 1.5", **code, **{"docs/refine.md": page + "| `strip_m` | m | 1.6 | |"})
        self.finds("option gone is not", **code, **{"docs/refine.md": page + "| `gone` | m | 1 | |"})

    def test_lengths(self):
        page = "## Formulas\n" + "x\n" * check_docs.METHOD_LINES
        self.finds("lines beyond formulas", **{"docs/refine.md": page})
        formulas = "## Formulas\n" + "    x\n" * 500
        self.assertEqual(self.faults(**{"docs/refine.md": formulas}), [])
        self.finds("200 characters", **{"docs/refine.md": "## Formulas\n" + "x" * 200 + "\n"})
        self.finds("belongs to docs/measured", **{"docs/refine.md": "## Formulas\n**missed** "})
        self.finds("more than half a page", **{"docs/decisions/x.md": "word " * 400})

    def measured(self, old, new, page="refine"):
        return {f"docs/measured/{page}.md": MEASURED.replace(old, new)}

    def test_measured_pages_name_one_commit(self):
        self.finds("does not name the sub-command", **self.measured("measure refine", "measure gone"))
        self.finds("was measured on no commit", **self.measured("Measured on commit 0123abc.\n\n", ""))
        self.finds("line of its own below the title", **self.measured("Measured on commit 0123abc.\n\n", ""))
        self.finds("nowhere else", **self.measured("missed**\n", "missed**\n\nMeasured on commit 0123abc.\n"))
        self.finds(
            "on 0123abc, 4567def: one commit", **self.measured("0123abc.\n", "0123abc.\nMeasured on commit 4567def.\n")
        )
        self.finds("on 0123abc + changes: one commit", **self.measured("0123abc", "0123abc + changes"))
        self.finds("not at its top: 4567def", **self.measured("missed", "missed since 4567def"))
        self.assertEqual(
            self.faults(**self.measured("missed", "1000000 nodes, 12345678 m, accede, 1e-6 and 0.1234567")), []
        )

    def test_pages_measured_anew_come_off_the_list(self):
        self.not_anew = {"refine"}
        self.assertEqual(self.faults(**self.measured("0123abc", "0123abc + changes")), [])
        self.finds("take it off NOT_MEASURED_ANEW")

    def test_notes_are_not_on_measured_pages(self):
        self.finds(
            "lines outside of what is measured",
            **self.measured("missed**\n", "<!-- measured: x -->\n1\n<!-- /measured -->\n" + "word\n" * 30),
        )
        self.assertEqual(
            self.faults(
                **self.measured("missed**\n", "<!-- measured: x -->\n" + "word\n" * 30 + "<!-- /measured -->\n")
            ),
            [],
        )
        self.finds("'tried and left' belongs to docs/notes", **self.measured("missed", "Tried and left: "))

    def test_notes_are_dated(self):
        self.assertEqual(
            self.faults(**{"docs/notes/refine.md": "# Notes\n\n## 2026-11-28: Tried\n\nmissed since 4567def\n"}), []
        )
        self.finds("'Tried' has no date", **{"docs/notes/refine.md": "# Notes\n\n## Tried\n"})


if __name__ == "__main__":
    unittest.main()
