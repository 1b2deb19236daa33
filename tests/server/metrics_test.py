"""/metrics has the names that docs/operations.md promises, in the form of OpenMetrics."""
import json
import os
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "docs/examples"), str(ROOT / "tests/server")]
from daemon import Daemon  # noqa: E402
from openapi_test import GRAPH, SCENE  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
LATER = {"alder_recoveries_total", "alder_worker_crashes_total", "alder_stream_images_dropped_total", "alder_checkpoint_seconds"}   # where it has happened


class MetricsTest(unittest.TestCase):
    def test_promised_names_are_there(self):
        promised = set(re.findall(r"`(alder_[a-z_]+)(?:\{\w+\})?`", (ROOT / "docs/operations.md").read_text()))
        self.assertGreater(len(promised), 18)
        with Daemon(BUILD) as daemon:
            scene = json.loads(daemon.ask("POST", "/v1/scenes", SCENE)[2])["id"]
            self.assertEqual(daemon.ask("POST", "/v1/renders", {"scene": scene}, {"Prefer": "wait=60"})[0], 200)
            live = json.loads(daemon.ask("POST", "/v1/renders", {"mode": "live", "graph": GRAPH, "resolution": [16, 16], "max_samples": 1})[2])["id"]
            daemon.ask("GET", "/v1/renders/%s/snapshot.png" % live)
            for _ in range(2):
                daemon.ask("PUT", "/v1/assets/sha256:2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824", b"hello")
            text = daemon.ask("GET", "/metrics")[2].decode()
        self.assertTrue(text.endswith("# EOF\n"))
        types = dict(re.findall(r"^# TYPE (\w+) (\w+)$", text, re.M))
        self.assertEqual(len(types), len(re.findall(r"^# TYPE", text, re.M)), "each family once")
        there = {name + ("_total" if kind == "counter" else "") for name, kind in types.items()}
        self.assertEqual(promised - LATER - there, set())
        for line in text.splitlines():
            self.assertRegex(line, r'^# (TYPE \w+ (counter|gauge|histogram)|EOF)$|^\w+(\{\w+="[^"]*"(,\w+="[^"]*")*\})? [-+0-9.e]+$')
        self.assertIn('alder_renders{state="succeeded"} 1', text)
        self.assertIn("alder_asset_dedup_bytes_total 5", text)


if __name__ == "__main__":
    unittest.main()
