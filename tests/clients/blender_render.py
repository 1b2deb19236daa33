"""Run by a Python with bpy: F12 with Alder of a small scene, and an alShaders network built in the node editor; results as JSON.

    python3 blender_render.py OUT_FOLDER
"""
import json
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "blender"))

import bpy  # noqa: E402
import alder_blender  # noqa: E402
from alder_blender import al_nodes, passes  # noqa: E402


def al_material():
    m = bpy.data.materials.new("al")
    m.use_nodes = True
    tree = m.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    remap = tree.nodes.new("alRemapFloat")
    surface = tree.nodes.new("alSurface")
    surface.inputs["diffuseColor"].default_value = (0.8, 0.2, 0.1, 1)
    tree.links.new(noise.outputs[0], remap.inputs["input"])
    tree.links.new(remap.outputs[0], surface.inputs["specular1Roughness"])
    tree.links.new(surface.outputs[0], out.inputs["Surface"])
    return m


def main(folder):
    alder_blender.register()
    scene = bpy.context.scene
    scene.render.engine = "ALDER"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100
    if hasattr(scene, "cycles"):
        scene.cycles.samples = 4
        scene.cycles.use_denoising = False   # the program does not
    for o in scene.objects:
        if o.type == "MESH":
            o.data.materials.clear()
            o.data.materials.append(al_material())
    layer = scene.view_layers[0]
    for switch in passes.SWITCHES:
        if hasattr(layer, switch):
            setattr(layer, switch, True)
    layer.use_pass_mist = True
    layer.use_pass_ambient_occlusion = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):   # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE"
        settings.use_exr_interleave = True   # one part
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    scene.render.filepath = os.path.join(folder, "f12.exr")
    bpy.ops.render.render(write_still=True)

    from alder_blender import engine
    engine.export(os.path.join(folder, "scene.alder"))
    with open(os.path.join(folder, "result.json"), "w") as f:
        json.dump({"nodes": sorted(c.bl_idname for c in al_nodes.CLASSES), "passes": passes.wanted(layer)[0]}, f)
    alder_blender.unregister()
    alder_blender.register()   # twice in one session, as when the add-on is switched off and on
    alder_blender.unregister()


try:
    main(sys.argv[-1])
    status = 0
except BaseException:
    import traceback
    traceback.print_exc()
    status = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)   # bpy may hang while it frees what an exception still holds
