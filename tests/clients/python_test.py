"""The Python package against a daemon of its own: pictures, graphs, errors, images, await."""
import asyncio
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest
from http.server import BaseHTTPRequestHandler, HTTPServer

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve()
SCENE = ROOT / "docs" / "examples" / "triangle.glb"
sys.path.insert(0, str(ROOT / "clients" / "python"))
try:
    import numpy as np
    import alder
    from alder import exr
except ImportError:
    np = None


@unittest.skipIf(np is None, "needs numpy")
class Images(unittest.TestCase):
    def test_written_files_read_back(self):
        rng = np.random.default_rng(1)
        channels = {"R": rng.random((37, 21), np.float32), "a.X": rng.random((37, 21)).astype(np.float16), "Z": np.full((37, 21), 1e10, np.float32)}
        back, attributes = exr.decode(exr.encode(channels, {"alder/samples": "8"}, origin=(3, 5), full=(64, 64)))
        self.assertEqual(attributes["alder/samples"], "8")
        self.assertEqual(attributes["dataWindow"], [3, 5, 23, 41])
        for name, plane in channels.items():
            self.assertTrue(np.array_equal(back[name], plane), name)

    def test_broken_files_are_told(self):
        data = exr.encode({"R": np.zeros((20, 20), np.float32)})
        for broken in (b"", b"nothing at all", data[:40], data[:200], data[:-5], data[:300] + b"\xff" * 40 + data[340:]):
            try:
                exr.decode(broken)
            except exr.ExrError:
                pass
        with self.assertRaises(exr.ExrError):
            exr.decode(data[:-5])

    def test_what_alder_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.exr")
            run = subprocess.run([str(BUILD / "alder"), "render", str(SCENE), "-o", path, "--resolution", "33x21", "--samples", "2", "--aov", "data", "--aov", "shading"],
                                 capture_output=True, text=True, timeout=120)
            self.assertEqual(run.returncode, 0, run.stderr)
            image = alder.Image.open(path)
            self.assertEqual((image.shape, image["beauty"].shape, image["N"].shape, image["Z"].shape, image.samples), ((21, 33), (21, 33, 3), (21, 33, 3), (21, 33), 2))
            shading = [n for n in image if n.startswith(("direct_", "indirect_")) or n in ("sss", "single_scatter", "emission", "background")]
            parts = shading if "direct_refraction" in shading else shading + ["refraction"]
            total = sum(image[n] for n in parts)
            self.assertLess(np.abs(total - image["beauty"]).max(), 1e-4 * np.abs(image["beauty"]).max(), parts)
            self.assertTrue(image._repr_png_().startswith(b"\x89PNG"))
            image.save(os.path.join(folder, "b.exr"))
            self.assertEqual(pathlib.Path(folder, "b.exr").read_bytes(), pathlib.Path(path).read_bytes())
            with self.assertRaises(KeyError):
                image["nothing"]


