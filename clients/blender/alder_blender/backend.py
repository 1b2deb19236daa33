"""Where a scene file is rendered: by the program `alder` on this machine, or by a daemon. Without Blender in it."""
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time


class RenderError(Exception):
    """The render did not give a picture; the message says why."""


def client_package():
    """The Python client: inside an installed add-on, installed, or beside it in the source tree."""
    try:
        from .vendor import alder
        return alder
    except ImportError:
        pass
    try:
        import alder
    except ImportError:
        tree = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python")
        if not os.path.isdir(os.path.join(tree, "alder")):
            raise RenderError("the Python client `alder` is not installed") from None
        sys.path.append(tree)
        import alder
    return alder


def find_program(preferred=""):
    """The program `alder`: as set, $ALDER, on $PATH, or in build/ of the source tree."""
    tree = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "build", "alder")
    for candidate in (preferred, os.environ.get("ALDER", ""), shutil.which("alder") or "", os.path.normpath(tree)):
        if candidate and os.access(candidate, os.X_OK) and os.path.isfile(candidate):
            return candidate
    raise RenderError("the program alder was not found: set its path in the add-on's preferences")


_local = {"client": None}
_local_lock = threading.Lock()


def local_client(program="", threads=0):
    """The client of a daemon that this process started: the alderd beside the program; one for all viewports."""
    with _local_lock:
        if _local["client"] is None:
            alder = client_package()
            beside = os.path.join(os.path.dirname(find_program(program)), "alderd")
            if not os.access(beside, os.X_OK):
                raise RenderError("there is no alderd beside %s: the viewport needs it" % find_program(program))
            _local["client"] = alder.local(*(("--threads", str(threads)) if threads else ()), program=beside)
        return _local["client"]


def stop_local():
    with _local_lock:
        client, _local["client"] = _local["client"], None
    if client is not None:
        client.close()


class Program:
    """Renders with the program; what a cancelled render has so far is given back."""

    def __init__(self, path="", threads=0):
        self.path, self.threads = find_program(path), threads

    def render(self, scene, layers, progress=lambda fraction: None, cancelled=lambda: False):
        """(alder.Image, warnings)."""
        folder = tempfile.mkdtemp(prefix="alder-f12-")
        try:
            out = os.path.join(folder, "out.exr")
            command = [self.path, "render", scene, "-o", out, "--progress"]
            for layer in layers:
                command += ["--aov", layer]
            if self.threads:
                command += ["--threads", str(self.threads)]
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
            warnings, status = self._follow(process, progress, cancelled)
            if not os.path.exists(out):
                raise RenderError(warnings[-1] if warnings else "alder ended with status %d" % status)
            return client_package().Image.open(out), warnings
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @staticmethod
    def _follow(process, progress, cancelled):
        warnings, rest, stopped = [], b"", None
        fd = process.stderr.fileno()
        while True:
            if select.select([fd], [], [], 0.05)[0]:
                piece = os.read(fd, 65536)
                if not piece:
                    break
                *lines, rest = (rest + piece).split(b"\n")
                for line in lines:
                    text = line.decode("utf-8", "replace")
                    match = re.match(r"progress ([0-9.]+)$", text)
                    if match:
                        progress(float(match.group(1)))
                    elif text:
                        warnings.append(re.sub(r"^alder: (warning: )?", "", text))
            if stopped is None and cancelled():
                stopped = time.monotonic()
                process.send_signal(signal.SIGINT)
            elif stopped is not None and time.monotonic() - stopped > 10:
                process.kill()
        process.stderr.close()
        return warnings, process.wait()


class Daemon:
    """Renders with a daemon by address and token: only what it lacks is sent."""

    def __init__(self, url, token=""):
        alder = client_package()
        self.client = alder.Client(url, token or None)
        self.error = alder.AlderError

    def render(self, scene, layers, progress=lambda fraction: None, cancelled=lambda: False):
        try:
            pushed = self.client.scenes.push(scene, progress=None)
            job = self.client.render(pushed, aovs=list(layers), output={"pixel_type": "float"})
            result, done = {}, threading.Event()

            def wait():
                try:
                    result["image"] = job.result(progress=lambda fraction, _: progress(fraction))
                except Exception as e:   # handed over
                    result["error"] = e
                done.set()
            threading.Thread(target=wait, daemon=True).start()
            while not done.wait(0.05):
                if cancelled():
                    if job.id is not None:
                        job.cancel()
                    raise RenderError("cancelled")
            if "error" in result:
                raise result["error"]
            return result["image"], pushed.warnings
        except self.error as e:
            raise RenderError(str(e)) from e
