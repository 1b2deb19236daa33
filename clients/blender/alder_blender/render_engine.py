"""The render engine "Alder": F12, animations and the viewport. F12 writes the scene as it is evaluated, renders it outside and takes
passes back; the viewport shows a live render of a daemon that follows edits."""
import os
import tempfile

import bpy
import numpy as np

from . import backend, denoise, passes, preferences, viewport
from .report import ExportError
from .scene import SceneExporter


def make_backend():
    p = preferences.current()
    if p.place == "DAEMON":
        return backend.Daemon(p.url, p.token)
    return backend.Program(bpy.path.abspath(p.program) if p.program else "", p.threads)


def live_client():
    """How a viewport gets its daemon: the one of the preferences, or one of this process."""
    p = preferences.current()
    if p.place == "DAEMON":
        return lambda url=p.url, token=p.token: backend.client_package().Client(url, token or None)
    program, threads = bpy.path.abspath(p.program) if p.program else "", p.threads
    return lambda: backend.local_client(program, threads)


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

    session = None     # of a viewport
    shown = None       # (number of the picture, size) that the texture has
    texture = None
    said = ""

    def __del__(self):
        if self.session is not None:
            self.session.close()
        if hasattr(super(), "__del__"):   # Blender 4.4
            super().__del__()

    # ---- viewport ----

    def view_update(self, context, depsgraph):
        try:
            size, samples = viewport.view_size(context), viewport.view_samples(context.scene)
            report = viewport.Report()
            camera = viewport.view_camera(context, report)
            updates = depsgraph.updates
            if self.session is None:
                self.session, updates = viewport.Session(live_client(), size, samples), None
                bpy.app.timers.register(viewport.redraw_when_new(self), first_interval=0.01)
            self.session.show(depsgraph, camera, size, samples, updates, context.space_data)
            for line in self.session.told:
                if line not in self.said:   # once
                    self.report({"WARNING"}, line)
            self.said = "\n".join(self.session.told)
        except (ExportError, backend.RenderError) as e:
            self.update_stats("Alder", str(e))

    def view_draw(self, context, depsgraph):
        if self.session is None:
            return
        try:
            size, samples = viewport.view_size(context), viewport.view_samples(context.scene)
            self.session.look(viewport.view_camera(context, viewport.Report()), size, samples)
        except ExportError as e:
            self.update_stats("Alder", str(e))
            return
        mirror = self.session.mirror
        picture = mirror.picture
        if mirror.error:
            self.update_stats("Alder", mirror.error.splitlines()[0])
        elif picture is None:
            self.update_stats("Alder", "Preparing")
        else:
            self.update_stats("Alder", "%d samples%s" % (picture.samples, " at 1/%d" % 2 ** picture.level if picture.level else ""))
        if picture is None:
            return
        if self.shown != picture.number or self.texture is None:
            self.texture, self.shown = viewport.texture_of(picture), picture.number
        viewport.draw(self, context, depsgraph, self.texture)

    # ---- final renders ----

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
            wanted = passes.layers(names, groups) + self._denoising_layers(depsgraph.scene)
            image, warnings = make_backend().render(path, list(dict.fromkeys(wanted)), self._progress, self.test_break)
            for line in warnings:
                if "not-exported" not in line:   # told already
                    self.report({"WARNING"}, line)
            self._show(layer, names, groups, image, self._denoised(depsgraph.scene, image))
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

    @staticmethod
    def _denoising_layers(scene):
        c = getattr(scene, "cycles", None)
        if c is None or not c.use_denoising:
            return []
        return {"RGB": [], "RGB_ALBEDO": ["denoise_albedo"]}.get(c.denoising_input_passes, ["denoise_albedo", "denoise_normal"])

    def _denoised(self, scene, image):
        """The beauty without noise, or None where the scene does not ask for it or this Blender cannot."""
        c = getattr(scene, "cycles", None)
        if c is None or not c.use_denoising:
            return None
        library = denoise.find_library(denoise.blender_folders(bpy))
        if library is None:
            self.report({"WARNING"}, "not denoised: this Blender comes without OpenImageDenoise")
            return None
        self.update_stats("", "Denoising")
        wanted = self._denoising_layers(scene)
        try:
            denoiser = denoise.Denoiser(library)
            try:
                return denoiser.denoise(image["beauty"], *(image[n] for n in wanted if n in image), prefilter=c.denoising_prefilter == "ACCURATE")
            finally:
                denoiser.close()
        except denoise.DenoiseError as e:
            self.report({"WARNING"}, "not denoised: %s" % e)
            return None

    def _show(self, view_layer, names, groups, image, denoised=None):
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
                self.report({"WARNING"}, "Alder has no pass %s yet" % name)
                continue
            if name == "Combined" and denoised is not None:
                pixels = np.concatenate([denoised, pixels[..., 3:]], axis=-1)
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
    backend.stop_local()
    for panel in _panels():
        panel.COMPAT_ENGINES.discard("ALDER")
    bpy.utils.unregister_class(AlderRenderEngine)
