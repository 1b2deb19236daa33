"""Strict renders: a texture that turns out broken only while it is read, long after it was opened, fails the job and is named."""
import hashlib
import json
import os
import pathlib
import struct
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/examples"))
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
SIDE, TILE = 1024, 64


def tiled_tiff():
    """RGB, 8 bit, uncompressed tiles; what describes it comes first, so that a file cut short still opens."""
    tiles, size = (SIDE // TILE) ** 2, TILE * TILE * 3
    entries, extra = [], b""
    extra_at = 8 + 2 + 11 * 12 + 4
    data_at = extra_at + 8 + 8 * tiles
    for tag, kind, values in ((256, 3, [SIDE]), (257, 3, [SIDE]), (258, 3, [8, 8, 8]), (259, 3, [1]), (262, 3, [2]), (277, 3, [3]), (284, 3, [1]),
                              (322, 3, [TILE]), (323, 3, [TILE]), (324, 4, [data_at + i * size for i in range(tiles)]), (325, 4, [size] * tiles)):
        packed = struct.pack("<%d%s" % (len(values), "HI"[kind - 3]), *values)
        if len(packed) > 4:
            entries.append(struct.pack("<HHII", tag, kind, len(values), extra_at + len(extra)))
            extra += packed + b"\0" * (len(packed) % 2)
        else:
            entries.append(struct.pack("<HHI", tag, kind, len(values)) + packed.ljust(4, b"\0"))
    head = b"II*\0" + struct.pack("<IH", 8, len(entries)) + b"".join(entries) + struct.pack("<I", 0)
    return head + extra.ljust(data_at - extra_at, b"\0") + bytes([180, 120, 60]) * (TILE * TILE * tiles)


def scene(digest):
    graph = {"nodes": {"t": {"type": "ShaderNodeTexImage", "params": {"image": {"asset": digest}}},
                       "s": {"type": "ShaderNodeBsdfDiffuse", "params": {"Color": {"node": "t", "output": "Color"}}}}, "outputs": {"surface": {"node": "s"}}}
    return {"alder_scene": 1, "cameras": {"cam": {"look_at": {"from": [0, -3, 0], "to": [0, 0, 0]}, "fov_degrees": 30}}, "materials": {"m": graph},
            "meshes": {"q": {"positions": [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], "triangles": [[0, 1, 2], [0, 2, 3]], "uv": [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]}},
            "instances": {"q": {"mesh": "q", "material": "m"}}, "lights": {"l": {"type": "point", "strength": 300, "look_at": {"from": [0, -3, 0], "to": [0, 0, 0]}}},
            "settings": {"resolution": [48, 48], "samples": 4}}


class StrictRenderTest(unittest.TestCase):
    def test_a_texture_that_breaks_while_it_is_read(self):
        whole = tiled_tiff()
        # Textures beyond the budget are read in tiles, as they are looked up.
        with Daemon(BUILD, "--texture-mib", "1") as daemon:
            def render(data, strict):
                digest = "sha256:" + hashlib.sha256(data).hexdigest()
                self.assertIn(daemon.ask("PUT", "/v1/assets/" + digest, data)[0], (200, 201))
                status, _, body = daemon.ask("POST", "/v1/scenes", scene(digest))
                self.assertEqual(status, 201, body)
                status, _, body = daemon.ask("POST", "/v1/renders", {"scene": json.loads(body)["id"], "strict": strict}, {"Prefer": "wait=120", "Accept": "application/json"})
                return status, json.loads(body)
            status, job = render(whole, True)
            self.assertEqual((status, job.get("state")), (200, "succeeded"), job)
            cut = whole[:len(whole) * 6 // 10]
            status, job = render(cut, False)
            self.assertEqual((status, job.get("state")), (200, "succeeded"), job)
            status, problem = render(cut, True)
            self.assertEqual((status, problem["type"]), (422, "/problems/scene-invalid"), problem)
            self.assertEqual(problem["errors"][0]["pointer"], "/materials/m/nodes/t/params/image", problem)
            self.assertEqual(problem["errors"][0]["code"], "asset-unreadable", problem)
            render_document = json.loads(daemon.ask("GET", "/v1/renders/" + problem["render"])[2])
            self.assertEqual((render_document["state"], render_document["outputs"]), ("failed", []))


if __name__ == "__main__":
    unittest.main()
