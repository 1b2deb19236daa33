"""Points per second of Alder's evaluator beside Cycles' SVM: the same graphs, one thread, the same processor, one run.

    python3 -m venv /tmp/bpy && /tmp/bpy/bin/pip install bpy==4.5.*        # Blender as a Python module; needs Python 3.11
    python3 tests/bench/cycles_svm.py --python /tmp/bpy/bin/python          # or: ALDER_BPY_PYTHON=/tmp/bpy/bin/python

Cycles renders a plane that fills the picture, each sample one shading point: no bounces, no lights. A figure is the difference of two
renders that differ in samples only, less the same for a constant colour (ray, intersection, film); Alder's is the difference of two
runs of `alder eval` that differ in repetitions only. Both are processor time, so that other programs disturb little, and the
smallest of several rounds, taken in turn.
"""
import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
GRAPHS = ("noise", "noise_fac", "graph30")
SIZE = 512


def processor_seconds(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


# ---- Cycles: runs inside a Python that has bpy -------------------------------------------------------------------------

def build_nodes(tree, graph):
    """The graph document as Blender nodes: properties by RNA name, sockets by identifier."""
    made = {}
    for name, node in graph["nodes"].items():
        made[name] = tree.nodes.new(node["type"])
    for name, node in graph["nodes"].items():
        target = made[name]
        properties = {p.identifier for p in target.bl_rna.properties}
        values = [(k, v) for k, v in node["params"].items() if not (isinstance(v, dict) and "node" in v)]
        for key, value in sorted(values, key=lambda kv: kv[0] not in properties):  # properties decide which sockets there are
            if key == "color_ramp":
                ramp = target.color_ramp
                ramp.color_mode, ramp.interpolation, ramp.hue_interpolation = value["color_mode"], value["interpolation"], value["hue_interpolation"]
                while len(ramp.elements) < len(value["elements"]):
                    ramp.elements.new(0.5)
                for element, e in zip(ramp.elements, value["elements"]):
                    element.position, element.color = e["position"], e["color"]
            elif key in properties:
                setattr(target, key, value)
            else:
                socket = next(s for s in target.inputs if s.identifier == key)
                socket.default_value = value if not isinstance(value, list) or len(socket.default_value) == len(value) else value + [1.0]
    for name, node in graph["nodes"].items():
        for key, value in node["params"].items():
            if isinstance(value, dict) and "node" in value:
                source = next(s for s in made[value["node"]].outputs if s.identifier == value["output"] or s.name == value["output"] and s.enabled)
                tree.links.new(source, next(s for s in made[name].inputs if s.identifier == key))
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(made[graph["outputs"]["surface"]["node"]].outputs[0], output.inputs["Surface"])


def measure_cycles(graph_file, few, many):
    """Prints processor nanoseconds a sample, by the difference of two renders."""
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=2)
    material = bpy.data.materials.new("m")
    material.use_nodes = True
    material.node_tree.nodes.clear()
    build_nodes(material.node_tree, json.loads(pathlib.Path(graph_file).read_text()))
    material.cycles.emission_sampling = "NONE"
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.cameras.new("c")
    camera.type, camera.ortho_scale = "ORTHO", 2
    scene.camera = bpy.data.objects.new("c", camera)
    scene.camera.location = (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.device, c.shading_system = "CPU", False
    c.use_adaptive_sampling, c.use_denoising, c.use_light_tree = False, False, False
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.volume_bounces = c.transparent_max_bounces = 0
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    seconds = []
    for samples in (1, few, many):  # the first one warms up
        c.samples = samples
        start = processor_seconds(resource.RUSAGE_SELF)
        bpy.ops.render.render()
        seconds.append(processor_seconds(resource.RUSAGE_SELF) - start)
    print("cycles-ns %.9g" % ((seconds[2] - seconds[1]) / (SIZE * SIZE * (many - few)) * 1e9))


# ---- Alder and the comparison ------------------------------------------------------------------------------------------

def cycles_ns(python, graph_file, few, many):
    run = subprocess.run([python, __file__, "--measure", graph_file, "--samples", str(few), str(many)], capture_output=True, text=True)
    line = [l for l in run.stdout.splitlines() if l.startswith("cycles-ns ")]
    if run.returncode or not line:
        raise SystemExit("%s: Cycles could not be measured:\n%s" % (python, (run.stdout + run.stderr)[-1500:]))
    return float(line[0].split()[1])


def alder_ns(alder, request_file, points, isa, repeat):
    seconds = []
    for count in (1, 1 + repeat):
        start = processor_seconds(resource.RUSAGE_CHILDREN)
        subprocess.run([alder, "eval", request_file, "--threads", "1", "--repeat", str(count), "--isa", isa], check=True, stdout=subprocess.DEVNULL)
        seconds.append(processor_seconds(resource.RUSAGE_CHILDREN) - start)
    return (seconds[1] - seconds[0]) / (repeat * points) * 1e9


def available(alder, isa, request_file):
    return subprocess.run([alder, "eval", request_file, "--isa", isa], capture_output=True).returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=os.environ.get("ALDER_BPY_PYTHON"), help="a Python that has bpy 4.5")
    parser.add_argument("--build", default=str(ROOT / "build"))
    parser.add_argument("--graphs", default=str(ROOT / "tests/data/graph_bench"))
    parser.add_argument("--isa", action="append", choices=["scalar", "sse4", "avx2", "avx512"], help="only this one; default: sse4, avx2, avx512")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", help="write the figures here too")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    parser.add_argument("--samples", type=int, nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        return measure_cycles(args.measure, *args.samples)
    if not args.python:
        parser.error("--python (or ALDER_BPY_PYTHON) names a Python 3.11 that has bpy: python3 -m venv D && D/bin/pip install 'bpy==4.5.*'")
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core for all that is measured
    alder = str(pathlib.Path(args.build) / "alder")
    points, state = 16384, 1
    with tempfile.TemporaryDirectory() as folder:
        positions = []
        for _ in range(points):
            xyz = []
            for _ in range(2):
                state = (state * 1664525 + 1013904223) & 0xFFFFFFFF
                xyz.append((state >> 8) / (1 << 24) * 2 - 1)
            positions.append(xyz + [0.0])
        # Cycles shades neighbours together too: pixels of a tile in order.
        positions.sort(key=lambda p: (int(p[1] * 32), int(p[0] * 32)))
        constant = {"nodes": {"emission": {"type": "ShaderNodeEmission", "params": {"Color": [0.5, 0.25, 0.125, 1.0], "Strength": 1.0}}}, "outputs": {"surface": {"node": "emission", "output": "Emission"}}}
        files = {"constant": os.path.join(folder, "constant.json")}
        pathlib.Path(files["constant"]).write_text(json.dumps(constant))
        requests = {}
        for name in GRAPHS:
            files[name] = str(pathlib.Path(args.graphs) / (name + ".graph.json"))
            graph = json.loads(pathlib.Path(files[name]).read_text())
            color = graph["outputs"]["aovs"]["color"]
            requests[name] = os.path.join(folder, name + ".request.json")
            pathlib.Path(requests[name]).write_text(json.dumps({"graph": graph, "points": {"count": points, "P": positions}, "outputs": [color["node"] + "." + color["output"]]}))
        isas = [i for i in args.isa or ("sse4", "avx2", "avx512") if available(alder, i, requests["noise"])]
        samples = {"constant": (8, 72), "noise": (8, 40), "noise_fac": (8, 40), "graph30": (4, 20)}
        theirs, ours = {}, {}
        for _ in range(args.rounds):
            for name, file in files.items():
                theirs.setdefault(name, []).append(cycles_ns(args.python, file, *samples[name]))
            for name in GRAPHS:
                for isa in isas:
                    ours.setdefault((name, isa), []).append(alder_ns(alder, requests[name], points, isa, 60 if name == "graph30" else 100))
    figures = {"cycles_ns": {n: min(v) for n, v in theirs.items()}, "alder_ns": {}, "ratio": {}}
    base = min(theirs["constant"])
    print("%-10s %22s %s" % ("", "Cycles SVM ns/point", "".join("%24s" % i for i in isas)))
    for name in GRAPHS:
        cycles = min(theirs[name]) - base
        row = {i: min(ours[name, i]) for i in isas}
        figures["alder_ns"][name], figures["ratio"][name] = row, {i: cycles / ns for i, ns in row.items()}
        print("%-10s %22s %s" % (name, "%.0f (median %.0f)" % (cycles, statistics.median(theirs[name]) - statistics.median(theirs["constant"])),
                                "".join("%24s" % ("%.1f ns: %.1fx" % (ns, cycles / ns)) for ns in row.values())))
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    sys.exit(main())
