"""Every command of README.md runs: the blocks marked `sh`, in order, in one shell, against a daemon of its own."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
sys.path.insert(0, str(ROOT / "docs" / "examples"))
from daemon import Daemon  # noqa: E402


def blocks():
    return re.findall(r"^```sh\n(.*?)^```", (ROOT / "README.md").read_text(), re.M | re.S)


@unittest.skipUnless(shutil.which("curl"), "curl is not installed")
class Readme(unittest.TestCase):
    def test_every_command_runs(self):
        script = "\n".join(blocks())
        self.assertIn("localhost:7420", script)
        with Daemon(BUILD) as daemon, tempfile.TemporaryDirectory() as folder:
            # Paths of the repository are reached through links; the daemon has a port of its own.
            os.symlink(ROOT / "docs", os.path.join(folder, "docs"))
            os.symlink(BUILD, os.path.join(folder, "build"))
            script = script.replace("localhost:7420", daemon.address)
            run = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, capture_output=True, text=True, timeout=280)
            self.assertEqual(run.returncode, 0, run.stdout[-2000:] + run.stderr[-2000:])
            for name, magic in (("ball.png", b"\x89PNG"), ("ball.exr", b"\x76\x2f\x31\x01"), ("frame.exr", b"\x76\x2f\x31\x01"), ("merged.exr", b"\x76\x2f\x31\x01")):
                data = pathlib.Path(folder, name).read_bytes()
                self.assertTrue(data.startswith(magic), name)
                self.assertGreater(len(data), 1000, name)
            self.assertIn('"suggest":"diffuseColor"', run.stdout)
            self.assertIn('"remap":[0.0,0.5,1.0]', run.stdout)

    def test_text_blocks_name_real_things(self):
        for name in re.findall(r"\]\(([^)]+)\)", (ROOT / "README.md").read_text()):
            if not name.startswith("http") and not name.endswith(".png"):
                self.assertTrue((ROOT / name).exists(), name)


if __name__ == "__main__":
    unittest.main()
