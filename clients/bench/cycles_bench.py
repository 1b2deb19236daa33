"""Renders a .blend with Cycles for `alder bench`, in a Python that has bpy: an EXR of the beauty and the seconds of the render call."""
import argparse
import json
import os
import sys
import time


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--threads", type=int, required=True)
    parser.add_argument("--stats", required=True)
    parser.add_argument("--resolution")
    args = parser.parse_args()
    try:
        import bpy
    except ImportError:
        print("this Python has no bpy", file=sys.stderr)
        return 2
    bpy.ops.wm.open_mainfile(filepath=os.path.abspath(args.file))
    scene = bpy.context.scene
    r, c = scene.render, scene.cycles
    r.engine = "CYCLES"
    r.threads_mode, r.threads = "FIXED", args.threads
    c.device, c.samples, c.use_denoising, c.use_adaptive_sampling = "CPU", args.samples, False, False
    c.seed = 1
    if args.resolution:
        r.resolution_x, r.resolution_y = (int(v) for v in args.resolution.split("x"))
        r.resolution_percentage = 100
    r.use_compositing = r.use_sequencer = False
    r.image_settings.file_format, r.image_settings.color_depth, r.image_settings.exr_codec = "OPEN_EXR", "32", "ZIP"
    r.filepath = os.path.abspath(args.output)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=False)
    seconds = time.perf_counter() - start
    bpy.data.images["Render Result"].save_render(r.filepath)
    with open(args.stats, "w") as f:
        json.dump({"seconds": {"render": seconds}}, f)
    sys.stdout.flush()
    os._exit(0)   # bpy frees its memory slowly, or not at all


if __name__ == "__main__":
    sys.exit(main())
