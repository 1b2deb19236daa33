"""nodes/README.md is true: its node compiles, is linked into a program of its own, and its commands print what the text says."""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
TEXT = (ROOT / "nodes" / "README.md").read_text()
EXAMPLE = "nodes/math/soft_step.cpp"


def block(kind):
    return re.findall(r"^```%s\n(.*?)^```" % kind, TEXT, re.M | re.S)


@unittest.skipUnless(shutil.which("ninja") and (BUILD / "compile_commands.json").exists(), "no build by ninja")
class NodesReadme(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.at = pathlib.Path(cls.folder.name)
        (cls.at / EXAMPLE).parent.mkdir(parents=True)
        (cls.at / EXAMPLE).write_text(block("cpp")[0])
        test = cls.at / "soft_step_test.cpp"
        test.write_text(block("cpp test")[0])
        (cls.at / "build").mkdir()
        commands = json.loads((BUILD / "compile_commands.json").read_text())

        def compile_like(model, source, output):
            words = shlex.split(next(c["command"] for c in commands if c["file"].endswith(model)))
            words = [w for w in words if not w.startswith("-O")]
            words[words.index("-o") + 1] = str(output)
            words[words.index("-c") + 1] = str(source)
            words[words.index("-c"):words.index("-c")] = ["-O1", "-I" + str(cls.at)]
            return subprocess.run(words, cwd=BUILD, capture_output=True, text=True)

        def link_with(target, extra):
            command = subprocess.run(["ninja", "-C", str(BUILD), "-t", "commands", "-s", target], capture_output=True, text=True, check=True).stdout.splitlines()[-1]
            link = next(part for part in command.split("&&") if " -o " + target + " " in part)
            words = shlex.split(link)
            words[words.index("-o") + 1] = str(cls.at / "build" / target)
            objects = [i for i, w in enumerate(words) if w.endswith(".o")]
            words[objects[-1] + 1:objects[-1] + 1] = [str(e) for e in extra]
            return subprocess.run(words, cwd=BUILD, capture_output=True, text=True)

        cls.steps = [compile_like("nodes/math/al_remap_float.cpp", cls.at / EXAMPLE, cls.at / "node.o"),
                     compile_like("tests/nodes/all_nodes_test.cpp", test, cls.at / "test.o")]
        if all(s.returncode == 0 for s in cls.steps):
            cls.steps.append(link_with("alder", [cls.at / "node.o"]))
            cls.steps.append(link_with("test_nodes", [cls.at / "node.o", cls.at / "test.o"]))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_example_builds(self):
        for step in self.steps:
            self.assertEqual(step.returncode, 0, step.stderr[-3000:])
        self.assertEqual(len(self.steps), 4)

    def test_the_commands_run(self):
        script = "\n".join(line for line in "\n".join(block("sh")).splitlines() if not line.startswith("./dev "))
        run = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=self.at, capture_output=True, text=True, timeout=120)
        self.assertEqual(run.returncode, 0, run.stderr)
        promised = re.search(r"soft_step\.json +# (\{.*\})", TEXT).group(1)
        self.assertEqual(run.stdout.splitlines().count(promised), 2, run.stdout)
        self.assertIn("0 to 1 with a soft edge", run.stdout)
        self.assertIn("SoftStep(", run.stdout)

    def test_the_test_passes_and_the_laws_hold(self):
        for pattern in ("SoftStep.*", "AllNodes.schema_is_complete"):
            run = subprocess.run([str(self.at / "build" / "test_nodes"), "--gtest_filter=" + pattern], cwd=BUILD, capture_output=True, text=True, timeout=120)
            self.assertEqual(run.returncode, 0, run.stdout[-2000:])
            self.assertIn("1 test", run.stdout)


if __name__ == "__main__":
    unittest.main()
