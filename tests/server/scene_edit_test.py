"""PATCH of a scene document: what an edit leaves alone is not built again, a live render follows, and pictures are those of a scene
made anew."""
import copy
import json
import os
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
sys.path.insert(0, str(ROOT / "tests/server"))
from daemon import Daemon  # noqa: E402
from openapi_test import GRAPH, SCENE  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
MERGE = {"Content-Type": "application/merge-patch+json"}


def two_things():
    scene = copy.deepcopy(SCENE)
    scene["meshes"]["floor"] = {"positions": [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], "triangles": [[0, 1, 2], [0, 2, 3]]}
    scene["instances"]["floor"] = {"mesh": "floor", "material": "m"}
    return scene


class SceneEditTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(BUILD).__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__()

    def ask(self, method, path, body=None, headers=None, expect=200):
        status, answered, text = self.daemon.ask(method, path, body, headers)
        self.assertEqual(status, expect, text[:500])
        return answered, text if "image" in answered.get("Content-Type", "") else json.loads(text or b"null")

    def create(self, scene):
        return self.ask("POST", "/v1/scenes", scene, expect=201)[1]

    def picture(self, scene):
        return self.ask("POST", "/v1/renders", {"scene": scene, "samples": 4, "output": {"pixel_type": "float"}}, {"Prefer": "wait=60", "Accept": "image/x-exr"})[1]

    def edit(self, scene, patch, **more):
        return self.ask("PATCH", "/v1/scenes/" + scene, patch, {**MERGE, "If-Match": "*", **more.pop("headers", {})}, **more)[1]

    def test_each_kind_of_edit_builds_only_what_it_touches(self):
        id = self.create(two_things())["id"]
        moved = self.edit(id, {"instances": {"a": {"transform": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]}}})
        self.assertEqual((moved["changed"], moved["rebuild"]), (["instances/a"], "instances"))
        self.assertEqual((moved["reused"]["meshes"], moved["reused"]["meshes_built"]), (2, 0), "a transform leaves the meshes' BVHs")
        self.assertEqual((moved["reused"]["materials_compiled"], moved["reused"]["world"]), (0, True))
        camera = self.edit(id, {"cameras": {"cam": {"fov_degrees": 55}}})
        self.assertEqual((camera["changed"], camera["rebuild"]), (["cameras/cam"], "none"))
        self.assertTrue(camera["reused"]["geometry"] and camera["reused"]["lights"])
        light = self.edit(id, {"lights": {"l": {"strength": 900}}})
        self.assertEqual((light["changed"], light["rebuild"]), (["lights/l"], "lights"))
        self.assertTrue(light["reused"]["geometry"])
        mesh = self.edit(id, {"meshes": {"t": {"positions": [[-1, 0, 0], [1, 0, 0], [0, 0, 1]]}}})
        self.assertEqual((mesh["changed"], mesh["rebuild"]), (["meshes/t"], "geometry"))
        self.assertEqual((mesh["reused"]["meshes"], mesh["reused"]["meshes_built"]), (1, 1), "the other mesh stays")
        shading = self.edit(id, {"materials": {"m": {"nodes": {"s": {"params": {"diffuseColor": [0, 0, 1]}}}}}})
        self.assertEqual(shading["rebuild"], "shading")
        self.assertTrue(shading["reused"]["geometry"])
        self.assertEqual(self.edit(id, {})["rebuild"], "none")

    def test_an_edited_scene_renders_as_one_made_anew(self):
        patch = {"instances": {"a": {"transform": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0.2]}}, "lights": {"l": {"strength": 900}}, "cameras": {"cam": {"fov_degrees": 60}},
                 "materials": {"m": {"nodes": {"s": {"params": {"diffuseColor": [0.1, 0.2, 0.9]}}}}}}
        id = self.create(two_things())["id"]
        before = self.picture(id)
        for name, value in patch.items():
            self.edit(id, {name: value})
        whole = two_things()
        whole["instances"]["a"].update(patch["instances"]["a"])
        whole["lights"]["l"].update(patch["lights"]["l"])
        whole["cameras"]["cam"].update(patch["cameras"]["cam"])
        whole["materials"]["m"]["nodes"]["s"]["params"].update(patch["materials"]["m"]["nodes"]["s"]["params"])
        after = self.picture(id)
        self.assertNotEqual(after, before)
        self.assertEqual(after, self.picture(self.create(whole)["id"]), "file by file the same")

    def test_edits_of_graphs_are_part_of_the_document(self):
        id = self.create(two_things())["id"]
        self.ask("PATCH", "/v1/scenes/%s/materials/m" % id, {"nodes": {"s": {"params": {"diffuseColor": [0, 1, 0]}}}}, {**MERGE, "If-Match": "*"})
        self.edit(id, {"settings": {"samples": 3}})
        self.assertEqual(self.ask("GET", "/v1/scenes/%s/materials/m" % id)[1]["nodes"]["s"]["params"]["diffuseColor"], [0, 1, 0])

    def test_what_would_be_wrong_leaves_the_scene_as_it_was(self):
        scene = self.create(two_things())
        at = "/v1/scenes/" + scene["id"]
        self.ask("PATCH", at, {"settings": {"samples": 1}}, MERGE, expect=428)
        self.ask("PATCH", at, {"settings": {"samples": 1}}, {**MERGE, "If-Match": '"99"'}, expect=412)
        problem = self.edit(scene["id"], {"instances": {"a": {"mesh": "nowhere"}}}, expect=422)
        self.assertEqual(problem["errors"][0]["pointer"], "/instances/a/mesh")
        self.ask("PATCH", "/v1/scenes/scn_" + 26 * "0", {}, {"If-Match": "*"}, expect=404)
        answered, now = self.ask("GET", at)
        self.assertEqual((now["revision"], answered["ETag"]), (1, scene["etag"]))
        operations = [{"op": "replace", "path": "/cameras/cam/fov_degrees", "value": 30}]
        edit = self.ask("PATCH", at, operations, {"Content-Type": "application/json-patch+json", "If-Match": scene["etag"]})[1]
        self.assertEqual(edit["scene"], {"revision": 2, "etag": '"2"'})

    def test_patches_that_cannot_be_applied_are_named(self):
        """An addition below something that holds nothing once ended the daemon."""
        at = "/v1/scenes/" + self.create(two_things())["id"]
        headers = {"Content-Type": "application/json-patch+json", "If-Match": "*"}
        for operation in ({"op": "add", "path": "/alder_scene/x", "value": 1}, {"op": "copy", "from": "/meshes", "path": "/cameras/cam/fov_degrees/x"},
                          {"op": "move", "from": "/lights", "path": "/lights/l/x"}, {"op": "remove", "path": "/nothing"}, {"op": "jump", "path": ""}, 7, {"op": 3},
                          {"op": "add", "path": "no pointer", "value": 1}):
            problem = self.ask("PATCH", at, [operation], headers, expect=422)[1]
            self.assertEqual((problem["type"], problem["errors"][0]["pointer"]), ("/problems/request-invalid", "/0"), operation)
        override = [{"op": "add", "path": "/settings/samples/x", "value": 1}]
        self.ask("POST", "/v1/renders", {"scene": at.rsplit("/", 1)[1], "overrides": override}, expect=422)

    def test_a_live_render_follows_and_says_which_edit_it_shows(self):
        id = self.create(two_things())["id"]
        live = self.ask("POST", "/v1/renders", {"mode": "live", "scene": id, "max_samples": 4}, expect=201)[1]
        at = "/v1/renders/" + live["id"]
        before = self.ask("GET", at + "/snapshot.exr")[1]
        self.edit(id, {"instances": {"a": {"transform": [1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0]}}}, headers={"Alder-Edit-Id": "moved"})
        for _ in range(600):
            answered, now = self.ask("GET", at + "/snapshot.exr")
            document = self.ask("GET", at)[1]
            if document["progress"]["up_to_date"] and document["revision"] == '"2"':
                break
        self.assertEqual(document["scene"], {"id": id, "revision": '"2"'})
        self.assertNotEqual(self.ask("GET", at + "/snapshot.exr")[1], before)
        self.ask("DELETE", at, expect=204)

    def test_explain_tells_values_of_nodes_and_closures(self):
        graph = {"nodes": {"c": {"type": "ShaderNodeMath", "params": {"operation": "ADD", "Value": 0.25, "Value_001": 0.5}},
                           "unused": {"type": "ShaderNodeTexNoise"},
                           "s": {"type": "ShaderNodeBsdfDiffuse", "params": {"Color": {"node": "c"}}}}, "outputs": {"surface": {"node": "s"}}}
        live = self.ask("POST", "/v1/renders", {"mode": "live", "graph": graph, "stage": "sphere", "resolution": [32, 32], "max_samples": 1}, expect=201)[1]
        at = "/v1/renders/%s/pixel?explain=1&" % live["id"]
        explain = self.ask("GET", at + "x=16&y=16")[1]["explain"]
        self.assertEqual((explain["hit"], explain["object"], explain["material"]), (True, "sphere", "subject"))
        self.assertAlmostEqual(explain["nodes"]["c"]["outputs"]["Value"], 0.75, 6)
        self.assertEqual(explain["nodes"]["s"]["inputs"]["Color"]["from"], "c.Value")
        self.assertAlmostEqual(explain["nodes"]["s"]["inputs"]["Color"]["value"], 0.75, 6)
        self.assertEqual([(c["node"], c["closure"]) for c in explain["closures"]], [("s", "diffuse")])
        for w in explain["closures"][0]["weight"]:
            self.assertAlmostEqual(w, 0.75, 5)
        self.assertTrue(any("unused" in s for s in explain["skipped"]), explain["skipped"])
        floor = self.ask("GET", at + "x=1&y=31")[1]
        self.assertEqual(floor["explain"]["material"], "floor")
        self.ask("GET", "/v1/renders/%s/pixel?x=1" % live["id"], expect=400)


if __name__ == "__main__":
    unittest.main()
