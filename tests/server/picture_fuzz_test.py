"""Random networks of all nodes with numbers of any size, rendered: every picture is finite, nowhere negative unless something in
it emits, and the daemon lives. ALDER_FUZZ_SECONDS makes it go on; ALDER_FUZZ_SEED starts elsewhere."""
import importlib.util
import json
import os
import pathlib
import random
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "docs/examples"), str(ROOT / "clients/python")]
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
SECONDS = float(os.environ.get("ALDER_FUZZ_SECONDS", 0))
SEED = int(os.environ.get("ALDER_FUZZ_SEED", 20260101))
PICTURES = 250

SCALES = [0.0, -0.0, 1e-45, 1e-38, 1e-20, 1e-8, 1e-3, 0.1, 0.5, 0.999999, 1.0, 1.0000001, 1.5, 2.0, 10.0, 1e3, 1e5, 1e8, 1e20, 1e30, 3.4e38]
# What may shine with negative strength, as in the originals: so may a debug view show a negative parameter.
EMITTERS = ("ShaderNodeEmission", "ShaderNodeBackground", "ShaderNodeVolumePrincipled", "ShaderNodeVolumeCoefficients", "emission", "Emission", '"debug"')


class Networks:
    """Random graph documents from the schemas of /v1/nodes."""

    def __init__(self, types, seed):
        self.random = random.Random(seed)
        outputs = lambda t: [o for o in t.get("outputs", []) if o["type"] != "closure"]   # noqa: E731
        self.closures = [t for t in types if t["closure"] and "Output" not in t["name"] and t["category"] != "volume"]
        self.functions = [(t, outputs(t)) for t in types if not t["closure"] and outputs(t)]

    def number(self):
        r = self.random
        return r.random() if r.random() < 0.5 else r.choice(SCALES) * (-1 if r.random() < 0.25 else 1)

    def value(self, param, depth, nodes):
        r, kind = self.random, param["type"]
        if kind == "closure":
            return {"node": self.node(r.choice(self.closures), depth + 1, nodes)} if depth < 3 else None
        if param.get("links") and depth < 3 and r.random() < 0.25:
            function, outputs = r.choice(self.functions)
            return {"node": self.node(function, depth + 1, nodes), "output": r.choice(outputs)["name"]}
        if kind == "float":
            return self.number()
        if kind in ("color", "vector", "point", "normal"):
            return [self.number() for _ in range(3)]
        if kind == "int":
            return r.choice([0, 1, 2, 3, 5, 16])
        if kind == "bool":
            return r.random() < 0.5
        return r.choice(param["enum"])["name"] if kind == "enum" else None

    def node(self, kind, depth, nodes):
        name = "n%d" % len(nodes)
        nodes[name] = None
        params = {}
        for param in kind["params"]:
            if self.random.random() < (0.9 if param["type"] == "closure" else 0.6):
                value = self.value(param, depth, nodes)
                if value is not None:
                    params[param["name"]] = value
        nodes[name] = {"type": kind["name"], "params": params}
        return name

    def graph(self):
        nodes = {}
        root = self.node(self.random.choice(self.closures), 0, nodes)
        return {"nodes": nodes, "outputs": {"surface": {"node": root}}}


@unittest.skipUnless(importlib.util.find_spec("numpy"), "NumPy is not installed")
class PictureFuzzTest(unittest.TestCase):
    def test_pictures_of_random_networks_are_finite_and_not_negative(self):
        import numpy
        from alder import exr
        rendered = refused = 0
        with Daemon(BUILD) as daemon:
            networks = Networks(json.loads(daemon.ask("GET", "/v1/nodes")[2])["items"], SEED)
            end = time.monotonic() + SECONDS
            while rendered + refused < PICTURES or time.monotonic() < end:
                body = {"graph": networks.graph(), "size": 16, "samples": 2, "stage": networks.random.choice(["shaderball", "sphere", "plane"])}
                status, _, answer = daemon.ask("POST", "/v1/preview", body, {"Accept": "image/x-exr"})
                text = json.dumps(body)
                self.assertIn(status, (200, 422), (answer[:300], text))
                if status == 422:
                    refused += 1
                    continue
                rendered += 1
                channels, _ = exr.decode(answer)
                rgb = numpy.stack([channels[c] for c in "RGB"])
                self.assertTrue(numpy.isfinite(rgb).all(), text)
                if not any(e in text for e in EMITTERS):
                    self.assertGreaterEqual(float(rgb.min()), 0, text)
        self.assertGreater(rendered, 4 * refused, (rendered, refused))
        print(f"{rendered} pictures, {refused} refused", end=" ")


if __name__ == "__main__":
    unittest.main()
