#!/usr/bin/env python3
"""A batch on a real Slurm cluster: slurmctld and two slurmd on this machine. Usage: slurm_test.py SWIFTLET

Ends with status 77 (skipped) where Slurm is not installed or we are not root, who alone may start its daemons here.
"""
import contextlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from results import rows

SWIFTLET = pathlib.Path(sys.argv[1]).resolve()
SCENARIO = """name: hover
duration_s: 60
world: {type: empty}
wind: {gusts: true}
vehicles:
  - {name: a, start: {position_m: [0, 0, 5]}, agent: {localization: {type: ground_truth}}}
"""
BATCH = """name: cluster
scenario: hover
variants: [{name: calm}, {name: windy, set: {wind.wind_at_6m_mps: 15}}]
seeds: {count: 32}
slurm: {episodes_per_task: 16, memory_per_cpu_mb: 1000}
"""
CONFIG = """ClusterName=swarm
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={d}/run/munge.socket
SlurmctldPort=16817
MpiDefault=none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SlurmdTimeout=10
KillWait=2
StateSaveLocation={d}/ctld
SlurmdSpoolDir={d}/spool.%n
SlurmctldPidFile={d}/run/slurmctld.pid
SlurmdPidFile={d}/run/slurmd.%n.pid
SlurmctldLogFile={d}/log/slurmctld.log
SlurmdLogFile={d}/log/slurmd.%n.log
SlurmdParameters=config_overrides
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port=17001 CPUs=1 RealMemory=4000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port=17002 CPUs=1 RealMemory=4000
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""
SKIPPED = 77


def say(*words):
    print(*words, flush=True)


def run(*arguments, check=True, **options):
    result = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=300, **options)
    if check and result.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {result.returncode}\n{result.stdout}{result.stderr}")
    return result


def wait_for(what, condition, seconds=240):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.2)
    raise RuntimeError(f"timed out waiting for {what}\n{run('squeue', check=False).stdout}")


@contextlib.contextmanager
def cluster(folder):
    for name in ("ctld", "log", "run", "spool.n1", "spool.n2"):
        (folder / name).mkdir(parents=True)
    key = folder / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    folder.chmod(0o755)
    config = folder / "slurm.conf"
    config.write_text(CONFIG.format(host=socket.gethostname().split(".")[0], d=folder))
    os.environ["SLURM_CONF"] = str(config)
    try:
        run("munged", f"--key-file={key}", f"--socket={folder}/run/munge.socket", f"--pid-file={folder}/run/munged.pid",
            f"--log-file={folder}/log/munged.log", f"--seed-file={folder}/run/munged.seed")
        run("slurmctld", "-f", config)
        for node in ("n1", "n2"):
            run("slurmd", "-f", config, "-N", node)
        wait_for("two idle nodes", lambda: run("sinfo", "-h", "-t", "idle", "-o", "%D", check=False).stdout.strip() == "2")
        yield
    finally:
        for name in ("slurmd.n1", "slurmd.n2", "slurmctld", "munged"):
            with contextlib.suppress(OSError, ValueError):
                os.kill(int((folder / f"run/{name}.pid").read_text()), signal.SIGTERM)
        time.sleep(1)


def states(job):
    """JobState by array task."""
    found = {}
    for line in run("scontrol", "show", "job", job, "-o", check=False).stdout.splitlines():
        fields = dict(word.split("=", 1) for word in line.split() if "=" in word)
        found[fields.get("ArrayTaskId", "")] = fields["JobState"]
    return found


def active(*jobs):
    return bool(run("squeue", "-h", "-j", ",".join(jobs), check=False).stdout.strip())


def submit(folder):
    output = run(SWIFTLET, "batch", "batch.yaml", "--out", "shared", "--slurm", "--submit", cwd=folder).stdout
    say(output)
    words = output[output.index("submitted: array"):].replace(",", "").split()
    return words[2], words[4]


def test(folder):
    (folder / "hover.yaml").write_text(SCENARIO)
    (folder / "batch.yaml").write_text(BATCH)
    run(SWIFTLET, "batch", "batch.yaml", "--out", "local", "--shard", "1/1", "-q", cwd=folder)
    expected = rows(folder / "local/results.sqlite")
    assert len(expected["episodes"]) == 64

    array, merge = submit(folder)
    wait_for("a running task", lambda: "RUNNING" in states(array).values())
    victim = next(task for task, state in states(array).items() if state == "RUNNING")
    time.sleep(0.5)
    say(f"killing task {victim} of {array}: {states(array)}")
    run("scancel", "--signal=KILL", "--full", f"{array}_{victim}")
    wait_for("the array and the merge", lambda: not active(array, merge))
    say("ended:", states(array), states(merge))
    assert states(array)[victim] != "COMPLETED", "the task should have been killed"
    assert states(merge)[""] == "FAILED", "the merge should report missing episodes"
    assert len(rows(folder / "shared/results.sqlite")["episodes"]) < 64

    # The user resubmits the task, then the merge.
    scripts = folder / "shared/slurm"
    again = run("sbatch", "--parsable", f"--array={victim}", scripts / "array.sbatch").stdout.strip()
    last = run("sbatch", "--parsable", f"--dependency=afterany:{again}", scripts / "merge.sbatch").stdout.strip()
    wait_for("the resumed task and the merge", lambda: not active(again, last))
    say("ended:", states(again), states(last))
    log = (scripts / f"merge_{last}.log").read_text()
    say(log)
    assert "64 of 64 episodes" in log
    assert states(last)[""] == "COMPLETED"
    assert rows(folder / "shared/results.sqlite") == expected, "the cluster's results differ from the local ones"
    hosts = sorted(p.name for p in (folder / "shared/shards").glob("*.sqlite"))
    say(f"row for row the local batch, from {hosts}")


def main():
    if os.geteuid() != 0 or any(shutil.which(p) is None for p in ("slurmctld", "slurmd", "munged", "sbatch")):
        say("skipped: needs root and Debian's slurm-wlm and munge")
        return SKIPPED
    for name in list(os.environ):
        if name.startswith("SLURM_"):
            del os.environ[name]
    with tempfile.TemporaryDirectory(prefix="swiftlet_slurm_") as name:
        folder = pathlib.Path(name)
        folder.chmod(0o755)  # munge insists
        with cluster(folder / "cluster"):
            work = folder / "work"
            work.mkdir()
            test(work)
    say("ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())
