#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each check of check_docs.py finds the fault that it is for, in a small tree made here, and finds none without it."""
import tempfile
import unittest
from pathlib import Path

import check_docs

SENTENCES = "dense CRF, angle variation, moving average, alpha blending, normals at tile borders\n"


def tree(root, **changes):
    """A repository that has no fault, with `changes`: path -> text."""
    files = {
        "README.md": "See [the method](docs/refine.md#formulas).\n",
        "src/orthodrive/refine/fit_chain.hpp": "// docs/refine.md\n",
        "src/roadquery/road_map.hpp": "",
        "tools/measure": "",
        "docs/refine.md": "# Refine\n\n`refine/fit_chain` and `scene/tileset.json`\n\n## Formulas\n\n" + SENTENCES,
        "docs/reference.md": SENTENCES,
        "docs/glossary.md": "".join(f"| **term {i}** | m | `refine/fit_chain` |\n" for i in range(30)),
        "docs/measured/refine.md": "By `tools/measure refine`: **missed**\n",
        **changes,
    }
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class CheckDocs(unittest.TestCase):
    def faults(self, **changes):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            tree(root, **changes)
            return check_docs.check(root)

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

    def test_sentences(self):
        for sentence in check_docs.SENTENCES:
            without = SENTENCES.replace(sentence, "")
            self.finds(f"'{sentence}' is in no file", **{"docs/refine.md": "## Formulas\n" + without})
            self.finds(f"where '{sentence}' is", **{"docs/reference.md": without})

    def test_sentences_in_comments_of_several_lines(self):
        comment = "// " + SENTENCES.replace(" ", "\n// ")
        changes = {"docs/refine.md": "## Formulas\n", "src/orthodrive/refine/fit_chain.hpp": comment}
        self.assertEqual(self.faults(**changes), [])

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
        page = "## Formulas\n" + SENTENCES + "## Options\n\n| name (`X`) | unit | default | |\n|---|---|---|---|\n"
        code = {"src/orthodrive/refine/fit_chain.hpp": "double step_m = 2.0, strip_m = 1.5;  bool clip = false;"}
        for row in ["| `step_m`, `X::strip_m` | m | 2, 1.5 | |", "| `clip` | | false | |"]:
            self.assertEqual(self.faults(**code, **{"docs/refine.md": page + row}), [])
        self.finds("strip_m is 1.6 there and 1.5", **code, **{"docs/refine.md": page + "| `strip_m` | m | 1.6 | |"})
        self.finds("option gone is not", **code, **{"docs/refine.md": page + "| `gone` | m | 1 | |"})

    def test_lengths(self):
        page = "## Formulas\n" + SENTENCES + "x\n" * check_docs.METHOD_LINES
        self.finds("lines beyond formulas", **{"docs/refine.md": page})
        formulas = "## Formulas\n" + SENTENCES + "    x\n" * 500
        self.assertEqual(self.faults(**{"docs/refine.md": formulas}), [])
        self.finds("200 characters", **{"docs/refine.md": "## Formulas\n" + "x" * 200 + "\n" + SENTENCES})
        self.finds("belongs to docs/measured", **{"docs/refine.md": "## Formulas\n**missed** " + SENTENCES})
        self.finds("more than half a page", **{"docs/decisions/x.md": "word " * 400})
        self.finds("what makes it", **{"docs/measured/refine.md": "1 m"})


if __name__ == "__main__":
    unittest.main()
