"""Scenes from the XML of Cycles' stand-alone program: camera, shaders, meshes, transforms, lights; what is told; alder render."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ALDER = str(pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve() / "alder")
sys.path.insert(0, str(ROOT / "clients" / "cycles_xml"))
import cycles_scene  # noqa: E402

SCENE = """<cycles>
<camera width="32" height="20"/>
<transform translate="0 0 -4"><camera type="perspective" fov="1"/></transform>
<background><background name="bg" strength="2.0" color="0.2, 0.4, 0.6"/><connect from="bg background" to="output surface"/></background>
<shader name="red">
 <noise_texture name="tex" scale="2.0"/>
 <mix_closure name="mix"/>
 <diffuse_bsdf name="d" color="0.8, 0.1, 0.1"/>
 <glossy_bsdf name="g" distribution="beckmann" roughness="0.25"/>
 <connect from="tex fac" to="mix fac"/>
 <connect from="d bsdf" to="mix closure1"/>
 <connect from="g bsdf" to="mix closure2"/>
 <connect from="mix closure" to="output surface"/>
</shader>
<transform rotate="90 0 0 1"><transform translate="1 0 0" scale="2 2 2"><state shader="red" interpolation="smooth">
 <mesh name="quad" P="-1 1 0  1 1 0  1 -1 0  -1 -1 0" nverts="4" verts="0 1 2 3" UV="0 1 1 1 1 0 0 0"/>
</state></transform></transform>
<transform translate="0 3 0"><light light_type="point" strength="10 5 5" size="0.5"/></transform>
</cycles>"""


class CyclesXml(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.catalogue = cycles_scene.catalogue(ALDER)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def convert(self, text):
        path = self.folder / "s.xml"
        path.write_text(text)
        report = cycles_scene.Report()
        scene = cycles_scene.Converter(str(path), self.catalogue, report)
        scene.convert()
        return scene.document, list(report.lines())

    def test_everything_of_a_scene(self):
        d, lines = self.convert(SCENE)
        self.assertEqual(lines, [])
        self.assertEqual(d["settings"]["resolution"], [32, 20])
        camera = d["cameras"]["camera"]
        self.assertEqual([camera["transform"][k] for k in (3, 7, 11, 10)], [0, 0, -4, -1])
        self.assertAlmostEqual(camera["fov_degrees"], 82.31, 1)   # 2 atan(tan(0.5) * 1.6)
        nodes = d["materials"]["red"]["nodes"]
        self.assertEqual(nodes["mix"]["type"], "ShaderNodeMixShader")
        self.assertEqual(nodes["g"]["params"]["distribution"], "BECKMANN")
        self.assertEqual({k: v["node"] for k, v in nodes["mix"]["params"].items()}, {"Fac": "tex", "Shader": "d", "Shader_001": "g"})
        t = d["instances"]["quad"]["transform"]
        for got, want in zip(t[:12], (0, -2, 0, 0, 2, 0, 0, 1, 0, 0, 2, 0)):   # turned after moved and scaled
            self.assertAlmostEqual(got, want, 6)
        light = d["lights"]["light"]
        self.assertAlmostEqual(light["strength"], 40 * 3.14159265, 4)
        self.assertEqual((light["color"], light["radius"]), ([1, 0.5, 0.5], 0.5))

    def test_what_is_not_understood_is_told(self):
        _, lines = self.convert(SCENE.replace("</cycles>", '<hair name="h"/><include src="nowhere.xml"/></cycles>').replace('scale="2.0"/>', 'scale="2.0" shininess="3"/>'))
        for word in ("<hair>", "nowhere.xml", "shininess"):
            self.assertTrue(any(word in line for line in lines), lines)

    def test_faults(self):
        for text in (SCENE.replace("0 1 2 3", "0 1 2 9"), SCENE.replace("beckmann", "beckman"), SCENE[:200], "<scene/>", "<cycles/>", SCENE.replace("2.0", "two")):
            path = self.folder / "bad.xml"
            path.write_text(text)
            run = subprocess.run([ALDER, "render", str(path), "-o", str(self.folder / "x.exr")], capture_output=True, text=True, timeout=60)
            self.assertEqual((run.returncode, len(run.stderr.splitlines())), (2, 1), run.stderr)

    def test_alder_renders_it(self):
        path = self.folder / "s.xml"
        path.write_text(SCENE)
        run = subprocess.run([ALDER, "render", str(path), "-o", str(self.folder / "x.exr"), "--samples", "2"], capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertNotIn("warning", run.stderr)


if __name__ == "__main__":
    unittest.main()
