"""Clients that mean no good or have bad luck: hundreds that send a byte a second, and a disk that is full."""
import hashlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
GRAPH = {"nodes": {"s": {"type": "alSurface"}}, "outputs": {"surface": {"node": "s"}}}


class SlowClientsTest(unittest.TestCase):
    def test_500_that_send_a_byte_a_second_leave_the_service_answering(self):
        with Daemon(BUILD, "--log-level", "warn") as daemon:
            host, port = daemon.address.rsplit(":", 1)
            slow = []
            for _ in range(500):
                s = socket.create_connection((host, int(port)), timeout=30)
                s.sendall(b"GET /v1/nodes HTT")
                slow.append(s)
            worst = 0
            for second in range(4):
                for s in slow:
                    try:
                        s.sendall(b"x")
                    except OSError:
                        pass   # given up already
                for path, body in (("/livez", None), ("/v1/version", None), ("/v1/preview", {"graph": GRAPH, "size": 16, "samples": 1})):
                    begun = time.monotonic()
                    self.assertEqual(daemon.ask("POST" if body else "GET", path, body)[0], 200, path)
                    worst = max(worst, time.monotonic() - begun)
                time.sleep(1)
            self.assertLess(worst, 2, "seconds for an answer meanwhile")
            # Headers have 5 s: who is not done by then is told so and closed.
            refused = 0
            for s in slow:
                s.settimeout(20)
                try:
                    answer = s.recv(400)
                except ConnectionError:
                    answer = b""
                refused += answer.startswith(b"HTTP/1.1 408") or answer == b""
                s.close()
            self.assertEqual(refused, 500)
            for _ in range(100):
                metrics = daemon.ask("GET", "/metrics")[2].decode()
                open_now = [float(line.split()[1]) for line in metrics.splitlines() if line.startswith("alder_connections ")][0]
                if open_now < 10:
                    break
                time.sleep(0.1)
            self.assertLess(open_now, 10, "connections left")


class FullDiskTest(unittest.TestCase):
    def test_uploads_are_refused_with_a_reason_and_go_on_when_there_is_room(self):
        with tempfile.TemporaryDirectory(prefix="alder-full-") as folder:
            if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", folder], capture_output=True).returncode:
                self.skipTest("no right to mount a small file system")
            try:
                with Daemon(BUILD, data=folder + "/data") as daemon:
                    def put(data):
                        return daemon.ask("PUT", "/v1/assets/sha256:" + hashlib.sha256(data).hexdigest(), data)
                    kept = os.urandom(1 << 20)
                    self.assertEqual(put(kept)[0], 201)
                    filler = os.path.join(folder, "filler")
                    with open(filler, "wb") as f:
                        try:
                            while True:
                                f.write(b"\0" * 65536)
                                f.flush()
                        except OSError:
                            pass
                    late = os.urandom(2 << 20)
                    status, _, body = put(late)
                    self.assertEqual((status, json.loads(body)["type"]), (507, "/problems/storage"))
                    status, _, body = daemon.ask("POST", "/v1/uploads", {"digest": "sha256:" + hashlib.sha256(late).hexdigest(), "size": len(late)})
                    self.assertEqual((status, json.loads(body)["type"]), (507, "/problems/storage"))
                    self.assertEqual(daemon.ask("GET", "/readyz")[0], 503, "it says that it takes no work")
                    self.assertEqual(daemon.ask("GET", "/livez")[0], 200)
                    self.assertEqual(daemon.ask("GET", "/v1/assets/sha256:" + hashlib.sha256(kept).hexdigest())[2], kept, "what is there can be read")
                    self.assertEqual(daemon.ask("POST", "/v1/preview", {"graph": GRAPH, "size": 16, "samples": 1})[0], 200, "previews need no disk")
                    os.remove(filler)
                    self.assertEqual(put(late)[0], 201, "room is back")
                    self.assertEqual(daemon.ask("GET", "/readyz")[0], 200)
                    self.assertEqual(sorted(f for f in os.listdir(folder + "/data/assets") if "tmp" in f), [], "nothing half written is left")
            finally:
                subprocess.run(["umount", folder], capture_output=True)


if __name__ == "__main__":
    unittest.main()
