"""What the texture filter gains: the error of few samples a pixel against many, with `--texture-filter` on and off, on one scene.

    python3 tests/bench/texture_filter.py --build build

A floor to the horizon with a fine random texture of 2,048 x 2,048 texels, repeated, lit by itself, so that all noise is the texture's.
The reference has 1,024 samples a pixel and no filter, an error of 0.017 of its own. Error: root of the mean squared difference over all pixels, in parts of the mean
of the image. What the filter blurs too much
would show at 64 samples.
"""
import argparse
import json
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "clients" / "python"))
from alder import exr  # noqa: E402


def png(path, side):
    """Grey blocks of one texel, 8 bit."""
    generator = random.Random(1)
    rows = b"".join(b"\0" + generator.randbytes(side) for _ in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def scene():
    uv = [[0, 0], [40, 0], [40, 40], [0, 0], [40, 40], [0, 40]]
    graph = {"version": 1, "nodes": {
        "uv": {"type": "ShaderNodeTexCoord"},
        "tex": {"type": "ShaderNodeTexImage", "params": {"image": {"file": "blocks.png", "colorspace": "Non-Color"}, "Vector": {"node": "uv", "output": "UV"}}},
        "glow": {"type": "ShaderNodeEmission", "params": {"Color": {"node": "tex", "output": "Color"}}}}, "outputs": {"surface": {"node": "glow"}}}
    return {"alder_scene": 1, "settings": {"resolution": [256, 144], "samples": 1},
            "cameras": {"cam": {"look_at": {"from": [0, -20, 1.5], "to": [0, 0, 0.5]}, "fov_degrees": 45}}, "materials": {"floor": graph},
            "meshes": {"floor": {"positions": [[-20, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]], "triangles": [[0, 1, 2], [0, 2, 3]], "uv": uv}},
            "instances": {"floor": {"mesh": "floor", "material": "floor"}}}


def render(build, folder, name, samples, seed, filtered):
    target = folder / (name + ".exr")
    subprocess.run([str(pathlib.Path(build) / "alder"), "render", str(folder / "floor.json"), "-o", str(target), "--samples", str(samples), "--seed", str(seed),
                    "--texture-filter", "on" if filtered else "off", "--pixel-type", "float", "--quiet"], check=True)
    channels, _ = exr.decode(target.read_bytes())
    return channels["R"].astype(np.float64)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build")
    parser.add_argument("--reference-samples", type=int, default=1024)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        png(folder / "blocks.png", 2048)
        (folder / "floor.json").write_text(json.dumps(scene()))
        truth = render(args.build, folder, "reference", args.reference_samples, 1000, False)
        for samples in (1, 4, 16, 64):
            errors = {}
            for filtered in (False, True):
                difference = render(args.build, folder, "picture", samples, 1, filtered) - truth
                errors[filtered] = float(np.sqrt(np.mean(difference ** 2)) / np.mean(truth))
            print("%3d samples a pixel: error %.4f without, %.4f with the filter: as if there were %.1f times as many" % (
                samples, errors[False], errors[True], (errors[False] / errors[True]) ** 2))


if __name__ == "__main__":
    main()
