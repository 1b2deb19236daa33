"""What keeps a live render in step with a document, without Blender: what is sent for an edit, and what is shown then."""
import os
import pathlib
import sys
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
for folder in (ROOT / "clients" / "blender", ROOT / "clients" / "python"):
    sys.path.insert(0, str(folder))
try:
    import numpy as np
    import alder
    from alder_blender.mirror import NOTHING, Box, Mirror, difference
except ImportError:
    np = None


def merged(target, patch):
    """RFC 7396, as it is written there."""
    if not isinstance(patch, dict):
        return patch
    out = dict(target) if isinstance(target, dict) else {}
    for key, value in patch.items():
        if value is None:
            out.pop(key, None)
        else:
            out[key] = merged(out.get(key), value)
    return out


@unittest.skipIf(np is None, "needs numpy")
class Differences(unittest.TestCase):
    def test_a_patch_makes_the_new_of_the_old(self):
        old = {"a": 1, "b": {"c": [1, 2], "d": {"e": 1}}, "gone": {"x": 1}, "flag": True, "kind": {"node": "n"}}
        new = {"a": 1, "b": {"c": [1, 3], "d": {"e": 1}, "f": {}}, "flag": 1, "kind": 0.5}
        patch = difference(old, new)
        self.assertEqual(patch, {"b": {"c": [1, 3], "f": {}}, "gone": None, "flag": 1, "kind": 0.5})
        self.assertEqual(merged(old, patch), new)
        self.assertIs(difference(new, {**new}), NOTHING)

    def test_equal_arrays_are_sent_once(self):
        box = Box()
        a, b = box.array(np.arange(6, dtype=np.float32), 3), box.array(np.arange(6, dtype=np.float32), 3)
        c = box.array(np.arange(5, dtype=np.uint8), 1)
        pieces = box.take()
        (digest, data), = pieces.items()
        self.assertIs(a, b)
        self.assertEqual((a["buffer"], c["buffer"], alder.client.Assets.digest(data)), (digest, digest, digest))
        self.assertEqual(np.frombuffer(data, "u1", 5, c["offset"]).tolist(), [0, 1, 2, 3, 4])
        self.assertIs(box.array(np.arange(6, dtype=np.float32), 3), a)
        self.assertEqual(box.take(), {})


@unittest.skipIf(np is None, "needs numpy")
class Edits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = alder.local(program=str(BUILD / "alderd"))

    @classmethod
    def tearDownClass(cls):
        cls.client.close()

    def document(self, box, color=(0.8, 0.1, 0.1), x=0.0):
        quad = np.array([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]], np.float32)
        return {"alder_scene": 1, "settings": {"resolution": [48, 32]}, "cameras": {"view": {"look_at": {"from": [x, -0.01, 4], "to": [x, 0, 0]}}}, "camera": "view",
                "materials": {"m": {"version": 1, "nodes": {"e": {"type": "ShaderNodeEmission", "params": {"Color": [*color, 1], "Strength": 1.0}}},
                                    "outputs": {"surface": {"node": "e"}}}},
                "meshes": {"q": {"positions": box.array(quad, 3), "triangles": box.array(np.array([[0, 1, 2], [0, 2, 3]], np.uint32), 3)}},
                "instances": {"q": {"mesh": "q", "material": "m"}}, "lights": {}}

    def test_edits_are_shown(self):
        box, asked, lock = Box(), [], threading.Lock()
        mirror = Mirror(lambda: self.client, (48, 32), 4)
        self.addCleanup(mirror.close)
        ask = mirror._ask

        def spy(method, path, body, **headers):
            with lock:
                asked.append((method, path.split("/")[2], body))
            return ask(method, path, body, **headers)
        mirror._ask = spy

        def middle():
            self.assertTrue(mirror.wait(30), mirror.error)
            h, w, _ = mirror.picture.layers["rgba"].shape
            return mirror.picture.layers["rgba"][h // 2, w // 2, :3].tolist()
        first = self.document(box)
        mirror.show(first, box.take())
        for got, want in zip(middle(), (0.8, 0.1, 0.1)):
            self.assertAlmostEqual(got, want, 2)
        asked.clear()
        mirror.show({**self.document(box, (0.1, 0.2, 0.7))}, box.take())
        for got, want in zip(middle(), (0.1, 0.2, 0.7)):
            self.assertAlmostEqual(got, want, 2)
        self.assertEqual(asked, [("PATCH", "scenes", {"nodes": {"e": {"params": {"Color": [0.1, 0.2, 0.7, 1]}}}})])
        mirror.show(self.document(box, (0.1, 0.2, 0.7), x=100.0), box.take())   # the camera looks past it
        self.assertEqual(middle(), [0, 0, 0])
        mirror.show(self.document(box, (float("nan"), 0.2, 0.7)), box.take())   # no JSON: told, and the next edit is another try
        self.assertFalse(mirror.wait(30))
        self.assertTrue(mirror.error)
        mirror.show(self.document(box), box.take())
        mirror._condition.acquire()
        mirror._condition.wait_for(lambda: mirror.error is None, 30)
        mirror._condition.release()
        for got, want in zip(middle(), (0.8, 0.1, 0.1)):
            self.assertAlmostEqual(got, want, 2)


if __name__ == "__main__":
    unittest.main()
