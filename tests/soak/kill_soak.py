"""kill -9 at random moments under load: no accepted render is lost or rendered twice, nothing is half written, every result has
the bits of an undisturbed one. `./dev soak --kills 100`; the tests run a few kills of the same."""
import argparse
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

GRAPH = {"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.3, 0.1], "specular1Roughness": 0.3}}},
         "outputs": {"surface": {"node": "s"}}}
SCENE = {"alder_scene": 1,
         "cameras": {"cam": {"look_at": {"from": [0, -5, 1], "to": [0, 0, 1]}, "fov_degrees": 40}},
         "materials": {"red": GRAPH},
         "meshes": {"tri": {"positions": [[-1, 0, 0], [1, 0, 0], [0, 0, 2]], "triangles": [[0, 1, 2]]}},
         "instances": {"a": {"mesh": "tri", "material": "red"}},
         "lights": {"sun": {"type": "sun", "strength": 3, "angle_degrees": 20}}}
KINDS = 6


def request_of(scene, kind):
    body = {"scene": scene, "samples": 400 + 333 * kind, "resolution": [64, 48], "seed": kind + 1, "aovs": ["shading"]}
    if kind == 5:
        body.update(frames="1-4", samples=300)
    return body


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Service:
    def __init__(self, build, folder, *options):
        self.command = [str(pathlib.Path(build) / "alderd"), "--data", folder, *options]
        self.folder = folder
        self.process = None
        self.restarts = []
        self.port = free_port()
        self.log = open(folder + ".log", "ab")

    def start(self):
        began = time.perf_counter()
        for _ in range(20):   # another program may have taken the port meanwhile
            self.process = subprocess.Popen(self.command + ["--listen", "127.0.0.1:%d" % self.port], stderr=self.log)
            while self.process.poll() is None:
                try:
                    if self.ask("GET", "/readyz")[0] == 200:
                        self.restarts.append(time.perf_counter() - began)
                        return self
                except OSError:
                    time.sleep(0.002)
            time.sleep(0.1)
        raise RuntimeError("alderd does not start: " + open(self.log.name, errors="replace").read()[-800:])

    def worker(self):
        """Process id of the worker, or None."""
        try:
            with open("/proc/%d/task/%d/children" % (self.process.pid, self.process.pid)) as f:
                direct = f.read().split()
        except OSError:
            direct = []
        for task in os.listdir("/proc/%d/task" % self.process.pid) if self.process.poll() is None else []:
            try:
                with open("/proc/%d/task/%s/children" % (self.process.pid, task)) as f:
                    direct += f.read().split()
            except OSError:
                pass
        return int(direct[0]) if direct else None

    def ask(self, method, path, body=None, headers=None, timeout=30):
        headers = dict(headers or {})
        data = None
        if body is not None:
            data = json.dumps(body).encode()
            headers["Content-Type"] = "application/json"
        request = urllib.request.Request("http://127.0.0.1:%d%s" % (self.port, path), data=data, method=method, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=timeout) as answer:
                return answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as e:
            return e.code, e.headers, e.read()

    def insist(self, method, path, body=None, headers=None):
        """The same until it is answered: the daemon may be killed at any moment."""
        while True:
            try:
                return self.ask(method, path, body, headers)
            except OSError:
                time.sleep(0.01)
            except Exception as e:   # an answer cut short (http.client has many names for it)
                if "http.client" not in type(e).__module__:
                    raise
                time.sleep(0.01)

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            self.process.wait(20)
        self.log.close()


def digests(render):
    return [o["digest"] for o in render["outputs"]]


def references(build, folder):
    service = Service(build, folder).start()
    try:
        scene = json.loads(service.ask("POST", "/v1/scenes", SCENE)[2])["id"]
        found = []
        for kind in range(KINDS):
            status, _, body = service.ask("POST", "/v1/renders", request_of(scene, kind), {"Prefer": "wait=300", "Accept": "application/json"}, 310)
            assert status == 200, body
            found.append(digests(json.loads(body)))
        return found
    finally:
        service.stop()


