"""The importer of Arnold's .ass materials: the format, every original test material, and what is told to the user."""
import glob
import io
import json
import os
import subprocess
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "ass"))

import ass_file  # noqa: E402
import ass_materials  # noqa: E402

DATA = os.path.join(HERE, "..", "data", "alshaders")
ALDER = os.path.join(os.environ.get("ALDER_BINARY_DIR") or os.path.join(HERE, "..", "..", "build"), "alder")
# Materials whose look rests on what this version does not have; the parameter that the error names.
REFUSED = {}


def convert(text, root=None):
    """(document, lines told)"""
    told = io.StringIO()
    document = ass_materials.Converter(ass_file.parse(text, "t.ass"), "t.ass", told).root(root)
    return document, told.getvalue().splitlines()


def engine(surface, more=""):
    return "MayaShadingEngine\n{\n name TARGET_SHADER\n beauty %s\n%s}\n" % (surface, more)


class Format(unittest.TestCase):
    def test_values_are_words_until_the_next_name(self):
        nodes = ass_file.parse('include "a.ass"\n# note\nalFractal\n{\n name "a b:c"\n scale 1 2 3\n matrix\n  1 0\n  0 1\n mode "off"\n turbulent off\n}\n')
        self.assertEqual(nodes.includes, ["a.ass"])
        node = nodes["a b:c"]
        self.assertEqual(node.params["scale"].numbers(), [1, 2, 3])
        self.assertEqual(node.params["matrix"].numbers(), [1, 0, 0, 1])
        self.assertTrue(node.params["mode"].words[0].quoted)
        self.assertFalse(node.params["turbulent"].words[0].quoted)

    def test_a_block_may_stand_on_one_line(self):
        self.assertEqual(ass_file.parse("alFractal { name a }")["a"].kind, "alFractal")

    def test_base_85_data_is_passed_over(self):
        nodes = ass_file.parse('polymesh\n{\n name m\n vidxs 24 1 b85UINT \n B $?ZE*$v"Mi2}x{\n shader"<\n\n smoothing on\n}\nalFractal\n{\n name f\n}\n')
        self.assertEqual(list(nodes), ["m", "f"])
        self.assertIn("smoothing", nodes["m"].params)
        self.assertNotIn("shader", nodes["m"].params)

    def test_arrays_of_names_reach_over_lines(self):
        nodes = ass_file.parse('x\n{\n name a\n declare g constant ARRAY NODE\n g 2 1 NODE\n one\n two\n last 1\n}\n')
        self.assertEqual(nodes["a"].params["g"].words, ["2", "1", "NODE", "one", "two"])
        self.assertEqual(nodes["a"].declared, {"g": "constant ARRAY NODE"})
        self.assertIn("last", nodes["a"].params)

    def test_faults_name_file_and_line(self):
        for text, where in (("alFractal\n{\n name a\n", "line 3"), ("alFractal\n{\n 1 2\n}\n", "line 3"), ("{\n}\n", "line 1"),
                            ('alFractal\n{\n name "a\n}\n', "line 3"), ("a\n{\n name x\n}\nb\n{\n name x\n}\n", "line 5"),
                            ("a\n{\n p 1\n p 2\n}\n", "line 4")):
            with self.assertRaises(ass_file.AssError) as raised:
                ass_file.parse(text, "f.ass")
            self.assertIn("f.ass, " + where, str(raised.exception))


