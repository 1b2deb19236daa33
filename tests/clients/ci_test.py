"""alder ci: suites that pass, differ and fail; reports, shards and updates of references."""
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
GRAPH = {"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.2, 0.1]}}}, "outputs": {"surface": {"node": "s"}}}


class Ci(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copy(ROOT / "docs" / "examples" / "triangle.glb", self.folder / "triangle.glb")
        (self.folder / "paint.json").write_text(json.dumps(GRAPH))
        self.suite = {"name": "pictures", "defaults": {"settings": {"samples": 4}, "layers": {"beauty": {"relmse_trimmed": 1e-6, "exact": True}}},
                      "cases": [{"name": "triangle", "scene": "triangle.glb", "settings": {"resolution": [32, 18]}, "reference": "refs/triangle.exr"},
                                {"name": "paint", "graph": "paint.json", "stage": "sphere", "settings": {"size": 24},
                                 "layers": {"beauty": {"relmse": 1e-6}, "Z": {"max_abs": 1e-3}}}]}

    def ci(self, *arguments, status=0):
        (self.folder / "suite.json").write_text(json.dumps(self.suite))
        run = subprocess.run([ALDER, "ci", str(self.folder / "suite.json"), *map(str, arguments)], capture_output=True, text=True, timeout=250)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return run

    def test_references_are_made_kept_and_changed_for_a_reason(self):
        run = self.ci(status=2)
        self.assertIn("--update", run.stdout)
        self.assertIn("--reason", self.ci("--update", status=2).stderr)
        self.ci("--update", "--reason", "first pictures")
        reference = (self.folder / "refs" / "triangle.exr").read_bytes()
        self.ci()
        self.ci("--update", "--reason", "nothing to do")
        self.assertEqual((self.folder / "refs" / "triangle.exr").read_bytes(), reference)
        history = [json.loads(line) for line in (self.folder / "suite.json.history.jsonl").read_text().splitlines()]
        self.assertEqual([(e["case"], e["reason"], e["previous_sha256"]) for e in history], [("triangle", "first pictures", None), ("paint", "first pictures", None)])
        self.suite["cases"][1]["overrides"] = [{"op": "replace", "path": "/nodes/s/params/diffuseColor", "value": [0.1, 0.2, 0.8]}]
        run = self.ci(status=1)
        self.assertIn("relmse", run.stdout)
        self.ci("--update", "--reason", "blue now")
        self.ci()

    def test_reports(self):
        self.ci("--update", "--reason", "first pictures")
        self.suite["cases"][1]["overrides"] = {"s.diffuseColor": [0.1, 0.2, 0.8]}
        self.suite["cases"].append({"name": "gone", "scene": "nowhere.glb"})
        report = self.folder / "report"
        self.ci("--junit", self.folder / "j.xml", "--report", report, status=2)
        suite = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot().find("testsuite")
        self.assertEqual([suite.get(k) for k in ("name", "tests", "failures", "errors")], ["pictures", "4", "1", "1"])
        cases = {c.get("name"): c for c in suite.iter("testcase")}
        self.assertEqual(set(cases), {"triangle beauty", "paint beauty", "paint Z", "gone"})
        self.assertIn("worst pixel", cases["paint beauty"].find("failure").get("message"))
        self.assertIn("no such file", cases["gone"].find("error").get("message"))
        properties = {p.get("name"): p.get("value") for p in cases["triangle beauty"].iter("property")}
        self.assertEqual((properties["samples"], properties["exact"], properties["relmse"]), ("4", "true", "0.0"))
        for attachment in cases["paint beauty"].find("system-out").text.split():
            self.assertTrue(os.path.isfile(attachment[len("[[ATTACHMENT|"):-2]), attachment)
        page = (report / "index.html").read_text()
        self.assertIn("1 of 3 good", page)
        self.assertNotIn("http", page.replace("http-equiv", ""))   # opens from disk, asks no network
        for source in set(part.split('"')[0] for part in page.split('src="')[1:]):
            self.assertTrue((report / source).read_bytes().startswith(b"\x89PNG"), source)

    def test_a_part_of_the_suite(self):
        self.ci("--update", "--reason", "first pictures")
        names = [[c["name"] for c in json.loads(self.ci("--json", *option).stdout)["cases"]]
                 for option in (["--only", "p*"], ["--shard", "1/2"], ["--shard", "2/2"], ["--shard", "3/3"])]
        self.assertEqual(names, [["paint"], ["triangle"], ["paint"], []])
        for option in (["--shard", "0/2"], ["--shard", "3/2"], ["--shard", "x"], ["--only", "nothing*"]):
            self.ci(*option, status=2)

    def test_noise_is_within_sigma_and_change_is_not(self):
        case = self.suite["cases"][1]
        case["settings"] = {"size": 64, "samples": 32}
        case["layers"] = {"beauty": {"sigma": 4}}
        self.suite["cases"] = [case]
        self.ci("--update", "--reason", "first pictures")
        for seed in (1, 2, 3):
            case["settings"]["seed"] = seed
            self.ci()
        case["overrides"] = {"s.diffuseColor": [0.77, 0.2, 0.1]}
        self.ci(status=1)

    def test_faults_of_the_suite_are_told_by_pointer(self):
        self.suite["cases"][0]["layers"] = {"beauty": {"relmes": 1}}
        self.suite["cases"][1]["setings"] = {}
        run = self.ci(status=2)
        self.assertIn("/cases/0/layers/beauty/relmes", run.stderr)
        self.assertIn("did you mean settings", run.stderr)


if __name__ == "__main__":
    unittest.main()
