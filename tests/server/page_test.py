"""The lookdev page in Chromium: it draws the network, controls come from the schema, edits change the picture. Skipped where
chromium and chromedriver are not installed (./dev test-page installs them)."""
import hashlib
import json
import os
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "docs/examples"), str(ROOT / "tests/server")]
from browser import Browser, have_browser  # noqa: E402
from daemon import Daemon  # noqa: E402

BUILD = os.environ.get("ALDER_BINARY_DIR", str(ROOT / "build"))
SHOTS = os.environ.get("ALDER_SCREENSHOTS")   # a folder: pictures of the page are left there

DONE = "const s = document.getElementById('status').dataset; return s.edit === String(arguments[0]) && s.edit"
MEAN = """const c = document.getElementById('canvas'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
let s = [0, 0, 0]; for (let i = 0; i < d.length; i += 4) for (let k = 0; k < 3; ++k) s[k] += d[i + k]; return s.map(x => 4 * x / d.length)"""
SAME = "const mean = (() => { " + MEAN + " })(); return String(mean) %s String(arguments[0])"
SET = """const e = document.querySelector(arguments[0]); e.value = arguments[1];
e.dispatchEvent(new Event('input', {bubbles: true})); e.dispatchEvent(new Event('change', {bubbles: true}))"""


class PageFilesTest(unittest.TestCase):
    def test_files_have_types_tags_and_a_policy_and_every_example_renders(self):
        with Daemon(BUILD) as daemon:
            self.assertEqual(daemon.ask("GET", "/")[0], 200, "it leads to the page")
            for path, kind in (("/ui", "text/html"), ("/ui/app.js", "text/javascript"), ("/ui/live.js", "text/javascript"), ("/ui/style.css", "text/css"), ("/ui/icon.svg", "image/svg+xml")):
                status, headers, _ = daemon.ask("GET", path)
                self.assertEqual(status, 200, path)
                self.assertTrue(headers["Content-Type"].startswith(kind), (path, headers["Content-Type"]))
                self.assertIn("default-src 'none'", headers["Content-Security-Policy"], path)
                self.assertEqual(daemon.ask("GET", path, headers={"If-None-Match": headers["ETag"]})[0], 304, path)
            for path in ("/ui/no.js", "/ui/examples/no.json", "/ui/..%2f..%2fetc%2fpasswd", "/ui/examples/..%2fapp.js"):
                self.assertEqual(daemon.ask("GET", path)[0], 404, path)
            about = json.loads(daemon.ask("GET", "/ui/examples")[2])
            self.assertIn("shaderball", about["stages"])
            self.assertGreaterEqual(len(about["examples"]), 4)
            for example in about["examples"]:
                graph = json.loads(daemon.ask("GET", "/ui/examples/" + example["file"])[2])
                status, _, body = daemon.ask("POST", "/v1/preview", {"graph": graph, "size": 32, "samples": 1}, {"Accept": "image/png"})
                self.assertEqual(status, 200, (example["file"], body[:500]))


