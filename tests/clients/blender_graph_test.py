"""The Blender exporter's pure parts: node trees (mocked) as graph documents, and the container. Nothing here needs Blender."""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from types import SimpleNamespace

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "blender"))

from alder_blender.graph import GraphWriter, output_node  # noqa: E402
from alder_blender.report import Report  # noqa: E402
from alder_blender.values import number, random_id  # noqa: E402
from blender_mock import RGBA, SHADER, VALUE, VECTOR, Socket, Tree  # noqa: E402

ALDER = os.path.join(os.environ.get("ALDER_BINARY_DIR") or os.path.join(HERE, "..", "..", "build"), "alder")


def write(tree, kind="material", **more):
    report = Report()
    graph, linked = GraphWriter(report, **more).document(tree, kind, "test")
    return graph, linked, report


def accepted(test, graph):
    """Alder reads the graph without a fault."""
    if not os.path.exists(ALDER):
        test.skipTest("no alder in the build folder")
    run = subprocess.run([ALDER, "validate", "-"], input=json.dumps(graph), capture_output=True, text=True, timeout=60)
    test.assertEqual(run.returncode, 0, run.stdout + run.stderr)


class Graphs(unittest.TestCase):
    def setUp(self):
        self.tree = Tree()
        self.out = self.tree.output()
        self.bsdf = self.tree.diffuse()
        self.tree.link(self.bsdf, "BSDF", self.out, "Surface")

    def test_sockets_by_identifier_and_only_what_somebody_set(self):
        graph, _, report = write(self.tree)
        self.assertEqual(graph, {"version": 1, "nodes": {"Diffuse BSDF": {"type": "ShaderNodeBsdfDiffuse", "params": {"Color": [0.8, 0.7, 0.6, 1.0], "Roughness": 0.0}}},
                                 "outputs": {"surface": {"node": "Diffuse BSDF", "output": "BSDF"}}})
        self.assertFalse(report)
        accepted(self, graph)

    def test_settings_links_and_constants_on_outputs(self):
        math = self.tree.add("Math", "ShaderNodeMath", [Socket("Value", VALUE, 0.5), Socket("Value_001", VALUE, 2.0), Socket("Value_002", VALUE, 9.0, enabled=False)],
                             [Socket("Value", VALUE, 0.0)], operation=("ENUM", "MULTIPLY"), use_clamp=("BOOLEAN", True))
        self.tree.link(self.tree.value(0.25), "Value", math, "Value")
        self.tree.link(math, "Value", self.bsdf, "Roughness")
        graph, _, _ = write(self.tree)
        self.assertEqual(graph["nodes"]["Math"], {"type": "ShaderNodeMath", "params": {"operation": "MULTIPLY", "use_clamp": True,
                                                                                       "Value": {"node": "Value", "output": "Value"}, "Value_001": 2.0}})
        self.assertEqual(graph["nodes"]["Value"]["params"], {"Value": 0.25})
        self.assertEqual(graph["nodes"]["Diffuse BSDF"]["params"]["Roughness"], {"node": "Math", "output": "Value"})
        accepted(self, graph)

    def test_what_nothing_uses_is_left_out(self):
        self.tree.value(3, "lonely")
        self.assertEqual(list(write(self.tree)[0]["nodes"]), ["Diffuse BSDF"])

    def test_reroutes_and_muted_nodes_are_passed_through(self):
        gamma = self.tree.add("Gamma", "ShaderNodeGamma", [Socket("Color", RGBA, [1, 0, 0, 1]), Socket("Gamma", VALUE, 2.0)], [Socket("Color", RGBA, [0, 0, 0, 1])])
        gamma.mute = True
        gamma.internal_links = [SimpleNamespace(from_socket=gamma.inputs[0], to_socket=gamma.outputs[0])]
        first, second = self.tree.reroute("a", RGBA), self.tree.reroute("b", RGBA)
        self.tree.link(gamma, "Color", first, "Input")
        self.tree.link(first, "Output", second, "Input")
        self.tree.link(second, "Output", self.bsdf, "Color")
        graph, _, _ = write(self.tree)
        self.assertEqual(graph["nodes"]["Diffuse BSDF"]["params"]["Color"], [1, 0, 0, 1], "the muted node passes its constant on")
        rgb = self.tree.add("RGB", "ShaderNodeRGB", [], [Socket("Color", RGBA, [0, 1, 0, 1])])
        self.tree.link(rgb, "Color", gamma, "Color")
        graph, _, _ = write(self.tree)
        self.assertEqual(graph["nodes"]["Diffuse BSDF"]["params"]["Color"], {"node": "RGB", "output": "Color"})
        self.assertEqual(sorted(graph["nodes"]), ["Diffuse BSDF", "RGB"])

    def test_muted_links_and_circles_of_reroutes_are_no_links(self):
        self.tree.link(self.tree.value(1.0), "Value", self.bsdf, "Roughness", muted=True)
        a, b = self.tree.reroute("a", RGBA), self.tree.reroute("b", RGBA)
        self.tree.link(a, "Output", b, "Input")
        self.tree.link(b, "Output", a, "Input")
        self.tree.link(a, "Output", self.bsdf, "Color")
        params = write(self.tree)[0]["nodes"]["Diffuse BSDF"]["params"]
        self.assertEqual(params, {"Color": [0.8, 0.7, 0.6, 1.0], "Roughness": 0.0})

    def test_a_colour_in_place_of_a_shader_shines(self):
        tree = Tree()
        out, rgb = tree.output(), tree.add("RGB", "ShaderNodeRGB", [], [Socket("Color", RGBA, [0, 1, 0, 1])])
        tree.link(rgb, "Color", out, "Surface")
        graph, _, _ = write(tree)
        node = graph["nodes"][graph["outputs"]["surface"]["node"]]
        self.assertEqual(node, {"type": "ShaderNodeEmission", "params": {"Color": {"node": "RGB", "output": "Color"}, "Strength": 1.0}})
        accepted(self, graph)

    def test_volumes_are_outputs(self):
        scatter = self.tree.add("Scatter", "ShaderNodeVolumeScatter", [Socket("Density", VALUE, 1.0)], [Socket("Volume", SHADER)])
        self.tree.link(scatter, "Volume", self.out, "Volume")
        graph, linked, _ = write(self.tree)
        self.assertIn("Volume", linked)
        self.assertEqual(graph["nodes"]["Scatter"]["type"], "ShaderNodeVolumeScatter")
        self.assertEqual(graph["outputs"]["volume"], {"node": "Scatter", "output": "Volume"})

    def test_nodes_that_no_document_can_hold_are_reported(self):
        script = self.tree.add("Script", "ShaderNodeScript", [], [Socket("Color", RGBA, [0, 0, 0, 1])])
        self.tree.link(script, "Color", self.bsdf, "Color")
        graph, _, report = write(self.tree)
        self.assertEqual(graph["nodes"]["Diffuse BSDF"]["params"]["Color"], [0.8, 0.7, 0.6, 1.0])
        self.assertEqual(report.lines(), ["not exported: node ShaderNodeScript: OSL scripts (test/Script)"])

    def test_the_output_for_cycles_goes_first(self):
        tree = Tree()
        for name, target, active in (("all", "ALL", True), ("cycles", "CYCLES", False), ("eevee", "EEVEE", True)):
            tree.output(name, target=target, active=active)
        self.assertEqual(output_node(tree, "ShaderNodeOutputMaterial").name, "cycles")
        self.assertIsNone(output_node(Tree(), "ShaderNodeOutputMaterial"))

    def test_ramps_curves_and_placements(self):
        ramp = SimpleNamespace(color_mode="HSV", interpolation="EASE", hue_interpolation="CW",
                               elements=[SimpleNamespace(position=0.1, color=[0, 0, 0, 1]), SimpleNamespace(position=0.9, color=[1, 0.5, 0, 1])])
        placed = SimpleNamespace(vector_type="POINT", translation=[1, 2, 3], rotation=[0, 0, 0], scale=[1, 1, 1], mapping_x="X", mapping_y="Y", mapping_z="Z")
        same = SimpleNamespace(**{**vars(placed), "translation": [0, 0, 0]})
        mapping = SimpleNamespace(extend="HORIZONTAL", use_clip=True, clip_min_x=0.0, clip_min_y=0.0, clip_max_x=1.0, clip_max_y=1.0, black_level=[0, 0, 0],
                                  white_level=[1, 1, 1], curves=[SimpleNamespace(points=[SimpleNamespace(location=[0, 0], handle_type="AUTO"),
                                                                                         SimpleNamespace(location=[1, 0.5], handle_type="VECTOR")])])
        noise = self.tree.add("Noise", "ShaderNodeTexNoise", [Socket("Vector", VECTOR, [0, 0, 0], hide_value=True), Socket("Scale", VALUE, 3.0)],
                              [Socket("Fac", VALUE, 0.0)], texture_mapping=("POINTER", placed))
        curve = self.tree.add("Curve", "ShaderNodeFloatCurve", [Socket("Factor", VALUE, 1.0), Socket("Value", VALUE, 1.0)], [Socket("Value", VALUE, 0.0)],
                              mapping=("POINTER", mapping))
        node = self.tree.add("Ramp", "ShaderNodeValToRGB", [Socket("Fac", VALUE, 0.5)], [Socket("Color", RGBA, [0, 0, 0, 1])], color_ramp=("POINTER", ramp))
        self.tree.link(noise, "Fac", curve, "Value")
        self.tree.link(curve, "Value", node, "Fac")
        self.tree.link(node, "Color", self.bsdf, "Color")
        graph, _, report = write(self.tree)
        self.assertEqual(graph["nodes"]["Noise"]["params"]["texture_mapping"]["translation"], [1, 2, 3])
        self.assertNotIn("Vector", graph["nodes"]["Noise"]["params"])
        self.assertEqual(graph["nodes"]["Ramp"]["params"]["color_ramp"]["elements"][1], {"position": 0.9, "color": [1, 0.5, 0, 1]})
        self.assertEqual(graph["nodes"]["Curve"]["params"]["mapping"]["curves"][0][1], {"location": [1, 0.5], "handle_type": "VECTOR"})
        self.assertFalse(report)
        accepted(self, graph)
        noise.texture_mapping = same
        self.assertNotIn("texture_mapping", write(self.tree)[0]["nodes"]["Noise"]["params"])

    def test_numbers_that_json_cannot_hold(self):
        self.assertEqual([number(x) for x in (float("nan"), float("inf"), -float("inf"), 0.1, 3, True)], ["nan", "inf", "-inf", 0.1, 3, True])

    def test_random_numbers_of_objects_are_cycles(self):
        # Object Info's Random as Cycles 4.5 renders it for objects of these names.
        for name, random in (("box", 0.7685173153877258), ("Suzanne.001", 0.45797663927078247), ("W\u00fcrfel", 0.570206880569458)):
            self.assertAlmostEqual(random_id(name) / 0xffffffff, random, 6, name)


