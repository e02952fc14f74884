# SPDX-License-Identifier: Apache-2.0
"""A build shared by two nodes of a Slurm cluster, one of them lost half-way. Writes docs/measured/cluster.md.

Slurm's daemons run on this machine, on the loopback, with one core a node: two nodes need two cores and nothing else
beside them. Needs slurmctld, slurmd, slurm-client and munge, and root. --site gives another site than Kvarnbyn.
"""

import contextlib
import hashlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from measuring.common import (
    PAGES,
    ROOT,
    Tool,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "cluster.json", PAGES / "cluster.md"
DRIVER = ROOT / "examples/cluster/slurm_build.sh"
CONF = """ClusterName=orthodrive
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CryptoType=crypto/munge
AuthInfo=socket={home}/munge.socket,cred_expire=20
CredType=cred/munge
StateSaveLocation={home}/state
SlurmdSpoolDir={home}/spool-%n
SlurmctldPidFile={home}/slurmctld.pid
SlurmdPidFile={home}/slurmd-%n.pid
SlurmctldLogFile={home}/slurmctld.log
SlurmdLogFile={home}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0,default_queue_depth=1000
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmctldTimeout=30
SlurmdParameters=config_overrides
SlurmdTimeout=15
InactiveLimit=0
KillWait=5
MinJobAge=300
ReturnToService=2
JobRequeue=1
{nodes}PartitionName=cells Nodes=node[1-{count}] Default=YES MaxTime=INFINITE State=UP
"""


def add_arguments(parser):
    add_tool(parser, "out/cluster")
    add_table(parser)
    parser.add_argument("--site", type=pathlib.Path, default=ROOT / "sites/kvarnbyn.toml")
    parser.add_argument("--name", help="of the site in the table; its file's otherwise")
    parser.add_argument(
        "--without-alone",
        action="store_true",
        help="leave out the build without Slurm: files are compared with those of one node",
    )
    parser.add_argument("--without-loss", action="store_true", help="leave out the builds that lose a node")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def pid_in(file):
    return int(file.read_text().strip())


@contextlib.contextmanager
def cluster(nodes):
    """Slurm with that many nodes of one core; gives the environment of its clients and its folder."""
    home = pathlib.Path(tempfile.mkdtemp(prefix="slurm-"))
    try:
        home.chmod(0o755)
        for name in ["state", *(f"spool-node{i + 1}" for i in range(nodes))]:
            (home / name).mkdir()
        (home / "munge.key").write_bytes(os.urandom(1024))
        (home / "munge.key").chmod(0o400)
        controller, *ports = free_ports(nodes + 1)
        host = socket.gethostname()
        lines = "".join(
            (
                f"NodeName=node{i + 1} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=8000 "
                "State=UNKNOWN\n"
            )
            for i, port in enumerate(ports)
        )
        (home / "slurm.conf").write_text(
            CONF.format(home=home, host=host, controller=controller, nodes=lines, count=nodes)
        )
        environment = {**os.environ, "SLURM_CONF": str(home / "slurm.conf")}
        run_program(
            "munged",
            "--force",
            f"--key-file={home}/munge.key",
            f"--socket={home}/munge.socket",
            f"--pid-file={home}/munged.pid",
            f"--log-file={home}/munged.log",
            f"--seed-file={home}/munged.seed",
        )
        run_program("slurmctld", "-c", env=environment)
        for i in range(nodes):
            run_program("slurmd", "-N", f"node{i + 1}", env=environment)
        for _ in range(100):
            if run_program("sinfo", "-h", "-N", "-o", "%T", env=environment).split() == ["idle"] * nodes:
                break
            time.sleep(0.2)
        else:
            sys.exit("cluster: Slurm's nodes do not come up:\n" + (home / "slurmctld.log").read_text()[-2000:])
        yield environment, home
    finally:
        for file in [*home.glob("slurmd-*.pid"), home / "slurmctld.pid", home / "munged.pid"]:
            with contextlib.suppress(OSError, ValueError):
                os.kill(pid_in(file), signal.SIGTERM)
        time.sleep(1)
        shutil.rmtree(home, ignore_errors=True)


def digests(out):
    """Of all files that a user gets; but for times."""
    skip = {"report.html", "run.json", "item.json"}
    return {
        str(f.relative_to(out)): hashlib.sha256(f.read_bytes()).hexdigest()
        for f in sorted(out.rglob("*"))
        if f.is_file() and ".orthodrive" not in f.parts and f.name not in skip
    }


def kill_node(home, name):
    """All at once, as when a machine loses its power: the daemon, the tasks' guards and the tasks."""
    victims = {pid_in(home / f"slurmd-{name}.pid")}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if f"SLURMD_NODENAME={name}".encode() not in (process / "environ").read_bytes().split(b"\0"):
                continue
            victims.add(int(process.name))
            parent = (process / "stat").read_text().rsplit(")", 1)[1].split()[1]
            if "slurmstepd" in pathlib.Path("/proc", parent, "comm").read_text():
                victims.add(int(parent))
    for pid in victims:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return len(victims)


CASES = {
    "one node": (1, None),
    "two nodes": (2, None),
    "two nodes, the one that helps lost": (2, "node2"),
    "two nodes, the one that builds lost": (2, "node1"),
}


def job_of(environment, node):
    """Index of the job that runs on a node."""
    for line in run_program("squeue", "-h", "-r", "-o", "%N %K", env=environment).splitlines():
        if line.split()[0] == node:
            return int(line.split()[1])
    sys.exit(f"cluster: no job runs on {node}")


def shared_build(args, out, nodes, lost):
    shutil.rmtree(out, ignore_errors=True)
    with cluster(nodes) as (environment, home):
        environment["ORTHODRIVE"] = str(args.tool.resolve())
        start = time.monotonic()
        log = (out.parent / f"{out.name}.log").open("w")
        build = subprocess.Popen(
            [DRIVER, args.site.resolve(), out, str(nodes)], env=environment, stdout=log, stderr=subprocess.STDOUT
        )
        killed = 0
        if lost:
            while build.poll() is None and len(list(out.glob(".orthodrive/cells/segment-*/cells/[0-9]*/cell.bin"))) < 3:
                time.sleep(0.2)
            if job_of(environment, lost) != (0 if lost == "node1" else 1):
                sys.exit("cluster: Slurm gave the jobs to the nodes in another order; run again")
            killed = kill_node(home, lost)
        if build.wait() != 0:
            sys.exit(f"cluster: the build failed, see {log.name}")
        return {"seconds": time.monotonic() - start, "killed": killed, "digests": digests(out)}


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for program in ("slurmctld", "slurmd", "sbatch", "munged"):
            if not shutil.which(program):
                sys.exit(f"cluster: needs {program} (tools/setup --peers)")
        args.out.mkdir(parents=True, exist_ok=True)
        tool, alone, expected = Tool(args.tool), args.out / "alone", None
        shutil.rmtree(alone, ignore_errors=True)
        of_site = numbers[args.name or args.site.stem] = {
            "commit": commit(),
            "machine": machine(),
            "load": round(os.getloadavg()[0], 1),
        }
        if not args.without_alone:
            of_site["alone"] = {"seconds": tool.timed("--threads", 1, "build", args.site, "-o", alone)}
            expected = digests(alone)
        for name, (nodes, lost) in CASES.items():
            if lost and args.without_loss:
                continue
            result = shared_build(args, args.out / name.replace(" ", "_").replace(",", ""), nodes, lost)
            found = result.pop("digests")
            expected = expected or found
            result["files"], result["different"] = (
                len(expected),
                sum(found.get(f) != d for f, d in expected.items()) + len(found.keys() - expected.keys()),
            )
            of_site[name] = result
            print(name, result, flush=True)
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"cluster": table(numbers)})


def table(numbers):
    text = header(["site", "built by", "seconds", "times one node", "files that differ", "load before"])
    for site, of_site in numbers.items():
        alone = of_site.get("alone", {}).get("seconds")
        text += row([site, "`build`, one thread, without Slurm", fixed(alone, 1), "", "", of_site["load"]])
        for name in CASES:
            if n := of_site.get(name):
                text += row(
                    [
                        "",
                        name,
                        fixed(n["seconds"], 1),
                        fixed(of_site["one node"]["seconds"] / n["seconds"]),
                        f"{n['different']} of {n['files']}",
                        "",
                    ]
                )
    return text + "\nAsked: two nodes 1.7 times one; one lost: the same bytes.\n" if numbers else ""