@unittest.skipUnless(have_browser(), "chromium and chromedriver are not installed")
class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(BUILD).__enter__()
        cls.browser = Browser(1360, 940).__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.daemon.__exit__()

    def open(self):
        self.browser.go(self.daemon.url + "/ui")
        self.browser.wait("return Number(document.getElementById('status').dataset.shown) >= 1")
        self.edits = 1
        self.browser.messages()   # of the test before
        self.act("document.getElementById('size').value = '128'; document.getElementById('size').dispatchEvent(new Event('change'))")
        self.act("document.getElementById('samples').value = '16'; document.getElementById('samples').dispatchEvent(new Event('change'))")

    def act(self, code, *arguments):
        """Does one edit and waits for its last picture."""
        self.browser.script(code, *arguments)
        self.edits += 1
        self.browser.wait(DONE, self.edits)

    def turn(self, value):
        self.browser.script("document.querySelectorAll('#mixer input[type=range]').forEach(e => { e.value = arguments[0]; e.dispatchEvent(new Event('input')) })", value)
        self.edits += 4
        self.browser.wait(DONE, self.edits)

    def rays(self):
        text = self.daemon.ask("GET", "/metrics")[2].decode()
        return sum(float(line.split()[-1]) for line in text.splitlines() if line.startswith("alder_live_passes_total"))

    def shot(self, name):
        if SHOTS:
            self.browser.screenshot(os.path.join(SHOTS, name + ".png"))

    def choose(self, example):
        self.act(SET, "#example", example)

    def test_an_edit_changes_the_picture_and_undo_brings_it_back(self):
        self.open()
        self.choose("weathered_paint.graph.json")
        nodes = self.browser.script("return [...document.querySelectorAll('#graph .node')].map(n => n.dataset.node)")
        self.assertEqual(len(nodes), 13, nodes)
        before = self.browser.script(MEAN)
        self.browser.script("document.querySelector('[data-node=dirt]').dispatchEvent(new Event('click'))")
        self.assertIn("alFractal", self.browser.script("return document.getElementById('node-summary').textContent"))
        self.shot("page")
        # The mix of paint choice from 0 to 1: blue instead of red.
        self.browser.script("document.querySelector('[data-node=\"paint choice\"]').dispatchEvent(new Event('click'))")
        self.act(SET, "[data-parameter=mix] input[type=number]", "1")
        after = self.browser.script(MEAN)
        self.assertGreater(before[0] - after[0], 2, (before, after))
        self.assertGreater(after[2] - before[2], 2, (before, after))
        self.act("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true}))")
        self.assertEqual(self.browser.script(MEAN), before)
        self.assertEqual(self.browser.messages(), [])

    def test_layers_light_groups_pixels_and_comparison(self):
        self.open()
        self.act("const b = document.getElementById('with-layers'); b.checked = true; b.dispatchEvent(new Event('change'))")
        self.browser.wait("return document.getElementById('layer').options.length > 8")
        layers = self.browser.script("return [...document.getElementById('layer').options].map(o => o.value)")
        for name in ("", "N", "direct_diffuse", "light_group_default"):
            self.assertIn(name, layers)
        beauty = self.browser.script(MEAN)
        self.browser.script(SET, "#layer", "N")
        self.browser.wait(SAME % "!==", beauty)
        self.browser.script(SET, "#layer", "")
        self.browser.wait(SAME % "===", beauty)
        self.browser.script(SET, "#exposure", "-6")
        self.assertLess(sum(self.browser.script(MEAN)), 0.5 * sum(beauty))
        self.browser.script(SET, "#exposure", "0")
        # Sliders of the light groups: all of them at 0 leave black, and back at 1 what was there; no ray is traced for it.
        names = self.browser.script("return [...document.querySelectorAll('#mixer label > span')].map(e => e.textContent)")
        self.assertEqual(names, ["key", "fill", "rim", "world"])
        rays = self.rays()
        self.turn(0)
        self.assertLess(max(self.browser.script(MEAN)), 1)
        self.turn(1)
        self.assertEqual(self.browser.script(MEAN), beauty)
        self.assertEqual(self.rays(), rays)
        self.browser.script("const c = document.getElementById('canvas').getBoundingClientRect(); document.getElementById('frame').dispatchEvent("
                            "new PointerEvent('pointermove', {clientX: c.left + c.width / 2, clientY: c.top + c.height / 2}))")
        rows = self.browser.script("return [...document.querySelectorAll('#pixel th')].map(t => t.textContent)")
        self.assertEqual(rows[0], "beauty at 64, 64")
        self.browser.wait("return document.querySelectorAll('#pixel th').length > arguments[0]", len(layers))   # the pointer rests: all layers
        self.browser.script("const c = document.getElementById('canvas').getBoundingClientRect(); document.getElementById('frame').dispatchEvent("
                            "new MouseEvent('click', {clientX: c.left + c.width / 2, clientY: c.top + c.height / 2}))")
        self.browser.wait("return document.getElementById('pixel').dataset.pinned")
        text = self.browser.script("return document.getElementById('pixel').innerText")
        self.assertIn("nodes at the first surface", text)
        self.assertIn("closures", text)
        self.shot("layers")
        self.browser.script("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: 'a', bubbles: true}))")
        self.act(SET, "#stage", "plane")
        other = self.browser.script(MEAN)
        self.browser.script(SET, "#wipe", "100")
        self.assertEqual(self.browser.script(MEAN), beauty)
        self.browser.script(SET, "#wipe", "0")
        self.assertEqual(self.browser.script(MEAN), other)
        self.assertEqual(self.browser.messages(), [])

    def test_a_fault_is_named_and_the_last_picture_stays(self):
        self.open()
        before = self.browser.script(MEAN)
        self.browser.script("const d = new DataTransfer(); d.items.add(new File([arguments[0]], 'bad.json')); "
                            "document.dispatchEvent(new DragEvent('drop', {dataTransfer: d, bubbles: true, cancelable: true}))",
                            json.dumps({"nodes": {"s": {"type": "alSurface", "params": {"diffuseColr": 1}}}, "outputs": {"surface": {"node": "s"}}}))
        self.edits += 1
        self.browser.wait(DONE, self.edits)
        text = self.browser.script("return document.getElementById('errors').textContent")
        self.assertIn("/nodes/s/params/diffuseColr", text)
        self.assertIn("diffuseColor", text)
        self.assertEqual(self.browser.script(MEAN), before)

    def test_a_token_is_asked_for_and_kept_in_a_cookie(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = os.path.join(folder, "tokens")
            with open(tokens, "w") as f:
                f.write("page:read,render,edit:" + hashlib.sha256(b"open sesame").hexdigest() + "\n")
            with Daemon(BUILD, "--token-file", tokens) as daemon:
                self.browser.go(daemon.url + "/ui")
                self.browser.wait("return document.getElementById('login').open")
                self.browser.script("document.getElementById('token').value = 'open sesame'; document.querySelector('#login button').click()")
                self.browser.wait("return Number(document.getElementById('status').dataset.shown) >= 1")
                self.assertEqual(self.browser.script("return document.cookie"), "", "no script reads it")
                self.browser.go(daemon.url + "/ui")
                self.browser.wait("return Number(document.getElementById('status').dataset.shown) >= 1")
                self.assertFalse(self.browser.script("return document.getElementById('login').open"))
        self.browser.go(self.daemon.url + "/livez")
        self.browser.messages()

    def test_the_keyboard_alone_reaches_nodes_and_controls(self):
        self.open()
        self.choose("weathered_paint.graph.json")
        self.browser.script("document.getElementById('graph').focus()")
        start = self.browser.script("return document.querySelector('[aria-selected=true]').dataset.node")
        self.assertEqual(start, "body")
        self.browser.keys("#graph", "\ue012")   # arrow left
        selected = self.browser.script("return document.querySelector('[aria-selected=true]').dataset.node")
        self.assertIn(selected, ("paint", "steel", "wear"))
        self.assertEqual(self.browser.script("return document.getElementById('node-title').textContent"), selected)
        unnamed = self.browser.script("return [...document.querySelectorAll('input,select,textarea')].filter(e => !e.hidden && !e.ariaLabel && !e.labels.length).map(e => e.outerHTML)")
        self.assertEqual(unnamed, [])

    def test_a_narrow_screen_has_one_column(self):
        with Browser(420, 900) as narrow:
            narrow.go(self.daemon.url + "/ui")
            narrow.wait("return Number(document.getElementById('status').dataset.shown) >= 1")
            wide = narrow.script("return document.documentElement.scrollWidth - document.documentElement.clientWidth")
            self.assertLessEqual(wide, 0)
            if SHOTS:
                narrow.screenshot(os.path.join(SHOTS, "narrow.png"))


if __name__ == "__main__":
    unittest.main()
