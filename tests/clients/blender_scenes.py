"""Run by a Python with bpy: builds the scene that blender_export_test.py looks at, and exports it.

    python3 blender_scenes.py OUT.alder
"""
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "clients", "blender"))

import bpy  # noqa: E402
from alder_blender import __main__ as command  # noqa: E402


def material(name, color=None):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    if color:
        m.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    return m


def add(name, data):
    o = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(o)
    return o


def grouped_material():
    """Twice: Scale -> Value, used twice; a painted image; a muted node."""
    g = bpy.data.node_groups.new("twice", "ShaderNodeTree")
    if hasattr(g, "interface"):
        g.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketFloat")
        g.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
    else:
        g.inputs.new("NodeSocketFloat", "In")
        g.outputs.new("NodeSocketFloat", "Out")
    a, b, m = g.nodes.new("NodeGroupInput"), g.nodes.new("NodeGroupOutput"), g.nodes.new("ShaderNodeMath")
    m.operation = "MULTIPLY"
    m.inputs[1].default_value = 2
    g.links.new(a.outputs[0], m.inputs[0])
    g.links.new(m.outputs[0], b.inputs[0])

    mat = material("grouped")
    t = mat.node_tree
    first, second = t.nodes.new("ShaderNodeGroup"), t.nodes.new("ShaderNodeGroup")
    first.node_tree = second.node_tree = g
    first.inputs[0].default_value = 0.125
    gamma = t.nodes.new("ShaderNodeGamma")
    gamma.mute = True
    image = t.nodes.new("ShaderNodeTexImage")
    image.image = bpy.data.images.new("painted", 4, 2)
    image.image.generated_color = (1, 0.5, 0.25, 1)
    bsdf = t.nodes["Principled BSDF"]
    t.links.new(first.outputs[0], second.inputs[0])
    t.links.new(second.outputs[0], bsdf.inputs["Roughness"])
    t.links.new(image.outputs["Color"], gamma.inputs["Color"])
    t.links.new(gamma.outputs["Color"], bsdf.inputs["Base Color"])
    return mat


def meshes():
    box = bpy.data.meshes.new("box")
    v = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    f = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    box.from_pydata(v, [], f)
    for p in box.polygons:
        p.use_smooth = p.index != 0
        p.material_index = p.index % 2
    for name in ("first", "second"):
        box.uv_layers.new(name=name)
    box.uv_layers["second"].active_render = True
    for domain, kind, n in (("POINT", "FLOAT", 8), ("FACE", "INT", 6), ("CORNER", "FLOAT_COLOR", 24), ("POINT", "FLOAT_VECTOR", 8)):
        a = box.attributes.new("%s_%s" % (domain, kind), kind, domain)
        for i in range(n):
            if kind == "FLOAT_COLOR":
                a.data[i].color = (i, i + 0.25, i + 0.5, 1)
            elif kind == "FLOAT_VECTOR":
                a.data[i].vector = (i, 2 * i, 3 * i)
            else:
                a.data[i].value = i
    box.materials.append(grouped_material())
    box.materials.append(material("blue", (0, 0, 1, 1)))
    o = add("box", box)
    o.visible_shadow = False
    o.pass_index = 7
    o.color = (0.5, 0.25, 0.125, 1)
    # Hidden in the viewport's sense only: a final render has it twice as fine.
    s = o.modifiers.new("subdivide", "SUBSURF")
    s.levels, s.render_levels, s.subdivision_type = 0, 1, "SIMPLE"

    tri = bpy.data.meshes.new("tri")
    tri.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    collection = bpy.data.collections.new("leaves")
    leaf = bpy.data.objects.new("leaf", tri)
    collection.objects.link(leaf)
    for i in range(5):
        e = add("place%d" % i, None)
        e.instance_type, e.instance_collection = "COLLECTION", collection
        e.location = (i, 0, 0)
    text = bpy.data.curves.new("text", "FONT")
    text.body = "A"
    add("text", text)
    add("hidden", tri).hide_render = True


def lights_and_camera():
    for name, kind, energy in (("point", "POINT", 10), ("spot", "SPOT", 20), ("sun", "SUN", 3), ("area", "AREA", 40)):
        light = bpy.data.lights.new(name, kind)
        light.energy = energy
        o = add(name, light)
        o.location = (0, 0, 5)
    bpy.data.lights["spot"].spot_size = math.radians(60)
    bpy.data.lights["area"].shape = "RECTANGLE"
    bpy.data.lights["area"].size, bpy.data.lights["area"].size_y = 2, 3
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.sensor_width, camera.lens, camera.shift_x = "HORIZONTAL", 36, 18, 0.25
    camera.dof.use_dof, camera.dof.aperture_fstop, camera.dof.focus_distance = True, 2, 7
    o = add("camera", camera)
    o.location = (0, 0, 10)
    bpy.context.scene.camera = o
    pano = bpy.data.cameras.new("pano")
    pano.type = "PANO"
    (pano if hasattr(pano, "panorama_type") else pano.cycles).panorama_type = "EQUIANGULAR_CUBEMAP_FACE"
    add("pano", pano)
    dome = bpy.data.cameras.new("dome")
    dome.type = "PANO"
    (dome if hasattr(dome, "panorama_type") else dome.cycles).panorama_type = "FISHEYE_EQUIDISTANT"
    add("dome", dome)


def hair_and_motion():
    """Two hairs, where this Blender lets Python make them, and a triangle that moves by 4 a frame and grows."""
    if hasattr(bpy.data, "hair_curves"):
        hair = bpy.data.hair_curves.new("hair")
        if hasattr(hair, "add_curves"):
            hair.add_curves([3, 2])
            for i, p in enumerate(hair.points):
                p.position = (i, 0.5 * i, 0)
                p.radius = 0.125 * (i + 1)
            add("hair", hair)
    mesh = bpy.data.meshes.new("moving")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    o = add("mover", mesh)
    for frame, x in ((0, 0.0), (2, 8.0)):
        o.location.x = x
        o.keyframe_insert("location", frame=frame)
        o.shape_key_add(name="key%d" % frame)
    grown = mesh.shape_keys.key_blocks[1]
    grown.data[1].co = (3, 0, 0)
    for frame, value in ((0, 0.0), (2, 1.0)):
        grown.value = value
        grown.keyframe_insert("value", frame=frame)
    for a in bpy.data.actions:
        bags = [b for l in getattr(a, "layers", ()) for t in l.strips for b in t.channelbags] or [a]   # Blender 4.4 has layers
        for k in [k for b in bags for c in b.fcurves for k in c.keyframe_points]:
            k.interpolation = "LINEAR"
    bpy.context.scene.render.use_motion_blur = True
    bpy.context.scene.render.motion_blur_shutter = 0.5


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    r = scene.render
    r.resolution_x, r.resolution_y, r.resolution_percentage = 64, 128, 50
    r.engine = "CYCLES"
    scene.cycles.samples = 9
    scene.cycles.max_bounces = 5
    scene.cycles.sample_clamp_indirect = 4
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    meshes()
    lights_and_camera()
    hair_and_motion()
    scene.frame_set(1)
    blend = os.path.splitext(sys.argv[1])[0] + ".blend"
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    status = command.main([blend, "-o", sys.argv[1]])
    strict = command.main([blend, "-o", sys.argv[1] + ".strict", "--strict", "--quiet"])
    print("statuses: %d %d" % (status, strict))


if __name__ == "__main__":
    main()
