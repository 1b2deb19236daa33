"""MaterialX documents as graphs, where there is the Python package MaterialX: in this Python, or in that of ALDER_MATERIALX_PYTHON."""
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ALDER = str(pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve() / "alder")
PYTHON = os.environ.get("ALDER_MATERIALX_PYTHON") or (sys.executable if importlib.util.find_spec("MaterialX") else None)
DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.38">
 <nodegraph name="ng">
  <constant name="c" type="color3"><input name="value" type="color3" value="0.9,0.1,0.1"/></constant>
  <position name="p" type="vector3"/>
  <extract name="x" type="float"><input name="in" type="vector3" nodename="p"/><input name="index" type="integer" value="2"/></extract>
  <multiply name="wide" type="float"><input name="in1" type="float" nodename="x"/><input name="in2" type="float" value="12"/></multiply>
  <sin name="s" type="float"><input name="in" type="float" nodename="wide"/></sin>
  <mix name="m" type="color3"><input name="fg" type="color3" nodename="c"/><input name="bg" type="color3" value="0.1,0.1,0.6"/><input name="mix" type="float" nodename="s"/></mix>
  <worleynoise3d name="w" type="float"/>
  <output name="out" type="color3" nodename="m"/>
  <output name="rough" type="float" nodename="w"/>
 </nodegraph>
 <standard_surface name="ss" type="surfaceshader"><input name="base" type="float" value="0.8"/><input name="base_color" type="color3" nodegraph="ng" output="out"/>
  <input name="specular_roughness" type="float" nodegraph="ng" output="rough"/><input name="coat_affect_color" type="float" value="1"/></standard_surface>
 <surfacematerial name="stripes" type="material"><input name="surfaceshader" type="surfaceshader" nodename="ss"/></surfacematerial>
 <open_pbr_surface name="op" type="surfaceshader"><input name="base_color" type="color3" value="0.9,0.6,0.2"/><input name="base_weight" type="float" value="0.5"/>
  <input name="base_metalness" type="float" value="1"/></open_pbr_surface>
 <surfacematerial name="gold" type="material"><input name="surfaceshader" type="surfaceshader" nodename="op"/></surfacematerial>
</materialx>"""


@unittest.skipIf(PYTHON is None, "needs the Python package MaterialX: set ALDER_MATERIALX_PYTHON to a Python that has it")
class MaterialX(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def convert(self, text, *options):
        path = self.folder / "m.mtlx"
        path.write_text(text)
        return subprocess.run([PYTHON, str(ROOT / "clients" / "materialx" / "materialx_scene.py"), str(path), *options], capture_output=True, text=True, timeout=60)

    def graph(self, material):
        out = self.folder / "g.json"
        run = self.convert(DOCUMENT, "--material", material, "-o", str(out))
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(out.read_text()), run.stderr

    def test_surfaces(self):
        graph, _ = self.graph("gold")
        params = graph["nodes"]["surface"]["params"]
        self.assertEqual(([round(x, 6) for x in params["Base Color"]], params["Metallic"], round(params["Roughness"], 6), params["Specular IOR Level"]), ([0.45, 0.3, 0.1, 1.0], 1.0, 0.3, 0.5))
        graph, told = self.graph("stripes")
        for word in ("coat_affect_color", "worleynoise3d"):
            self.assertIn(word, told)
        self.assertAlmostEqual(graph["nodes"]["surface"]["params"]["Roughness"], 0.2, 6)   # what has no counterpart leaves the default
        run = subprocess.run([ALDER, "validate", "-"], input=json.dumps(graph), capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_patterns_have_the_values_of_the_document(self):
        graph, _ = self.graph("stripes")
        request = {"graph": graph, "points": {"count": 1, "P": [[0.0, 0.0, 0.1]]}, "outputs": ["s", "m.Result_Color"]}
        run = subprocess.run([ALDER, "eval", "-"], input=json.dumps(request), capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        outputs = json.loads(run.stdout)["outputs"]
        self.assertAlmostEqual(outputs["s"][0], 0.932039, 5)   # sin(1.2)
        for got, want in zip(outputs["m.Result_Color"][0], (0.1 + 0.8 * 0.932039, 0.1, 0.6 - 0.5 * 0.932039)):
            self.assertAlmostEqual(got, want, 5)

    def test_the_scene_renders(self):
        run = self.convert(DOCUMENT, "-o", str(self.folder / "m.alder"))
        self.assertEqual(run.returncode, 0, run.stderr)
        run = subprocess.run([ALDER, "render", str(self.folder / "m.alder"), "-o", str(self.folder / "m.exr"), "--samples", "1", "--resolution", "64x32"], capture_output=True,
                             text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_faults(self):
        for text in ("", "<materialx", '<materialx version="1.38"/>'):
            run = self.convert(text)
            self.assertEqual((run.returncode, len(run.stderr.splitlines())), (2, 1), run.stderr)


if __name__ == "__main__":
    unittest.main()
