"""Command line: python3 -m alder_blender FILE.blend -o OUT.alder, in a Python that has bpy.

Or inside Blender: blender -b FILE.blend --python-expr "import sys; sys.path.insert(0, 'clients/blender');
from alder_blender.__main__ import main; main(['-o', 'OUT.alder'])"

Exit status: 0 written; 1 with --strict, where something was left out; 2 the request or the scene is wrong.
"""
import argparse
import os
import sys
import time


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m alder_blender", description="Write a Blender scene for Alder.")
    parser.add_argument("file", nargs="?", metavar="FILE.blend", help="left out inside Blender: the open file")
    parser.add_argument("-o", "--output", metavar="OUT.alder", help="default: the .blend's name")
    parser.add_argument("--scene", help="default: the file's active scene")
    parser.add_argument("--view-layer", help="default: the active one")
    parser.add_argument("--frame", type=float, help="default: the file's current frame")
    parser.add_argument("--strict", action="store_true", help="fail, and write nothing, where something cannot be exported")
    parser.add_argument("--quiet", action="store_true", help="only errors")
    a = parser.parse_args(arguments)
    try:
        import bpy
    except ImportError:
        return _fail("this Python has no bpy: pip install bpy, or run inside Blender (see --help)")
    try:
        import numpy  # noqa: F401
    except ImportError:
        return _fail("this Python has no numpy (Debian: apt-get install python3-numpy)")
    from . import engine
    from .report import ExportError

    if a.file:
        if not os.path.isfile(a.file):
            return _fail("%s: no such file" % a.file)
        try:
            bpy.ops.wm.open_mainfile(filepath=os.path.abspath(a.file))
        except RuntimeError as e:
            return _fail("%s: %s" % (a.file, str(e).strip()))
    name = a.file or bpy.data.filepath
    if not a.output and not name:
        return _fail("no output name: use -o OUT.alder")
    path = os.path.abspath(a.output or os.path.splitext(name)[0] + ".alder")
    scene = bpy.data.scenes.get(a.scene) if a.scene else bpy.context.scene
    if scene is None:
        return _fail("no scene \"%s\": there are %s" % (a.scene, ", ".join(s.name for s in bpy.data.scenes)))
    layer = scene.view_layers.get(a.view_layer) if a.view_layer else None
    if a.view_layer and layer is None:
        return _fail("no view layer \"%s\": there are %s" % (a.view_layer, ", ".join(v.name for v in scene.view_layers)))
    if a.frame is not None:
        scene.frame_set(int(a.frame // 1), subframe=a.frame % 1)
    started = time.perf_counter()
    temporary = "%s.%d.part" % (path, os.getpid())
    try:
        exporter = engine.export(temporary, scene, layer)
        left_out = bool(exporter.report)
        if not (a.strict and left_out):
            os.replace(temporary, path)
    except (ExportError, OSError, RuntimeError) as e:
        return _fail("%s: %s" % (name, str(e).strip()))
    finally:
        if os.path.exists(temporary):
            os.unlink(temporary)
    d = exporter.document
    if not a.quiet:
        print("%s: %d meshes, %d instances, %d materials, %d lights in %.1f s" % (
            path if not (a.strict and left_out) else name, len(d["meshes"]), sum(len(g[3]) for g in exporter.groups.values()),
            len(d["materials"]), len(d["lights"]), time.perf_counter() - started))
        for line in exporter.report.lines():
            print(line)
    if a.strict and left_out:
        return _fail("%s: not everything can be exported; nothing written" % name, 1)
    return 0


def _fail(text, status=2):
    print("alder_blender: " + text, file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
