#!/usr/bin/env python3
"""Readers under libFuzzer: builds the preset `fuzz` and runs each target for a while, from the files of tests/fuzz/corpus; `scene` begins
with the scenes that ship, too.

    tests/fuzz/fuzz.py [--seconds 60] [--keep FOLDER] [NAME ...]

Prints a line a target: executions, places in the program that they reached, findings. The exit code is 1 where a target crashed, broke a
promise, waited more than 10 s or took more than 2 GiB; the input that did it is kept in build/fuzz/findings and named. --keep is for long runs: it
holds what was found worth going on from. The exit code is 77 where clang 14 is missing (apt-get install clang-14 libclang-rt-14-dev libomp-14-dev).
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).resolve().parent / "corpus"


def build():
    if not shutil.which("clang++-14"):
        print("skipped: no clang++-14; apt-get install clang-14 libclang-rt-14-dev libomp-14-dev")
        sys.exit(77)
    for command in (["cmake", "--preset", "fuzz"], ["cmake", "--build", "--preset", "fuzz"]):
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout[-3000:] + done.stderr[-3000:])


def fuzz(name, seconds, keep, scratch):
    """Runs one target, whose files go to the folder `scratch`. Returns whether it found nothing."""
    found = ROOT / "build" / "fuzz" / "findings"
    found.mkdir(exist_ok=True)
    work = keep / name
    work.mkdir(parents=True, exist_ok=True)
    command = [ROOT / "build" / "fuzz" / "tests" / "fuzz" / f"fuzz_{name}", f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048",
               "-max_len=8192", "-print_final_stats=1", f"-artifact_prefix={found}/{name}_", work, CORPUS / name,
               *([ROOT / "scenes"] if name == "scene" else [])]
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, errors="replace",
                          env=dict(os.environ, OMP_NUM_THREADS="1", ASAN_OPTIONS="detect_leaks=0", TMPDIR=scratch))
    executions = re.search(r"number_of_executed_units:\s*(\d+)", done.stderr)
    reached = re.findall(r"cov: (\d+)", done.stderr)
    print(f"{name}: {executions[1] if executions else '?'} executions, {reached[-1] if reached else '?'} places reached, "
          f"{'nothing found' if done.returncode == 0 else 'FOUND'}", flush=True)
    if done.returncode:
        print(done.stderr[-4000:], flush=True)
    return done.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="NAME")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    build()
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as scratch:
        names = options.targets or sorted(p.name for p in CORPUS.iterdir())
        sound = [fuzz(name, options.seconds, options.keep or Path(scratch, "kept"), scratch) for name in names]
    sys.exit(not all(sound))


main()
