#!/usr/bin/env python3
"""The Debian package as a user meets it: lintian finds no error, and on a machine that has nothing but Debian's base it installs, and films.

    tests/package/package.py [--deb FILE]

Without --deb it builds the package (preset portable). The clean machine is a folder that mmdebstrap fills from the mirrors of this machine's apt. Needs
root; without it, or without the programs, the exit code is 77.
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

FILM = """set -e
whorl --version
cd /tmp
whorl render honey_coil --quality draft
test -s out/honey_coil/honey_coil.mp4
test -s /usr/share/man/man1/whorl.1.gz -a -s /usr/share/bash-completion/completions/whorl -a -s /usr/share/whorl/whorl_import.py -a -s /usr/share/whorl/whorl_export.py
"""


def run(*words, **more):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, **more)
    if done.returncode:
        sys.exit(f"{' '.join(str(w) for w in words)[:200]}: code {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def links(folder):
    """Number of links between the pages, and to images and scenes. Exits at a dead link."""
    found = [(page, link) for page in folder.rglob("*.md") for link in re.findall(r"\]\(([^)#:\s]+)[^):\s]*\)", page.read_text())]
    dead = [f"{page.relative_to(folder)}: {link}" for page, link in found if not (page.parent / link).exists()]
    if dead or not found:
        sys.exit("dead links in the package:\n" + "\n".join(dead))
    return len(found)


def build():
    folder = ROOT / "build" / "portable"
    run("cmake", "--preset", "portable", "-DWHORL_TESTS=OFF", "-DWHORL_BENCHMARKS=OFF", cwd=ROOT)
    for old in folder.glob("whorl_*.deb"):
        old.unlink()
    run("cmake", "--build", folder, "--target", "package", cwd=ROOT)
    return next(folder.glob("whorl_*.deb"))


def suite():
    """Debian's name of this release."""
    lines = dict(line.split("=", 1) for line in Path("/etc/os-release").read_text().splitlines() if "=" in line)
    return lines["VERSION_CODENAME"].strip('"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deb", type=Path)
    options = parser.parse_args()
    missing = [name for name in ("lintian", "mmdebstrap") if not shutil.which(name)]
    if missing or os.geteuid() != 0:
        print(f"skipped: apt-get install {' '.join(missing)}" if missing else "skipped: a clean root needs root")
        sys.exit(77)
    package = (options.deb or build()).resolve()
    print(run("lintian", "--allow-root", "--fail-on", "error", package).strip() or "lintian has nothing to say", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        machine = Path(folder) / "machine"
        run("mmdebstrap", "--variant=apt", "--aptopt=Apt::Install-Recommends false", f"--customize-hook=copy-in {package} /tmp",
            f'--customize-hook=chroot "$1" apt-get install -y /tmp/{package.name}', suite(), machine)
        # With /proc, as on any machine: the program finds its scenes by where it lies. The mount goes with the process.
        inside = 'mount -t proc proc "$0/proc" && exec chroot "$0" sh -c "$1"'
        print(links(machine / "usr/share/doc/whorl"), "links of the documentation hold")
        print(run("unshare", "--mount", "sh", "-c", inside, machine, FILM, env={"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": "/root", "LANG": "C.UTF-8"}), end="")
    print("the package installs and films")


main()
