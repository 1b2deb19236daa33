"""An evaluated Blender mesh as a mesh of the scene document: arrays by foreach_get, corners of triangles from loops of polygons."""
import numpy as np

# What says something else than a shader's attribute: geometry, selections, editing.
BUILT_IN = {"position", "material_index", "sharp_face", "sharp_edge", "crease_edge", "crease_vert", "bevel_weight_edge",
            "bevel_weight_vert", "custom_normal", "freestyle_edge", "freestyle_face", "face_set"}
# data_type: (property of the elements, channels, numpy type that foreach_get fills)
ATTRIBUTE_TYPES = {
    "FLOAT": ("value", 1, np.float32), "INT": ("value", 1, np.int32), "INT8": ("value", 1, np.int32), "BOOLEAN": ("value", 1, bool),
    "FLOAT2": ("vector", 2, np.float32), "FLOAT_VECTOR": ("vector", 3, np.float32), "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32)}
DOMAINS = {"POINT": "point", "CORNER": "corner", "FACE": "face"}


def read(collection, name, width, dtype=np.float32):
    out = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, out)
    return out


def export_mesh(mesh, box, report, where, generated=None):
    """The document's mesh, or None where there is no triangle. `box`: a Container. `generated`: told where coordinates of the
    undeformed mesh are needed."""
    if hasattr(mesh, "calc_loop_triangles"):
        mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    triangles = read(mesh.loop_triangles, "vertices", 3, np.int32)
    loops = read(mesh.loop_triangles, "loops", 3, np.int32)
    polygons = read(mesh.loop_triangles, "polygon_index", 1, np.int32)
    positions = read(mesh.vertices, "co", 3)
    out = {"positions": box.array(positions, 3), "triangles": box.array(triangles.astype(np.uint32), 3)}

    smooth = read(mesh.polygons, "use_smooth", 1, bool)[polygons]
    corner_normals = _corner_normals(mesh)
    if corner_normals is not None:
        out["corner_normals"] = box.array(corner_normals.reshape(-1, 3)[loops], 3)
    elif not smooth.any():
        out["smooth"] = False
    else:
        # Blender's vertex normals weigh whole polygons, not their triangles.
        out["normals"] = box.array(_vertex_normals(mesh), 3)
        if not smooth.all():
            out["smooth"] = box.array(smooth.astype(np.uint8), 1)

    slots = read(mesh.polygons, "material_index", 1, np.int32)[polygons]
    if slots.any():
        slots = np.maximum(slots, 0)
        out["face_material"] = box.array(slots.astype(np.uint16 if slots.max() < 65536 else np.uint32), 1)

    lower, upper = _texture_space(mesh)
    out["generated_bounds"] = [lower, upper]
    if generated is not None and _is_deformed(mesh, positions):
        generated(where)

    attributes = {}
    _uv_maps(mesh, loops, box, out, attributes)
    _attributes(mesh, loops, polygons, box, attributes, report, where)
    if attributes:
        out["attributes"] = attributes
    return out


def slots_needed(mesh):
    return 1 + max(0, int(read(mesh.polygons, "material_index", 1, np.int32).max())) if len(mesh.polygons) else 1


def _corner_normals(mesh):
    """Normals by corner where they differ from those by point: sharp edges, custom normals."""
    if hasattr(mesh, "normals_domain"):   # Blender 4.1
        return read(mesh.corner_normals, "vector", 3) if mesh.normals_domain == "CORNER" else None
    if mesh.use_auto_smooth or mesh.has_custom_normals:
        mesh.calc_normals_split()
        return read(mesh.loops, "normal", 3)
    return None


def _vertex_normals(mesh):
    if hasattr(mesh, "vertex_normals"):   # Blender 3.1
        return read(mesh.vertex_normals, "vector", 3)
    return read(mesh.vertices, "normal", 3)


def _texture_space(mesh):
    if hasattr(mesh, "texspace_location"):
        middle, half = mesh.texspace_location, mesh.texspace_size
    else:   # Blender 3.x keeps them on the original
        middle, half = mesh.texco_mesh.texspace_location, mesh.texco_mesh.texspace_size
    middle, half = [float(x) for x in middle], [float(x) for x in half]
    return [m - h for m, h in zip(middle, half)], [m + h for m, h in zip(middle, half)]


def _is_deformed(mesh, positions):
    if len(mesh.vertices) == 0 or not hasattr(mesh.vertices[0], "undeformed_co"):
        return False
    before = read(mesh.vertices, "undeformed_co", 3)
    size = np.abs(positions).max()
    return bool(np.abs(before - positions).max() > 1e-5 * size)


def _uv_maps(mesh, loops, box, out, attributes):
    for layer in mesh.uv_layers:
        data = read(layer.uv, "vector", 2) if hasattr(layer, "uv") else read(layer.data, "uv", 2)
        array = box.array(data.reshape(-1, 2)[loops], 2)
        attributes[layer.name] = {"domain": "corner", "channels": 2, "values": array}
        if layer.active_render or "uv" not in out:
            out["uv"] = array


def _attributes(mesh, loops, polygons, box, attributes, report, where):
    for a in mesh.attributes:
        if a.name in BUILT_IN or a.name.startswith(".") or a.name in attributes:
            continue
        if a.domain not in DOMAINS or a.data_type not in ATTRIBUTE_TYPES:
            # Cycles passes over these too.
            report.note("attribute of type %s on %s" % (a.data_type, a.domain), "%s.%s" % (where, a.name))
            continue
        name, width, dtype = ATTRIBUTE_TYPES[a.data_type]
        data = read(a.data, name, width, dtype).astype(np.float32, copy=False).reshape(-1, width)
        if a.domain == "CORNER":
            data = data[loops]
        elif a.domain == "FACE":
            data = data[polygons]
        if not np.isfinite(data).all():
            report.unsupported("values that are not finite in an attribute (written as 0)", "%s.%s" % (where, a.name))
            data = np.where(np.isfinite(data), data, np.float32(0))
        attributes[a.name] = {"domain": DOMAINS[a.domain], "channels": width, "values": box.array(data, width)}
