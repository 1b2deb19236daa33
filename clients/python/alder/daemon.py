"""A daemon for this process: started on a free port with a data folder of its own, stopped when it is closed or Python ends."""
from __future__ import annotations

import atexit
import os
import shutil
import subprocess
import tempfile
import time

from .errors import Unreachable


def find_program(name: str = "alderd") -> str:
    """$ALDERD (or $ALDER for "alder"), then $PATH, then build/ of the source tree that this file lies in."""
    named = os.environ.get(name.upper())
    if named:
        return named
    found = shutil.which(name)
    if found:
        return found
    tree = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "build", name)
    if os.access(tree, os.X_OK):
        return os.path.normpath(tree)
    raise Unreachable("there is no %s: put it on PATH, or name it in the environment variable %s" % (name, name.upper()))


class LocalDaemon:
    def __init__(self, program: str | None = None, options: tuple[str, ...] = (), start_seconds: float = 20.0):
        self.folder = tempfile.mkdtemp(prefix="alder-")
        port_file = os.path.join(self.folder, "port")
        self._log = open(os.path.join(self.folder, "log"), "wb")
        command = [program or find_program(), "--listen", "127.0.0.1:0", "--data", os.path.join(self.folder, "data"), "--port-file", port_file, *options]
        try:
            # A session of its own: Ctrl-C in a script ends the render, not the daemon under it.
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._log, start_new_session=True)
        except OSError as e:
            self._remove()
            raise Unreachable("%s: %s" % (command[0], e)) from e
        atexit.register(self.close)
        deadline = time.monotonic() + start_seconds
        while not self._address(port_file):
            if self.process.poll() is not None or time.monotonic() > deadline:
                text = self.log()[-500:]
                self.close()
                raise Unreachable("alderd did not start: %s" % text)
            time.sleep(0.002)
        self.url = "http://" + self._address(port_file)

    @staticmethod
    def _address(port_file: str) -> str:
        try:
            with open(port_file) as f:
                return f.read().strip()
        except FileNotFoundError:
            return ""

    def log(self) -> str:
        self._log.flush()
        with open(self._log.name, errors="replace") as f:
            return f.read()

    def close(self) -> None:
        atexit.unregister(self.close)
        process = getattr(self, "process", None)
        if process is not None and process.poll() is None:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._remove()

    def _remove(self) -> None:
        self._log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
