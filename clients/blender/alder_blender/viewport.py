"""Rendering in the viewport: the scene as the viewport evaluates it, kept in step with a live render of a daemon.

A change of a material's nodes writes that material alone; anything else writes the document anew, with meshes and materials that did
not change taken from the time before, and the mirror sends what differs.
"""
import math

import bpy

from . import objects, values
from .mirror import Box, Mirror
from .report import ExportError, Report
from .scene import SceneExporter

VIEW = "view"   # name of the viewport's camera in the document
UNLIMITED = 1 << 16


class Cache:
    """What exports of one viewport share."""

    def __init__(self):
        self.box = Box()
        self.meshes = {}      # (object, its data) -> (kind, entry of the document, label, slots)
        self.materials = {}   # name -> graph

    def forget(self, updates):
        """Drops what the dependency graph says has changed. False where that is materials' nodes alone."""
        only_materials = True
        for u in updates:
            i = u.id.original if u.id.original is not None else u.id
            if isinstance(i, bpy.types.Material):
                self.materials.pop(i.name_full, None)
            elif isinstance(i, bpy.types.NodeTree):
                if i in bpy.data.node_groups.values():   # any material may use it
                    self.materials.clear()
                    only_materials = False
            elif isinstance(i, bpy.types.Object):
                if u.is_updated_geometry:
                    self.meshes = {k: v for k, v in self.meshes.items() if k[0] != i.name_full}
                only_materials &= not u.is_updated_geometry and not u.is_updated_transform
            elif isinstance(i, (bpy.types.Mesh, bpy.types.Curve, bpy.types.MetaBall)) or type(i).__name__ in ("Curves", "PointCloud"):
                if u.is_updated_geometry:
                    self.meshes = {k: v for k, v in self.meshes.items() if k[1] != i.name_full}
                    only_materials = False
            elif isinstance(i, bpy.types.Image):
                self.materials.clear()
                only_materials = False
            else:
                only_materials = False
        return not only_materials


class ViewExporter(SceneExporter):
    """The scene of a viewport: its own camera, no motion, and parts of earlier exports."""

    def __init__(self, depsgraph, cache, camera, size, space=None):
        super().__init__(depsgraph, None, cache.box)
        self.motion.on = False
        self.cache, self.view_camera, self.size, self.space = cache, camera, size, space

    def export(self):
        document = super().export()
        document.pop("report")
        document["settings"]["resolution"] = list(self.size)
        return document

    def _cameras(self):
        self.document["cameras"][VIEW], self.document["camera"] = self.view_camera, VIEW

    def _is_shown(self, instance):
        if not instance.show_self:
            return False
        if self.space is None or instance.is_instance:
            return True
        return instance.object.original.visible_in_viewport_get(self.space)   # local view, hidden kinds of objects

    def _material_graph(self, m, name):
        key = m.original.name_full if m.original is not None else m.name_full
        if key not in self.cache.materials:
            self.cache.materials[key] = super()._material_graph(m, name)
        return dict(self.cache.materials[key])

    def _own(self, o):
        """The key of an object's own shape; None for shapes that only instances show."""
        evaluated = o.original.evaluated_get(self.depsgraph)
        if evaluated.data is None or o.data is None or evaluated.data.as_pointer() != o.data.as_pointer():
            return None
        return o.original.name_full, o.original.data.name_full

    def _cached(self, o, kind, make):
        key = self._own(o)
        found = self.cache.meshes.get(key)
        pointer = o.data.as_pointer()
        if pointer not in self.meshes and key is not None and found is not None and found[0] == kind:
            _, entry, label, slots = found
            if label is not None:
                label = self._free(label, self.document[kind])
                self.document[kind][label] = entry
            self.meshes[pointer] = (label, slots)
            return label, slots
        label, slots = make()
        if key is not None:
            self.cache.meshes[key] = (kind, self.document[kind].get(label), label, slots)
        return label, slots

    def _mesh(self, o, name):
        if o.type != "MESH":
            return super()._mesh(o, name)
        return self._cached(o, "meshes", lambda: super(ViewExporter, self)._mesh(o, name))

    def _threads(self, o, name, kind):
        return self._cached(o, kind, lambda: super(ViewExporter, self)._threads(o, name, kind))