class Originals(unittest.TestCase):
    def test_all_convert_and_keep_every_parameter(self):
        files = sorted(glob.glob(os.path.join(DATA, "test_*.ass")))
        self.assertEqual(len(files), 12)
        for path in files:
            with self.subTest(os.path.basename(path)):
                out, told = io.StringIO(), io.StringIO()
                self.assertEqual(ass_materials.main([path], out, told), 0, told.getvalue())
                document = json.loads(out.getvalue())
                root = document["outputs"]["surface"]["node"]
                self.assertIn(document["nodes"][root]["type"], ("alSurface", "alLayer"))
                for name, node in ass_file.read(path).items():
                    if node.kind == "standard" or not node.kind.startswith("al"):
                        continue
                    for param in node.params:
                        here = param in document["nodes"][name]["params"]
                        line = "%s %s: %s: " % (node.kind, name, param)
                        self.assertTrue(here or line in told.getvalue(), "%s of %s is gone without a word" % (param, name))

    def test_older_parameters_are_told_with_what_they_cost(self):
        told = io.StringIO()
        ass_materials.main([os.path.join(DATA, "test_als_jade.ass")], io.StringIO(), told)
        lines = told.getvalue()
        self.assertRegex(lines, r"alSurface TARGET_SURFACE: ssStrength: .*look may differ")
        self.assertRegex(lines, r"alFractal jade:alFractal1: ridgeOffset: .*computes the same")

    def test_links_bump_and_layers(self):
        def graph(name):
            out = io.StringIO()
            ass_materials.main([os.path.join(DATA, name + ".ass")], out, io.StringIO())
            return json.loads(out.getvalue())["nodes"]

        coat = graph("test_als_ccover_bump")
        self.assertEqual(coat["bump2d6"]["type"], "ShaderNodeBump")
        self.assertEqual(coat["bump2d6"]["params"]["Height"], {"node": "alFractal3", "component": "r"})
        self.assertEqual(coat["bump2d6"]["params"]["Distance"], 0.300000012)
        surface = coat["TARGET_SURFACE"]["params"]
        self.assertEqual(surface["specular1Normal"], {"node": "alInputVector1"}, "its own normal stays")
        self.assertEqual(surface["diffuseNormal"], {"node": "bump2d6", "output": "Normal"})
        layer = graph("test_als_lyr_glass_goldleaf")
        self.assertEqual(layer["als_lyr_glass_goldleaf"]["params"]["layer2"], {"node": "als_goldleaf"})
        self.assertNotIsInstance(layer["als_glass"]["params"]["specular1Normal"], dict)
        self.assertEqual(layer["als_goldleaf"]["params"]["diffuseNormal"]["node"], "bump2d5")
        jade = graph("test_als_jade")["TARGET_SURFACE"]["params"]
        self.assertEqual(jade["diffuseColor"], {"node": "jade:alCombineColor2"})

    def test_they_compile_or_name_what_is_missing(self):
        if not os.path.exists(ALDER):
            self.skipTest("no %s" % ALDER)
        for path in sorted(glob.glob(os.path.join(DATA, "test_*.ass"))):
            name = os.path.splitext(os.path.basename(path))[0]
            with self.subTest(name):
                out = io.StringIO()
                ass_materials.main([path], out, io.StringIO())
                request = {"graph": json.loads(out.getvalue()), "points": {"count": 1}, "outputs": [],
                           "closure": {"output": "surface", "wi": [0, 0.6, 0.8], "wo": [0, -0.6, 0.8]}}
                done = subprocess.run([ALDER, "eval", "-"], input=json.dumps([request]), capture_output=True, text=True, timeout=60)
                answer = json.loads(done.stdout)[0]
                if name in REFUSED:
                    self.assertEqual([e["found"] for e in answer["error"]["errors"]], [REFUSED[name]])
                else:
                    self.assertNotIn("error", answer)
                    self.assertTrue(all(0 <= x < 1e6 for x in answer["closure"]["f_cos"][0]), answer)


