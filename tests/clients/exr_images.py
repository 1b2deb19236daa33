"""Small EXR files for tests, made with the Python client's writer."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "clients" / "python"))

import numpy as np  # noqa: E402

from alder import exr  # noqa: E402


def write(path, rgb, variance=None, **layers):
    channels = {c: rgb[..., i] for i, c in enumerate("RGB")}
    if variance is not None:
        channels.update({"variance." + c: variance[..., i] for i, c in enumerate("RGB")})
    channels.update({k: np.asarray(v, np.float32) for k, v in layers.items()})
    pathlib.Path(path).write_bytes(exr.encode({k: np.asarray(v, np.float32) for k, v in channels.items()}))
    return str(path)


def picture(width=64, height=40, seed=1):
    """Gradients, edges and a bright spot: something for every part of a metric."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float64)
    rgb = np.stack([x / width, y / height, 0.3 + 0.3 * np.sin(x / 5)], axis=-1)
    rgb[10:20, 12:30] = [4.0, 0.2, 0.1]
    rgb[30:32, 40:44] = 60.0
    return (rgb + 0.02 * np.random.default_rng(seed).random((height, width, 3))).astype(np.float32)
