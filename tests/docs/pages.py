"""Checks the user's pages (README.md and docs/guide) with the program: their scenes, commands, keys, links and images.

    python3 tests/docs/pages.py build/release/whorl

A ```toml block whose first line is a comment with a file's name (`# my_honey.toml`) is a whole scene: it must be accepted unchanged. Any other ```toml
block is a part of a scene: it must be accepted at the end of a small one. A block that begins with another file's name (`# wedge.obj`) is that file.
Of each command line every option must exist, and a scene that it names must be accepted with the options given, a shipped one at its coarsest unless
the line says otherwise. Without an option that changes it, a shipped scene must only exist (tests/tools/camera_warnings.cpp plans all of them at every
quality).
"""
import json
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs/guide").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
WITH_A_SCENE = ("render", "plan", "live")
BASE = """
[time]
end = 1.0
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.1, 0.1, 0.1]
[fluid]
spacing = 7e-3
[[emitter]]
position = [0, 0.05, 0]
radius = 0.02
speed = 0.2
"""
OF_A_DRY_RUN = ("--set", "--with", "--until", "--frames", "--size", "--fps", "--quality", "--export", "--threads", "--seed")


class Checker:
    def __init__(self, whorl):
        self.whorl, self.faults, self.checked = Path(whorl).resolve(), [], 0
        self.schema = json.loads(self.run(ROOT, "schema").stdout)
        self.options, self.outcomes = {}, {}

    def run(self, folder, *words):
        return subprocess.run([self.whorl, *words], cwd=folder, capture_output=True, text=True)

    def expect(self, page, what, holds, why=""):
        self.checked += 1
        if not holds:
            self.faults.append(f"{page.relative_to(ROOT)}: {what}: {why}".rstrip(": "))

    def accepted(self, page, what, folder, *words):
        if (folder, words) not in self.outcomes:  # pages repeat themselves
            self.outcomes[folder, words] = self.run(folder, "render", *words, "--dry-run")
        outcome = self.outcomes[folder, words]
        self.expect(page, what, outcome.returncode == 0, outcome.stderr)

    def page(self, page):
        text = page.read_text()
        with tempfile.TemporaryDirectory() as folder:
            parts = self.files(page, text, Path(folder))
            for name in sorted(Path(folder).glob("*.toml")):
                if "[time]" in name.read_text():
                    self.accepted(page, name.name, folder, name.name)
            for n, part in enumerate(parts):
                (Path(folder) / f"part_{n}.toml").write_text(BASE + part)
                self.accepted(page, f"the part that begins with {part.splitlines()[0]}", folder, f"part_{n}.toml")
            for line in self.commands(text):
                self.command(page, line, folder)
        self.links(page, text)
        self.keys(page, text)
        for path in re.findall(r"`?((?:tools|scenes)/[\w/]+\.\w+)", text):
            self.expect(page, path, (ROOT / path).exists(), "no such file")

    @staticmethod
    def files(page, text, folder):
        """Writes the files that the page prints; returns the parts of scenes."""
        parts = []
        for language, body in BLOCK.findall(text):
            name = re.match(r"# ([\w.]+\.\w+)\n", body)
            if name:
                (folder / name[1]).write_text(body)
            elif language == "toml":
                parts.append(body)
        return parts

    @staticmethod
    def commands(text):
        for line in re.findall(r"^(?:    |`)?(?:build/release/)?(whorl .*)$|`(?:build/release/)?(whorl [^`]+)`", text, re.M):
            yield (line[0] or line[1]).split("  #")[0]

    def command(self, page, line, folder):
        words = shlex.split(line.split(" > ")[0].split(" && ")[0].strip("`"), comments=True)[1:]
        if not words or words[0].isupper():
            return
        subcommand = words[0]
        if subcommand not in self.options:
            outcome = self.run(ROOT, subcommand, "--help")
            self.options[subcommand] = set(re.findall(r"--[\w-]+", outcome.stdout)) if outcome.returncode == 0 else None
        known = self.options[subcommand]
        self.expect(page, line, known is not None or subcommand.startswith("--"), f"no subcommand {subcommand}")
        if known is None:
            return
        for word in words:
            if word.startswith("--"):
                self.expect(page, line, word.split("=")[0] in known, f"no option {word}")
        names = [w for w in words[1:] if not w.startswith("-")]
        if subcommand in ("tradeoff", "stability") and names:
            self.expect(page, line, any((ROOT / "scenes/studies").rglob(names[0] + ".toml")) or names[0].startswith("my_"), "no such study")
        if subcommand in WITH_A_SCENE and names and not names[0].isupper():
            self.scene(page, line, words[1:], folder)

    def scene(self, page, line, words, folder):
        scene, rest = words[0], words[1:]
        if "recording.toml" in scene or scene.startswith("SCENE") or f"whorl_export.py -- {scene}" in page.read_text():
            return
        dry = [scene]
        if not (Path(folder) / scene).exists() and "--quality" not in rest:
            dry += ["--quality", "draft"]
        for option, value in zip(rest, rest[1:] + [""]):
            if option == "--with" and not (Path(folder) / value).exists():
                continue  # what another command of the page writes
            if option in OF_A_DRY_RUN:
                dry += [option, value]
        local = any((Path(folder) / word).exists() for word in dry)
        if not local and not set(dry) & set(OF_A_DRY_RUN) - {"--quality", "--threads"}:
            self.expect(page, line, any((ROOT / "scenes").rglob(f"{scene}.toml")), f"no scene {scene}")
            return
        self.accepted(page, line, folder if local else ROOT, *dry)

    def links(self, page, text):
        for link in re.findall(r"\]\(([^)#\s]+)", text):
            if "://" not in link:
                self.expect(page, link, (page.parent / link).exists(), "no such file")

    def keys(self, page, text):
        for path in re.findall(r"`([a-z_]+(?:\[\d+\])?(?:\.[a-z_]+(?:\[\d+\])?)+)(?: = [^`]*)?`", text):
            section, *rest = re.sub(r"\[\d+\]", "", path).split(".")
            if section in self.schema["properties"] and rest[-1] not in ("csv", "json", "png", "toml"):
                self.expect(page, path, self.known(self.schema["properties"][section], rest), "no such key")

    def known(self, schema, names):
        if "$ref" in schema:
            schema = self.schema["$defs"][schema["$ref"].split("/")[-1]]
        if schema.get("type") == "array" and names:
            schema = schema["items"]
        if not names:
            return True
        found = schema.get("properties", {}).get(names[0])
        return found is not None and self.known(found, names[1:])


def main():
    checker = Checker(sys.argv[1])
    for page in PAGES:
        checker.page(page)
    print("\n".join(checker.faults) or f"{checker.checked} things hold on {len(PAGES)} pages")
    return 1 if checker.faults else 0


if __name__ == "__main__":
    sys.exit(main())
