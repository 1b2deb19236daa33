"""Run by a Python with bpy: a graph document for each shader node there is, as the exporter writes it.

    python3 blender_nodes.py OUT.json
"""
import json
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "blender"))

import bpy  # noqa: E402
from alder_blender.graph import REFUSED, GraphWriter  # noqa: E402
from alder_blender.report import Report  # noqa: E402

LAYOUT = {"ShaderNodeGroup", "ShaderNodeTree"}


def main():
    graphs = {}
    for name in sorted(n for n in dir(bpy.types) if n.startswith("ShaderNode") and n not in LAYOUT and n not in REFUSED):
        tree = bpy.data.node_groups.new("t", "ShaderNodeTree")
        try:
            node = tree.nodes.new(name)
        except RuntimeError:
            continue   # a base class, or a node of another renderer's
        if name.startswith("ShaderNodeOutput") or not any(s.enabled for s in node.outputs):
            continue
        out = tree.nodes.new("ShaderNodeOutputMaterial")
        output = next(s for s in node.outputs if s.enabled)
        tree.links.new(output, out.inputs["Volume" if output.identifier == "Volume" else "Surface"])
        report = Report()
        graph, _ = GraphWriter(report, version=bpy.app.version[:2] if bpy.app.version < (4, 5) else None).document(tree, "material", name)
        graphs[name] = {"graph": graph, "told": report.lines()}
    with open(sys.argv[1], "w") as f:
        json.dump(graphs, f)


if __name__ == "__main__":
    main()
