"""The registry, declared in the code, against the catalogues of Blender 4.5 and alShaders: names, types, defaults, enums."""
import gzip
import json
import os
import subprocess
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ALDER = os.path.join(os.environ.get("ALDER_BINARY_DIR") or os.path.join(HERE, "..", "build"), "alder")

CYCLES_TYPES = {"VALUE": {"float"}, "VECTOR": {"vector"}, "RGBA": {"color"}, "SHADER": {"closure"}, "STRING": {"string", "image"}, "INT": {"int", "float"},
                "FLOAT": {"float", "vector"}, "BOOLEAN": {"bool"}, "ENUM": {"enum"}, "POINTER": {"image", "ramp", "curve", "json", "string", "matrix"}}
AL_TYPES = {"int": "int", "point": "vector", "vector": "vector", "rgb": "color", "bool": "bool", "string": "string", "matrix": "matrix", "float": "float", "enum": "enum"}
# Arnold hands surface results on as rgb; here they are closures.
SURFACES = {("alLayer", "layer1"), ("alLayer", "layer2"), ("alCel", "surfaceShader")}
# Parameters that the originals do not have.
OURS = {("alHair", "fibreModel")}
# Of the node editor only, without effect on a value.
EDITOR_ONLY = {"color_mapping", "show_texture", "image_user", "cache_point_density"}
# Rotation sockets of the Mix node are disabled in every shader tree.
NEVER_ENABLED = {("ShaderNodeMix", "A_Rotation"), ("ShaderNodeMix", "B_Rotation"), ("ShaderNodeMix", "Result_Rotation")}


def load(name):
    with gzip.open(os.path.join(HERE, "catalogues", name), "rt") as f:
        return json.load(f)


def same(a, b):
    if isinstance(a, list) and isinstance(b, list):
        flat = [x for row in a for x in (row if isinstance(row, list) else [row])]
        other = [x for row in b for x in (row if isinstance(row, list) else [row])]
        return len(flat) >= len(other) and all(same(x, y) for x, y in zip(flat, other))  # Blender's colours carry alpha
    if isinstance(a, bool) or isinstance(b, bool) or isinstance(a, str):
        return a == b
    return abs(a - b) <= 1e-6 * max(1.0, abs(a))


class Catalogues(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        run = subprocess.run([ALDER, "nodes", "--json"], capture_output=True, text=True, check=True)
        cls.registry = {n["name"]: n for n in json.loads(run.stdout)["items"]}

    def test_alshaders(self):
        faults = []
        for name, node in load("alshaders.json.gz").items():
            ours = self.registry.get(name)
            if not ours:
                continue
            params = {p["name"]: p for p in ours["params"]}
            names = {p["name"] for p in node["params"]}
            faults += ["%s.%s is not in the catalogue" % (name, p) for p in params if p not in names and (name, p) not in OURS]
            for p in node["params"]:
                q = params.get(p["name"])
                if q is None:
                    faults.append("%s.%s is missing" % (name, p["name"]))
                    continue
                if q["type"] != AL_TYPES[p["type"]] and not (p["type"] == "string" and q["type"] == "image") \
                        and (name, p["name"]) not in SURFACES:
                    faults.append("%s.%s is a %s, not a %s" % (name, p["name"], q["type"], p["type"]))
                if p["type"] == "enum" and [i["name"] for i in q["enum"]] != p["enum"]:
                    faults.append("%s.%s has the items %s, not %s" % (name, p["name"], [i["name"] for i in q["enum"]], p["enum"]))
                if "default" in p and q["default"] is not None and not same(p["default"], q["default"]):
                    faults.append("%s.%s defaults to %s, not %s" % (name, p["name"], q["default"], p["default"]))
        self.assertEqual(faults, [])

    def test_cycles(self):
        faults = []
        for name, node in load("cycles.json.gz").items():
            ours = self.registry.get(name)
            if not ours:
                continue
            params = {p["name"]: p for p in ours["params"]}
            for p in node["inputs"]:
                if p["type"] == "ROTATION" or (name, p["identifier"]) in NEVER_ENABLED:
                    continue
                q = params.get(p["identifier"])
                if q is None:
                    faults.append("%s: no socket %s" % (name, p["identifier"]))
                elif q["type"] not in CYCLES_TYPES[p["type"]]:
                    faults.append("%s.%s is a %s, not a %s" % (name, p["identifier"], q["type"], p["type"]))
                elif p["default"] is not None and q["default"] is not None and p["type"] != "SHADER" and not same(p["default"], q["default"]):
                    faults.append("%s.%s defaults to %s, not %s" % (name, p["identifier"], q["default"], p["default"]))
            for p in node["properties"]:
                if p["name"] in EDITOR_ONLY:
                    continue
                q = params.get(p["name"])
                if q is None:
                    faults.append("%s: no property %s" % (name, p["name"]))
                    continue
                if q["type"] not in CYCLES_TYPES[p["type"]]:
                    faults.append("%s.%s is a %s, not a %s" % (name, p["name"], q["type"], p["type"]))
                elif p["type"] == "ENUM" and not {i["name"] for i in q["enum"]} >= set(p["items"]):
                    faults.append("%s.%s lacks the items %s" % (name, p["name"], sorted(set(p["items"]) - {i["name"] for i in q["enum"]})))
                elif p["type"] in ("ENUM", "BOOLEAN", "FLOAT", "INT") and p["default"] is not None and not same(p["default"], q["default"]):
                    faults.append("%s.%s defaults to %s, not %s" % (name, p["name"], q["default"], p["default"]))
            outputs = {o["name"] for o in ours["outputs"]}
            for p in node["outputs"]:
                if p["type"] != "ROTATION" and p["identifier"] not in outputs:
                    faults.append("%s: no output %s" % (name, p["identifier"]))
        self.assertEqual(faults, [])


if __name__ == "__main__":
    unittest.main()
