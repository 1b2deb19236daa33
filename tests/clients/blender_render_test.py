"""F12 with Alder, in a Python that has bpy (this one, ALDER_BPY_PYTHON) or an installed Blender: the passes are those that
`alder render` gives for the exported scene. Also, without Blender: what passes are made of, and that the add-on packs."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ALDER = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve() / "alder"
for folder in (HERE, ROOT / "clients" / "blender", ROOT / "clients" / "python"):
    sys.path.insert(0, str(folder))
try:
    import numpy as np
    import alder
except ImportError:
    np = None
from alder_blender import backend, passes  # noqa: E402
from blender_export_test import command  # noqa: E402


@unittest.skipIf(np is None, "needs numpy")
class F12(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.holder.name)
        run = command("blender_render.py", str(cls.folder))
        if run is None or not ALDER.exists():
            raise unittest.SkipTest("no bpy: set ALDER_BPY_PYTHON to a Python that has it, or install Blender")
        cls.run_ = subprocess.run(run, capture_output=True, text=True, timeout=120, env={**os.environ, "ALDER": str(ALDER)})
        if "No module named 'numpy'" in cls.run_.stderr:
            raise unittest.SkipTest("Blender's Python has no numpy: apt-get install python3-numpy")
        if cls.run_.returncode:
            raise AssertionError(cls.run_.stdout[-3000:] + cls.run_.stderr[-3000:])
        cls.result = json.loads((cls.folder / "result.json").read_text())
        cls.f12 = alder.Image.open(cls.folder / "f12.exr")
        aovs = [a for layer in passes.layers(cls.result["passes"]) for a in ("--aov", layer)]
        subprocess.run([str(ALDER), "render", str(cls.folder / "scene.alder"), "-o", str(cls.folder / "direct.exr"), "--quiet", *aovs], check=True, timeout=120)
        cls.direct = alder.Image.open(cls.folder / "direct.exr")

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def test_every_pass_is_that_of_the_program(self):
        seen = 0
        for name in self.result["passes"]:
            want = passes.compose(name, self.direct)
            if want is None and name in passes.NAMED:   # a renderer without it
                self.assertIn("Alder has no pass %s yet" % name, self.run_.stdout + self.run_.stderr)
                continue
            self.assertIsNotNone(want, name)
            letters = passes.channels(name)[1]
            for i in range(want.shape[-1]):
                hits = [c for c in self.f12.channels if c.endswith(".%s.%s" % (name, letters[i])) or len(letters) == 1 and c.endswith(".%s.V" % name) or
                        name == "UV" and c.endswith(".UV." + "UVA"[i])]
                self.assertTrue(hits, "%s.%s is not among %s" % (name, letters[i], sorted(self.f12.channels)))
                got = self.f12.channels[hits[0]]
                self.assertTrue(np.array_equal(got, want[..., i]), "%s.%s: off by %g" % (name, letters[i], np.abs(got - want[..., i]).max()))
                seen += 1
        self.assertGreater(seen, 30)
        self.assertGreater(self.f12.channels[[c for c in self.f12.channels if c.endswith("Combined.R")][0]].max(), 0.05)

    def test_what_is_not_there_is_told(self):
        self.assertIn("Alder has no pass AO yet", self.run_.stdout + self.run_.stderr)

    def test_networks_of_the_node_editor(self):
        with zipfile.ZipFile(self.folder / "scene.alder") as z:
            graph = json.loads(z.read("scene.json"))["materials"]["al"]
        nodes = {n["type"]: n["params"] for n in graph["nodes"].values()}
        self.assertEqual(set(nodes), {"alSurface", "alRemapFloat", "ShaderNodeTexNoise"})
        self.assertIsInstance(nodes["alSurface"]["specular1Roughness"], dict)
        self.assertAlmostEqual(nodes["alSurface"]["diffuseColor"][0], 0.8, 6)
        run = subprocess.run([str(ALDER), "validate", "-"], input=json.dumps(graph), capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        catalogue = json.loads(subprocess.run([str(ALDER), "nodes", "--json"], capture_output=True, text=True, check=True).stdout)["items"]
        self.assertEqual(self.result["nodes"], sorted(i["name"] for i in catalogue if i["system"] == "alshaders"), "write al_nodes.json anew: make_add_on.py --nodes")


@unittest.skipIf(np is None, "needs numpy")
class Viewport(unittest.TestCase):
    def test_edits_reach_the_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            run = command("blender_viewport.py", folder)
            if run is None or not ALDER.exists():
                self.skipTest("no bpy: set ALDER_BPY_PYTHON to a Python that has it, or install Blender")
            done = subprocess.run(run, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL, env={**os.environ, "ALDER": str(ALDER)})
            if "No module named 'numpy'" in done.stdout + done.stderr:
                self.skipTest("Blender's Python has no numpy: apt-get install python3-numpy")
            self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr[-3000:])
            result = json.loads((pathlib.Path(folder) / "result.json").read_text())
        for got, want in zip(result["first"], (0.1, 0.8, 0.1)):
            self.assertAlmostEqual(got, want, 2)
        for got, want in zip(result["edited"], (0.1, 0.2, 0.9)):
            self.assertAlmostEqual(got, want, 2)
        sent = result["patch"]["materials"]["lamp"]["nodes"]["Emission"]["params"]   # and nothing beside it
        self.assertEqual([len(x) for x in (result["patch"], result["patch"]["materials"], result["patch"]["materials"]["lamp"], sent)], [1, 1, 1, 1], result["patch"])
        self.assertEqual([round(x, 6) for x in sent["Color"]], [0.1, 0.2, 0.9, 1])
        self.assertEqual(result["moved"], [0, 0, 0])
        self.assertLess(result["update_seconds"], 0.05)   # 0.0005 on a machine with nothing else to do


@unittest.skipIf(np is None, "needs numpy")
class Backends(unittest.TestCase):
    SCENE = {"alder_scene": 1, "settings": {"resolution": [40, 24], "samples": 4}, "cameras": {"c": {"look_at": {"from": [4, -6, 3], "to": [0, 0, 0]}}},
             "meshes": {"m": {"positions": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}}, "instances": {"m": {"mesh": "m"}},
             "lights": {"l": {"type": "point", "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 4], "strength": 300}}}

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "scene.alder")

    def write(self, **settings):
        scene = json.loads(json.dumps(self.SCENE))
        scene["settings"].update(settings)
        with zipfile.ZipFile(self.path, "w") as z:
            z.writestr("scene.json", json.dumps(scene))
        return self.path

    def test_program_and_daemon_give_the_same_picture(self):
        told = []
        image, warnings = backend.Program(str(ALDER)).render(self.write(), ["N"], told.append)
        self.assertEqual((image.shape, warnings, told[-1]), ((24, 40), [], 1.0))
        client = alder.local(program=str(ALDER.parent / "alderd"))
        try:
            other, _ = backend.Daemon(client.url).render(self.path, ["N"])
        finally:
            client.close()
        for layer in ("beauty", "N"):
            self.assertTrue(np.array_equal(image[layer], other[layer]), layer)

    def test_a_cancelled_render_gives_what_is_there(self):
        started = []
        image, _ = backend.Program(str(ALDER)).render(self.write(resolution=[640, 360], samples=1 << 20), [], started.append, lambda: len(started) > 0)
        self.assertLess(image.samples, 1 << 20)
        self.assertFalse(image.complete)

    def test_faults_are_told(self):
        with self.assertRaises(backend.RenderError) as caught:
            backend.Program(str(ALDER)).render(self.write(resolution=[0, 0]), [])
        self.assertIn("resolution", str(caught.exception))
        with self.assertRaises(backend.RenderError):
            backend.Daemon("http://127.0.0.1:9").render(self.write(), [])


@unittest.skipIf(np is None, "needs numpy")
class Passes(unittest.TestCase):
    def test_light_passes_are_divided_by_their_colour(self):
        one = np.ones((2, 3), np.float32)
        channels = {c: one for c in "RGBA"}
        for layer, value in (("direct_diffuse", 0.3), ("diffuse_color", 0.5), ("direct_specular", 0.2), ("specular_color", 0.0)):
            channels.update({"%s.%s" % (layer, c): one * np.float32(value) for c in "RGB"})
        channels["uv.U"], channels["uv.V"] = one * 0, one * 0
        image = alder.Image(channels)
        self.assertTrue(np.allclose(passes.compose("DiffDir", image), 0.6))
        self.assertTrue((passes.compose("GlossDir", image) == 0).all())
        self.assertEqual(passes.compose("UV", image)[..., 2].max(), 0)
        self.assertEqual(passes.compose("Combined", image).shape, (2, 3, 4))
        self.assertIsNone(passes.compose("VolumeDir", image))

    def test_the_add_on_packs(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.zip")
            subprocess.run([sys.executable, str(ROOT / "clients" / "blender" / "make_add_on.py"), "-o", path], check=True)
            with zipfile.ZipFile(path) as z:
                names = z.namelist()
                for name in ("__init__.py", "blender_manifest.toml", "al_nodes.json", "render_engine.py", "vendor/alder/exr.py"):
                    self.assertIn("alder_blender/" + name, names)
                z.extractall(folder)
            code = "import sys; sys.path.insert(0, %r); from alder_blender import backend, passes; print(backend.client_package().__file__)" % folder
            run = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True)
            self.assertIn("vendor", run.stdout, run.stderr)


if __name__ == "__main__":
    unittest.main()
