"""A render engine that writes instead of rendering: only to an engine does Blender give the scene evaluated as for a final render."""
import bpy

from .report import ExportError
from .scene import SceneExporter


class AlderExportEngine(bpy.types.RenderEngine):
    bl_idname = "ALDER_EXPORT"
    bl_label = "Alder Export"
    bl_use_preview = False
    bl_use_postprocess = False
    bl_use_gpu_context = False
    bl_use_eevee_viewport = False

    def render(self, depsgraph):
        if AlderExportEngine.result is not None:
            return   # one view layer only
        try:
            exporter = SceneExporter(depsgraph, self)
            exporter.export()
            exporter.box.write(AlderExportEngine.path, exporter.document)
            AlderExportEngine.result = exporter
        except BaseException as e:   # Blender would print and forget it
            AlderExportEngine.result = e

    result = None
    path = None


def export(path, scene=None, view_layer=None):
    """Writes the scene as it renders at its current frame; gives the exporter, with its document and report."""
    context = bpy.context
    scene = scene or context.scene
    layers = [v for v in scene.view_layers if v.use]
    if not layers:
        raise ExportError("no view layer of scene %s is used for rendering" % scene.name)
    view_layer = view_layer or (context.view_layer if scene == context.scene and context.view_layer.use else layers[0])
    if scene.camera is None:
        raise ExportError("scene %s has no camera" % scene.name)
    registered = hasattr(bpy.types, "AlderExportEngine")
    if not registered:
        bpy.utils.register_class(AlderExportEngine)
    r = scene.render
    kept = {k: getattr(r, k) for k in ("engine", "use_compositing", "use_sequencer", "resolution_x", "resolution_y")}
    AlderExportEngine.path, AlderExportEngine.result = path, None
    try:
        r.engine = "ALDER_EXPORT"
        r.use_compositing = r.use_sequencer = False
        bpy.ops.render.render(write_still=False, layer=view_layer.name, scene=scene.name)
        result = AlderExportEngine.result
    finally:
        for k, v in kept.items():
            setattr(r, k, v)
        AlderExportEngine.path, AlderExportEngine.result = None, None
        if not registered:
            bpy.utils.unregister_class(AlderExportEngine)
    if isinstance(result, BaseException):
        raise result
    if result is None:
        raise ExportError("Blender did not render the scene")
    return result
