"""GET /v1/openapi.json: every route is there, and real answers fit the schemas that it gives."""
import json
import os
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
GRAPH = {"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"diffuseColor": [0.8, 0.3, 0.1]}}}, "outputs": {"surface": {"node": "s"}}}
SCENE = {"alder_scene": 1, "cameras": {"cam": {"look_at": {"from": [0, -5, 1], "to": [0, 0, 1]}, "fov_degrees": 40}}, "materials": {"m": GRAPH},
         "meshes": {"t": {"positions": [[-1, 0, 0], [1, 0, 0], [0, 0, 2]], "triangles": [[0, 1, 2]]}},
         "instances": {"a": {"mesh": "t", "material": "m", "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}},
         "lights": {"l": {"type": "point", "strength": 300, "look_at": {"from": [0, -3, 3], "to": [0, 0, 1]}}}, "settings": {"resolution": [16, 16], "samples": 2}}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}


def faults(schema, value, document, at=""):
    """What of a value does not fit a schema, as far as these schemas go."""
    if "$ref" in schema:
        target = document
        for part in schema["$ref"][2:].split("/"):
            target = target[part]
        return faults(target, value, document, at)
    if "anyOf" in schema:
        each = [faults(s, value, document, at) for s in schema["anyOf"]]
        return [] if any(not e for e in each) else min(each, key=len)
    found = []
    names = schema.get("type", [])
    names = [names] if isinstance(names, str) else names
    if names:
        fits = any(isinstance(value, (int, float)) and not isinstance(value, bool) and (n == "number" or value == int(value)) if n in ("number", "integer")
                   else isinstance(value, TYPES[n]) for n in names)
        if not fits:
            return ["%s is %s, not %s" % (at, json.dumps(value)[:60], names)]
    if "const" in schema and value != schema["const"]:
        found.append("%s is not %r" % (at, schema["const"]))
    if "enum" in schema and value not in schema["enum"]:
        found.append("%s is %r, none of %s" % (at, value, schema["enum"]))
    if isinstance(value, str) and "pattern" in schema and not re.search(schema["pattern"], value):
        found.append("%s is %r, not like %s" % (at, value, schema["pattern"]))
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not schema.get("minimum", value) <= value <= schema.get("maximum", value):
        found.append("%s is out of range" % at)
    if isinstance(value, list):
        if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
            found.append("%s has %d items" % (at, len(value)))
        for i, item in enumerate(value):
            found += faults(schema.get("items", {}), item, document, "%s/%d" % (at, i))
    if isinstance(value, dict):
        found += ["%s has no '%s'" % (at, name) for name in schema.get("required", []) if name not in value]
        more = schema.get("additionalProperties", {})
        for name, item in value.items():
            known = schema.get("properties", {}).get(name)
            if known is None and more is False:
                found.append("%s has '%s'" % (at, name))
            else:
                found += faults(known if known is not None else more, item, document, at + "/" + name)
    return found


class OpenApiTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(BUILD).__enter__()
        cls.document = json.loads(cls.daemon.ask("GET", "/v1/openapi.json")[2])

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__()

    def ask(self, method, path, route, body=None, headers=None):
        """Asks, and holds the answer against the schema of its operation."""
        status, answered, text = self.daemon.ask(method, path, body, headers or {})
        answers = self.document["paths"][route][method.lower()]["responses"]
        self.assertIn(str(status), answers, (method, path, text[:300]))
        kind = answered.get("Content-Type", "").split(";")[0]
        content = answers[str(status)].get("content", {})
        if text:
            self.assertIn(kind, content, (method, path, status))
        value = json.loads(text) if kind.endswith("json") and text else None
        if value is not None and "schema" in content[kind]:
            self.assertEqual(faults(content[kind]["schema"], value, self.document), [], (method, path))
        return status, answered, value

    def body(self, route, method="post", kind="application/json"):
        return self.document["paths"][route][method]["requestBody"]["content"][kind]["schema"]

    def test_every_route_is_described_and_every_reference_leads_somewhere(self):
        source = (ROOT / "server/routes.cpp").read_text()
        served = set(re.findall(r'\{"(GET|POST|PUT|PATCH|DELETE)", "([^"]+)", \w+, kScope', source))
        described = {(m.upper(), path) for path, item in self.document["paths"].items() for m in item}
        self.assertEqual(served - described, set())
        self.assertEqual(described - served, set())
        for name in set(re.findall(r'"\$ref": ?"#/components/schemas/(\w+)"', json.dumps(self.document))):
            self.assertIn(name, self.document["components"]["schemas"])
        ids = [o["operationId"] for item in self.document["paths"].values() for o in item.values()]
        self.assertEqual(len(ids), len(set(ids)))
        for item in self.document["paths"].values():
            for operation in item.values():
                for answer in operation["responses"].values():
                    for link in answer.get("links", {}).values():
                        self.assertIn(link["operationId"], ids)

    def test_bodies_are_described_by_what_reads_them(self):
        preview = self.body("/v1/preview")
        self.assertEqual(preview["required"], ["graph"])
        self.assertIs(preview["additionalProperties"], False)
        self.assertEqual(faults(preview, {"graph": GRAPH, "size": [4, 4], "samples": 1, "view": {"exposure": 1}}, self.document), [])
        for wrong in ({"graph": GRAPH, "samples": 0}, {"graph": GRAPH, "sampels": 1}, {"graph": GRAPH, "view": {"exposure": 99}}, {"size": 4}, {"graph": GRAPH, "size": 5000}):
            self.assertNotEqual(faults(preview, wrong, self.document), [], wrong)
            self.assertEqual(self.daemon.ask("POST", "/v1/preview", wrong)[0], 422, wrong)
        final, live = self.body("/v1/renders")["anyOf"]
        self.assertIn("scene", final["required"])
        self.assertEqual(live["properties"]["mode"]["enum"], ["live"])
        self.assertEqual({p["name"]: p["required"] for p in self.document["paths"]["/v1/renders/{id}/pixel"]["get"]["parameters"]}, {"id": True, "x": True, "y": True, "explain": False})

    def test_answers_fit_their_schemas(self):
        for path in ("/v1/version", "/readyz", "/v1/nodes", "/v1/openapi.json", "/livez", "/metrics", "/about", "/ui", "/ui/examples", "/v1/renders"):
            self.assertEqual(self.ask("GET", path, path)[0], 200, path)
        self.ask("GET", "/v1/nodes/alSurface", "/v1/nodes/{type}")
        self.ask("GET", "/v1/nodes/alSurfac", "/v1/nodes/{type}")
        self.ask("GET", "/v1/version?x=1", "/v1/version")
        self.ask("POST", "/v1/graphs/validate", "/v1/graphs/validate", {"graph": GRAPH})
        self.ask("POST", "/v1/graphs/validate", "/v1/graphs/validate", {"graph": {"nodes": 3}})
        self.ask("POST", "/v1/evaluate", "/v1/evaluate", {"graph": {"nodes": {"n": {"type": "ShaderNodeTexNoise"}}}, "points": {"count": 2}, "outputs": ["n.Fac"]})
        for kind in ("application/json", "image/png"):
            self.ask("POST", "/v1/preview", "/v1/preview", {"graph": GRAPH, "size": 8, "samples": 1}, {"Accept": kind})
        self.ask("POST", "/v1/preview", "/v1/preview", {"graph": {"nodes": {"s": {"type": "alSurfac"}}}})
        self.ask("POST", "/v1/assets/missing", "/v1/assets/missing", {"digests": ["sha256:" + 64 * "0"]})
        status, _, upload = self.ask("POST", "/v1/uploads", "/v1/uploads", {"digest": "sha256:" + 64 * "1", "size": 10})
        self.assertEqual(status, 201)
        self.ask("GET", "/v1/uploads/" + upload["id"], "/v1/uploads/{id}")
        self.ask("DELETE", "/v1/uploads/" + upload["id"], "/v1/uploads/{id}")

    def test_a_scene_and_its_renders_fit_their_schemas(self):
        status, _, scene = self.ask("POST", "/v1/scenes", "/v1/scenes", SCENE)
        self.assertEqual(status, 201)
        at = "/v1/scenes/" + scene["id"]
        self.ask("GET", at, "/v1/scenes/{id}")
        self.ask("GET", at + "/materials/m", "/v1/scenes/{id}/materials/{name}")
        self.ask("PATCH", at, "/v1/scenes/{id}", {"settings": {"samples": 1}})   # 428
        self.ask("PATCH", at, "/v1/scenes/{id}", {"settings": {"samples": 1}}, {"If-Match": "*", "Content-Type": "application/merge-patch+json"})
        status, _, job = self.ask("POST", "/v1/renders", "/v1/renders", {"scene": scene["id"]})
        self.assertEqual(status, 202)
        self.ask("POST", "/v1/renders", "/v1/renders", {"scene": scene["id"], "seed": 3}, {"Prefer": "wait=60", "Accept": "application/json"})
        render = "/v1/renders/" + job["id"]
        for what in ("", "/outputs", "/stats", "/log"):
            self.ask("GET", render + what, "/v1/renders/{id}" + what)
        self.ask("DELETE", render, "/v1/renders/{id}")
        status, _, live = self.ask("POST", "/v1/renders", "/v1/renders", {"mode": "live", "graph": GRAPH, "resolution": [16, 16], "max_samples": 2})
        self.assertEqual(status, 201)
        at = "/v1/renders/" + live["id"]
        self.ask("GET", at, "/v1/renders/{id}")
        self.ask("GET", at + "/pixel?x=8&y=7&explain=1", "/v1/renders/{id}/pixel")
        self.ask("PATCH", at, "/v1/renders/{id}", {"mix": {"1": {"intensity": 2}}})
        self.ask("PATCH", at + "/graph", "/v1/renders/{id}/graph", {"nodes": {"s": {"params": {"diffuseColor": [0, 0, 1]}}}}, {"If-Match": "*", "Content-Type": "application/merge-patch+json"})
        self.ask("GET", at + "/stats", "/v1/renders/{id}/stats")
        self.ask("POST", at + "/cancel", "/v1/renders/{id}/cancel")


if __name__ == "__main__":
    unittest.main()
