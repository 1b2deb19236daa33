#!/usr/bin/env python3
"""What an interactive session feels: seconds from an edit to the picture at the client, re-mixes, small requests while all
processors render, and many event streams. Starts a daemon of its own.

    tests/bench/bench_service.py [--build build] [--edits 100] [--streams 200] [--json FILE]
"""
import argparse, http.client, json, os, re, signal, subprocess, sys, tempfile, threading, time

GRAPH = {"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.3, 0.1], "specular1Roughness": 0.3}}},
         "outputs": {"surface": {"node": "s"}}}


class Daemon:
    def __init__(self, build):
        self.folder = tempfile.TemporaryDirectory()
        port_file = os.path.join(self.folder.name, "port")
        self.process = subprocess.Popen([os.path.join(build, "alderd"), "--listen", "127.0.0.1:0", "--data", self.folder.name, "--port-file", port_file],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(200):
            if os.path.exists(port_file):
                break
            time.sleep(0.05)
        self.port = int(open(port_file).read().rsplit(":", 1)[1])

    def connect(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)

    def memory_mib(self):
        with open(f"/proc/{self.process.pid}/status") as f:
            return int(re.search(r"VmRSS:\s+(\d+)", f.read())[1]) / 1024

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(20)


def ask(connection, method, path, body=None, headers=None):
    for attempt in (1, 2):
        try:
            connection.request(method, path, json.dumps(body) if body is not None else None, {"Content-Type": "application/json", **(headers or {})})
            answer = connection.getresponse()
            data = answer.read()
            break
        except (BrokenPipeError, ConnectionResetError, http.client.RemoteDisconnected):
            connection.close()  # idle for longer than the daemon keeps connections
            if attempt == 2:
                raise
    if answer.status >= 400:
        sys.exit(f"{method} {path}: {answer.status} {data.decode()}")
    return json.loads(data) if data.startswith(b"{") else data


class Pictures(threading.Thread):
    """Reads preview.mjpg and notes when each edit was seen, and when the first picture at full resolution after it."""

    def __init__(self, daemon, live):
        super().__init__(daemon=True)
        self.seen, self.full, self.news, self.count, self.wanted = {}, {}, threading.Condition(), 0, None
        self.connection = daemon.connect()
        self.connection.request("GET", f"/v1/renders/{live}/preview.mjpg")
        self.answer = self.connection.getresponse()
        self.start()

    def run(self):
        try:
            while True:
                head = {}
                while True:
                    line = self.answer.readline()
                    if not line:
                        return
                    line = line.strip().decode("latin-1")
                    if not line and head:
                        break
                    if ": " in line:
                        name, value = line.split(": ", 1)
                        head[name] = value
                self.answer.read(int(head["Content-Length"]))
                now = time.perf_counter()
                with self.news:
                    self.count += 1
                    for token in filter(None, head.get("Alder-Edits", "").split(", ")):
                        self.seen[token] = now
                        self.wanted = token
                    if head["Alder-Divisor"] == "1" and self.wanted and self.wanted not in self.full:
                        self.full[self.wanted] = now
                    self.news.notify_all()
        except (OSError, ValueError, http.client.HTTPException):
            return

    def wait(self, table, token, seconds=30):
        with self.news:
            if not self.news.wait_for(lambda: token in table, seconds):
                sys.exit(f"no picture of edit {token} within {seconds} s")
            return table[token]


def figures(seconds):
    s = sorted(seconds)
    return {"median_ms": round(1e3 * s[len(s) // 2], 2), "p99_ms": round(1e3 * s[min(len(s) - 1, int(0.99 * len(s)))], 2), "n": len(s)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", default="build")
    parser.add_argument("--edits", type=int, default=100)
    parser.add_argument("--streams", type=int, default=200)
    parser.add_argument("--json")
    a = parser.parse_args()
    daemon = Daemon(a.build)
    c = daemon.connect()
    live = ask(c, "POST", "/v1/renders", {"mode": "live", "graph": GRAPH, "stage": "shaderball", "resolution": [256, 256], "max_samples": 4096})["id"]
    pictures = Pictures(daemon, live)
    while pictures.count < 8:
        time.sleep(0.05)
    results, first, full, remix = {}, [], [], []
    for i in range(a.edits):
        start = time.perf_counter()
        ask(c, "PATCH", f"/v1/renders/{live}/graph", {"nodes": {"s": {"params": {"specular1Roughness": 0.1 + 0.8 * i / a.edits}}}},
            {"If-Match": "*", "Alder-Edit-Id": f"p{i}"})
        first.append(pictures.wait(pictures.seen, f"p{i}") - start)
        full.append(pictures.wait(pictures.full, f"p{i}") - start)
        time.sleep(0.02)
    results["edit_to_first_picture"] = figures(first)
    results["edit_to_full_resolution"] = figures(full)
    for i in range(a.edits):
        start = time.perf_counter()
        ask(c, "PATCH", f"/v1/renders/{live}", {"mix": {"1": {"intensity": 0.5 + i / a.edits}}}, {"Alder-Edit-Id": f"m{i}"})
        remix.append(pictures.wait(pictures.seen, f"m{i}") - start)
    results["remix_to_picture"] = figures(remix)

    def timed(path, n=300):
        d, out = daemon.connect(), []
        for _ in range(n):
            start = time.perf_counter()
            ask(d, "GET", path)
            out.append(time.perf_counter() - start)
            time.sleep(0.002)
        return figures(out)

    results["livez_while_rendering"] = timed("/livez")
    results["document_while_rendering"] = timed(f"/v1/renders/{live}")
    before, streams = daemon.memory_mib(), []
    for _ in range(a.streams):
        d = daemon.connect()
        d.request("GET", f"/v1/renders/{live}/events")
        streams.append((d, d.getresponse()))
    ask(c, "PATCH", f"/v1/renders/{live}/graph", {"nodes": {"s": {"params": {"specular1Roughness": 0.95}}}}, {"If-Match": "*", "Alder-Edit-Id": "last"})
    start, reached = time.perf_counter(), 0
    for _, answer in streams:
        while True:
            line = answer.readline()
            if not line:
                break
            if b'"last"' in line:
                reached += 1
                break
    results["event_streams"] = {"open": len(streams), "told_of_an_edit": reached, "seconds": round(time.perf_counter() - start, 3),
                                "memory_mib_before": round(before), "memory_mib": round(daemon.memory_mib())}
    results["livez_with_streams"] = timed("/livez")
    daemon.stop()
    for name, value in results.items():
        print(f"{name:28} {json.dumps(value)}")
    if a.json:
        with open(a.json, "w") as f:
            json.dump(results, f, indent=1)


if __name__ == "__main__":
    main()
