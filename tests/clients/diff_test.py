"""alder diff: figures against their definitions, limits, layers, reports, and how sigma tells noise from change."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ALDER = str(pathlib.Path(os.environ.get("ALDER_BINARY_DIR", ROOT / "build")).resolve() / "alder")
sys.path.insert(0, str(ROOT / "tests" / "clients"))
try:
    import numpy as np
    import exr_images
except ImportError:
    np = None

# HDR-FLIP of the pictures below by the authors' flip-evaluator 1.7, with its own settings.
AUTHORS_FLIP = {"noise": 0.0491648, "shifted": 0.3113045, "darker": 0.2921367}


def changed(name, rgb):
    if name == "noise":
        return rgb * (1 + 0.2 * (np.random.default_rng(7).random(rgb.shape) - 0.5)).astype(np.float32)
    if name == "shifted":
        return np.roll(rgb, 2, axis=1)
    return rgb * np.float32(0.8)


def diff(*arguments):
    return subprocess.run([ALDER, "diff", *map(str, arguments)], capture_output=True, text=True, timeout=120)


@unittest.skipIf(np is None, "needs numpy")
class Diff(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.rgb = exr_images.picture()
        self.reference = exr_images.write(self.folder / "ref.exr", self.rgb)

    def figures(self, test, *arguments, reference=None, status=0):
        run = diff(test, reference or self.reference, "--json", *arguments)
        self.assertEqual(run.returncode, status, run.stderr)
        return json.loads(run.stdout)

    def test_figures_are_what_they_are_called(self):
        x = changed("noise", self.rgb)
        x[3, 4, 1] = np.nan
        f = self.figures(exr_images.write(self.folder / "a.exr", x))
        ok = np.isfinite(x).all(-1)
        a, r = x[ok].astype(np.float64), self.rgb[ok].astype(np.float64)
        relative = ((a - r) ** 2 / (r ** 2 + 0.01)).mean(-1)
        kept = np.sort(relative)[:len(relative) - int(len(relative) * 0.001)]
        for name, want in (("rmse", np.sqrt(((a - r) ** 2).mean())), ("relmse", relative.mean()), ("relmse_trimmed", kept.mean()),
                           ("max_abs", np.abs(a - r).max()), ("bias", a.mean() / r.mean() - 1)):
            self.assertAlmostEqual(f[name] / want, 1, 6, name)
        self.assertEqual((f["nonfinite"], f["ref_nonfinite"], f["exact"], f["sigma"]), (1, 0, False, None))
        d = np.abs(np.nan_to_num(x, nan=0) - self.rgb).max(-1) * ok
        self.assertEqual(f["max_abs_at"], [int(d.argmax() % 64), int(d.argmax() // 64)])

    def test_flip_is_the_authors(self):
        for name, want in AUTHORS_FLIP.items():
            got = self.figures(exr_images.write(self.folder / "a.exr", changed(name, self.rgb)))["flip"]
            self.assertLess(abs(got - want), 2e-5 + 2e-4 * want, "%s: flip %.7f against %.7f" % (name, got, want))
        self.assertEqual(self.figures(self.reference)["flip"], 0)
        for broken in (np.nan, np.inf, -1.0, 1e38):
            x = self.rgb.copy()
            x[5:7, 5:9] = broken
            f = self.figures(exr_images.write(self.folder / "a.exr", x))["flip"]
            self.assertTrue(0 < f < 1, "%s: %s" % (broken, f))
        black = exr_images.write(self.folder / "black.exr", self.rgb * 0)
        self.assertTrue(0 <= self.figures(self.reference, reference=black)["flip"] <= 1)

    def test_limits_decide_the_status(self):
        near = exr_images.write(self.folder / "near.exr", self.rgb * np.float32(1.001))
        run = diff(near, self.reference, "--limit", "relmse=1e-3", "--limit", "bias=0.01", "--limit", "nonfinite=0")
        self.assertEqual(run.returncode, 0, run.stderr)
        run = diff(near, self.reference, "--limit", "relmse=1e-9")
        self.assertEqual(run.returncode, 1)
        self.assertIn("relmse", run.stderr)
        self.assertIn("worst pixel", run.stderr)
        self.assertEqual(diff(near, self.reference, "--limit", "exact").returncode, 1)
        self.assertEqual(diff(self.reference, self.reference, "--limit", "exact").returncode, 0)
        run = diff(near, self.reference, "--limit", "relmes=1")
        self.assertEqual(run.returncode, 2)
        self.assertIn("did you mean 'relmse'", run.stderr)
        self.assertEqual(diff(near, self.reference, "--limit", "flip=-1").returncode, 2)
        self.assertEqual(diff(near, self.reference, "--limit", "sigma=4").returncode, 1)   # no variances: cannot pass

    def test_files_that_do_not_fit_are_status_2(self):
        small = exr_images.write(self.folder / "small.exr", self.rgb[:20])
        (self.folder / "text.exr").write_text("no picture")
        for test in (small, self.folder / "text.exr", self.folder / "nowhere.exr"):
            run = diff(test, self.reference)
            self.assertEqual(run.returncode, 2, test)
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)

    def test_layers_and_channels(self):
        a = exr_images.write(self.folder / "a.exr", self.rgb, Z=self.rgb[..., 0] + 1)
        b = exr_images.write(self.folder / "b.exr", self.rgb, Z=self.rgb[..., 0])
        self.assertAlmostEqual(self.figures(a, "--layer", "Z", reference=b)["max_abs"], 1, 5)
        self.assertEqual(self.figures(a, "--layer", "beauty.G", reference=b)["max_abs"], 0)
        self.assertEqual([f["layer"] for f in self.figures(a, "--layer", "all", reference=b)], ["beauty", "Z"])
        run = diff(a, b, "--layer", "beuty")
        self.assertEqual(run.returncode, 2)
        self.assertIn("beauty", run.stderr)

    def test_reports(self):
        x = exr_images.write(self.folder / "a.exr", changed("shifted", self.rgb))
        run = diff(x, self.reference, "--limit", "flip=0.001", "--junit", self.folder / "j.xml", "--heat-map", self.folder / "h.png")
        self.assertEqual(run.returncode, 1)
        suite = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot().find("testsuite")
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))
        self.assertIn("flip", suite.find("testcase/failure").get("message"))
        self.assertIn("relmse", [p.get("name") for p in suite.iter("property")])
        self.assertTrue((self.folder / "h.png").read_bytes().startswith(b"\x89PNG"))

    def test_sigma_tells_noise_from_change(self):
        rng = np.random.default_rng(3)
        truth = np.concatenate([self.rgb] * 4, axis=1)
        deviation = 0.3 * truth + 0.01

        def noisy(name, mean, n=16):
            samples = mean + deviation * rng.standard_normal((n, *mean.shape))
            return exr_images.write(self.folder / name, samples.mean(0), variance=samples.var(0, ddof=1) / n)
        a = noisy("a.exr", truth)
        for i in range(4):
            f = self.figures(noisy("b.exr", truth), reference=a)
            self.assertLess(f["sigma"], 4, "equal pictures, try %d" % i)
            self.assertGreater(f["relmse"], 1e-3)   # a fixed threshold would have to be far above the noise
        self.assertGreater(self.figures(noisy("c.exr", truth * 1.03), reference=a)["sigma"], 6, "3 % brighter")
        local = truth.copy()
        local[16:32, 96:112] *= 1.3
        self.assertGreater(self.figures(noisy("d.exr", local), reference=a)["sigma"], 6, "one square changed")
        self.assertEqual(self.figures(a, reference=a)["sigma"], 0)


if __name__ == "__main__":
    unittest.main()
