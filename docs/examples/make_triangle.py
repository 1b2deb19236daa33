"""Writes triangle.glb: a small glTF scene of two materials, a camera and a light, for the examples. Standard library only."""
import json
import pathlib
import struct

positions = [(-1, 0, 0), (1, 0, 0), (0, 1.6, 0), (-3, 0, 3), (3, 0, 3), (3, 0, -3), (-3, 0, -3)]
triangles = [0, 1, 2]
floor = [3, 4, 5, 3, 5, 6]
buffer = b"".join(struct.pack("<3f", *p) for p in positions) + struct.pack("<%dH" % len(triangles), *triangles) + b"\0\0" + struct.pack("<%dH" % len(floor), *floor)
at = 12 * len(positions)
document = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point", "intensity": 400}]}},
    "scene": 0,
    "scenes": [{"nodes": [0, 1, 2, 3]}],
    "nodes": [
        {"name": "sail", "mesh": 0},
        {"name": "floor", "mesh": 1},
        {"name": "camera", "camera": 0, "translation": [0, 1.2, 5], "rotation": [-0.05, 0, 0, 0.99875]},
        {"name": "lamp", "translation": [2, 4, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.7778, "znear": 0.01}}],
    "materials": [
        {"name": "sail", "doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.05, 1], "metallicFactor": 0, "roughnessFactor": 0.4}},
        {"name": "floor", "doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0.8}},
    ],
    "meshes": [
        {"name": "sail", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
        {"name": "floor", "primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "material": 1}]},
    ],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", "min": [-3, 0, -3], "max": [3, 1.6, 3]},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
    ],
    "bufferViews": [
        {"buffer": 0, "byteOffset": 0, "byteLength": at},
        {"buffer": 0, "byteOffset": at, "byteLength": 6},
        {"buffer": 0, "byteOffset": at + 8, "byteLength": 12},
    ],
    "buffers": [{"byteLength": len(buffer)}],
}
text = json.dumps(document, separators=(",", ":")).encode()
text += b" " * (-len(text) % 4)
buffer += b"\0" * (-len(buffer) % 4)
chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
pathlib.Path(__file__).with_name("triangle.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
