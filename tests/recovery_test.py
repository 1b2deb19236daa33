"""What survives kill -9 and a full disk: alderd and its worker as programs. ./dev soak does the same for longer."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
sys.path.insert(0, str(ROOT / "tests" / "soak"))
import kill_soak  # noqa: E402


class Recovery(unittest.TestCase):
    def test_kill_9_of_daemon_and_worker_loses_nothing(self):
        figures = kill_soak.soak(BUILD, kills=4, jobs=6, seed=3)
        self.assertEqual(figures["renders"], 6)
        self.assertLess(figures["restart_seconds_most"], 10)

    def test_a_full_disk_pauses_and_a_free_one_goes_on(self):
        folder = tempfile.mkdtemp(prefix="alder-full-")
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24m", "tmpfs", folder], capture_output=True)
        if mounted.returncode != 0:
            os.rmdir(folder)
            self.skipTest("a file system of its own cannot be mounted here")
        service = None
        try:
            service = kill_soak.Service(BUILD, folder + "/data")
            service.log.close()
            service.log = open(os.devnull, "ab")
            service.start()
            scene = json.loads(service.ask("POST", "/v1/scenes", kill_soak.SCENE)[2])["id"]
            body = {"scene": scene, "samples": 16, "resolution": [512, 512], "output": {"pixel_type": "float", "compression": "none"}, "aovs": ["shading"]}
            status, _, answer = service.ask("POST", "/v1/renders", body)
            self.assertEqual(status, 202, answer)
            path = "/v1/renders/" + json.loads(answer)["id"]

            def until(wanted):
                end = time.time() + 60
                while time.time() < end:
                    render = json.loads(service.ask("GET", path)[2])
                    if render["state"] == wanted:
                        return render
                    time.sleep(0.05)
                self.fail("not %s: %s" % (wanted, render))

            paused = until("paused")   # some 27 MB of result do not fit 24
            self.assertEqual(paused["reason"], "disk-full")
            self.assertEqual(service.ask("GET", "/v1/renders")[0], 200, "the store stays readable")
            subprocess.run(["mount", "-o", "remount,size=400m", folder], check=True, capture_output=True)
            done = until("succeeded")
            self.assertGreater(done["outputs"][0]["bytes"], 20 << 20)
        finally:
            if service:
                service.stop()
            subprocess.run(["umount", "-l", folder], capture_output=True)
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    unittest.main()
