"""The render engine "Alder": F12 and animations. The scene is written as it is evaluated, rendered outside, and comes back as passes."""
import os
import tempfile

import bpy
import numpy as np

from . import backend, passes, preferences
from .report import ExportError
from .scene import SceneExporter


def make_backend():
    p = preferences.current()
    if p.place == "DAEMON":
        return backend.Daemon(p.url, p.token)
    return backend.Program(bpy.path.abspath(p.program) if p.program else "", p.threads)


def light_group_names(view_layer):
    return [g.name for g in getattr(view_layer, "lightgroups", ())][:8]


class AlderRenderEngine(bpy.types.RenderEngine):
    bl_idname = "ALDER"
    bl_label = "Alder"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_gpu_context = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_spherical_stereo = False

    def update_render_passes(self, scene=None, renderlayer=None):
        """What the compositor shows as sockets."""
        names, _ = passes.wanted(renderlayer, light_group_names(renderlayer))
        for name in names:
            count, letters, kind = passes.channels(name)
            self.register_pass(scene, renderlayer, name, count, letters, kind)

    def render(self, depsgraph):
        layer = depsgraph.view_layer
        groups = light_group_names(layer)
        names, missing = passes.wanted(layer, groups)
        for name in missing:
            self.report({"WARNING"}, "Alder has no pass %s yet" % name)
        folder = tempfile.mkdtemp(prefix="alder-scene-")
        path = os.path.join(folder, "scene.alder")
        try:
            self.update_stats("", "Writing the scene")
            exporter = SceneExporter(depsgraph)
            exporter.export()
            exporter.box.write(path, exporter.document)
            for line in exporter.report.lines():
                self.report({"WARNING"}, line)
            if self.test_break():
                return
            self.update_stats("", "Rendering")
            image, warnings = make_backend().render(path, passes.layers(names, groups), self._progress, self.test_break)
            for line in warnings:
                if "not-exported" not in line:   # told already
                    self.report({"WARNING"}, line)
            self._show(layer, names, groups, image)
        except (ExportError, backend.RenderError, OSError) as e:
            if self.test_break():
                return
            self.report({"ERROR"}, str(e))
            self.error_set(str(e))
        finally:
            for name in os.listdir(folder):
                os.unlink(os.path.join(folder, name))
            os.rmdir(folder)

    def _progress(self, fraction):
        self.update_progress(fraction)
        self.update_stats("", "Rendering %d %%" % (100 * fraction))

    def _show(self, view_layer, names, groups, image):
        height, width = image.shape
        for name in names:
            if not passes.is_own(name):
                count, letters, _ = passes.channels(name)
                self.add_pass(name, count, letters, layer=view_layer.name)
        result = self.begin_result(0, 0, width, height, layer=view_layer.name)
        by_name = {p.name: p for p in result.layers[0].passes}
        for name in names:
            if name not in by_name:
                continue
            pixels = passes.compose(name, image, groups)
            if pixels is None:
                self.report({"WARNING"}, "the image has no layers for pass %s" % name)
                continue
            target = by_name[name]
            flat = np.ascontiguousarray(pixels[::-1, :, :target.channels], np.float32)   # Blender's rows begin at the bottom
            if bpy.app.version >= (4, 0, 0):
                target.rect.foreach_set(flat.reshape(-1))
            else:   # there foreach_set takes one number a pixel
                target.rect = flat.reshape(-1, target.channels).tolist()
        self.end_result(result)


# Panels of Blender and Cycles that say something to Alder, too: all that Cycles has, less what sets up Cycles itself.
NOT_OURS = {"CYCLES_RENDER_PT_sampling_advanced", "CYCLES_RENDER_PT_performance", "CYCLES_RENDER_PT_performance_threads", "CYCLES_RENDER_PT_performance_memory",
            "CYCLES_RENDER_PT_performance_acceleration_structure", "CYCLES_RENDER_PT_performance_final_render", "CYCLES_RENDER_PT_performance_viewport",
            "CYCLES_RENDER_PT_debug", "CYCLES_RENDER_PT_bake", "CYCLES_RENDER_PT_bake_influence", "CYCLES_RENDER_PT_bake_selected_to_active", "CYCLES_RENDER_PT_bake_output"}


def _panels():
    todo = list(bpy.types.Panel.__subclasses__())
    while todo:
        panel = todo.pop()
        todo.extend(panel.__subclasses__())
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if isinstance(engines, set) and "CYCLES" in engines | ({"CYCLES"} if "BLENDER_RENDER" in engines else set()) and panel.__name__ not in NOT_OURS:
            yield panel


def register():
    bpy.utils.register_class(AlderRenderEngine)
    for panel in _panels():
        panel.COMPAT_ENGINES.add("ALDER")


def unregister():
    for panel in _panels():
        panel.COMPAT_ENGINES.discard("ALDER")
    bpy.utils.unregister_class(AlderRenderEngine)
