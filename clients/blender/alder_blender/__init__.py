"""Alder for Blender: writes a Blender scene as an .alder file.

    python3 -m alder_blender FILE.blend -o OUT.alder

The modules without Blender in them (`graph`, `values`, `container`, `report`) can be imported anywhere; the others need `bpy`.
"""


def register():
    from . import operator
    operator.register()


def unregister():
    from . import operator
    operator.unregister()
