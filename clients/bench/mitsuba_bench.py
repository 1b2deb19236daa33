"""Renders a Mitsuba 3 scene for `alder bench`, in a Python that has mitsuba: an EXR and the seconds of the render call."""
import argparse
import json
import subprocess
import sys
import time


def works(variant):
    """Whether a picture comes of it: an LLVM that is too old (Debian 12's is) ends the process."""
    code = "import mitsuba as m; m.set_variant(%r); m.Bitmap(m.render(m.load_dict(m.cornell_box()), spp=1))" % variant
    return subprocess.run([sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--threads", type=int, required=True)
    parser.add_argument("--stats", required=True)
    parser.add_argument("--resolution")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    args = parser.parse_args()
    try:
        import drjit
        import mitsuba
    except ImportError:
        print("this Python has no mitsuba", file=sys.stderr)
        return 2
    if args.variant.startswith("llvm") and not works(args.variant):
        print("%s does not work with this machine's LLVM (name a newer one in DRJIT_LIBLLVM_PATH); scalar_rgb is used" % args.variant, file=sys.stderr)
        args.variant = "scalar_rgb"
    mitsuba.set_variant(args.variant)
    drjit.set_thread_count(args.threads)
    defaults = {}
    if args.resolution:
        defaults = dict(zip(("width", "height"), args.resolution.split("x")))
    scene = mitsuba.load_file(args.file, **defaults)
    start = time.perf_counter()
    image = mitsuba.render(scene, spp=args.samples, seed=1)
    bitmap = mitsuba.Bitmap(image)   # waits for the computation
    seconds = time.perf_counter() - start
    bitmap.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32).write(args.output)
    with open(args.stats, "w") as f:
        json.dump({"seconds": {"render": seconds}}, f)
    return 0


if __name__ == "__main__":
    sys.exit(main())
