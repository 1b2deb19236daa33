"""alder bench: table, ratios, plot, variants, and Cycles where there is bpy; shell completion and the manual page."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ALDER = str(pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve() / "alder")
SCENE = str(ROOT / "docs" / "examples" / "triangle.glb")


def alder(*arguments, **environment):
    return subprocess.run([ALDER, *arguments], capture_output=True, text=True, timeout=250, env={**os.environ, **environment})


class Bench(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_error_falls_with_samples(self):
        svg = self.folder / "plot.svg"
        run = alder("bench", SCENE, "--samples", "4,16,64", "--resolution", "48x27", "--variant", "other seed: --seed 7", "--svg", str(svg), "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        series = json.loads(run.stdout)["series"]
        self.assertEqual([s["name"] for s in series], ["alder", "other seed"])
        for s in series:
            errors = [m["relmse_trimmed"] for m in s["measures"]]
            self.assertGreater(errors[0], 3 * errors[2], errors)   # 16 times the samples
            self.assertTrue(all(m["seconds"] > 0 for m in s["measures"]))
        self.assertNotEqual(series[0]["measures"][0]["relmse"], series[1]["measures"][0]["relmse"])
        plot = xml.etree.ElementTree.parse(svg).getroot()
        tag = "{http://www.w3.org/2000/svg}"
        self.assertEqual((len(plot.findall(tag + "polyline")), len(plot.findall(tag + "circle"))), (2, 6))

    def test_table(self):
        run = alder("bench", SCENE, "--samples", "2,4", "--resolution", "16x9", "--variant", "same: --seed 0")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("efficiency", run.stdout)
        self.assertIn("x as fast as same", run.stdout)

    def test_wrong_requests(self):
        for arguments in (["/nowhere.glb"], [SCENE, "--variant", "nameless"], [SCENE, "--variant", "x: --nonsense"], [SCENE, "--samples", "0"],
                          [SCENE, "--reference", "/nowhere.exr"], [SCENE, "--variant", 'x: "--seed']):
            run = alder("bench", *arguments, *(["--resolution", "8x8", "--reference-factor", "1"]))
            self.assertEqual(run.returncode, 2, "%s: %s" % (arguments, run.stderr))
            self.assertIn("alder: ", run.stderr)

    def test_cycles_beside_it(self):
        python = os.environ.get("ALDER_BPY_PYTHON")
        if not python:
            self.skipTest("no bpy: set ALDER_BPY_PYTHON to a Python that has it")
        blend = str(self.folder / "cube.blend")
        code = ("import bpy, sys, os; sys.path.insert(0, %r); from alder_blender import engine; s = bpy.context.scene; s.render.engine = 'CYCLES'; s.cycles.samples = 8\n"
                "bpy.ops.wm.save_as_mainfile(filepath=%r); engine.export(%r); sys.stdout.flush(); os._exit(0)") % (str(ROOT / "clients" / "blender"), blend, blend + ".alder")
        subprocess.run([python, "-c", code], check=True, capture_output=True, timeout=120)
        run = alder("bench", blend + ".alder", "--cycles", blend, "--samples", "8,32", "--resolution", "48x27", "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        series = {s["kind"]: s for s in json.loads(run.stdout)["series"]}
        errors = [m["relmse_trimmed"] for m in series["cycles"]["measures"]]
        self.assertLess(errors[1], errors[0])   # Cycles converges to Alder's picture

    def test_a_side_that_is_not_there_is_told(self):
        run = alder("bench", SCENE, "--mitsuba", "/nowhere.xml", "--samples", "1", "--resolution", "8x8", ALDER_MITSUBA_PYTHON="/nowhere/python")
        self.assertEqual(run.returncode, 3)
        self.assertIn("ALDER_MITSUBA_PYTHON", run.stderr)


    def test_the_documentation(self):
        import re
        shutil.copy(SCENE, self.folder / "shot.glb")
        script = "\n".join(re.findall(r"^```sh\n(.*?)^```", (ROOT / "docs" / "bench.md").read_text(), re.M | re.S))
        run = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=self.folder, capture_output=True, text=True, timeout=250,
                             env={**os.environ, "PATH": "%s:%s" % (os.path.dirname(ALDER), os.environ["PATH"])})
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue((self.folder / "plot.svg").read_text().startswith("<svg"))


class Completion(unittest.TestCase):
    def test_bash(self):
        script = alder("completion", "bash").stdout
        def complete(*words):
            text = script + '\nCOMP_WORDS=(%s); COMP_CWORD=%d; _alder; echo "${COMPREPLY[@]}"' % (" ".join("'%s'" % w for w in words), len(words) - 1)
            run = subprocess.run(["bash", "-c", text], capture_output=True, text=True)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            return run.stdout.split()
        self.assertEqual(complete("alder", "ren"), ["render"])
        self.assertEqual(complete("alder", "render", "--sample-o"), ["--sample-offset"])
        self.assertIn("--limit", complete("alder", "diff", "--"))

    def test_the_others_know_every_command(self):
        commands = [c for c in ("render", "preview", "merge", "diff", "ci", "bench", "validate", "eval", "graph", "nodes")]
        for kind in ("zsh", "fish", "man"):
            text = alder("completion", kind).stdout
            for command in commands:
                self.assertIn(command, text, kind)
        if shutil.which("fish"):
            subprocess.run(["fish", "-n"], input=alder("completion", "fish").stdout, text=True, check=True)
        man = alder("completion", "man").stdout
        self.assertTrue(man.startswith(".TH ALDER 1"))
        self.assertIn("\\-\\-sample\\-offset", man)
        if shutil.which("man") and shutil.which("groff"):
            run = subprocess.run(["groff", "-man", "-Tascii", "-ww"], input=man, capture_output=True, text=True)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(alder("completion", "tcsh").returncode, 2)


if __name__ == "__main__":
    unittest.main()
