"""The commands of docs/graphs.md run, and what the text says of their output is so. Also: alder graph on the benchmark graphs."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
ALDER = str(BUILD / "alder")
TEXT = (ROOT / "docs" / "graphs.md").read_text()
EXAMPLE = "docs/examples/groups.graph.json"


def graph(*arguments, stdin=None):
    return subprocess.run([ALDER, "graph", *arguments], input=stdin, cwd=ROOT, capture_output=True, text=True, timeout=60)


class Graphs(unittest.TestCase):
    def test_every_command_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(ROOT / "docs", os.path.join(folder, "docs"))
            os.symlink(BUILD, os.path.join(folder, "build"))
            script = "\n".join(re.findall(r"^```sh\n(.*?)^```", TEXT, re.M | re.S))
            run = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(pathlib.Path(folder, "graph.dot").read_text().startswith("digraph"))

    def test_documents_in_the_text_compile(self):
        for block in re.findall(r"^```json\n(.*?)^```", TEXT, re.M | re.S):
            request = {"graph": json.loads(block), "points": {"count": 2, "attributes": {"wear": [1.5, 2]}}, "outputs": ["b.y"]}
            run = subprocess.run([ALDER, "eval", "-"], input=json.dumps(request), capture_output=True, text=True)
            self.assertEqual(json.loads(run.stdout)["outputs"]["b.y"], [6.0, 8.0], run.stderr)

    def test_each_fate_is_told(self):
        text = graph(EXAMPLE, "--dump").stdout
        nodes = text[text.index("\nnodes\n"):text.index("\nvarying")]
        for line in ("  run\n", "  folded to constants\n    gain: folded to a constant: 0.75\n", "  switched off\n    coarse/cells: off.B_Float: not selected\n" if "coarse/cells: off" in nodes else "  never asked for\n",
                     "fine/cells: nothing asked for needs it\n", "position: passes a value of the point"):
            self.assertIn(line, nodes)
        program = text[text.index("\nprogram\n"):]
        self.assertEqual(program.count("= ShaderNodeTexNoise(P.xyz"), 2, text)
        self.assertNotIn("Voronoi", program)
        self.assertRegex(program, r"= ShaderNodeMath\(r\d+, (1, )?0\.5.*\)  # fine/contrast")
        self.assertRegex(program, r"lobe beckmann of surface: r\d")
        self.assertEqual(graph(EXAMPLE).stdout, text, "the default, and the same each time")

    def test_one_output_is_the_program_for_it_alone(self):
        text = graph(EXAMPLE, "--output", "coarse.Cells").stdout
        self.assertIn("= ShaderNodeTexVoronoi(", text)
        self.assertNotIn("= ShaderNodeTexNoise(", text)
        self.assertEqual(graph(EXAMPLE, "--output", "coarse.Cell").returncode, 2)
        self.assertEqual(graph(EXAMPLE, "--output", "coarse.Cells", "--ray", "shadow").returncode, 2)
        self.assertEqual(graph("-", stdin='{"nodes": {}}').returncode, 2)

    def test_lazy_regions_and_merged_nodes_show(self):
        noise = {"type": "ShaderNodeTexNoise", "params": {"Scale": 3.0, "Vector": {"attribute": "v"}}}
        document = {"nodes": {"n1": noise, "n2": noise,
                              "m": {"type": "ShaderNodeMix", "params": {"data_type": "FLOAT", "Factor_Float": {"attribute": "f"}, "A_Float": 0.5, "B_Float": {"node": "n1", "output": "Fac"}}},
                              "s": {"type": "ShaderNodeMath", "params": {"operation": "ADD", "Value": {"node": "m", "output": "Result_Float"}, "Value_001": {"node": "n3", "output": "Color"}}},
                              "n3": {"type": "ShaderNodeTexVoronoi", "params": {"Vector": {"attribute": "v"}}}}}
        text = graph("-", "--output", "m.Result_Float", stdin=json.dumps(document)).stdout
        self.assertRegex(text, r"only where r\d+ != 0 \(points gathered\):\n    r\d+ = ShaderNodeTexNoise\(attribute:v")
        document["nodes"]["m"]["params"]["A_Float"] = {"node": "n2", "output": "Fac"}
        text = graph("-", "--output", "m.Result_Float", stdin=json.dumps(document)).stdout
        self.assertRegex(text, r"  merged with an equal node\n    n[12]: merged: computes what n[12] computes")

    def test_the_drawing_is_whole(self):
        for file in [EXAMPLE, *sorted(str(p) for p in (ROOT / "tests/data/graph_bench").glob("*.graph.json"))]:
            dot = graph(file, "--dot").stdout
            self.assertEqual(dot.count("{"), dot.count("}"), file)
            declared = set(re.findall(r"^ *([nif]\d+) \[", dot, re.M))
            used = set(re.findall(r"([nif]\d+) -> ", dot)) | set(re.findall(r" -> ([nif]\d+)", dot))
            self.assertEqual(used - declared, set(), file)
            document = json.loads((ROOT / file).read_text())
            for name in document["nodes"]:
                self.assertIn('"%s\\n' % name, dot)
            self.assertIn("fillcolor=palegreen", dot)


if __name__ == "__main__":
    unittest.main()
