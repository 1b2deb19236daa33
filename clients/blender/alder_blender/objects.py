"""Cameras and lamps of a Blender scene in the scene document's terms."""
import math

from .report import ExportError
from .values import matrix, number, numbers


def degrees(radians):
    """Half a circle in 32 bits is a little more than 180 degrees."""
    return number(min(math.degrees(radians), 180.0))


def transform(m):
    return matrix(m)[:12]


def visibility(o):
    """Only what is off."""
    out = {"camera": o.visible_camera, "diffuse": o.visible_diffuse, "glossy": o.visible_glossy, "transmission": o.visible_transmission,
           "volume": o.visible_volume_scatter, "shadow": o.visible_shadow}
    return {k: False for k, on in out.items() if not on}


def fit_and_larger(fit, width, height):
    """Length of the side that the sensor is fitted to, and of the larger one, in pixels."""
    larger = max(width, height)
    return {"HORIZONTAL": width, "VERTICAL": height}.get(fit, larger), larger


def export_camera(o, scene, report):
    """None where the document has no such camera."""
    c = o.data
    r = scene.render
    aspect_x, aspect_y = r.pixel_aspect_x, r.pixel_aspect_y
    if aspect_x != aspect_y:
        report.unsupported("pixels that are not square", "scene " + scene.name)
    fit, larger = fit_and_larger(c.sensor_fit, r.resolution_x, r.resolution_y)
    out = {"transform": transform(o.matrix_world), "near_clip": number(c.clip_start), "far_clip": number(c.clip_end)}
    if c.type == "ORTHO":
        out["type"] = "orthographic"
        out["ortho_scale"] = number(c.ortho_scale * larger / fit)
    elif c.type == "PERSP":
        sensor = c.sensor_height if c.sensor_fit == "VERTICAL" else c.sensor_width
        out["fov_degrees"] = number(math.degrees(2 * math.atan(0.5 * sensor / c.lens * larger / fit)))
    elif c.type == "PANO" and _panorama(c, out):
        pass
    else:
        report.unsupported("camera of type " + c.type + (" (%s)" % _panorama_type(c) if c.type == "PANO" else ""), o.name)
        return None
    if (c.shift_x or c.shift_y) and c.type != "PANO":
        out["shift"] = numbers([c.shift_x * fit / larger, c.shift_y * fit / larger])
    if c.dof.use_dof:
        # Millimetres for a lens; an orthographic one has none.
        length = 1.0 if c.type == "ORTHO" else c.lens * 1e-3
        out["aperture_radius"] = number(length / (2 * max(c.dof.aperture_fstop, 1e-5)))
        out["focus_distance"] = number(max(_focus_distance(o), 1e-5))
        if c.dof.aperture_blades > 2:
            out["aperture_blades"] = c.dof.aperture_blades
            out["aperture_rotation_degrees"] = number(math.degrees(c.dof.aperture_rotation))
        if c.dof.aperture_ratio != 1:
            out["aperture_ratio"] = number(c.dof.aperture_ratio)
    return out


PANORAMAS = {"EQUIRECTANGULAR": "equirectangular", "FISHEYE_EQUIDISTANT": "fisheye_equidistant", "FISHEYE_EQUISOLID": "fisheye_equisolid",
             "MIRRORBALL": "mirror_ball"}


def _panorama_type(c):
    return getattr(c, "panorama_type", None) or getattr(getattr(c, "cycles", None), "panorama_type", "")   # Blender 5 | 4 and 3


def _panorama(c, out):
    """False where the document has no such panorama."""
    kind = PANORAMAS.get(_panorama_type(c))
    if kind is None:
        return False
    s = c if hasattr(c, "panorama_type") else c.cycles
    out["type"] = "panoramic"
    out["panorama"] = kind
    if kind == "equirectangular":
        for name in ("longitude_min", "longitude_max", "latitude_min", "latitude_max"):
            out[name + "_degrees"] = number(max(-360.0, min(360.0, math.degrees(getattr(s, name)))))
            if name.startswith("latitude"):
                out[name + "_degrees"] = max(-90.0, min(90.0, out[name + "_degrees"]))
    elif kind.startswith("fisheye"):
        out["fisheye_fov_degrees"] = number(math.degrees(s.fisheye_fov))
        out["fisheye_lens_mm"] = number(s.fisheye_lens)
        out["sensor_mm"] = numbers([c.sensor_width, c.sensor_height])
    return True


def _focus_distance(o):
    focus = o.data.dof.focus_object
    if focus is None:
        return o.data.dof.focus_distance
    if o.data.dof.focus_subtarget:
        raise ExportError("camera %s: focus on a bone is not supported" % o.name)
    # Along the viewing axis, as Blender measures it.
    m = o.matrix_world
    away = focus.matrix_world.translation - m.translation
    axis = m.col[2].to_3d().normalized()
    return abs(axis.dot(away))


def export_light(o, light, report):
    """The lamp without its graph."""
    out = {"type": light.type.lower(), "transform": transform(o.matrix_world), "color": numbers(light.color),
           "strength": number(light.energy * 2.0 ** getattr(light, "exposure", 0.0))}
    if getattr(light, "use_temperature", False):   # Blender 4.5
        out["color"] = numbers([a * b for a, b in zip(light.color, light.temperature_color)])
    if not getattr(light, "normalize", True):
        out["normalize"] = False
    if light.type in ("POINT", "SPOT"):
        out["radius"] = number(light.shadow_soft_size)
        if getattr(light, "use_soft_falloff", False) and light.shadow_soft_size > 0:
            out["soft_falloff"] = True
    if light.type == "SPOT":
        out["spot_angle_degrees"] = degrees(light.spot_size)
        out["spot_blend"] = number(light.spot_blend)
    elif light.type == "SUN":
        out["angle_degrees"] = degrees(light.angle)
    elif light.type == "AREA":
        x = light.size
        y = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        out["size"] = numbers([x, y])
        if light.shape in ("DISK", "ELLIPSE"):
            out["shape"] = "ellipse"
        out["spread_degrees"] = degrees(light.spread)
    cast = light.use_shadow
    if hasattr(light, "cycles") and hasattr(light.cycles, "cast_shadow"):   # before Blender 4.3
        cast = light.cycles.cast_shadow
    if not cast:
        out["cast_shadow"] = False
    hidden = visibility(o)
    if hidden:
        out["visibility"] = hidden
    bounces = getattr(getattr(light, "cycles", None), "max_bounces", 1024)
    if bounces < 1024:
        report.unsupported("limit of a light's bounces", o.name)
    return out
