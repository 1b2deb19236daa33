"""Meshes of .ass files as those of a scene document: polygons to triangles, indexed normals and texture coordinates to corners."""
import array as arrays
import math
import sys

from ass_file import AssError, array


class Buffers:
    """One buffer for all arrays; array() gives what the document says in their place."""
    name = "geometry.bin"

    def __init__(self):
        self.data = bytearray()

    def array(self, numbers, channels, kind="f32"):
        code = {"f32": "f", "u32": "I"}[kind]
        values = arrays.array(code, [int(n) for n in numbers] if kind == "u32" else numbers)
        if sys.byteorder == "big":
            values.byteswap()
        offset = len(self.data)
        self.data += values.tobytes()
        return {"buffer": self.name, "type": kind, "offset": offset, "count": len(values) // channels}


def _numbers(node, name):
    value = node.params.get(name)
    if value is None:
        return None
    found = array(value)
    if found is None:
        plain = value.numbers()
        if plain is None:
            raise AssError("line %d: %s of %s is no array of numbers" % (value.line, name, node.name))
        return plain
    return found


def _indices(node, name, count, limit):
    found = _numbers(node, name)
    if found is None:
        return None
    found = [int(i) for i in found]
    if len(found) < count:
        raise AssError("line %d: %s of %s has %d of %d indices" % (node.params[name].line, name, node.name, len(found), count))
    if any(not 0 <= i < limit for i in found[:count]):
        raise AssError("line %d: %s of %s points beyond its %d values" % (node.params[name].line, name, node.name, limit))
    return found


def convert_mesh(node, scene, buffers):
    """(mesh, shaders) of a polymesh node, or (None, []) for one without faces."""
    points = _numbers(node, "vlist")
    if not points:
        scene.report("mesh without points", node.name)
        return None, []
    if getattr(node.params["vlist"], "keys", 1) > 1:
        scene.report("deformation of a mesh (its first key counts)", node.name)
    if any(not math.isfinite(x) for x in points):
        raise AssError("line %d: vlist of %s has numbers that are not finite" % (node.params["vlist"].line, node.name))
    sides = _numbers(node, "nsides")
    if sides is None:
        whole = _numbers(node, "vidxs") or []
        sides = [3] * (len(whole) // 3)
    sides = [int(n) for n in sides]
    corners = sum(sides)
    vidxs = _indices(node, "vidxs", corners, len(points) // 3)
    if vidxs is None or not sides:
        scene.report("mesh without faces", node.name)
        return None, []
    normals, uvs = _numbers(node, "nlist"), _numbers(node, "uvlist")
    nidxs = _indices(node, "nidxs", corners, len(normals) // 3) if normals else None
    uvidxs = _indices(node, "uvidxs", corners, len(uvs) // 2) if uvs else None
    if normals and nidxs is None and len(normals) == len(points):
        nidxs = vidxs
    if uvs and uvidxs is None and len(uvs) // 2 == len(points) // 3:
        uvidxs = vidxs
    shidxs = _numbers(node, "shidxs")

    triangles, at, corner_of, faces = [], 0, [], []
    for face, n in enumerate(sides):
        for k in range(1, n - 1):
            corner = (at, at + k, at + k + 1)
            triangles.extend(vidxs[c] for c in corner)
            corner_of.extend(corner)
            faces.append(face)
        at += n
    if not triangles:
        scene.report("mesh without faces", node.name)
        return None, []
    mesh = {"positions": buffers.array(points, 3), "triangles": buffers.array(triangles, 3, "u32")}
    if nidxs is not None and scene.get(node, "smoothing", True) is not False:
        m = scene.matrix(node)
        determinant = (m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]))
        del determinant   # normals turn with the surface, mirrored or not
        mesh["corner_normals"] = buffers.array([normals[nidxs[c] * 3 + k] for c in corner_of for k in range(3)], 3)
    elif scene.get(node, "smoothing", False) is not True:
        mesh["smooth"] = False
    if uvidxs is not None:
        mesh["uv"] = buffers.array([uvs[uvidxs[c] * 2 + k] for c in corner_of for k in range(2)], 2)
    shaders = scene.shaders(node)
    if shidxs is not None and len(shaders) > 1:
        if len(shidxs) < len(sides):
            raise AssError("line %d: shidxs of %s has %d of %d faces" % (node.params["shidxs"].line, node.name, len(shidxs), len(sides)))
        mesh["face_material"] = buffers.array([min(int(shidxs[f]), len(shaders) - 1) for f in faces], 1, "u32")
    else:
        shaders = shaders[:1]
    kind = scene.get(node, "subdiv_type", "none")
    if kind not in ("none", 0, 0.0) and scene.get(node, "subdiv_iterations", 1) != 0:
        scene.report("subdivision of a mesh (its cage is shown)", node.name)
    return mesh, shaders or [None]


def sphere(center, radius, buffers, rings=48, segments=96):
    """Latitude and longitude, poles along Y, with normals and texture coordinates."""
    points, uv, normals, triangles = [], [], [], []
    for i in range(rings + 1):
        for j in range(segments + 1):
            theta, phi = math.pi * i / rings, 2 * math.pi * j / segments
            n = (math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
            normals.append(n)
            points.extend(center[k] + radius * n[k] for k in range(3))
            uv.append((j / segments, 1 - i / rings))
    for i in range(rings):
        for j in range(segments):
            a, b = i * (segments + 1) + j, (i + 1) * (segments + 1) + j
            if i > 0:
                triangles.append((a, b, a + 1))
            if i < rings - 1:
                triangles.append((a + 1, b, b + 1))
    corners = [c for t in triangles for c in t]
    return {"positions": buffers.array(points, 3), "triangles": buffers.array(corners, 3, "u32"),
            "corner_normals": buffers.array([x for c in corners for x in normals[c]], 3), "uv": buffers.array([x for c in corners for x in uv[c]], 2)}
