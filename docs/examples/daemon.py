"""Starts an alderd of its own on a free port, with a data folder of its own, and stops it again. Standard library only."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request


class Daemon:
    """with Daemon("build") as d: d.get("/livez")"""

    def __init__(self, build, *options, data=None):
        self.data = data   # else a folder that goes with it
        self.program = str(pathlib.Path(build) / "alderd")
        self.options = list(options)

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="alder-")
        port_file = os.path.join(self.folder, "port")
        self.log = open(os.path.join(self.folder, "log"), "wb")
        self.started = time.perf_counter()
        self.process = subprocess.Popen(
            [self.program, "--listen", "127.0.0.1:0", "--data", self.data or os.path.join(self.folder, "data"), "--port-file", port_file, *self.options],
            stderr=self.log)
        while not os.path.exists(port_file):
            if self.process.poll() is not None:
                raise RuntimeError("alderd ended with status %d: %s" % (self.process.returncode, self.log_text()[-500:]))
            time.sleep(0.001)
        with open(port_file) as f:
            self.address = f.read().strip()
        self.url = "http://" + self.address
        return self

    def log_text(self):
        self.log.flush()
        with open(self.log.name, errors="replace") as f:
            return f.read()

    def stop(self):
        if self.process.poll() is None:
            self.process.terminate()
        return self.process.wait(20)

    def __exit__(self, *_):
        self.stop()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def ask(self, method, path, body=None, headers=None):
        """(status, headers, bytes); errors are answers too."""
        headers = dict(headers or {})
        if body is not None and not isinstance(body, bytes):
            body = json.dumps(body).encode()
            headers.setdefault("Content-Type", "application/json")
        request = urllib.request.Request(self.url + path, data=body, method=method, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=600) as answer:
                return answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as e:
            return e.code, e.headers, e.read()
