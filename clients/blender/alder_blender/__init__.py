"""Alder for Blender: a render engine, alShaders' nodes in the shader editor, and scenes as .alder files.

    python3 -m alder_blender FILE.blend -o OUT.alder

The modules without Blender in them (`graph`, `values`, `container`, `report`, `passes`, `backend`) can be imported anywhere; the others
need `bpy`.
"""

# For Blender before 4.2, which reads no manifest.
bl_info = {"name": "Alder", "author": "The Alder project", "version": (0, 1, 0), "blender": (3, 4, 0), "category": "Render",
           "description": "Render with Alder, and export scenes for it"}


def _modules():
    from . import al_nodes, operator, preferences, render_engine
    return preferences, al_nodes, render_engine, operator


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()
