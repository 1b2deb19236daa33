"""alder jobs, show, wait, cancel, logs, fetch: a daemon's renders from the command line, with the exit statuses that scripts rely on."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "docs/examples"), str(ROOT / "tests/server")]
from daemon import Daemon  # noqa: E402
from openapi_test import SCENE  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))


class JobsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(BUILD).__enter__()
        cls.scene = json.loads(cls.daemon.ask("POST", "/v1/scenes", SCENE)[2])["id"]

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__()

    def submit(self, **more):
        status, _, body = self.daemon.ask("POST", "/v1/renders", {"scene": self.scene, **more})
        self.assertEqual(status, 202, body)
        return json.loads(body)["id"]

    def alder(self, *arguments, status=0, server=None):
        done = subprocess.run([BUILD + "/alder", *arguments], capture_output=True, text=True, timeout=120, env={**os.environ, "ALDER_URL": server or self.daemon.url})
        self.assertEqual(done.returncode, status, (arguments, done.stdout, done.stderr))
        return done.stdout if status == 0 else done.stderr

    def test_wait_show_logs_and_fetch(self):
        id = self.submit(samples=2, labels={"shot": "sq10"}, output={"name": "pic"})
        self.assertIn("succeeded", self.alder("wait", id))
        shown = self.alder("show", id)
        self.assertIn("pic.exr", shown)
        self.assertIn("shot=sq10", shown)
        self.assertEqual(json.loads(self.alder("show", id, "--json"))["state"], "succeeded")
        self.assertIn("succeeded", self.alder("logs", id))
        with tempfile.TemporaryDirectory() as folder:
            out = self.alder("fetch", id, "-o", folder).strip()
            self.assertEqual(out, os.path.join(folder, "pic.exr"))
            self.assertEqual(pathlib.Path(out).read_bytes()[:4], b"\x76\x2f\x31\x01")
            self.assertEqual(os.listdir(folder), ["pic.exr"], "nothing half written")
            self.alder("fetch", id, "-o", folder + "/other.exr")
            self.assertTrue(os.path.exists(folder + "/other.exr"))

    def test_lists_are_filtered(self):
        one, two = self.submit(samples=1, seed=5, labels={"shot": "a b"}), self.submit(samples=1, seed=6, labels={"shot": "c"})
        for id in (one, two):
            self.alder("wait", id)
        lines = self.alder("jobs", "--label", "shot=a b").splitlines()
        self.assertEqual([line.split()[0] for line in lines], [one])
        self.assertIn(two, self.alder("jobs", "--state", "succeeded"))
        self.assertEqual(self.alder("jobs", "--state", "failed"), "")
        self.assertEqual(len(json.loads(self.alder("jobs", "--limit", "1", "--json"))["items"]), 1)
        self.alder("jobs", "--label", "shot", status=2)

    def test_cancel_and_waiting_without_end(self):
        id = self.submit(samples=1 << 20, resolution=[512, 512])
        self.assertIn("alder: %s is" % id, self.alder("wait", id, "--timeout", "1", status=75))
        self.alder("fetch", id, status=75)
        self.alder("cancel", id)
        self.alder("wait", id, status=130)

    def test_what_is_not_there(self):
        self.alder("show", "rnd_" + 26 * "0", status=2)
        self.alder("show", "../../etc", status=2)
        self.assertIn("cannot be reached", self.alder("jobs", status=3, server="http://127.0.0.1:1"))


if __name__ == "__main__":
    unittest.main()