class Groups(unittest.TestCase):
    def group(self, name):
        """twice(Fac) = Fac * 2"""
        g = Tree(name)
        into = g.add("Group Input", "NodeGroupInput", [], [Socket("Socket_1", VALUE, 0.5)])
        math = g.add("Math", "ShaderNodeMath", [Socket("Value", VALUE, 0.5), Socket("Value_001", VALUE, 2.0)], [Socket("Value", VALUE, 0.0)], operation=("ENUM", "MULTIPLY"))
        out = g.add("Group Output", "NodeGroupOutput", [Socket("Socket_0", VALUE, 0.0)])
        out.is_active_output = True
        g.link(into, "Socket_1", math, "Value")
        g.link(math, "Value", out, "Socket_0")
        return g

    def use(self, tree, name, group):
        return tree.add(name, "ShaderNodeGroup", [Socket("Socket_1", VALUE, 0.125)], [Socket("Socket_0", VALUE, 0.0)], node_tree=("POINTER", group))

    def test_one_definition_many_uses_nested(self):
        inner = self.group("inner")
        outer = self.group("outer")
        nested = self.use(outer, "Nested", inner)
        outer.links[-1].from_node, outer.links[-1].from_socket = nested, nested.outputs[0]
        tree = Tree()
        out, bsdf = tree.output(), tree.diffuse()
        a, b, c = self.use(tree, "a", outer), self.use(tree, "b", outer), self.use(tree, "c", inner)
        tree.link(bsdf, "BSDF", out, "Surface")
        tree.link(a, "Socket_0", b, "Socket_1")
        tree.link(b, "Socket_0", c, "Socket_1")
        tree.link(c, "Socket_0", bsdf, "Roughness")
        graph, _, report = write(tree)
        self.assertFalse(report)
        self.assertEqual(sorted(graph["groups"]), ["inner", "outer"])
        self.assertEqual(graph["nodes"]["a"], {"type": "ShaderNodeGroup", "group": "outer", "params": {"Socket_1": 0.125}})
        self.assertEqual(graph["groups"]["inner"]["inputs"], {"Socket_1": {"type": "NodeSocketFloat", "default": 0.5}})
        self.assertEqual(graph["groups"]["inner"]["nodes"]["Group Output"]["params"], {"Socket_0": {"node": "Math", "output": "Value"}})
        self.assertEqual(graph["groups"]["outer"]["nodes"]["Nested"]["group"], "inner")
        accepted(self, graph)

    def test_a_group_without_tree_is_reported(self):
        tree = Tree()
        out, bsdf = tree.output(), tree.diffuse()
        tree.link(bsdf, "BSDF", out, "Surface")
        tree.link(self.use(tree, "lost", None), "Socket_0", bsdf, "Roughness")
        graph, _, report = write(tree)
        self.assertEqual(list(graph["nodes"]), ["Diffuse BSDF"])
        self.assertTrue(report)


