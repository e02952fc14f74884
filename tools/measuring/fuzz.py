"""How often readers of foreign files were run by libFuzzer without a finding left. Writes docs/measured/fuzz.md.

Runs `tools/fuzz` for each reader and adds what ran to bench/results/fuzz.json. After a change of a reader that mends a finding
its count begins anew: --forget READER.
"""
import datetime

from measuring.common import *

STORE, PAGE = "fuzz.json", PAGES / "fuzz.md"


def add_arguments(parser):
    add_table(parser)
    parser.add_argument("--only", nargs="+", metavar="READER", help="these readers; all of them otherwise")
    parser.add_argument("--seconds", type=int, default=1800, help="of each reader (1800)")
    parser.add_argument("--forget", nargs="+", default=[], metavar="READER", help="readers whose counts begin anew")


def names():
    script = (ROOT / "tools/fuzz").read_text()
    return [name for group in ("own", "of_files") for name in re.search(rf"^{group}=\(([^)]*)\)", script, re.M)[1].split()]


def run(args):
    results = read_results(STORE, {})
    for name in args.forget:
        results.pop(name, None)
    for name in [] if args.table else args.only or names():
        subprocess.run([str(ROOT / "tools/fuzz"), name, str(args.seconds)], check=True, cwd=ROOT)
        log = (ROOT / "build/fuzz" / f"{name}.log").read_text(errors="replace")
        runs, seconds = re.search(r"^Done (\d+) runs in (\d+) second", log, re.M).groups()
        covered = re.findall(r"\bcov: (\d+)", log)
        before = results.get(name, {"runs": 0, "seconds": 0})
        results[name] = {"runs": before["runs"] + int(runs), "seconds": before["seconds"] + int(seconds), "edges": int(covered[-1]) if covered else 0,
                         "last": datetime.date.today().isoformat(), "commit": commit(), **machine()}
        write_results(STORE, results)
    if args.forget:
        write_results(STORE, results)
    table = header(["reader", "runs", "minutes", "branches seen", "ten million runs or 30 minutes"])
    for name in names():
        if name not in results:
            table += row([name, 0, 0, "", "no"])
            continue
        r = results[name]
        reached = r["runs"] >= 10_000_000 or r["seconds"] >= 1800
        table += row([name, f"{r['runs']:,}".replace(",", " "), fixed(r["seconds"] / 60, 1), r["edges"], "yes" if reached else "no"])
    write_between(PAGE, "fuzz", table)
