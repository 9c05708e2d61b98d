#!/usr/bin/env python3
"""`whorl farm --on slurm` on a real Slurm that this script starts on the loopback address and stops again: the films are those of a local
run, also where a job is taken from its node half-way and begun again.

    tests/farm/slurm.py PROGRAM

Needs root, and Debian's slurm-wlm and munge (apt-get install slurm-wlm munge); without them it says so and ends with 77. Nothing but the
processes that it started is ended.
"""
import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from small_film import film, rows  # noqa: E402

FILM = film(0.5, 3e-3, "132, 64")
LONG_FILM = film(0.5, 1.8e-3, "132, 64")  # long enough for its job to lose its node meanwhile
PANELS = FILM + """
style = "particles"
field = "speed"
[[panel]]
label = "thick"
[[panel]]
label = "thin"
set = ["fluid.viscosity=2"]
"""
STUDY = """
scenes = ["film.toml"]
set = ["time.end=0.1"]
[[knob]]
key = "time.cfl"
values = [0.2, 0.4]
[accuracy]
of = "conserved"
column = "kinetic_energy"
at = "last"
"""
CONFIG = """
ClusterName=whorl
SlurmctldHost={name}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
MinJobAge=300
SlurmdTimeout=20
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
NodeName={name} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=films Nodes={name} Default=YES MaxTime=INFINITE State=UP
"""


def check(condition, what):
    print(("ok    " if condition else "WRONG ") + what, flush=True)
    if not condition:
        raise SystemExit(1)


class Slurm:
    """munged, slurmctld and slurmd in a folder of their own."""

    def __init__(self, folder):
        self.folder, self.children = folder, []
        name = os.uname().nodename.split(".")[0]
        for part in ("state", "spool"):
            (folder / part).mkdir()
        (folder / "slurm.conf").write_text(CONFIG.format(name=name, folder=folder, control=26817, node=26818))
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"), OMP_NUM_THREADS="1", XDG_CACHE_HOME=str(folder / "cache"))
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
                   f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed")
        self.start("slurmctld", "-D", "-c")
        self.node = self.start("slurmd", "-D", "-c")
        for _ in range(300):
            if self.ask("sinfo", "--noheader", "--format=%T").strip() in ("idle", "mixed", "allocated"):
                return
            time.sleep(0.1)
        raise SystemExit("Slurm did not come up: " + self.ask("sinfo") + (folder / "slurmctld.log").read_text()[-2000:])

    def start(self, *words):
        child = subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.children.append(child)
        time.sleep(1)
        return child

    def ask(self, *words):
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True)
        return done.stdout or done.stderr

    def stop(self):
        subprocess.run(["scancel", "--user=root"], env=self.environment, capture_output=True)
        time.sleep(1)
        for child in reversed(self.children):
            if child.poll() is None:
                child.send_signal(signal.SIGTERM)
                try:
                    child.wait(timeout=20)
                except subprocess.TimeoutExpired:
                    child.kill()


def same_film(local, farmed, tables=("diagnostics.csv",)):
    for table in tables:
        check(rows(local / table) == rows(farmed / table), f"{table} is that of the local run")
    names = sorted(p.name for p in (local / "frames").iterdir())
    check(sorted(p.name for p in (farmed / "frames").iterdir()) == names, f"{len(names)} pictures")
    other = [n for n in names if (local / "frames" / n).read_bytes() != (farmed / "frames" / n).read_bytes()]
    check(not other, "every picture is that of the local run, bit for bit" + (f", but {other}" if other else ""))
    for name in ("film.mp4", "contact.png"):
        check((local / name).exists() == (farmed / name).exists(), name)


def main():
    program = Path(sys.argv[1]).resolve()
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if not shutil.which(name)]
    if missing or os.geteuid() != 0:
        print("skipped: this needs root, slurm-wlm and munge; apt-get install --no-install-recommends slurm-wlm munge")
        raise SystemExit(77)
    folder = Path(tempfile.mkdtemp(prefix="whorl-slurm-"))
    slurm = Slurm(folder)
    try:
        def whorl(*words, **more):
            return subprocess.run([program, *words], env=slurm.environment, capture_output=True, text=True, cwd=folder, timeout=900, **more)

        (folder / "film.toml").write_text(FILM)
        (folder / "long_film.toml").write_text(LONG_FILM)
        (folder / "panels.toml").write_text('name = "film"\n' + PANELS)
        for scene in ("film", "panels", "long_film"):
            check(whorl("render", f"{scene}.toml", "--threads", "1", "--out", f"local_{scene}", "--quiet").returncode == 0, f"{scene}: local run")

        done = whorl("farm", "film.toml", "--on", "slurm", "--out", "farmed_film", "--pieces", "3")
        print(done.stderr)
        check(done.returncode == 0, "a film: simulated once, drawn in three pieces, encoded")
        same_film(folder / "local_film", folder / "farmed_film")

        done = whorl("farm", "panels.toml", "--on", "slurm", "--out", "farmed_panels")
        print(done.stderr)
        check(done.returncode == 0, "a film of panels: a job each, and one that gathers")
        same_film(folder / "local_panels", folder / "farmed_panels", ("panels/1/diagnostics.csv", "panels/2/diagnostics.csv"))

        # A study, whose runs are jobs one by one. Figures that are times differ from run to run.
        (folder / "study.toml").write_text(STUDY)
        for command in ("tradeoff", "stability"):
            tables = []
            for place in ("local", "slurm"):
                out = f"{command}_{place}"
                done = whorl(command, "study.toml", "--on", place, "--jobs", "2", "--threads", "1", "--out", out, *(["--all"] if command == "tradeoff" else []))
                check(done.returncode == 0, f"{command} on {place} {done.stderr}")
                with open(folder / out / f"{command}.csv") as file:
                    own = ("time.cfl", "error", "status", "state", "largest_stable", "first_bad_step", "why")
                    tables.append(sorted(tuple(row.get(name) for name in own) for row in csv.DictReader(file)))
            check(len(tables[0]) == 2 and tables[0] == tables[1], f"the table of {command} is that of a local run")

        # A job loses its node half-way; Slurm restarts it, and it continues from its checkpoint.
        farm = subprocess.Popen([program, "farm", "long_film.toml", "--on", "slurm", "--out", "taken", "--pieces", "2"], env=slurm.environment, cwd=folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while not list((folder / "taken" / "checkpoints").glob("00000[3-9].whorl")) and farm.poll() is None:
            time.sleep(0.02)
        slurm.node.kill()
        job = slurm.ask("squeue", "--noheader", "--name=whorl-simulate", "--format=%A").split()[0]
        slurm.node = slurm.start("slurmd", "-D")
        print("requeued:", slurm.ask("scontrol", "requeue", job))
        slurm.ask("scontrol", "release", job)
        text = farm.communicate(timeout=600)[1]
        print(text)
        check(farm.returncode == 0, "the film is made though its node was killed and its job requeued")
        same_film(folder / "local_long_film", folder / "taken")
        check('"resumed": 1' in (folder / "taken" / "run.json").read_text(), "it went on from its checkpoint")
    finally:
        slurm.stop()
    shutil.rmtree(folder)


main()
