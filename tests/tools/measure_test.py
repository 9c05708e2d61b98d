"""Tests of tools/measure.py: what it writes and what it refuses. Nothing is simulated."""
import contextlib
import io
import json
import math
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import numpy as np
from measure import command, drawing, registry, runs, theory

page = "# Page\r\n\nbefore\n<!-- begin a -->\nold\n\nolder\n<!-- end a -->\nafter\n  <!-- begin b -->\n  <!-- end b -->\nno newline"


class Sections(unittest.TestCase):
    def test_only_what_stands_between_the_markers_changes(self):
        new = registry.replace_section(page, "a", "| 1 |\n| 2 |")
        self.assertEqual(new, page.replace("old\n\nolder\n", "| 1 |\n| 2 |\n"))
        self.assertEqual(registry.replace_section(new, "a", "| 1 |\n| 2 |\n"), new)

    def test_a_section_is_indented_as_its_marker(self):
        self.assertEqual(registry.replace_section(page, "b", "one\n\ntwo"),
                         page.replace("  <!-- end b -->", "  one\n\n  two\n  <!-- end b -->"))

    def test_a_page_without_both_markers_once_and_in_order_is_refused(self):
        for text in ("", page.replace("<!-- end a -->", ""), page + "\n<!-- begin a -->", "<!-- end a -->\n<!-- begin a -->\n",
                     page.replace("begin a", "begin c")):
            with self.assertRaises(registry.MeasureError):
                registry.replace_section(text, "a", "new")

    def test_a_refused_page_stays_as_it_is_and_nothing_is_measured(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "README.md"
            for text in ("no markers\n", "<!-- begin a -->\n"):
                file.write_text(text)
                with self.assertRaises(registry.MeasureError):
                    command.measure(registry.Table("a", "", "", self.fail), runs.Measurement(into=folder))
                self.assertEqual([f.name for f in Path(folder).iterdir()], ["README.md"])
                self.assertEqual(file.read_text(), text)

    def test_a_page_is_written_byte_for_byte_but_for_its_section(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "docs/reports/page.md"
            registry.write_file(file, page.encode())
            m = runs.Measurement(into=folder, say=lambda text: None)
            command.measure(registry.Table("a", "", "", lambda m: "new"), m)
            self.assertEqual(file.read_bytes(), page.replace("old\n\nolder\n", "new\n").encode())

    def test_a_part_of_a_table_and_a_try_are_shown_and_not_written(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "README.md"
            for keys in ({"only": ["row"]}, {"settings": ["a=1"]}, {"writes": False}):
                registry.write_file(file, page.encode())
                m = runs.Measurement(into=folder, say=lambda text: None, **keys)
                with contextlib.redirect_stdout(io.StringIO()) as shown:
                    command.measure(registry.Table("a", "", "", lambda m: "part"), m)
                self.assertEqual((shown.getvalue(), file.read_bytes()), ("part\n", page.encode()))

    def test_cells_cannot_break_a_table(self):
        self.assertEqual(registry.markdown("a | b | c", [[1, "x|y\nz"], ["", "2"]]),
                         "| a | b | c |\n|---|---|---|\n| 1 | x/y z | |\n| | 2 | |")


class Results(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        self.addCleanup(self.scratch.cleanup)

    def report(self, folder, cpu):
        folder.mkdir(parents=True)
        (folder / "run.json").write_text(json.dumps({"cpu_seconds": cpu, "particle_steps": 1e6, "predicted_wall_seconds": None,
                                                     "iterations_per_step": {"pressure": 3, "viscosity": 0.5},
                                                     "stages": {"draw": {"cpu_seconds": 1}, "move": {"cpu_seconds": 2}}}))

    def test_run_json_of_a_run_and_of_panels(self):
        self.report(self.folder / "one", 4)
        one = runs.Run(self.folder / "one")
        self.assertEqual((one.cpu_seconds, one.drawing_seconds, one.microseconds, one.iterations_per_step), (4, 1, 4, 3.5))
        for panel in (1, 2):
            self.report(self.folder / f"two/panels/{panel}", 4)
        self.assertEqual((runs.Run(self.folder / "two").cpu_seconds, runs.Run(self.folder / "two").drawing_seconds), (8, 2))

    def test_csv_with_missing_values(self):
        self.report(self.folder / "run", 1)
        (self.folder / "run/t.csv").write_text('time,frequency,"words, quoted"\n0,,1\n0.5,2.5,\n')
        table = runs.Run(self.folder / "run").table("t.csv")
        self.assertEqual(list(table), ["time", "frequency", "words, quoted"])
        self.assertTrue(math.isnan(table["frequency"][0]) and math.isnan(table["words, quoted"][1]))
        self.assertEqual(runs.Run(self.folder / "run").last("t.csv")["frequency"], 2.5)
        self.assertTrue(math.isnan(runs.number("")) and math.isnan(runs.number(None)))

    def program(self, text):
        file = self.folder / "whorl"
        file.write_text("#!/bin/sh\n" + text)
        file.chmod(0o755)
        m = runs.Measurement(file, say=lambda text: None)
        m.out = self.folder / "out"
        return m

    def test_a_result_is_used_again_for_the_same_command_and_scene_alone(self):
        m = self.program(f'echo run >> {self.folder}/count\nfor k; do [ "$last" = --out ] && folder=$k; last=$k; done\n'
                         'mkdir -p "$folder" && echo {} > "$folder/run.json"\n')
        scene = m.toml_file("scene", {"a": 1})
        for settings in (["a=1"], ["a=1"], ["a=2"]):
            m.render(scene, "run", *settings)
        self.assertEqual((self.folder / "count").read_text(), "run\n" * 2)
        m.toml_file("scene", {"a": 1})
        m.render(scene, "run", "a=2")
        self.assertEqual((self.folder / "count").read_text(), "run\n" * 2)
        m.toml_file("scene", {"a": 2})
        os.utime(scene, (2e9, 2e9))
        m.render(scene, "run", "a=2")
        self.assertEqual((self.folder / "count").read_text(), "run\n" * 3)
        os.utime(scene, (1e9, 1e9))
        m.again = True
        m.render(scene, "run", "a=2")
        self.assertEqual((self.folder / "count").read_text(), "run\n" * 4)

    def test_a_failed_run_is_a_row_with_its_reason_and_is_not_kept(self):
        m = self.program("echo 'whorl: no such scene' >&2; exit 2\n")
        self.assertEqual(runs.attempt(lambda: [m.render("scene", "run").microseconds]), ["failed (2): no such scene"])
        self.assertTrue((self.folder / "out/run.log").read_text().startswith("failed: "))

    def test_toml_reads_back(self):
        keys = {"name": 'a "b"', "time": {"end": 0.5, "slow": True}, "solid": [{"min": [0, -1.5, 2]}, {"kind": "box"}],
                "quality": {"draft": {"fluid.spacing": 1e-3}}}
        self.assertEqual(runs.tomllib.loads(runs.toml(keys)), keys)
        for scene in (runs.root / "scenes").glob("*.toml"):
            keys = runs.read_scene(scene)
            self.assertEqual(runs.tomllib.loads(runs.toml(keys)), keys)


class Numerics(unittest.TestCase):
    def test_frequency_of_a_noisy_swing(self):
        t = np.linspace(0, 3, 400)
        self.assertAlmostEqual(theory.frequency(t, 5 + np.sin(2 * np.pi * 2.14 * t) + 0.05 * np.cos(300 * t)), 2.14, delta=0.02)
        self.assertEqual(theory.frequency(t, t), 0)

    def test_zeros_between_samples(self):
        self.assertEqual(theory.zeros([0, 1, 2, 3], [1, -1, -1, 3], 0), [0.5, 2.25])
        self.assertEqual(theory.zeros([0, 1, 2, 3], [1, -1, -1, 3], 2), [0.5])

    def test_a_falling_thread_keeps_its_momentum(self):
        nu, U = 0.05, 0.1
        z, u = theory.falling_thread_speed(nu, U, 0.25)
        stretch = np.gradient(np.log(u), z)
        self.assertAlmostEqual(u[0], U, delta=1e-6)
        self.assertAlmostEqual(stretch[-1], 0, delta=0.05)  # no tension where fluid is removed
        weight = theory.gravity * np.trapz(1 / u, z)
        self.assertAlmostEqual((u[-1] - u[0] + 3 * nu * stretch[0]) / weight, 1, delta=1e-3)

    def test_the_longest_link_is_the_gap(self):
        points = np.array([[k * 1.0, 0, 0] for k in (0, 1, 2, 3, 5.5, 6.5)])
        self.assertEqual(theory.longest_link(points[[3, 0, 5, 2, 4, 1]]), 2.5)


class Names(unittest.TestCase):
    def reported(self, *arguments):
        with contextlib.redirect_stderr(io.StringIO()) as reported, contextlib.redirect_stdout(io.StringIO()) as shown:
            code = command.main(arguments)
        return code, reported.getvalue() + shown.getvalue()

    def test_an_unknown_name_is_told_with_the_nearest_valid_one(self):
        code, reported = self.reported("coils", "sewing_machin")
        self.assertEqual((code, reported), (2, 'measure.py: no table "sewing_machin"; did you mean "sewing_machine"? (--list shows all)\n'))

    def test_the_list_has_every_name(self):
        code, reported = self.reported("--list")
        self.assertEqual((code, len(reported.splitlines())), (0, len(registry.tables)))

    def test_the_pages_name_tables_that_there_are(self):
        for file in (runs.root / "README.md", *runs.root.glob("docs/**/*.md")):
            text = file.read_text(encoding="utf-8")
            for name in re.findall(r"<!-- begin (\w+) -->", text):
                self.assertTrue(registry.tables[name].section, name)
                registry.replace_section(text, name, "")
            for pattern in re.findall(r"tools/measure\.py '?(\w[\w*]*)", text):
                self.assertTrue(registry.find(pattern))

    def test_every_name_can_be_made_as_far_as_its_commands_go(self):
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "docs/guide/page.md"
            registry.write_file(page, b"![](../pictures/guide/a.jpg)\n```toml\n# a.toml\n[time]\n```\n")
            for name in registry.tables:
                with self.subTest(name), np.errstate(all="ignore"):
                    code, reported = self.reported(name, "--dry-run", "--into", folder, "--program", "whorl")
                    self.assertEqual(code, 0)
                    self.assertGreater(len(reported.splitlines()), 1, reported)
            self.assertEqual([file for file in Path(folder).rglob("*") if file.is_file()], [page])


class Drawing(unittest.TestCase):
    def test_a_drawing_is_the_same_bytes_each_time(self):
        def draw(axes):
            axes.plot([0, 1], [0, 1], label="a")
            axes.legend()

        first, second = drawing.figure(4, 3, draw), drawing.figure(4, 3, draw)
        self.assertEqual(first, second)
        self.assertTrue(first.startswith(b"<?xml") and b"<svg" in first)


if __name__ == "__main__":
    unittest.main()