@unittest.skipIf(np is None, "needs numpy")
class Daemon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = alder.local(program=str(BUILD / "alderd"))
        cls.scene = cls.client.scenes.push(SCENE, progress=None)

    @classmethod
    def tearDownClass(cls):
        cls.client.close()

    def test_a_render_is_that_of_the_command_line(self):
        image = self.client.render(self.scene, samples=4, resolution=[48, 27], seed=0, aovs=["shading"], output={"pixel_type": "float"}).result(progress=None)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.exr")
            subprocess.run([str(BUILD / "alder"), "render", str(SCENE), "-o", path, "--resolution", "48x27", "--samples", "4", "--seed", "0", "--aov", "shading", "--quiet"], check=True, timeout=120)
            reference = alder.Image.open(path)
        self.assertEqual(list(image), list(reference))
        self.assertTrue(np.array_equal(image["beauty"], reference["beauty"]))
        self.assertEqual(image.samples, 4)

    def test_scenes_and_assets_are_sent_once(self):
        data = os.urandom(1000)
        digest = self.client.assets.digest(data)
        self.assertEqual(self.client.assets.missing([digest]), [digest])
        self.assertEqual(self.client.assets.push(data), digest)
        self.assertEqual(self.client.assets.missing([digest]), [])
        self.assertEqual(self.client.assets.get(digest), data)
        material = self.scene.materials[0]
        graph = self.scene[material]
        self.scene[material] = graph
        self.assertEqual(self.scene[material], graph)

    def test_graphs_are_built_checked_and_shown(self):
        g = self.client.graph()
        noise = g.ShaderNodeTexNoise(Scale=8)
        remap = g.alRemapFloat("remap", input=noise.Fac, RMPcontrast=1.5)
        body = g.alSurface(diffuseColor=(0.8, 0.2, 0.1), specular1Roughness=remap)
        g.surface = body
        g.aovs["wear"] = remap
        document = g.document()
        self.assertEqual(document["nodes"]["remap"]["params"]["input"], {"node": "ShaderNodeTexNoise", "output": "Fac"})
        self.assertTrue(self.client.validate(g)["ok"])
        image = self.client.preview(g, size=24, samples=1, aovs=["wear"])
        self.assertEqual((image.shape, image["wear"].shape), ((24, 24), (24, 24)))
        self.assertIn("alSurface", dir(g))
        self.assertIn("specular1Roughness", dir(body))
        with self.assertRaises(alder.Invalid) as caught:
            g.alSurface(diffuseColour=1)
        self.assertIn("diffuseColor", str(caught.exception))
        with self.assertRaises(AttributeError):
            g.alSurfac()
        compile(self.client.nodes.stub(), "stub", "exec")
        value = self.client.evaluate(g, {"count": 2, "P": np.zeros((2, 3))}, ["remap"])
        self.assertEqual(len(value["outputs"]["remap"]), 2)

    def test_every_node_of_the_catalogue_can_be_made(self):
        for name in self.client.nodes.types:
            g = self.client.graph()
            getattr(g, name)()
            self.assertTrue(self.client.validate(g)["ok"], name)

    def test_errors_have_the_pointer(self):
        with self.assertRaises(alder.Invalid) as caught:
            self.client.preview({"version": 1, "nodes": {"s": {"type": "alSurface", "params": {"specular1Roughnes": 1}}}, "outputs": {"surface": {"node": "s"}}}, size=8, samples=1)
        error = caught.exception
        self.assertEqual((error.status, error.type, error.errors[0]["pointer"], error.errors[0]["suggest"]),
                         (422, "graph-invalid", "/graph/nodes/s/params/specular1Roughnes", "specular1Roughness"))
        self.assertIn("did you mean", str(error))
        with self.assertRaises(alder.NotFound):
            self.client.scenes.get("scn_00000000000000000000000000")
        with self.assertRaises(alder.AlderError):
            self.client.render(self.scene, samples=-3).result(progress=None)

    def test_await(self):
        async def session():
            async with await alder.aio.connect(self.client.url) as c:
                scene = await c.scenes.push(SCENE, progress=None)
                jobs = [await c.render(scene, samples=1, resolution=[16, 9], seed=s) for s in (1, 2)]
                images = await asyncio.gather(*(j.result(progress=None) for j in jobs))
                self.assertFalse(np.array_equal(images[0]["beauty"], images[1]["beauty"]))
                return [i async for i in jobs[0].images()]
        self.assertEqual(asyncio.run(session())[-1].samples, 1)

    def test_a_kept_render_is_followed_and_cancelled(self):
        job = self.client.render(self.scene, samples=64, resolution=[96, 54])
        images = list(job.images(0.02))
        self.assertIsNotNone(job.id)
        samples = [i.samples for i in images]
        self.assertEqual(samples, sorted(samples))
        self.assertEqual((job.state, samples[-1]), ("succeeded", 64))
        job = self.client.render(self.scene, samples=1 << 20, resolution=[640, 360])
        job.cancel()
        with self.assertRaises(alder.RenderFailed):
            job.result(timeout=60, progress=None)
        self.assertEqual(job.state, "cancelled")

    def test_a_live_view_shows_each_edit(self):
        scene = self.client.scenes.push(SCENE, progress=None)
        target = scene.materials[0] + "/Principled BSDF.Base Color"
        view = self.client.live(scene, size=(96, 54))
        with view:
            for color in ([1, 0, 0, 1], [0, 1, 0, 1]):
                view[target] = color
                latency = view.wait(20)
                self.assertIsNotNone(latency)
                self.assertLess(latency, 20)
            self.assertEqual(view[target], [0, 1, 0, 1])
            self.assertEqual(scene[scene.materials[0]]["nodes"]["Principled BSDF"]["params"]["Base Color"], [0, 1, 0, 1])
            self.assertGreater(view.image().samples, 0)

    def test_the_example_of_the_documentation(self):
        text = (ROOT / "docs" / "python.md").read_text()
        code = text.split("```python\n", 1)[1].split("```", 1)[0]
        self.assertLessEqual(len(code.strip().splitlines()), 10)
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "shot.glb").write_bytes(SCENE.read_bytes())
            run = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, timeout=250,
                                 env={**os.environ, "PYTHONPATH": str(ROOT / "clients" / "python"), "ALDER_URL": self.client.url})
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(pathlib.Path(folder, "shot.exr").read_bytes().startswith(b"\x76\x2f\x31\x01"))


class Faults(BaseHTTPRequestHandler):
    """A daemon that is busy twice, then answers."""
    seen = []

    def do_POST(self):
        Faults.seen.append((self.path, self.headers["Idempotency-Key"]))
        self.rfile.read(int(self.headers["Content-Length"]))
        busy = len(Faults.seen) < 3
        body = json.dumps({"type": "/problems/queue-full", "title": "full"} if busy else {"ok": True}).encode()
        self.send_response(503 if busy else 200)
        if busy:
            self.send_header("Retry-After", "0.01")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@unittest.skipIf(np is None, "needs numpy")
class Transport(unittest.TestCase):
    def test_passing_faults_are_retried_under_one_key(self):
        server = HTTPServer(("127.0.0.1", 0), Faults)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            client = alder.Client("http://127.0.0.1:%d" % server.server_port)
            self.assertTrue(client.validate({})["ok"])
        finally:
            server.shutdown()
            server.server_close()
        self.assertEqual(len(Faults.seen), 3)
        self.assertEqual(len({key for _, key in Faults.seen}), 1)

    def test_nobody_there(self):
        client = alder.Client("http://127.0.0.1:9", timeout=2)
        client.transport.retries = 1
        with self.assertRaises(alder.Unreachable):
            client.version()

    def test_live_targets(self):
        from alder.live import split_target
        nodes = {"a/b": {"x.y": {}, "x": {}}, "a": {"n": {}}}
        self.assertEqual(split_target("a/b/x.y.Base Color", list(nodes), nodes.__getitem__), ("a/b", "x.y", "Base Color"))
        self.assertEqual(split_target("a/n.p", list(nodes), nodes.__getitem__), ("a", "n", "p"))
        for wrong in ("c/n.p", "a/m.p", "a/n"):
            with self.assertRaises(KeyError):
                split_target(wrong, list(nodes), nodes.__getitem__)


if __name__ == "__main__":
    unittest.main()