class Standard(unittest.TestCase):
    def params(self, text):
        document, told = convert(engine("s") + "standard\n{\n name s\n%s}\n" % text)
        return document["nodes"]["s"]["params"], told

    def test_plastic_pair_has_the_same_parameters(self):
        def surface(name):
            nodes = ass_file.read(os.path.join(DATA, name))
            return ass_materials.Converter(nodes, name, io.StringIO()).root()["nodes"]["TARGET_SURFACE"]["params"]

        for finish in ("rough", "shiny"):
            a, b = surface("test_ai_bplastic_%s.ass" % finish), surface("test_als_bplastic_%s.ass" % finish)
            for name in ("diffuseStrength", "diffuseColor", "specular1Strength", "specular1Color", "specular1Roughness", "specular1Ior"):
                self.assertAlmostEqual(a[name] if not isinstance(a[name], list) else a[name][1],
                                       b[name] if not isinstance(b[name], list) else b[name][1], 6, name)

    def test_glass_and_mirror(self):
        params, told = self.params(" Kd 0\n Kt 0.9\n Kt_color 1 0 0\n IOR 1.5\n refraction_roughness 0.2\n Kr 0.5\n Fresnel on\n Krn 0.04\n")
        self.assertEqual(params["transmissionColor"], [1, 0, 0])
        self.assertEqual(params["transmissionIor"], 1.5)
        self.assertIs(params["transmissionLinkToSpecular1"], False)
        self.assertAlmostEqual(params["specular2Ior"], 1.5)
        self.assertTrue(any(": Kr: " in line for line in told))

    def test_what_is_near_or_left_out_is_told(self):
        params, told = self.params(' Ks 1\n specular_brdf "ward_duer"\n direct_diffuse 0.5\n wobble 3\n Fresnel_affect_diff off\n')
        text = "\n".join(told)
        for param in ("specular_brdf", "direct_diffuse", "wobble", "Fresnel_affect_diff", "specular_Fresnel"):
            self.assertIn(": %s: " % param, text)
        self.assertEqual(params["specular1Ior"], 1000)

    def test_absorption_becomes_coefficients(self):
        params, _ = self.params(" Kt 1\n transmittance 0.5 1 1\n")
        self.assertAlmostEqual(params["ssAbsorption"][0], 0.6931472, 6)


class Networks(unittest.TestCase):
    SURFACE = "alSurface\n{\n name s\n diffuseColor f\n}\nalFractal\n{\n name f\n octaves 2\n}\n"

    def test_a_surface_with_and_without_bump_is_there_twice(self):
        text = engine("l") + self.SURFACE + "alLayer\n{\n name l\n layer1 s\n layer2 b\n mix 0.5\n}\nmayaBump2D\n{\n name b\n bump_map f.r\n bump_height 2\n shader s\n}\n"
        document, _ = convert(text)
        layer = document["nodes"]["l"]["params"]
        self.assertNotEqual(layer["layer1"], layer["layer2"])
        bumped = document["nodes"][layer["layer2"]["node"]]["params"]
        self.assertEqual(bumped["diffuseNormal"], {"node": "b", "output": "Normal"})
        self.assertEqual(bumped["diffuseColor"], {"node": "f"}, "patterns are shared")
        self.assertNotIn("diffuseNormal", document["nodes"][layer["layer1"]["node"]]["params"])

    def test_bump_over_bump_is_chained(self):
        bump = "mayaBump2D\n{\n name %s\n bump_map f.r\n shader %s\n}\n"
        document, _ = convert(engine("b2") + self.SURFACE + bump % ("b1", "s") + bump % ("b2", "b1"))
        self.assertEqual(document["nodes"]["b1"]["params"]["Normal"], {"node": "b2", "output": "Normal"})
        self.assertEqual(document["nodes"]["s"]["params"]["diffuseNormal"]["node"], "b1")

    def test_what_cannot_be_converted_is_an_error(self):
        for text, words in ((engine("t") + "MayaRamp\n{\n name t\n}\n", "MayaRamp"), (engine("nowhere"), "beauty"),
                            ("alFractal\n{\n name f\n}\n", "shading engines"),
                            (engine("l") + "alLayer\n{\n name l\n layer1 l\n}\n", "itself"),
                            (engine("s") + "alSurface\n{\n name s\n diffuseColor lost\n}\n", "diffuseColor")):
            with self.assertRaises(ass_materials.Failure) as raised:
                convert(text)
            self.assertIn(words, str(raised.exception))

    def test_settings_of_the_engine_that_matter_are_told(self):
        _, told = convert(engine("s", " enable_matte on\n odd 1\n") + self.SURFACE)
        self.assertEqual(len(told), 2)

    def test_a_missing_file_ends_with_2(self):
        err = io.StringIO()
        self.assertEqual(ass_materials.main([os.path.join(DATA, "none.ass")], io.StringIO(), err), 2)
        self.assertIn("none.ass", err.getvalue())


if __name__ == "__main__":
    unittest.main()
