"""Blender's values as JSON: numbers, sockets' constants, colour ramps, curves, placements of textures."""
import math

IDENTITY_MAPPING = {"vector_type": "POINT", "translation": [0, 0, 0], "rotation": [0, 0, 0], "scale": [1, 1, 1],
                    "mapping_x": "X", "mapping_y": "Y", "mapping_z": "Z"}


def number(x):
    """Nine digits tell every 32-bit float from its neighbours; JSON has no name for what is not finite."""
    if isinstance(x, (bool, int)):
        return x
    x = float(x)
    if math.isfinite(x):
        return float("%.9g" % x)
    return "nan" if x != x else "inf" if x > 0 else "-inf"


def numbers(xs):
    return [number(x) for x in xs]


def socket_value(socket):
    """The constant of an unlinked socket, or None where there is none (shaders)."""
    kind = socket.type
    if kind == "VALUE":
        return number(socket.default_value)
    if kind in ("INT", "BOOLEAN", "STRING", "MENU"):
        return socket.default_value
    if kind in ("RGBA", "VECTOR", "ROTATION"):
        return numbers(socket.default_value)
    return None


def matrix(m):
    return [number(x) for row in m for x in row]


def color_ramp(ramp):
    return {"color_mode": ramp.color_mode, "interpolation": ramp.interpolation, "hue_interpolation": ramp.hue_interpolation,
            "elements": [{"position": number(e.position), "color": numbers(e.color)} for e in ramp.elements]}


def curve_mapping(mapping):
    return {"extend": mapping.extend, "use_clip": bool(mapping.use_clip),
            "clip": numbers([mapping.clip_min_x, mapping.clip_min_y, mapping.clip_max_x, mapping.clip_max_y]),
            "black_level": numbers(mapping.black_level), "white_level": numbers(mapping.white_level),
            "curves": [[{"location": numbers(p.location), "handle_type": p.handle_type} for p in c.points] for c in mapping.curves]}


def texture_mapping(mapping):
    """None for the identity."""
    out = {"vector_type": mapping.vector_type, "translation": numbers(mapping.translation), "rotation": numbers(mapping.rotation),
           "scale": numbers(mapping.scale), "mapping_x": mapping.mapping_x, "mapping_y": mapping.mapping_y, "mapping_z": mapping.mapping_z}
    return None if out == IDENTITY_MAPPING else out


def random_id(name):
    """Blender's number of an object that is not an instance, from its name: a string hash, mixed as the last step of Jenkins' lookup3
    (public domain, 2006)."""
    mask = 0xffffffff
    h = 0
    for byte in name.encode():
        h = (h * 37 + byte) & mask
    a = b = c = (0xdeadbeef + (2 << 2) + 13) & mask
    a = (a + h) & mask

    def rotated(x, k):
        return ((x << k) | (x >> (32 - k))) & mask

    c = ((c ^ b) - rotated(b, 14)) & mask
    a = ((a ^ c) - rotated(c, 11)) & mask
    b = ((b ^ a) - rotated(a, 25)) & mask
    c = ((c ^ b) - rotated(b, 16)) & mask
    a = ((a ^ c) - rotated(c, 4)) & mask
    b = ((b ^ a) - rotated(a, 14)) & mask
    return ((c ^ b) - rotated(b, 24)) & mask
