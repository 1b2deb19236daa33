"""Every delivered node against tables of what Cycles and alShaders computed.

Tables are read from tests/reference, or from the folder that ALDER_REFERENCE names (same layout: cycles_nodes, cycles_bsdf,
alshaders). Each case becomes one request to `alder eval`; tolerances are the tables' own (tolerances.json, the `tol` of each
closure point and the README's terms). Tables of nodes that this version does not have are left out by name, and counted.
"""
import glob
import gzip
import json
import math
import os
import subprocess
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.environ.get("ALDER_REFERENCE") or os.path.join(HERE, "reference")
ALDER = os.path.join(os.environ.get("ALDER_BINARY_DIR") or os.path.join(HERE, "..", "build"), "alder")
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}

# Values that are data of the object or hashes made outside the shader.
GIVEN = {("ShaderNodeNewGeometry", "Pointiness"), ("ShaderNodeNewGeometry", "Random Per Island")}
# Derived from the camera and P, which the table rounds to float; the renderer had the length itself: a few ulp apart.
DERIVED = {("ShaderNodeLightPath", "Ray Length"): 5e-7}
# World cases do not say how the camera was turned.
NEEDS_CAMERA = {("ShaderNodeTexCoord", "Camera"), ("ShaderNodeTexCoord", "Window")}
NOT_EVALUATED = {"ShaderNodeObjectInfo", "ShaderNodePointInfo", "ShaderNodeHairInfo", "implicit_conversion"}
NO_LIGHT = {"ShaderNodeEmission", "ShaderNodeHoldout", "ShaderNodeBsdfTransparent"}


def load(path):
    with gzip.open(path, "rt") if path.endswith(".gz") else open(path) as f:
        return json.load(f)


def number(x):
    return SPECIAL[x] if isinstance(x, str) else float(x)


def flat(v):
    if isinstance(v, list):
        return [y for x in v for y in flat(x)]
    return [number(v)]


def varies(value, count):
    return isinstance(value, list) and len(value) == count and (isinstance(value[0], list) or count not in (2, 3, 4))


def with_paths(value, folder):
    if isinstance(value, dict):
        return {k: os.path.join(folder, v) if k == "file" and isinstance(v, str) else with_paths(v, folder) for k, v in value.items()}
    return value


def sockets(inputs, count, attributes):
    params = {}
    for name, value in inputs.items():
        if value is None:
            continue
        if varies(value, count):
            attributes["in:" + name] = value
            params[name] = {"attribute": "in:" + name}
        else:
            params[name] = value
    return params


def as_mended(node, case):
    """The case where the tables hold a defect of the original that Alder mends, in terms that avoid it; None where there are none.
    (The C++ tests of these nodes hold them against every case, defects included.)"""
    if node == "alFlowNoise" and case.get("lattice") != "positive":   # negative lattice coordinates wrapped by 255
        return None
    if node == "alGaborNoise":
        if case["params"]["anisotropy"] != "anisotropic":             # random directions to one side only
            return None
        return dict(case, params=dict(case["params"], impulses=case["impulsesEffective"]))  # the bits of the float as an integer
    return case