def view_size(context):
    """Pixels of the region, fewer where the scene asks for larger ones."""
    scene = context.scene
    pixel = getattr(scene.render, "preview_pixel_size", "AUTO")
    divisor = int(pixel) if pixel.isdigit() else 1
    return max(1, context.region.width // divisor), max(1, context.region.height // divisor)


def view_samples(scene):
    c = getattr(scene, "cycles", None)
    return (c.preview_samples or UNLIMITED) if c is not None else 128


def view_camera(context, report):
    """The viewport's camera for the document. Frame, zoom and shift are what the projection of the region says."""
    region, space, size = context.region_data, context.space_data, view_size(context)
    matrix, window = region.view_matrix.inverted(), region.window_matrix
    out = {}
    camera = space.camera or context.scene.camera
    if region.view_perspective == "CAMERA" and camera is not None and camera.type == "CAMERA":
        found = objects.export_camera(camera.evaluated_get(context.evaluated_depsgraph_get()), context.scene, report)
        if found is None:
            raise ExportError("camera %s: type %s is not supported" % (camera.name, camera.data.type))
        out = found
        if out.get("type") == "panoramic":
            return out
    return projected(out, matrix, window, size, space.clip_start, space.clip_end)


def projected(camera, matrix, window, size, clip_start, clip_end):
    """`camera` seen through an OpenGL projection `window` from `matrix` (rows), for a picture of `size`."""
    width, height = size
    larger = max(size)
    out = dict(camera)
    along = 0 if width >= height else 1
    is_perspective = window[3][3] == 0
    if is_perspective:
        out.pop("type", None)
        out["fov_degrees"] = values.number(math.degrees(2 * math.atan(1 / window[along][along])))
        x, y = window[0][2] / 2, window[1][2] / 2
        out.setdefault("near_clip", values.number(clip_start))
        out.setdefault("far_clip", values.number(clip_end))
        rows = [list(r) for r in matrix]
    else:
        out["type"] = "orthographic"
        out.pop("fov_degrees", None)
        out["ortho_scale"] = values.number(2 / window[along][along])
        x, y = -window[0][3] / 2, -window[1][3] / 2
        rows = [list(r) for r in matrix]
        if not camera:   # what lies behind the viewer is seen, too
            for r in rows[:3]:
                r[3] += r[2] * clip_end
            out["near_clip"], out["far_clip"] = 1e-3, values.number(2 * clip_end)
    shift = [x * width / larger, y * height / larger]
    out.pop("shift", None)
    if max(abs(s) for s in shift) > 1e-6:
        out["shift"] = values.numbers(shift)
    out["transform"] = values.numbers([v for r in rows[:3] for v in r])
    return out


def redraw_when_new(engine):
    """A timer that asks for a redraw when there is something new to draw; it ends with its viewport."""
    seen = [None, None]

    def look():
        try:
            session = engine.session
            if session is None:
                return None
            now = [session.mirror.picture, session.mirror.error]
            if now[0] is not seen[0] or now[1] != seen[1]:
                seen[:] = now
                engine.tag_redraw()
            return 0.02
        except ReferenceError:   # Blender has removed the engine
            return None
    return look


def texture_of(picture):
    import gpu
    import numpy as np
    pixels = np.ascontiguousarray(picture.layers["rgba"][::-1], np.float32)   # OpenGL's rows begin at the bottom
    return gpu.types.GPUTexture((picture.width, picture.height), format="RGBA16F", data=gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1)))


def draw(engine, context, depsgraph, texture):
    import gpu
    from gpu_extras.presets import draw_texture_2d
    gpu.state.blend_set("ALPHA_PREMULT")
    engine.bind_display_space_shader(depsgraph.scene)
    draw_texture_2d(texture, (0, 0), context.region.width, context.region.height)
    engine.unbind_display_space_shader()
    gpu.state.blend_set("NONE")


class Session:
    """One viewport. `client`: gives the daemon's client."""

    def __init__(self, client, size, samples, layers=()):
        self.cache = Cache()
        self.mirror = Mirror(client, size, samples, layers)
        self.document = None
        self.told = []        # what the last whole export left out
        self.camera = None

    def show(self, depsgraph, camera, size, samples, updates=None, space=None):
        """After a change of the scene. `updates`: what changed, all where left out."""
        self.mirror.resize(size, samples)
        whole = updates is None or self.document is None
        if not whole:
            if not len(updates):
                return self.look(camera, size, samples)
            whole = self.cache.forget(updates)
        elif updates is None:
            self.cache.materials.clear()
            self.cache.meshes.clear()
        if not whole and self._materials(depsgraph, updates):
            return self.look(camera, size, samples)
        exporter = ViewExporter(depsgraph, self.cache, camera, size, space)
        document = exporter.export()
        self.told = exporter.report.lines()
        self._show(document, camera)

    def _show(self, document, camera):
        self.document, self.camera = document, camera
        self.mirror.show(document, self.cache.box.take())

    def _materials(self, depsgraph, updates):
        """Writes the changed materials alone. False where one of them needs the whole scene."""
        exporter = ViewExporter(depsgraph, self.cache, self.camera, self.document["settings"]["resolution"])
        materials = dict(self.document["materials"])
        for u in updates:
            if not isinstance(u.id, bpy.types.Material):
                continue
            name = u.id.original.name_full
            if name not in materials:
                continue   # nothing shows it
            graph = exporter._material_graph(u.id, name)
            before = materials[name]
            if "pass_index" in before or u.id.pass_index:
                graph["pass_index"] = u.id.pass_index
            if ("displacement" in graph) != ("displacement" in before) or graph.get("displacement") != before.get("displacement") or graph.get("pass_index") != before.get("pass_index"):
                return False
            materials[name] = graph
        self._show({**self.document, "materials": materials}, self.camera)
        return True

    def look(self, camera, size, samples):
        """After a change of the view alone."""
        self.mirror.resize(size, samples)
        if self.document is not None and camera != self.camera:
            self._show({**self.document, "cameras": {VIEW: camera}}, camera)

    def close(self):
        self.mirror.close()
