# SPDX-License-Identifier: Apache-2.0
"""Asks one of ASAM's checkers about a file: asam_checker.py qc_opendrive|qc_openscenario FILE RESULT.xqar. Prints how
many of its checks ran and what it found, by level, as JSON.
"""

import json
import pathlib
import subprocess
import sys
from xml.etree import ElementTree

BUNDLES = {"qc_opendrive": "xodrBundle", "qc_openscenario": "xoscBundle"}
LEVELS = {"1": "errors", "2": "warnings", "3": "information"}


def main(checker_name, file, result):
    config = pathlib.Path(result).with_suffix(".config.xml")
    root = ElementTree.Element("Config")
    ElementTree.SubElement(root, "Param", name="InputFile", value=file)
    bundle = ElementTree.SubElement(root, "CheckerBundle", application=BUNDLES[checker_name])
    ElementTree.SubElement(bundle, "Param", name="resultFile", value=result)
    ElementTree.ElementTree(root).write(config)
    subprocess.run(
        [pathlib.Path(sys.executable).parent / checker_name, "-c", config],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    report = ElementTree.parse(result).getroot()
    found = {
        "completed": sum(checker.get("status") == "completed" for checker in report.iter("Checker")),
        **{level: [] for level in LEVELS.values()},
    }
    for issue in report.iter("Issue"):
        where = [place.get("xpath") for place in issue.iter("XMLLocation")]
        found[LEVELS[issue.get("level")]].append([issue.get("ruleUID"), *where])
    print(json.dumps(found))


main(*sys.argv[1:])