class Case:
    """One request and what its answer must be."""

    def __init__(self, table, case, folder):
        self.table, self.case, self.node = table, case, table["node"]
        self.request, self.expected = None, {}
        kind = table.get("format")
        if kind == "bsdf-reference/1":
            self.closure(case)
        elif "outputs" in case:
            self.cycles(case, folder)
        elif "output" in case and "params" in case and not case.get("basis") and not case.get("links") and "hits" not in case:
            self.alshaders(case)

    def cycles(self, case, folder):
        context = case.get("context") or {}
        if "stochastic" in case or context.get("height"):
            return
        count, attributes = case.get("points", 1), {}
        params = dict(with_paths(case.get("properties", {}), folder))
        params.update(sockets(case.get("inputs", {}), count, attributes))
        points = {"count": count, "attributes": attributes}
        self.count = count
        world = context.get("tree") == "world" and "camera_to_world" not in context
        self.expected = {"node." + o: flat(v) for o, v in case["outputs"].items()
                         if (self.node, o) not in GIVEN and not (world and (self.node, o) in NEEDS_CAMERA)}
        self.request = {"graph": {"nodes": {"node": {"type": self.node, "params": params}}}, "points": points, "outputs": list(self.expected)}
        if context:
            points.update(context.get("fields", {}))
            points["surface"] = {k: v for k, v in context.items() if k not in ("fields", "mesh", "tree", "height", "footprint_note")}
            if "mesh" in context:
                points["surface"]["mesh_file"] = os.path.join(folder, context["mesh"])
            if context.get("tree") == "world":
                self.request["domain"] = "world"

    def alshaders(self, case):
        case = as_mended(self.node, case)
        if case is None:
            return
        points = {"count": 1, "attributes": {k: [v] for k, v in (case.get("userData") or {}).items()}}
        points.update({k: [v] for k, v in case.get("globals", {}).items()})
        self.count = 1
        self.expected = {"node": flat(case["output"])}
        self.request = {"graph": {"nodes": {"node": {"type": self.node, "params": dict(case["params"])}}}, "points": points, "outputs": ["node"]}

    def closure(self, case):
        if "graph" in case or "f_cos" not in case or self.node in NO_LIGHT:
            return
        count, attributes = case["count"], {}
        params = dict(case.get("properties", {}))
        params.update(sockets(case["inputs"], count, attributes))
        for name, value in case.get("defaults", {}).items():
            if value is not None:
                params.setdefault(name, value)
        points = {"count": count, "attributes": attributes, "I": case["wo"]}
        points.update({k: case[k] for k in ("N", "Ng", "T", "backfacing", "h", "pixel_coverage") if k in case})
        self.count = count
        self.expected = {"f_cos": flat(case["f_cos"])}
        self.request = {"graph": {"nodes": {"node": {"type": self.node, "params": params}}, "outputs": {"surface": {"node": "node"}}}, "points": points,
                        "closure": {"output": "surface", "wi": case["wi"], "wo": case["wo"]}}

    # ---- judging ----
    def faults(self, answer, rules):
        """Lines saying what is wrong; empty when the case passes."""
        if "error" in answer:
            return ["refused: " + json.dumps(answer["error"])[:300]]
        lines = []
        for key, want in self.expected.items():
            value = (answer.get("closure") or {}).get(key) if key == "f_cos" else answer["outputs"].get(key)
            if value is None:
                lines.append("%s is missing" % key)
                continue
            got = flat(value)
            if key == "f_cos":  # the tables hold radiance: what is scattered and what the closure emits
                got = [a + b for a, b in zip(got, flat(answer["closure"]["emission"]))]
            if len(got) != len(want) and len(got) % self.count == 0 and len(want) % self.count == 0:
                have, need = len(got) // self.count, len(want) // self.count
                got = [g for i, g in enumerate(got) if i % have < need]
            if len(got) != len(want):
                lines.append("%s: %d numbers for %d" % (key, len(got), len(want)))
                continue
            ratios, allowed = self.ratios(key, got, want, rules)
            outside = [i for i, r in enumerate(ratios) if not r <= 1]
            worst = max(range(len(ratios)), key=lambda i: ratios[i])
            hard = key == "f_cos" and not ratios[worst] <= self.hard[worst]
            if len(outside) > math.ceil(allowed * self.count - 1e-9) or hard:
                w = len(want) // self.count
                lines.append("%s: %d of %d points outside, worst %.3g x tolerance at point %d: got %s, reference %s" % (
                    key, len(outside), self.count, ratios[worst], worst, got[worst * w:worst * w + w], want[worst * w:worst * w + w]))
        return lines

    def ratios(self, key, got, want, rules):
        width = max(1, len(want) // self.count)
        pairs = [list(zip(got[i * width:i * width + width], want[i * width:i * width + width])) for i in range(self.count)]
        if key == "f_cos":
            self.hard, out = [], []
            for i, p in enumerate(pairs):
                ratio = hard = 0.0
                for g, w in p:
                    allowed, limit = self.allowed(i, p.index((g, w)), w)
                    r = abs(g - w) / allowed if math.isfinite(g) else math.inf
                    if r >= ratio:
                        ratio, hard = r, limit
                out.append(ratio)
                self.hard.append(hard)
            if self.table.get("kind") != "curve":
                return out, 0.03
            return out, 0.12 if "f_cos_standard_error" in self.case else 0.01
        rule = {"limit": 1e-3 if self.node == "alGaborNoise" else 2e-4, "outliers": 0.0}  # Gabor sums: the specification's own allowance
        if rules is not None:
            rule = {"limit": 1e-5, "outliers": 0.0, "scale": "output"}
            for r in rules:
                if r["node"] == self.node and r.get("output", key.split(".", 1)[1]) == key.split(".", 1)[1] and all(
                        (self.case.get("note") if k == "note" else self.case.get("properties", {}).get(k)) == v for k, v in r.get("when", {}).items()):
                    rule = r
        limit = max(rule["limit"], DERIVED.get((self.node, key.split(".", 1)[-1]), 1.2e-7))
        out = []
        for i, p in enumerate(pairs):
            scale = {"unit": 1.0, "scene": 30.0}.get(rule.get("scale"), 1e-3)
            if rule.get("scale") in ("inputs", "inputs2", "scene"):
                size = self.input_size(i)
                scale = max(scale, size * size if rule["scale"] == "inputs2" and size > 1 else size)
            ratio = 0.0
            for g, w in p:
                if not math.isfinite(w):
                    r = math.inf if math.isfinite(g) else 0.0
                else:
                    r = abs(g - w) / (max(abs(w), scale) * limit) if math.isfinite(g) else math.inf
                ratio = max(ratio, r)
            out.append(ratio)
        return out, rule.get("outliers", 0.0)

    def allowed(self, i, channel, w):
        """Tolerance of a closure's value, and how many times that no point may exceed. README of the tables."""
        if self.table.get("kind") != "curve":
            allowed = self.case["tol"][i] + self.term(i) * abs(w)
            return allowed, 20 + 1e-6 / allowed
        name = self.case["name"]
        if self.node == "ShaderNodeBsdfHair":
            return 5e-4 * abs(w) + 2e-6, 40
        if name.startswith("chiang"):
            return 5e-5 * abs(w) + 1e-7, 10
        if "r_only" in name:
            return 1e-4 * abs(w) + 1e-6, 1
        # Huang's TT and TRT: Cycles' estimate against our integral. Where the tilt of the scales bounds the visible width, Cycles'
        # rounding decides whether the end of its integral is seen, which matters to what is left of dim values.
        return 4 * self.case["f_cos_standard_error"][i][channel] + 1e-2 * abs(w) + 1e-6, 10

    def input_size(self, point):
        size = 0.0
        for value in self.case.get("inputs", {}).values():
            if value is not None:
                size = max([size] + [abs(x) for x in flat(value[point] if varies(value, self.count) else value) if math.isfinite(x)])
        return size

    def term(self, point):
        """Relative allowance of the closure tables' README, for what depends on recomputed energy tables."""
        properties = self.case.get("properties", {})
        if self.node == "ShaderNodeBsdfPrincipled":
            return 5e-4
        if self.node == "ShaderNodeBsdfSheen":
            return 1e-4 if properties.get("model", "MICROFIBER") == "MICROFIBER" else 0.0
        if properties.get("distribution") == "MULTI_GGX":
            if self.node == "ShaderNodeBsdfGlass":
                return 3e-3 if self.case.get("backfacing", [0] * self.count)[point] else 5e-4
            return 2e-4
        return 0.0


class Stochastic(unittest.TestCase):
    """Nodes that cast rays: means over many evaluations of each point against the reference's means, on the reference's meshes, within
    four times the error that both means have together.

    The table's means are over a whole pixel, at whose middle the point lies: where that saw more than one face, it is not the mean at
    the point. Ambient Occlusion's table tells these pixels: there its colour is not the face's own times the occlusion. Bevel's has the
    same points.
    """

    EVALUATIONS = 48
    REFERENCE_EVALUATIONS = 256

    @staticmethod
    def table(name):
        paths = glob.glob(os.path.join(ROOT, "cycles_nodes", name + ".json*"))
        return (load(paths[0]), os.path.dirname(os.path.abspath(paths[0]))) if paths else (None, None)

    def pixels_of_several_faces(self):
        mixed = set()
        for case in self.table("ShaderNodeAmbientOcclusion")[0]["cases"]:
            for p, own, color, open_part in zip(case["context"]["fields"]["P"], case["inputs"]["Color"], case["outputs"]["Color"], case["outputs"]["AO"]):
                if any(abs(number(c) - o * number(open_part)) > 2e-4 for c, o in zip(color[:3], own)):
                    mixed.add(tuple(p))
        return mixed

    def check(self, name):
        table, folder = self.table(name)
        if not table or not os.path.exists(ALDER):
            self.skipTest("no table")
        mixed = self.pixels_of_several_faces()
        for case in table["cases"]:
            n, k = case["points"], self.EVALUATIONS
            repeated = lambda v: [x for x in v for _ in range(k)] if isinstance(v, list) and len(v) == n else v
            attributes = {}
            params = dict(case["properties"])
            params.update(sockets(case["inputs"], n, attributes))
            context = case["context"]
            points = {"count": n * k, "attributes": {a: repeated(v) for a, v in attributes.items()},
                      "surface": {a: v for a, v in context.items() if a not in ("fields", "mesh")}}
            points["surface"]["mesh_file"] = os.path.join(folder, context["mesh"])
            points.update({f: repeated(v) for f, v in context["fields"].items()})
            # Rays are random by position and view: a view turned by less than matters makes each evaluation another one.
            points["I"] = [[x + 1e-7 * (i % k) for x in v] for i, v in enumerate(points["I"])]
            request = {"graph": {"nodes": {"node": {"type": name, "params": params}}}, "points": points, "outputs": ["node." + o for o in case["outputs"]]}
            run = subprocess.run([ALDER, "eval", "-"], input=json.dumps(request), capture_output=True, text=True, timeout=600)
            answer = json.loads(run.stdout)
            self.assertNotIn("error", answer)
            single = [i for i, p in enumerate(context["fields"]["P"]) if tuple(p) not in mixed]
            self.assertGreater(len(single), n // 2)
            for output, want in case["outputs"].items():
                want, got = flat(want), flat(answer["outputs"]["node." + output])
                width, given = len(got) // (n * k), len(want) // n
                reference_error, outside, worst = case["stochastic"]["rms_error_of_mean"][output], [], 0.0
                for i in single:
                    for c in range(min(width, given)):
                        values = [got[(i * k + j) * width + c] for j in range(k)]
                        mean = sum(values) / k
                        variance = sum((v - mean) ** 2 for v in values) / (k - 1)
                        limit = 4 * math.sqrt(variance / k + max(variance / self.REFERENCE_EVALUATIONS, reference_error ** 2))
                        ratio = abs(mean - want[i * given + c]) / limit
                        worst = max(worst, ratio)
                        if ratio > 1:
                            outside.append((i, round(ratio, 2)))
                # Four standard errors, themselves estimated: one value in a few thousand lies beyond.
                self.assertLessEqual(len(outside), max(1, len(single) // 200), "%s %s %s: outside %s of %d, worst %.2f" % (name, case["properties"], output, outside[:6], len(single), worst))
                self.assertLess(worst, 1.5, "%s %s %s" % (name, case["properties"], output))

    def test_ambient_occlusion(self):
        self.check("ShaderNodeAmbientOcclusion")

    def test_bevel(self):
        self.check("ShaderNodeBevel")


def available():
    run = subprocess.run([ALDER, "nodes", "--json"], capture_output=True, text=True, check=True)
    listing = json.loads(run.stdout)
    items = listing.get("items", listing.get("nodes", [])) if isinstance(listing, dict) else listing
    return {i["type"] if "type" in i else i["name"] for i in items}


class ReferenceTables(unittest.TestCase):
    """One test a table, added below."""


def check(path):
    def test(self):
        folder = os.path.dirname(os.path.abspath(path))
        table = load(path)
        tolerances = os.path.join(folder, "tolerances.json")
        rules = load(tolerances)["rules"] if os.path.exists(tolerances) else None
        cases = [c for c in (Case(table, case, folder) for case in table.get("cases", [])) if c.request]
        if not cases:
            self.skipTest("no case that can be evaluated point by point")
        run = subprocess.run([ALDER, "eval", "-"], input=json.dumps([c.request for c in cases]), capture_output=True, text=True, timeout=600)
        self.assertIn(run.returncode, (0, 2), run.stderr[-500:])
        answers = json.loads(run.stdout)
        self.assertEqual(len(answers), len(cases))
        failed = []
        for i, (case, answer) in enumerate(zip(cases, answers)):
            failed += ["case %d %s: %s" % (i, json.dumps(case.case.get("properties", {}))[:100], line) for line in case.faults(answer, rules)]
        # One point a case: up to 1 % of a table's cases may lie outside (alShaders tables).
        few = rules is None and table.get("format") == "node-reference/1"
        if len(failed) > (0.01 * len(cases) if few else 0):
            self.fail("%d of %d cases outside:\n  %s" % (len(failed), len(cases), "\n  ".join(failed[:8])))

    return test


def add_tables():
    if not os.path.exists(ALDER):
        return
    nodes = available()
    for path in sorted(glob.glob(os.path.join(ROOT, "*", "*.json*"))):
        name = os.path.basename(path).split(".json")[0]
        if name == "tolerances" or name in NOT_EVALUATED or name not in nodes or name in ("alSurface", "alHair", "alLayer"):
            continue
        setattr(ReferenceTables, "test_" + name, check(path))


add_tables()

if __name__ == "__main__":
    unittest.main()
