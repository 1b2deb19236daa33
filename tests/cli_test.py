"""alder and alderd as programs: options, outputs, exit statuses, signals, and what a user reads on stderr."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
ALDER = str(BUILD / "alder")
SCENE = str(ROOT / "docs/examples/triangle.glb")
sys.path.insert(0, str(ROOT / "docs" / "examples"))
from daemon import Daemon  # noqa: E402

REMAP = {"graph": {"version": 1, "nodes": {"r": {"type": "alRemapFloat", "params": {"input": {"attribute": "x"}, "RMPcontrast": 2}}}, "outputs": {}},
         "points": {"count": 3, "attributes": {"x": [0.25, 0.5, 0.75]}}, "outputs": ["r"]}
SURFACE = {"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.2, 0.1]}}}, "outputs": {"surface": {"node": "s"}}}


def alder(*arguments, stdin=None, cwd=None):
    return subprocess.run([ALDER, *arguments], input=stdin, capture_output=True, text=True, timeout=250, cwd=cwd)


class Eval(unittest.TestCase):
    def test_one_request_on_every_instruction_set(self):
        for option in ([], ["--isa=scalar"], ["--isa=sse4"], ["--precision=double"], ["--threads=1", "--repeat=3"]):
            run = alder("eval", "-", "--stats", *option, stdin=json.dumps(REMAP))
            self.assertEqual(run.returncode, 0, run.stderr)
            answer = json.loads(run.stdout)
            for got, want in zip(answer["outputs"]["r"], (0.0, 0.5, 1.0)):
                self.assertAlmostEqual(got, want, 6, str(option))
            self.assertEqual(answer["stats"]["points"], 3)

    def test_an_array_keeps_its_order_and_its_wrong_requests(self):
        wrong = json.loads(json.dumps(REMAP))
        wrong["graph"]["nodes"]["r"]["params"]["RMPgian"] = 1
        run = alder("eval", stdin=json.dumps([REMAP, wrong, 7, REMAP]))
        self.assertEqual(run.returncode, 0, run.stderr)
        answers = json.loads(run.stdout)
        self.assertEqual(len(answers), 4)
        self.assertEqual(answers[0], answers[3])
        self.assertEqual(answers[1]["error"]["errors"][0]["suggest"], "RMPgain")
        self.assertIn("error", answers[2])

    def test_faults_are_one_line_each_and_status_2(self):
        wrong = json.loads(json.dumps(REMAP))
        wrong["graph"]["nodes"]["r"]["params"] = {"RMPgian": 1, "RMPbais": 1}
        run = alder("eval", stdin=json.dumps(wrong))
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        lines = run.stderr.splitlines()
        self.assertEqual(len(lines), 2)
        self.assertIn("/graph/nodes/r/params/RMP", lines[0])
        self.assertIn("did you mean", lines[0])
        wrong["lenient"] = True
        self.assertEqual(alder("eval", stdin=json.dumps(wrong)).returncode, 0)
        for bad in ("{", "", '{"a": 1, "a": 2}', "[1", '{"points": NaN}'):
            run = alder("eval", stdin=bad)
            self.assertEqual(run.returncode, 2, bad)
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)

    def test_options_are_checked(self):
        for arguments in (["eval", "--isa=mmx"], ["eval", "--repeat=0"], ["eval", "/nowhere.json"], ["nonsense"], [], ["eval", "--nonsense"]):
            run = alder(*arguments, stdin="")
            self.assertEqual(run.returncode, 2, arguments)
            self.assertTrue(run.stderr.startswith("alder: "), run.stderr)
        self.assertEqual(alder("--help").returncode, 0)
        self.assertIn("--isa", alder("eval", "--help").stdout)


class Catalogue(unittest.TestCase):
    def test_nodes(self):
        listing = alder("nodes").stdout
        self.assertIn("alSurface", listing)
        items = json.loads(alder("nodes", "--json").stdout)["items"]
        self.assertEqual(len(items), len(listing.splitlines()))
        self.assertIn("specular1Roughness", alder("nodes", "alSurface").stdout)
        run = alder("nodes", "alSurfac")
        self.assertEqual(run.returncode, 2)
        self.assertIn("alSurface", run.stderr)

    def test_validate(self):
        with tempfile.TemporaryDirectory() as folder:
            good, bad = os.path.join(folder, "good.json"), os.path.join(folder, "bad.json")
            pathlib.Path(good).write_text(json.dumps(SURFACE))
            pathlib.Path(bad).write_text(json.dumps(SURFACE).replace("diffuseColor", "difuseColor"))
            run = alder("validate", good)
            self.assertEqual(run.returncode, 0, run.stderr)
            run = alder("validate", good, bad)
            self.assertEqual(run.returncode, 1)
            self.assertIn("diffuseColor", run.stderr)
            report = json.loads(alder("validate", "--json", good, bad).stdout)
            self.assertEqual((report[good]["ok"], report[bad]["ok"]), (True, False))


class Render(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def render(self, out, *arguments, status=0):
        run = alder("render", SCENE, "-o", self.path(out), "--resolution", "48x27", *arguments)
        self.assertEqual(run.returncode, status, run.stderr)
        return run

    def bytes(self, name):
        return pathlib.Path(self.path(name)).read_bytes()

    def test_same_seed_same_bytes_for_any_thread_count(self):
        for name, threads in (("one.exr", "1"), ("two.exr", "2"), ("seven.exr", "7")):
            self.render(name, "--samples", "4", "--threads", threads, "--aov", "shading", "--aov", "data")
        self.assertEqual(self.bytes("one.exr"), self.bytes("two.exr"))
        self.assertEqual(self.bytes("one.exr"), self.bytes("seven.exr"))
        self.render("other.exr", "--samples", "4", "--seed", "9", "--aov", "shading", "--aov", "data")
        self.assertNotEqual(self.bytes("one.exr"), self.bytes("other.exr"))

    def test_statistics(self):
        self.render("a.exr", "--samples", "2", "--stats", self.path("stats.json"))
        stats = json.loads(self.bytes("stats.json"))
        self.assertEqual(stats["samples"], 2)
        self.assertTrue(stats["complete"])
        self.assertGreaterEqual(stats["rays"]["camera"], 48 * 27 * 2)
        self.assertGreater(stats["peak_memory_bytes"], 1 << 20)
        self.assertEqual(sorted(stats["seconds"]), ["build", "compile", "load", "render", "write"])

    def test_set_changes_one_constant(self):
        self.render("a.exr", "--samples", "2")
        material = "sail"
        run = alder("render", SCENE, "-o", self.path("x.exr"), "--set", "sial/x.y=1")
        self.assertEqual(run.returncode, 2)
        self.assertIn("did you mean 'sail'", run.stderr)
        run = alder("render", SCENE, "-o", self.path("x.exr"), "--set", material + "/nothing.y=1")
        self.assertEqual(run.returncode, 2)
        self.assertIn("no such node", run.stderr)
        node = run.stderr.split("did you mean '")[1].split("'")[0] if "did you mean" in run.stderr else "Principled BSDF"
        self.render("b.exr", "--samples", "2", "--set", material + "/" + node + ".Base Color=[0, 0, 1]")
        self.assertNotEqual(self.bytes("a.exr"), self.bytes("b.exr"))
        run = alder("render", SCENE, "-o", self.path("x.exr"), "--set", material + "/" + node + ".Bas Color=1")
        self.assertEqual(run.returncode, 2)
        self.assertIn("Base Color", run.stderr)

    def test_wrong_requests(self):
        for arguments in (["/nowhere.glb"], [SCENE, "--crop", "0,0,99999,5"], [SCENE, "--crop", "5,5,2,2"], [SCENE, "--resolution", "0x5"], [SCENE, "--resolution", "5"],
                          [SCENE, "-o", self.path("a.bmp")], [SCENE, "--samples", "0"], [str(ROOT / "README.md")]):
            run = alder("render", *arguments, cwd=self.folder.name)
            self.assertEqual(run.returncode, 2, "%s: %s" % (arguments, run.stderr))
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        run = alder("render", SCENE, "--samples", "1", "--resolution", "8x8", "-o", "/nowhere/a.exr")
        self.assertEqual(run.returncode, 3, run.stderr)

    def test_interruption_keeps_what_is_there(self):
        process = subprocess.Popen([ALDER, "render", SCENE, "-o", self.path("part.exr"), "--resolution", "640x360", "--samples", "1000000", "--stats", self.path("stats.json")],
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertIn("incomplete", stderr)
        self.assertFalse(json.loads(self.bytes("stats.json"))["complete"])
        self.assertTrue(self.bytes("part.exr").startswith(b"\x76\x2f\x31\x01"))
        self.assertIn(b"alder/complete", self.bytes("part.exr"))

    def test_a_deadline(self):
        start = time.perf_counter()
        self.render("a.exr", "--seconds", "0.3", "--samples", "1000000", status=4)
        self.assertLess(time.perf_counter() - start, 30)

    def test_preview(self):
        pathlib.Path(self.path("g.json")).write_text(json.dumps(SURFACE))
        run = alder("preview", self.path("g.json"), "-o", self.path("g.png"), "--stage", "sphere", "--size", "32", "--samples", "1")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(self.bytes("g.png").startswith(b"\x89PNG"))
        run = alder("preview", self.path("g.json"), "-o", self.path("b.png"), "--stage", "sphere", "--size", "32", "--samples", "1", "--set", "s.diffuseColor=[0,1,0]")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertNotEqual(self.bytes("g.png"), self.bytes("b.png"))
        self.assertEqual(alder("preview", self.path("g.json"), "--stage", "spher").returncode, 2)

    def test_parts_merge_to_the_whole(self):
        aovs = [a for name in ("shading", "data", "quality") for a in ("--aov", name)]
        self.render("whole.exr", "--samples", "32", *aovs)
        self.render("a.exr", "--samples", "16", *aovs)
        self.render("b.exr", "--samples", "16", "--sample-offset", "16", *aovs)
        run = alder("merge", self.path("b.exr"), self.path("a.exr"), "-o", self.path("merged.exr"))
        self.assertEqual(run.returncode, 0, run.stderr)
        run = alder("merge", self.path("a.exr"), self.path("a.exr"), "-o", self.path("x.exr"))
        self.assertEqual(run.returncode, 2)
        self.assertIn("share samples 0 to 15", run.stderr)
        self.render("c.exr", "--samples", "16", "--sample-offset", "16", "--seed", "3", *aovs)
        self.assertEqual(alder("merge", self.path("a.exr"), self.path("c.exr"), "-o", self.path("x.exr")).returncode, 2)
        # Merging the whole with nothing else is the identity, up to what a merge recomputes: then both files compare by value.
        for name in ("whole", "merged"):
            run = alder("merge", self.path(name + ".exr"), "-o", self.path(name + ".png"), "--quiet")
            self.assertEqual(run.returncode, 0, run.stderr)
        whole, merged = self.bytes("whole.png"), self.bytes("merged.png")
        self.assertEqual(whole, merged)


class Program(unittest.TestCase):
    def test_stops_in_good_order(self):
        with Daemon(BUILD) as daemon:
            self.assertEqual(daemon.ask("GET", "/livez")[0], 200)
            start = time.perf_counter()
            self.assertEqual(daemon.stop(), 0)
            self.assertLess(time.perf_counter() - start, 10)
            events = [json.loads(line)["event"] for line in daemon.log_text().splitlines()]
            self.assertEqual(events[0], "listening")
            self.assertEqual(events[-1], "stopped")

    def test_refuses_wrong_options(self):
        with tempfile.TemporaryDirectory() as folder:
            for options in (["--listen", "0.0.0.0:0"], ["--listen", "nonsense"], ["--nonsense"], ["--listen", "127.0.0.1:0", "--asset-root", "/nowhere"],
                            ["--listen", "127.0.0.1:0", "--token-file", "/nowhere"]):
                run = subprocess.run([str(BUILD / "alderd"), "--data", os.path.join(folder, "data"), *options], capture_output=True, text=True, timeout=30)
                self.assertEqual(run.returncode, 2, "%s: %s" % (options, run.stderr))
                self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
            run = subprocess.run([str(BUILD / "alderd"), "--listen", "127.0.0.1:0", "--data", "/proc/nowhere"], capture_output=True, text=True, timeout=30)
            self.assertEqual(run.returncode, 3, run.stderr)

    def test_environment_names_options_too(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([str(BUILD / "alderd"), "--data", folder], env={**os.environ, "ALDER_LISTEN": "0.0.0.0:0"}, capture_output=True, text=True, timeout=30)
            self.assertEqual(run.returncode, 2)
            self.assertIn("0.0.0.0:0", run.stderr)

    def test_demo(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([sys.executable, str(ROOT / "docs/examples/demo.py"), "--build", str(BUILD), "--output", folder, "--size", "48", "--samples", "2"],
                                 capture_output=True, text=True, timeout=250)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(pathlib.Path(folder, "shaderball.exr").read_bytes().startswith(b"\x76\x2f\x31\x01"))
            self.assertTrue(pathlib.Path(folder, "shaderball.png").read_bytes().startswith(b"\x89PNG"))
            self.assertIn("unused look", run.stdout)
            self.assertIn("direct_diffuse", run.stdout)


if __name__ == "__main__":
    unittest.main()
