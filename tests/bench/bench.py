"""The figures behind ./dev bench: latencies of the daemon, compile times, points per second. Medians on this machine."""
import argparse
import http.client
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "examples"))
from daemon import Daemon  # noqa: E402


def percentile(values, fraction):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(fraction * len(ordered)))]


def timing_parts(header):
    return {name: float(ms) for name, ms in re.findall(r"(\w+);dur=([\d.]+)", header or "")}


def preview_latency(daemon, graph, samples, kind, count):
    """Warm previews over one connection. The seed changes, so that nothing comes from the result cache."""
    connection = http.client.HTTPConnection(daemon.address)
    total, parts = [], {}
    for i in range(count + 2):
        body = json.dumps({"graph": graph, "size": 256, "samples": samples, "seed": i})
        start = time.perf_counter()
        connection.request("POST", "/v1/preview", body, {"Content-Type": "application/json", "Accept": kind})
        answer = connection.getresponse()
        data = answer.read()
        seconds = time.perf_counter() - start
        if answer.status != 200:
            raise SystemExit("preview: %d %s" % (answer.status, data[:300]))
        if i >= 2:
            total.append(seconds * 1e3)
            for name, ms in timing_parts(answer.headers["Server-Timing"]).items():
                parts.setdefault(name, []).append(ms)
    split = ", ".join("%s %.1f" % (name, statistics.median(ms)) for name, ms in parts.items())
    label = "preview 256x256, %d spp, %s" % (samples, kind.split("/")[1].replace("x-", ""))
    print("%-44s %8.1f ms   p95 %.1f   (%s)" % (label, statistics.median(total), percentile(total, 0.95), split))
    return {"median_ms": statistics.median(total), "p95_ms": percentile(total, 0.95), "split_ms": {n: statistics.median(m) for n, m in parts.items()}}


def start_figures(build, graph, count):
    live, first = [], []
    for _ in range(count):
        with Daemon(build) as daemon:
            status, _, _ = daemon.ask("GET", "/livez")
            live.append((time.perf_counter() - daemon.started) * 1e3)
            assert status == 200
        with Daemon(build) as daemon:
            status, _, body = daemon.ask("POST", "/v1/preview", {"graph": graph, "size": 256, "samples": 1}, {"Accept": "image/png"})
            if status != 200:
                raise SystemExit("preview: %d %s" % (status, body[:300]))
            first.append((time.perf_counter() - daemon.started) * 1e3)
    print("%-44s %8.1f ms   p95 %.1f" % ("alderd start -> /livez", statistics.median(live), percentile(live, 0.95)))
    print("%-44s %8.1f ms   p95 %.1f" % ("alderd start -> first preview, whole", statistics.median(first), percentile(first, 0.95)))
    return {"start_to_livez_ms": statistics.median(live), "start_to_first_preview_ms": statistics.median(first)}


def livez_under_load(build, graph, count):
    """/livez while all processors render."""
    with Daemon(build) as daemon:
        import threading
        stop = threading.Event()

        def load():
            seed = 0
            while not stop.is_set():
                seed += 1
                daemon.ask("POST", "/v1/preview", {"graph": graph, "size": 512, "samples": 16, "seed": seed}, {"Accept": "image/x-exr"})

        worker = threading.Thread(target=load)
        worker.start()
        time.sleep(0.5)
        connection, times = http.client.HTTPConnection(daemon.address), []
        for _ in range(count):
            start = time.perf_counter()
            connection.request("GET", "/livez")
            connection.getresponse().read()
            times.append((time.perf_counter() - start) * 1e3)
            time.sleep(0.01)
        stop.set()
        worker.join()
    print("%-44s %8.2f ms   p99 %.2f" % ("/livez while rendering", statistics.median(times), percentile(times, 0.99)))
    return {"livez_under_load_median_ms": statistics.median(times), "livez_under_load_p99_ms": percentile(times, 0.99)}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default="build")
    parser.add_argument("--quick", action="store_true", help="fewer repetitions")
    parser.add_argument("--json", help="write the figures here too")
    args = parser.parse_args()
    graph = json.loads((ROOT / "docs/examples/weathered_paint.graph.json").read_text())
    figures = start_figures(args.build, graph, 3 if args.quick else 11)
    with Daemon(args.build) as daemon:
        figures["preview"] = {"%s@%d" % (kind, samples): preview_latency(daemon, graph, samples, kind, 5 if args.quick else 31)
                              for samples in (1, 16) for kind in ("image/png", "image/x-exr")}
    figures.update(livez_under_load(args.build, graph, 50 if args.quick else 300))
    command = [str(pathlib.Path(args.build) / "graph_bench"), str(ROOT / "tests/data/graph_bench")] + (["--quick"] if args.quick else [])
    figures["graph"] = graph_figures = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    print("%-44s %8.2f ms   (%d instructions)" % ("compile a graph of 200 nodes", graph_figures["compile_200_nodes_ms"], graph_figures["compile_200_nodes_instructions"]))
    print("%-44s %8.3f ms" % ("one constant changed, same program", graph_figures["edit_constant_ms"]))
    print("%-44s %8.2f ms" % ("one constant changed, compiled again", graph_figures["edit_recompile_ms"]))
    evaluator = graph_figures["evaluator"]
    print("%-44s %s" % ("compile, microseconds a node", "   ".join("%s nodes %.2f" % item for item in evaluator["compile_us_per_node"].items())))
    print("%-44s %8.3f" % ("10 nodes of 1,000 : the 10 alone", evaluator["ten_of_1000_nodes"]))
    print("%-44s %8.3f       (an index that varies: %.3f)" % ("switch : its selected branch alone", evaluator["constant_switch"], evaluator["varying_switch"]))
    print("%-44s %s" % ("mix, 0 at half of the points : at none", "   ".join("runs of %s %.3f" % item for item in evaluator["mix_half_zero"].items())))
    for name, by_isa in graph_figures["points_per_second"].items():
        scalar = by_isa["scalar"]
        print("%-44s %s" % ("points per second, one thread: " + name, "   ".join("%s %.2f M (%.1fx)" % (isa, rate / 1e6, rate / scalar) for isa, rate in by_isa.items())))
    if os.environ.get("ALDER_BPY_PYTHON"):
        subprocess.run([sys.executable, str(ROOT / "tests/bench/cycles_svm.py"), "--build", args.build], check=True)
    else:
        print("%-44s %s" % ("beside Cycles' SVM", "not run: ALDER_BPY_PYTHON names no Python with bpy (tests/bench/cycles_svm.py --help)"))
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
