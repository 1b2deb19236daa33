"""Makes gltf_sample.glb with Blender's own exporter, and gltf_sample.json with what Blender says about the same scene.

Run in a Python that has bpy 4.5: python3 make_gltf_sample.py FOLDER
"""
import json
import math
import os
import sys

import bpy

folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def image(name, colorspace, pixel):
    im = bpy.data.images.new(name, 16, 16)
    im.colorspace_settings.name = colorspace
    values = []
    for y in range(16):
        for x in range(16):
            values += pixel(x / 15, y / 15)
    im.pixels = values
    im.pack()
    return im


def material(name):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    return m, m.node_tree, m.node_tree.nodes["Principled BSDF"]


def texture(tree, im, uv=None):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = im
    if uv:
        uv_node = tree.nodes.new("ShaderNodeUVMap")
        uv_node.uv_map = uv
        tree.links.new(uv_node.outputs["UV"], node.inputs["Vector"])
    return node


def add(name, mesh, mat, location, rotation=(0, 0, 0), scale=(1, 1, 1), parent=None):
    o = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(o)
    o.parent = parent
    o.location, o.rotation_euler, o.scale = location, rotation, scale
    if mat:
        o.data.materials.append(mat)
    return o


def primitive(op, **options):
    op(**options)
    o = bpy.context.object
    mesh = o.data
    bpy.data.objects.remove(o)
    return mesh


painted, tree, bsdf = material("painted")
color = texture(tree, image("color", "sRGB", lambda x, y: (x, y, 0.25, 1)))
tree.links.new(color.outputs["Color"], bsdf.inputs["Base Color"])
rough = texture(tree, image("rough", "Non-Color", lambda x, y: (0, x, y, 1)))
split = tree.nodes.new("ShaderNodeSeparateColor")
tree.links.new(rough.outputs["Color"], split.inputs["Color"])
tree.links.new(split.outputs["Green"], bsdf.inputs["Roughness"])
tree.links.new(split.outputs["Blue"], bsdf.inputs["Metallic"])
bumpy = texture(tree, image("bumpy", "Non-Color", lambda x, y: (0.5 + 0.1 * x, 0.5, 0.9, 1)), "UVMap.001")
normal = tree.nodes.new("ShaderNodeNormalMap")
normal.uv_map = "UVMap.001"
normal.inputs["Strength"].default_value = 0.75
tree.links.new(bumpy.outputs["Color"], normal.inputs["Color"])
tree.links.new(normal.outputs["Normal"], bsdf.inputs["Normal"])

glass, tree, bsdf = material("glass")
bsdf.inputs["Base Color"].default_value = (0.9, 0.95, 1, 1)
bsdf.inputs["Transmission Weight"].default_value = 1
bsdf.inputs["Roughness"].default_value = 0.1
bsdf.inputs["IOR"].default_value = 1.33

lacquer, tree, bsdf = material("lacquer")
bsdf.inputs["Base Color"].default_value = (0.8, 0.1, 0.05, 1)
bsdf.inputs["Coat Weight"].default_value = 0.6
bsdf.inputs["Coat Roughness"].default_value = 0.2
bsdf.inputs["Metallic"].default_value = 0.25
bsdf.inputs["Emission Color"].default_value = (0.1, 0.2, 1, 1)
bsdf.inputs["Emission Strength"].default_value = 3

sphere = primitive(bpy.ops.mesh.primitive_uv_sphere_add, segments=12, ring_count=6)
for p in sphere.polygons:
    p.use_smooth = True
second = sphere.uv_layers.new(name="UVMap.001")
for a, b in zip(sphere.uv_layers[0].data, second.data):
    b.uv = (a.uv[0] * 2, a.uv[1] * 3)
cube = primitive(bpy.ops.mesh.primitive_cube_add)
cube.materials.append(glass)
cube.materials.append(lacquer)
for p in cube.polygons:
    p.material_index = p.index % 2

root = bpy.data.objects.new("root", None)
scene.collection.objects.link(root)
root.location, root.rotation_euler, root.scale = (1, 2, 3), (0.3, -0.2, 0.7), (1, 2, 0.5)
add("ball", sphere, painted, (0, 0, 1))
add("left", cube, None, (-3, 0.5, 0.25), (0.1, 0.2, 0.3), (1, 1, 1), root)
add("right", cube, None, (3, -0.5, 0.75), (0, 0, 1), (0.5, 0.5, -0.5), root)

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
camera.location, camera.rotation_euler = (7, -9, 5), (1.1, 0.05, 0.6)
camera.data.lens = 35
scene.camera = camera
scene.render.resolution_x, scene.render.resolution_y = 640, 480
for kind, energy in (("SUN", 2.5), ("POINT", 100), ("SPOT", 250)):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    data.color = (1, 0.75, 0.5)
    if kind == "SPOT":
        data.spot_size, data.spot_blend = math.radians(50), 0.3
    lamp = bpy.data.objects.new(kind.lower(), data)
    scene.collection.objects.link(lamp)
    lamp.location, lamp.rotation_euler = (1, 2, energy / 20), (0.5, 0.25, -0.4)
bpy.context.view_layer.update()

bpy.ops.export_scene.gltf(filepath=os.path.join(folder, "gltf_sample.glb"), export_format="GLB", export_cameras=True,
                          export_lights=True, export_tangents=False, export_apply=False)

facts = {"objects": {}, "lights": {}, "camera": {}}
for o in scene.objects:
    matrix = [v for row in o.matrix_world for v in row]
    if o.type == "MESH":
        world = [o.matrix_world @ v.co for v in o.data.vertices]
        facts["objects"][o.name] = {"matrix": matrix, "min": [min(v[i] for v in world) for i in range(3)],
                                    "max": [max(v[i] for v in world) for i in range(3)],
                                    "area": sum(p.area for p in o.data.polygons),
                                    "materials": [m.name for m in o.data.materials if m],
                                    "area_by_material": [sum(p.area for p in o.data.polygons if p.material_index == i)
                                                         for i in range(max(1, len(o.data.materials)))]}
    elif o.type == "LIGHT":
        facts["lights"][o.name] = {"matrix": matrix, "energy": o.data.energy, "color": list(o.data.color), "type": o.data.type}
    elif o.type == "CAMERA":
        facts["camera"] = {"matrix": matrix, "angle_x": o.data.angle_x}
# Texture coordinates of the ball: uv at points that are easy to find again.
facts["ball_uv"] = [[list(sphere.vertices[loop.vertex_index].co), list(sphere.uv_layers[0].data[loop.index].uv)] for loop in sphere.loops]
with open(os.path.join(folder, "gltf_sample.json"), "w") as f:
    json.dump(facts, f, indent=None, separators=(",", ":"))
