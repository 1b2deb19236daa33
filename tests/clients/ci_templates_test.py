"""The ready CI files parse, and what they run works; the commands and the suite of docs/ci.md, too."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
DOCS = ROOT / "docs"
ENVIRONMENT = {**os.environ, "PATH": "%s:%s" % (BUILD, os.environ["PATH"])}


def shell(script, cwd, **environment):
    return subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=cwd, env={**ENVIRONMENT, **environment}, capture_output=True, text=True, timeout=250)


def commands(text):
    """The lines that call alder ci."""
    return [re.sub(r"^- ", "", line.strip()) for line in text.splitlines() if re.match(r"\s*(- )?alder ci ", line)]


class Templates(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copytree(DOCS / "examples", self.folder / "docs" / "examples")
        shutil.copytree(DOCS / "ci", self.folder / "docs" / "ci")
        self.suite = "docs/ci/example/suite.json"

    def test_they_are_yaml(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("needs PyYAML")
        github = yaml.safe_load((DOCS / "ci" / "github-action.yml").read_text())
        steps = github["jobs"]["pictures"]["steps"]
        self.assertTrue(any("alder ci" in s.get("run", "") for s in steps))
        gitlab = yaml.safe_load((DOCS / "ci" / "gitlab.yml").read_text())
        self.assertEqual(gitlab["pictures"]["artifacts"]["reports"]["junit"], "pictures.xml")

    def test_their_commands_run(self):
        self.assertEqual(shell("alder ci %s --update --reason 'first pictures'" % self.suite, self.folder).returncode, 0)
        for name, variables in (("github-action.yml", {}), ("gitlab.yml", {"CI_NODE_INDEX": "2", "CI_NODE_TOTAL": "2"})):
            found = commands((DOCS / "ci" / name).read_text())
            self.assertEqual(len(found), 1, name)
            run = shell(found[0].replace("${{ matrix.shard }}", "1"), self.folder, SUITE=self.suite, **variables)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            self.assertIn("<testsuite ", (self.folder / "pictures.xml").read_text())
            self.assertIn("1 of 1 good", (self.folder / "pictures-report" / "index.html").read_text())

    def test_the_documentation(self):
        text = (DOCS / "ci.md").read_text()
        suite = json.loads(re.search(r"^```json\n(.*?)^```", text, re.M | re.S).group(1))
        (self.folder / "suite.json").write_text(json.dumps(suite))
        shutil.copy(DOCS / "examples" / "triangle.glb", self.folder / "shot.glb")
        shutil.copy(DOCS / "examples" / "weathered_paint.graph.json", self.folder / "paint.json")
        script = re.search(r"^```sh\n(.*?)^```", text, re.M | re.S).group(1)
        first, second, third = script.strip().splitlines()
        for command in (first, second):
            run = shell(command, self.folder)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        for seed, name in ((1, "result"), (2, "reference")):
            shell("alder render shot.glb -o %s.exr --resolution 64x36 --samples 32 --seed %d --aov variance" % (name, seed), self.folder)
        run = shell(third, self.folder)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
