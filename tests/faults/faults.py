#!/usr/bin/env python3
"""Failures of the environment, injected into a small film: finished files must stay, the message must name the cause, and `whorl resume`
must make the film of an undisturbed run.

    tests/faults/faults.py PROGRAM [--kills 20] [--seed 1] [NAME ...]

Prints a line a fault and the sums "tried, survived, lost"; the exit code is 1 where anything was lost. A full disk needs root (a small
tmpfs); without it those are left out, and said so.
"""
import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from small_film import film, rows  # noqa: E402

SCENE = film(0.3, 4e-3, "64, 36", """[[probe]]
name = "all"
kind = "region"
min = [-1, -1, -1]
max = [1, 1, 1]
""")

JUMPING_CLOCK = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sys/time.h>
#include <time.h>
static long jump(void) {
    static long calls;
    return 86400 * (__atomic_add_fetch(&calls, 1, __ATOMIC_RELAXED) / 20 % 3 - 1);
}
int clock_gettime(clockid_t id, struct timespec* t) {
    static int (*real)(clockid_t, struct timespec*);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    const int result = real(id, t);
    if (id == CLOCK_REALTIME) t->tv_sec += jump();
    return result;
}
int gettimeofday(struct timeval* restrict t, void* restrict zone) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    t->tv_sec = now.tv_sec, t->tv_usec = now.tv_nsec / 1000;
    return 0;
}
time_t time(time_t* to) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return to ? (*to = now.tv_sec) : now.tv_sec;
}
"""


NO_LOCKS = r"""
#include <errno.h>
int flock(int file, int how) {
    (void)file, (void)how;
    errno = ENOLCK;
    return -1;
}
"""


class Lost(Exception):
    pass


class Faults:
    def __init__(self, program, kills, seed, folder):
        self.program, self.kills, self.random, self.folder = str(Path(program).resolve()), kills, random.Random(seed), folder
        self.scene = folder / "film.toml"
        self.scene.write_text(SCENE)
        self.environment = dict(os.environ, OMP_NUM_THREADS="1", XDG_CACHE_HOME=str(folder / "cache"))
        self.tried = self.survived = 0

    def command(self, out, *more):
        return [self.program, "render", self.scene, "--export", "points", "--quiet", "--threads", "1", "--out", out, *more]

    def run(self, *words, **more):
        return subprocess.run([str(w) for w in words], capture_output=True, text=True, env=more.pop("env", self.environment), timeout=600, **more)

    def resume(self, out):
        return self.run(self.program, "resume", out, "--quiet", "--threads", "1")

    def undisturbed(self):
        out = self.folder / "undisturbed"
        if not out.exists():
            began = time.monotonic()
            done = self.run(*self.command(out))
            if done.returncode:
                sys.exit(done.stderr)
            self.seconds = time.monotonic() - began
        return out

    def same(self, out):
        whole = self.undisturbed()
        for name in ("diagnostics.csv", "probes/all.csv"):
            if rows(out / name) != rows(whole / name):
                raise Lost(f"{name} is another")
        for kind in ("points", "frames"):
            names = sorted(p.name for p in (whole / kind).iterdir())
            if sorted(p.name for p in (out / kind).iterdir() if not p.name.startswith(".")) != names:
                raise Lost(f"other files in {kind}")
            for name in names:
                if (out / kind / name).read_bytes() != (whole / kind / name).read_bytes():
                    raise Lost(f"{kind}/{name} is another")
        if not (out / "film.mp4").exists():
            raise Lost("no video")

    def case(self, what, work):
        self.tried += 1
        try:
            work()
            self.survived += 1
            print(f"survived  {what}", flush=True)
        except (Lost, OSError, subprocess.TimeoutExpired) as why:
            print(f"LOST      {what}: {why}", flush=True)

    def said(self, done, code, *words):
        if done.returncode != code or any(w not in done.stderr for w in words):
            raise Lost(f"code {done.returncode}, said: {done.stderr[-500:]}")

    # The faults

    def kill(self):
        """SIGKILL at a random moment, then resume."""
        self.undisturbed()
        for k in range(self.kills):
            moment, out = self.random.uniform(0.02, 1.05 * self.seconds), self.folder / f"killed{k}"

            def work():
                child = subprocess.Popen([str(w) for w in self.command(out)], env=self.environment, stderr=subprocess.PIPE)
                time.sleep(moment)
                child.send_signal(signal.SIGKILL)
                child.communicate()
                done = self.resume(out)
                if done.returncode == 2 and ("not a run folder" in done.stderr or "folder not found" in done.stderr):
                    done = self.run(*self.command(out))  # no output yet: restarted
                self.said(done, 0)
                self.same(out)

            self.case(f"SIGKILL after {moment:.2f} s", work)
            shutil.rmtree(out, ignore_errors=True)

    def two(self):
        """Two programs in one folder: the second is refused, the first continues undisturbed."""
        out = self.folder / "two"

        def work():
            first = subprocess.Popen([str(w) for w in self.command(out)], env=self.environment, stderr=subprocess.DEVNULL)
            while not (out / "run.json").exists() and first.poll() is None:
                time.sleep(0.01)
            first.send_signal(signal.SIGSTOP)  # so that it is at work until the others have been refused
            try:
                for words in (self.command(out), self.command(out, "--overwrite"), [self.program, "resume", out]):
                    self.said(self.run(*words), 2, "another run is at work in this folder")
            finally:
                first.send_signal(signal.SIGCONT)
            if first.wait() != 0:
                raise Lost("the first was disturbed")
            self.same(out)

        self.case("two programs in one folder", work)

    def ffmpeg(self):
        """ffmpeg that dies, or is slow."""
        tools = self.folder / "tools"
        tools.mkdir()
        real = shutil.which("ffmpeg")
        environment = dict(self.environment, PATH=f"{tools}:{self.environment['PATH']}")

        def fake(script):
            (tools / "ffmpeg").write_text("#!/bin/bash\n" + script)
            (tools / "ffmpeg").chmod(0o755)

        def dies():
            out = self.folder / "dies"
            fake('[ "$1" = -version ] && exec %s -version\nhead -c 20000 >/dev/null; echo "encoder fell over" >&2; exit 3\n' % real)
            self.said(self.run(*self.command(out), env=environment), 1, "the video encoder ended early", "encoder fell over")
            self.said(self.resume(out), 0)
            self.same(out)

        def is_slow():
            out = self.folder / "slow"
            fake('[ "$1" = -version ] || sleep 3\nexec %s "$@"\n' % real)
            self.said(self.run(*self.command(out), env=environment), 0)
            self.same(out)

        def dies_at_the_end():
            out = self.folder / "dies_late"
            fake('case "$*" in *faststart*) echo "no room" >&2; exit 1;; esac\nexec %s "$@"\n' % real)
            self.said(self.run(*self.command(out), env=environment), 1, "cannot rewrite the video", "no room")
            self.said(self.resume(out), 0)
            self.same(out)

        self.case("ffmpeg dies", dies)
        self.case("ffmpeg is slow", is_slow)
        self.case("ffmpeg dies as it closes the file", dies_at_the_end)

    def removed(self):
        """The folder is removed while the film is made."""
        out = self.folder / "removed"

        def work():
            child = subprocess.Popen([str(w) for w in self.command(out)], env=self.environment, stderr=subprocess.PIPE, text=True)
            while not (out / "frames/000003.png").exists() and child.poll() is None:
                time.sleep(0.01)
            os.rename(out, self.folder / "taken")
            text = child.communicate(timeout=120)[1]
            if child.returncode != 1 or "was removed or renamed while the run was at work" not in text:
                raise Lost(f"code {child.returncode}, said: {text[-500:]}")
            os.rename(self.folder / "taken", out)
            self.said(self.resume(out), 0)
            self.same(out)

        self.case("the folder is taken away, and put back", work)

    def full(self):
        """A disk that is full at one write or another; then there is room."""
        if os.geteuid() != 0:
            print("left out: a full disk needs root")
            return
        disk = self.folder / "disk"
        disk.mkdir()
        size = sum(f.stat().st_size for f in self.undisturbed().rglob("*") if f.is_file())
        for part in (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9):
            kilobytes = max(8, int(part * size / 1024))

            def work():
                if self.run("mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", disk).returncode:
                    raise Lost("no tmpfs could be mounted")
                try:
                    out = disk / "film"
                    done = self.run(*self.command(out))
                    self.said(done, 1)
                    if not any(w in done.stderr for w in ("No space left", "space", "ended early", "failed")):
                        raise Lost(f"said: {done.stderr[-300:]}")
                    self.run("mount", "-o", "remount,size=64m", disk)
                    done = self.resume(out)
                    if done.returncode == 2 and ("not a run folder" in done.stderr or "folder not found" in done.stderr):
                        done = self.run(*self.command(out))
                    self.said(done, 0)
                    self.same(out)
                finally:
                    self.run("umount", disk)

            self.case(f"a disk with room for {kilobytes} kB of {size // 1024}", work)

    def clock(self):
        """The clock jumps back and forth by a day during the run, and the program is suspended for some seconds."""
        out, jumping = self.folder / "clock", self.folder / "jumping.so"

        def work():
            built = self.run("cc", "-shared", "-fPIC", "-o", jumping, "-x", "c", "-", "-ldl", input=JUMPING_CLOCK)
            if built.returncode:
                raise Lost(f"no clock that jumps could be built: {built.stderr[-300:]}")
            child = subprocess.Popen([str(w) for w in self.command(out)], env=dict(self.environment, LD_PRELOAD=str(jumping)), stderr=subprocess.PIPE, text=True)
            while not (out / "frames/000003.png").exists() and child.poll() is None:
                time.sleep(0.01)
            child.send_signal(signal.SIGSTOP)
            time.sleep(3)
            child.send_signal(signal.SIGCONT)
            text = child.communicate(timeout=120)[1]
            if child.returncode != 0:
                raise Lost(f"code {child.returncode}, said: {text[-500:]}")
            self.same(out)

        self.case("a clock that jumps", work)

    def locks(self):
        """A disk without locks, as on clusters: reported, and the film is made."""
        out, none = self.folder / "unlocked", self.folder / "no_locks.so"

        def work():
            built = self.run("cc", "-shared", "-fPIC", "-o", none, "-x", "c", "-", input=NO_LOCKS)
            if built.returncode:
                raise Lost(f"nothing without locks could be built: {built.stderr[-300:]}")
            self.said(self.run(*self.command(out), env=dict(self.environment, LD_PRELOAD=str(none))), 0, "has no locks (No locks available)")
            self.same(out)

        self.case("a disk without locks", work)

    def nan(self):
        """Expressions that become NaN at some time: reported, and finished frames are kept."""
        narrow = "abs(t-0.15037)<0.0002 ? sqrt(-1) : "
        for name, settings, codes in (
                ("a nozzle's speed", ["emitter[0].speed=t>0.1 ? sqrt(-1) : 0.3"], (2,)),
                ("a nozzle's speed for a moment", [f"emitter[0].speed={narrow}0.3"], (0, 1)),
                ("a force", ["fluid.force=['t>0.1 ? sqrt(-1) : 0', '0', '0']"], (2,)),
                ("gravity for a moment", [f"domain.gravity=['{narrow}0', '-9.81', '0']"], (0, 1)),
                ("a viscosity that ages", ["fluid.viscosity=age>0.1 ? 0/0 : 50"], (1, 2)),
                ("a solid's way", ["solid[0]={shape=\"sphere\", radius=0.01, position=['0', '0.01', 't>0.1 ? sqrt(-1) : 0.03']}"], (2,))):
            out = self.folder / "nan"
            shutil.rmtree(out, ignore_errors=True)

            def work():
                done = self.run(*self.command(out, "--no-images", *[w for s in settings for w in ("--set", s)]))
                if done.returncode not in codes:
                    raise Lost(f"code {done.returncode}, said: {done.stderr[-400:]}")
                if done.returncode == 1 and not ("diverged at" in done.stderr and "stage" in done.stderr or "finite" in done.stderr):
                    raise Lost(f"said: {done.stderr[-400:]}")
                if done.returncode != 2 and "nan" in (out / "diagnostics.csv").read_text():
                    raise Lost("nan in the diagnostics")

            self.case(f"{name} is not a number", work)

    def memory(self):
        """Less memory than the scene needs: refused before anything is written."""
        out = self.folder / "memory"

        def work():
            limit = 3 << 30
            done = self.run("prlimit", f"--as={limit}", *self.command(out, "--no-images", "--set", "fluid.spacing=2e-4"))
            self.said(done, 2, "of memory, and", "are free")
            if out.exists():
                raise Lost("a folder was made")

        self.case("3 GiB of memory for a scene that needs more", work)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("faults", nargs="*")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_intermixed_args()
    with tempfile.TemporaryDirectory() as folder:
        faults = Faults(options.program, options.kills, options.seed, Path(folder))
        for name in options.faults or ("two", "ffmpeg", "removed", "full", "clock", "locks", "nan", "memory", "kill"):
            getattr(faults, name)()
        print(f"tried {faults.tried}, survived {faults.survived}, lost {faults.tried - faults.survived}")
        sys.exit(faults.tried != faults.survived)


main()
