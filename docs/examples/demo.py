"""The demonstration behind ./dev demo: one network through the daemon to a multi-layer EXR and a PNG."""
import argparse
import json
import pathlib
import sys
import time

from daemon import Daemon

EXAMPLES = pathlib.Path(__file__).resolve().parent


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default="build")
    parser.add_argument("--output", default="demo-output")
    parser.add_argument("--graph", default=str(EXAMPLES / "weathered_paint.graph.json"))
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--samples", type=int, default=64)
    args = parser.parse_args()
    output = pathlib.Path(args.output)
    output.mkdir(parents=True, exist_ok=True)
    graph = json.loads(pathlib.Path(args.graph).read_text())
    request = {"graph": graph, "stage": "shaderball", "size": args.size, "samples": args.samples, "seed": 1,
               "aovs": ["shading", "data", "light_groups"] + sorted(graph["outputs"].get("aovs", {}))}

    with Daemon(args.build) as daemon:
        status, _, body = daemon.ask("POST", "/v1/graphs/validate", {"graph": graph})
        report = json.loads(body)
        if status != 200 or not report["ok"]:
            print(json.dumps(report, indent=1), file=sys.stderr)
            return 2
        for name, kind in (("shaderball.exr", "image/x-exr"), ("shaderball.png", "image/png")):
            start = time.perf_counter()
            status, headers, body = daemon.ask("POST", "/v1/preview", request, {"Accept": kind})
            seconds = time.perf_counter() - start
            if status != 200:
                print(body.decode(errors="replace"), file=sys.stderr)
                return 3
            (output / name).write_bytes(body)
            print("%s: %d bytes, %.2f s (%s)" % ((output / name).resolve(), len(body), seconds, headers["Server-Timing"]))
        status, _, body = daemon.ask("POST", "/v1/preview", dict(request, samples=1, size=64), {"Accept": "application/json"})
        answer = json.loads(body)
    compiled = report["compiled"]
    print("graph: %d nodes, %d live, %d instructions, %d values folded" %
          (compiled["nodes"], compiled["live_nodes"], compiled["instructions"], compiled["constant_folded"]))
    skipped = compiled["pruned"]
    print("skipped: %s" % ("; ".join(skipped) if skipped else "nothing"))
    stats = answer["stats"]
    evaluations, left_out = stats["node_evaluations"], stats["node_evaluations_skipped"]
    print("evaluations at shading points: %d made, %d skipped because no point of the batch needed them" % (evaluations, left_out))
    print("layers: " + " ".join(answer["layers"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
