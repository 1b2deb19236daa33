"""Run by a Python with bpy: the viewport's session without a window: a shining plane, its colour edited, moved away; results as JSON.

    python3 blender_viewport.py OUT_FOLDER
"""
import json
import os
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "blender"))

import bpy  # noqa: E402
import alder_blender  # noqa: E402
from alder_blender import backend, mirror, viewport  # noqa: E402

SIZE = (48, 32)
WINDOW = [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]]   # a perspective projection
ABOVE = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]


def main(folder):
    alder_blender.register()
    for o in list(bpy.data.objects):
        bpy.data.objects.remove(o)
    bpy.context.scene.world = None
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    plane = bpy.data.objects.new("plane", mesh)
    bpy.context.scene.collection.objects.link(plane)
    material = bpy.data.materials.new("lamp")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    emission.inputs["Color"].default_value = (0.1, 0.8, 0.1, 1)
    mesh.materials.append(material)
    bpy.context.view_layer.update()

    camera = viewport.projected({}, ABOVE, WINDOW, SIZE, 0.1, 100)
    session = viewport.Session(backend.local_client, SIZE, 4)
    seconds = []

    def middle():
        assert session.mirror.wait(30), session.mirror.error
        rgba = session.mirror.picture.layers["rgba"]
        return [float(x) for x in rgba[rgba.shape[0] // 2, rgba.shape[1] // 2, :3]]

    def update(scene, depsgraph):
        started = time.perf_counter()
        session.show(depsgraph, camera, SIZE, 4, depsgraph.updates)
        seconds.append(time.perf_counter() - started)
    session.show(bpy.context.evaluated_depsgraph_get(), camera, SIZE, 4)
    result = {"first": middle()}
    bpy.app.handlers.depsgraph_update_post.append(update)
    before = session.document
    emission.inputs["Color"].default_value = (0.1, 0.2, 0.9, 1)
    bpy.context.view_layer.update()
    result["edited"], result["update_seconds"] = middle(), seconds[-1]
    result["patch"] = mirror.difference(before, session.document)
    plane.location.x = 1000
    bpy.context.view_layer.update()
    result["moved"] = middle()
    session.close()
    with open(os.path.join(folder, "result.json"), "w") as f:
        json.dump(result, f)
    bpy.app.handlers.depsgraph_update_post.clear()
    alder_blender.unregister()   # ends the daemon


try:
    main(sys.argv[-1])
    status = 0
except BaseException:
    import traceback
    traceback.print_exc()
    backend.stop_local()
    status = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)   # bpy may hang while it frees what an exception still holds
