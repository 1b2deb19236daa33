"""The Blender exporter on a scene built for it, in a Python that has bpy: this one, ALDER_BPY_PYTHON, or an installed Blender."""
import importlib.util
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
ALDER = os.path.join(os.environ.get("ALDER_BINARY_DIR") or os.path.join(HERE, "..", "..", "build"), "alder")
FORMATS = {"f32": "f", "u32": "I", "u16": "H", "u8": "B"}


def command(script, out):
    """How to run a script with bpy, or None."""
    script = os.path.join(HERE, script)
    python = os.environ.get("ALDER_BPY_PYTHON") or (sys.executable if importlib.util.find_spec("bpy") else None)
    if python:
        return [python, script, out]
    if shutil.which("blender"):
        return ["blender", "-b", "--factory-startup", "--python-exit-code", "9", "--python-expr",
                "import runpy, sys; sys.argv = ['x', %r]; runpy.run_path(%r, run_name='__main__')" % (out, script)]
    return None


class Export(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = os.path.join(cls.folder.name, "scene.alder")
        run = command("blender_scenes.py", cls.path)
        if run is None:
            cls.folder.cleanup()
            raise unittest.SkipTest("no bpy: set ALDER_BPY_PYTHON to a Python that has it, or install Blender")
        cls.run_ = subprocess.run(run, capture_output=True, text=True, timeout=250)
        if "has no numpy" in cls.run_.stderr:
            raise unittest.SkipTest("Blender's Python has no numpy: apt-get install python3-numpy")
        if cls.run_.returncode or not os.path.exists(cls.path):
            raise AssertionError(cls.run_.stdout[-4000:] + cls.run_.stderr[-4000:])
        with zipfile.ZipFile(cls.path) as z:
            cls.names = z.namelist()
            cls.scene = json.loads(z.read("scene.json"))
            cls.buffer = z.read("geometry.bin")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def array(self, a, channels):
        n = a["count"] * channels
        flat = struct.unpack_from("<%d%s" % (n, FORMATS[a["type"]]), self.buffer, a["offset"])
        return [flat[i:i + channels] for i in range(0, n, channels)] if channels > 1 else list(flat)

    def test_alder_renders_it(self):
        if not os.path.exists(ALDER):
            self.skipTest("no alder in the build folder")
        out = os.path.join(self.folder.name, "scene.exr")
        run = subprocess.run([ALDER, "render", self.path, "-o", out, "--samples", "1"], capture_output=True, text=True, timeout=100)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(os.path.exists(out))

    def test_settings(self):
        s = self.scene["settings"]
        self.assertEqual(s["resolution"], [32, 64])
        self.assertEqual((s["samples"], s["max_bounces"], s["clamp_indirect"], s["clamp_direct"]), (9, 5, 4, 0))

    def test_camera_is_fitted_to_its_side(self):
        c = self.scene["cameras"]["camera"]
        # 90 degrees across the smaller side: the larger one, twice as long, sees 2 atan 2.
        self.assertAlmostEqual(c["fov_degrees"], 126.869898, 4)
        self.assertEqual(c["shift"], [0.125, 0])
        self.assertAlmostEqual(c["aperture_radius"], 0.0045, 6)
        self.assertAlmostEqual(c["focus_distance"], 7, 5)
        self.assertEqual(sorted(self.scene["cameras"]), ["camera", "dome"])
        self.assertEqual(self.scene["cameras"]["dome"]["panorama"], "fisheye_equidistant")

    def test_mesh_is_the_one_of_final_renders(self):
        m = self.scene["meshes"]["box"]
        self.assertEqual((m["positions"]["count"], m["triangles"]["count"]), (26, 48), "subdivided once")
        self.assertEqual(set(self.array(m["face_material"], 1)), {0, 1})
        smooth = self.array(m["smooth"], 1) if "smooth" in m else None
        if smooth is not None:   # Blender 4.1 and later may give corner normals instead
            self.assertEqual(smooth.count(0), 8)
        self.assertEqual(m["generated_bounds"], [[-1, -1, -1], [1, 1, 1]])

    def test_attributes_keep_their_domains(self):
        m = self.scene["meshes"]["box"]
        a = m["attributes"]
        self.assertEqual({k: (v["domain"], v["channels"]) for k, v in a.items()},
                         {"first": ("corner", 2), "second": ("corner", 2), "POINT_FLOAT": ("point", 1), "FACE_INT": ("face", 1),
                          "CORNER_FLOAT_COLOR": ("corner", 4), "POINT_FLOAT_VECTOR": ("point", 3)})
        self.assertEqual(m["uv"], a["second"]["values"], "the map active for rendering")
        points = self.array(a["POINT_FLOAT_VECTOR"]["values"], 3)
        self.assertEqual(points[:8], [(i, 2 * i, 3 * i) for i in range(8)])
        faces = self.array(a["FACE_INT"]["values"], 1)
        self.assertEqual(sorted(faces), sorted(list(range(6)) * 8))
        # A triangle's corners are corners of its polygon: values of one original face never mix.
        corners = self.array(a["CORNER_FLOAT_COLOR"]["values"], 4)
        self.assertEqual(len(corners), 144)
        for t, face in enumerate(faces):
            for k in range(3):
                self.assertTrue(4 * face <= corners[3 * t + k][0] <= 4 * face + 3, (t, face, corners[3 * t + k]))

    def test_instances_share_their_mesh(self):
        i = self.scene["instances"]
        placed = [k for k, v in i.items() if v.get("mesh") == "tri"]
        matrices = []
        for k in placed:
            matrices += self.array(i[k]["transforms"], 12) if "transforms" in i[k] else [tuple(i[k]["transform"])]
        self.assertEqual(sorted(m[3] for m in matrices), [0, 1, 2, 3, 4], "five of the collection, none of the hidden object")
        self.assertEqual(len([m for m in self.scene["meshes"] if m.startswith("tri")]), 1)
        self.assertIn("text", i)

    def test_object_settings(self):
        box = self.scene["instances"]["box"]
        self.assertEqual(box["visibility"], {"shadow": False})
        self.assertEqual((box["pass_index"], box["color"]), (7, [0.5, 0.25, 0.125]))
        self.assertEqual(box["materials"], ["grouped", "blue"])
        self.assertTrue(0 < box["random"] < 1)

    def test_hair_curves(self):
        if "hair" not in self.scene["instances"]:
            self.skipTest("this Blender's Python makes no hair curves")
        self.assertEqual(self.scene["instances"]["hair"]["curves"], "hair")
        h = self.scene["curves"]["hair"]
        self.assertEqual(self.array(h["counts"], 1), [3, 2])
        self.assertEqual(self.array(h["radii"], 1), [0.125, 0.25, 0.375, 0.5, 0.625])
        self.assertEqual(self.array(h["positions"], 3)[4], (4, 2, 0))
        self.assertIn(h["form"], ("ribbon", "round"))

    def test_motion(self):
        """Keys over half a frame around frame 1, where it is at 4: from 3 to 5."""
        o = self.scene["instances"]["mover"]
        self.assertEqual([round(m[3], 5) for m in self.array(o["motion"], 12)], [3, 4, 5])
        self.assertNotIn("motion", self.scene["instances"]["box"])
        motion = self.scene["meshes"][o["mesh"]]["motion"]
        self.assertEqual(motion["steps"], 3)
        self.assertEqual([round(p[0], 5) for p in self.array(motion["positions"], 3)[1::3]], [1.75, 2, 2.25])

    def test_lights(self):
        lights = self.scene["lights"]
        self.assertEqual({k: (v["type"], v["strength"]) for k, v in lights.items()},
                         {"point": ("point", 10), "spot": ("spot", 20), "sun": ("sun", 3), "area": ("area", 40)})
        self.assertAlmostEqual(lights["spot"]["spot_angle_degrees"], 60, 4)
        self.assertEqual(lights["area"]["size"], [2, 3])
        self.assertTrue(lights["area"]["spread_degrees"] <= 180)

    def test_materials(self):
        g = self.scene["materials"]["grouped"]
        groups = [n for n in g["nodes"].values() if n["type"] == "ShaderNodeGroup"]
        self.assertEqual([n["group"] for n in groups], ["twice", "twice"])
        self.assertIn("twice", g["groups"])
        bsdf = g["nodes"]["Principled BSDF"]["params"]
        self.assertEqual(bsdf["Base Color"], {"node": "Image Texture", "output": "Color"}, "the muted Gamma is passed through")
        image = g["nodes"]["Image Texture"]["params"]["image"]
        self.assertEqual(image["colorspace"], "sRGB")
        self.assertIn(image["file"], self.names)
        self.assertEqual(self.scene["materials"]["blue"]["nodes"]["Principled BSDF"]["params"]["Base Color"], [0, 0, 1, 1])

    def test_what_is_left_out_is_told(self):
        told = {e["what"]: e["where"] for e in self.scene["report"]["unsupported"]}
        self.assertEqual(told.get("camera of type PANO (EQUIANGULAR_CUBEMAP_FACE)"), ["pano"])
        self.assertIn("not exported: camera of type PANO (EQUIANGULAR_CUBEMAP_FACE) (pano)", self.run_.stdout)
        self.assertIn("statuses: 0 1", self.run_.stdout)
        self.assertEqual([f for f in os.listdir(self.folder.name) if "strict" in f], [], "--strict writes nothing")


class Nodes(unittest.TestCase):
    maxDiff = None

    def test_alder_takes_every_node_as_it_is_written(self):
        if not os.path.exists(ALDER):
            self.skipTest("no alder in the build folder")
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "nodes.json")
            run = command("blender_nodes.py", out)
            if run is None:
                self.skipTest("no bpy: set ALDER_BPY_PYTHON to a Python that has it, or install Blender")
            made = subprocess.run(run, capture_output=True, text=True, timeout=250)
            self.assertTrue(os.path.exists(out), made.stdout[-3000:] + made.stderr[-3000:])
            with open(out) as f:
                graphs = json.load(f)
            self.assertGreater(len(graphs), 80)
            files = []
            for name, g in graphs.items():
                self.assertTrue(not g["told"] or name == "ShaderNodeTexSky", "%s: %s" % (name, g["told"]))   # Blender 5.0 has a model more
                files.append(os.path.join(folder, name + ".json"))
                with open(files[-1], "w") as f:
                    json.dump(g["graph"], f)
            run = subprocess.run([ALDER, "validate", "--json", *files], capture_output=True, text=True, timeout=100)
            answers = json.loads(run.stdout)
            self.assertEqual(len(answers), len(files), run.stderr)
            wrong = []
            for path, answer in answers.items():
                # Nodes that this version of Alder does not have, and says so.
                wrong += ["%s: %s" % (os.path.basename(path), e) for e in answer.get("errors", []) if not e["code"].startswith("unsupported")]
            self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
