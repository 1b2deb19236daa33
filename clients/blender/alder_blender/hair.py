"""Hair curves and point clouds as curves and points of the scene document."""
import numpy as np

from .meshes import ATTRIBUTE_TYPES, read

# What says something else than a shader's attribute.
BUILT_IN = {"position", "radius", "curve_type", "cyclic", "resolution", "normal_mode", "custom_normal", "handle_left", "handle_right",
            "handle_type_left", "handle_type_right", "nurbs_order", "nurbs_weight", "knots_mode", "surface_uv_coordinate", "material_index",
            "velocity", "tilt"}
FORMS = {"RIBBONS": "ribbon", "THICK": "round", "THICK_LINEAR": "linear"}
DEFAULT_RADIUS = 0.005   # Cycles', where there is no such attribute
POLY = 1


def points_of(data):
    """Positions and radii: of hair curves, or of a point cloud."""
    positions = read(data.attributes["position"].data, "vector", 3)
    radius = data.attributes.get("radius")
    if radius is None or radius.data_type != "FLOAT":
        return positions, np.full(len(positions) // 3, DEFAULT_RADIUS, np.float32)
    return positions, read(radius.data, "value", 1)


def export_curves(curves, scene, box, report, where, with_normals):
    """None where no curve has a segment."""
    if len(curves.curves) == 0:
        return None
    positions, radii = points_of(curves)
    counts = read(curves.curves, "points_length", 1, np.int32)
    settings = getattr(scene, "cycles_curves", None)
    out = {"positions": box.array(positions, 3), "radii": box.array(radii, 1), "counts": box.array(counts.astype(np.uint32), 1)}
    form = FORMS.get(getattr(settings, "shape", "RIBBONS"), "ribbon")
    kinds = curves.attributes.get("curve_type")
    if kinds is not None and len(kinds.data) and kinds.data[0].value == POLY:
        form = "linear"
    out["form"] = form
    if form == "ribbon" and settings is not None:
        out["subdivisions"] = min(int(getattr(settings, "subdivisions", 2)), 15)
    if with_normals:
        if hasattr(curves, "normals") and len(curves.normals) == len(radii):
            out["normals"] = box.array(read(curves.normals, "vector", 3), 3)
        else:
            report.unsupported("normals of hair curves (elliptical hair lies at random)", where)
    _attributes(curves, {"POINT": "point", "CURVE": "curve"}, box, out, report, where)
    return out


def export_points(cloud, box, report, where):
    """None where there is no point."""
    if len(cloud.points) == 0:
        return None
    positions, radii = points_of(cloud)
    out = {"positions": box.array(positions, 3), "radii": box.array(radii, 1)}
    _attributes(cloud, {"POINT": "point"}, box, out, report, where)
    return out


def _attributes(data, domains, box, out, report, where):
    attributes = {}
    for a in data.attributes:
        if a.name in BUILT_IN or a.name.startswith("."):
            continue
        if a.domain not in domains or a.data_type not in ATTRIBUTE_TYPES:
            report.note("attribute of type %s on %s" % (a.data_type, a.domain), "%s.%s" % (where, a.name))
            continue
        name, width, dtype = ATTRIBUTE_TYPES[a.data_type]
        values = read(a.data, name, width, dtype).astype(np.float32, copy=False)
        if not np.isfinite(values).all():
            report.unsupported("values that are not finite in an attribute (written as 0)", "%s.%s" % (where, a.name))
            values = np.where(np.isfinite(values), values, np.float32(0))
        attributes[a.name] = {"domain": domains[a.domain], "channels": width, "values": box.array(values, width)}
    if attributes:
        out["attributes"] = attributes
