"""Preferences: where Alder renders."""
import os

import bpy


class AlderPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    place: bpy.props.EnumProperty(name="Render with", default="PROGRAM", items=(
        ("PROGRAM", "This machine", "The program alder on this machine"),
        ("DAEMON", "A daemon", "A daemon alderd, here or elsewhere")))
    program: bpy.props.StringProperty(name="Program", subtype="FILE_PATH", description="Path of alder; empty: found on PATH")
    threads: bpy.props.IntProperty(name="Threads", min=0, max=1024, description="0: all processors")
    url: bpy.props.StringProperty(name="Address", default="http://127.0.0.1:7420")
    token: bpy.props.StringProperty(name="Token", subtype="PASSWORD")

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(self, "place")
        for name in (("program", "threads") if self.place == "PROGRAM" else ("url", "token")):
            self.layout.prop(self, name)


class _Defaults:
    """Without preferences (the add-on is not enabled but imported): the environment's."""
    place = "PROGRAM"
    program, threads, token = "", 0, ""
    url = ""


def current():
    addon = bpy.context.preferences.addons.get(__package__)
    found = addon.preferences if addon is not None and addon.preferences is not None else _Defaults()
    if os.environ.get("ALDER_URL"):   # scripts in background mode
        class FromEnvironment(_Defaults):
            place, url = "DAEMON", os.environ["ALDER_URL"]
            token = _token()
        return FromEnvironment()
    return found


def _token():
    path = os.environ.get("ALDER_TOKEN_FILE")
    if not path:
        return ""
    with open(path) as f:
        return f.readline().strip()


def register():
    bpy.utils.register_class(AlderPreferences)


def unregister():
    bpy.utils.unregister_class(AlderPreferences)