def soak(build, kills, jobs, seed=1, say=lambda text: None):
    """Returns figures; raises AssertionError with what is wrong."""
    rng = random.Random(seed)
    root = tempfile.mkdtemp(prefix="alder-soak-")
    service = None
    try:
        expected = references(build, root + "/reference")
        service = Service(build, root + "/data", "--checkpoint-seconds", "0.05").start()
        scene = json.loads(service.insist("POST", "/v1/scenes", SCENE)[2])["id"]
        accepted, trouble = {}, []

        def submit_all():
            try:
                for number in range(jobs):
                    status, _, body = service.insist("POST", "/v1/renders", request_of(scene, number % KINDS),
                                                     {"Idempotency-Key": "soak-%d" % number, "Cache-Control": "no-cache"})
                    if status != 202:
                        trouble.append("render %d: %d %s" % (number, status, body[:200]))
                        return
                    accepted[json.loads(body)["id"]] = number % KINDS
                    time.sleep(rng.random() * 0.1)
            except Exception as e:
                trouble.append(repr(e))

        submitter = threading.Thread(target=submit_all)
        submitter.start()
        killed = {"daemon": 0, "worker": 0}
        for number in range(kills):
            time.sleep(rng.expovariate(3.0))
            if rng.random() < 0.5:
                service.kill()
                killed["daemon"] += 1
                service.start()
            else:
                pid = service.worker()
                if pid:
                    try:
                        os.kill(pid, signal.SIGKILL)
                        killed["worker"] += 1
                    except ProcessLookupError:
                        pass
            say("%d of %d kills, %d renders accepted" % (number + 1, kills, len(accepted)))
        submitter.join()
        assert not trouble, trouble
        attempts = 0
        for render, kind in accepted.items():
            end = time.time() + 300
            while True:
                status, _, body = service.insist("GET", "/v1/renders/" + render)
                assert status == 200, "%s is lost: %d" % (render, status)
                found = json.loads(body)
                if found["state"] in ("succeeded", "failed", "cancelled") or time.time() > end:
                    break
                time.sleep(0.02)
            assert found["state"] == "succeeded", found
            assert digests(found) == expected[kind], "%s (kind %d): other bits" % (render, kind)
            attempts += found["attempt"] - 1
            for output in found["outputs"]:
                status, _, body = service.insist("GET", "/v1/renders/%s/outputs/%s" % (render, output["file"]))
                assert status == 200 and "sha256:" + hashlib.sha256(body).hexdigest() == output["digest"], output
        listed, cursor = [], ""
        while cursor is not None:
            page = json.loads(service.insist("GET", "/v1/renders?limit=100" + cursor)[2])
            listed += [r["id"] for r in page["items"]]
            cursor = "&cursor=" + page["next"] if page["next"] else None
        assert sorted(listed) == sorted(accepted), "%d renders for %d keys" % (len(listed), len(accepted))
        folders = set(os.listdir(root + "/data/renders"))
        assert folders == set(accepted), folders ^ set(accepted)
        partial = [p for r in folders for p in pathlib.Path(root, "data", "renders", r, "outputs").iterdir() if p.suffix != ".exr"]
        assert not partial, partial
        return {"renders": len(accepted), "killed": killed, "attempts_lost": attempts, "lost": 0, "corrupt": 0,
                "restart_seconds_most": round(max(service.restarts), 3)}
    finally:
        if service:
            service.stop()
        shutil.rmtree(root, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default="build")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--renders", type=int, default=0, help="default: one for two kills")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    began = time.time()
    figures = soak(args.build, args.kills, args.renders or max(6, args.kills // 2), args.seed,
                   lambda text: print("\r" + text, end="", file=sys.stderr, flush=True) if sys.stderr.isatty() else None)
    figures["seconds"] = round(time.time() - began, 1)
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