class Containers(unittest.TestCase):
    def test_arrays_and_files_come_back(self):
        try:
            import numpy as np
        except ImportError:
            self.skipTest("no numpy")
        import zipfile

        from alder_blender.container import Container
        box = Container()
        a = box.array(np.arange(6, dtype=np.float32), 3)
        b = box.array(np.arange(5, dtype=np.uint8), 1)
        c = box.array(np.array([[7, 8, 9]], np.uint32), 3)
        box.file("images/x.png", b"pixels")
        with tempfile.TemporaryDirectory() as folder:
            first, second = os.path.join(folder, "1.alder"), os.path.join(folder, "2.alder")
            box.write(first, {"alder_scene": 1})
            box.write(second, {"alder_scene": 1})
            with open(first, "rb") as f, open(second, "rb") as g:
                self.assertEqual(f.read(), g.read(), "equal scenes are equal files")
            with zipfile.ZipFile(first) as z:
                self.assertEqual(json.loads(z.read("scene.json")), {"alder_scene": 1})
                self.assertEqual(z.read("images/x.png"), b"pixels")
                data = z.read("geometry.bin")
        self.assertEqual((a["type"], a["count"], b["type"], b["count"], c["count"]), ("f32", 2, "u8", 5, 1))
        self.assertEqual(np.frombuffer(data, "<f4", 6, a["offset"]).tolist(), [0, 1, 2, 3, 4, 5])
        self.assertEqual(np.frombuffer(data, "u1", 5, b["offset"]).tolist(), [0, 1, 2, 3, 4])
        self.assertEqual(np.frombuffer(data, "<u4", 3, c["offset"]).tolist(), [7, 8, 9])


if __name__ == "__main__":
    unittest.main()
