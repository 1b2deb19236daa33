"""File > Export > Alder (.alder)."""
import bpy
from bpy_extras.io_utils import ExportHelper

from . import engine
from .report import ExportError


class ExportAlder(bpy.types.Operator, ExportHelper):
    """Write the scene, as it renders at the current frame, for Alder"""
    bl_idname = "export_scene.alder"
    bl_label = "Export Alder"
    filename_ext = ".alder"
    filter_glob: bpy.props.StringProperty(default="*.alder", options={"HIDDEN"})

    def execute(self, context):
        try:
            exporter = engine.export(self.filepath)
        except (ExportError, OSError) as e:
            self.report({"ERROR"}, str(e))
            return {"CANCELLED"}
        for line in exporter.report.lines():
            self.report({"WARNING"}, line)
        return {"FINISHED"}


def _menu(self, context):
    self.layout.operator(ExportAlder.bl_idname, text="Alder (.alder)")


def register():
    bpy.utils.register_class(ExportAlder)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    bpy.utils.unregister_class(ExportAlder)
