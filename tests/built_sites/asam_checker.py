"""Asks ASAM's OpenDRIVE checker about a file: asam_checker.py FILE.xodr RESULT.xqar. Prints how many of its checks ran and
what it found, by level, as JSON."""
import json
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as xml

LEVELS = {"1": "errors", "2": "warnings", "3": "information"}


def main(xodr, result):
    config = pathlib.Path(result).with_suffix(".config.xml")
    root = xml.Element("Config")
    xml.SubElement(root, "Param", name="InputFile", value=xodr)
    bundle = xml.SubElement(root, "CheckerBundle", application="xodrBundle")
    xml.SubElement(bundle, "Param", name="resultFile", value=result)
    xml.ElementTree(root).write(config)
    subprocess.run([pathlib.Path(sys.executable).parent / "qc_opendrive", "-c", config], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    report = xml.parse(result).getroot()
    found = {"completed": sum(checker.get("status") == "completed" for checker in report.iter("Checker")),
             **{level: [] for level in LEVELS.values()}}
    for issue in report.iter("Issue"):
        where = [place.get("xpath") for place in issue.iter("XMLLocation")]
        found[LEVELS[issue.get("level")]].append([issue.get("ruleUID"), *where])
    print(json.dumps(found))


main(*sys.argv[1:])
