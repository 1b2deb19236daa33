"""alShaders' nodes in the shader editor, made from Alder's catalogue (al_nodes.json: `make_add_on.py --nodes` writes it anew).

A node's type is its name in Alder, so that the exporter writes it as it is: inputs are sockets, choices and switches are settings.
"""
import json
import os
import re

import bpy

SOCKETS = {"float": "NodeSocketFloat", "int": "NodeSocketInt", "bool": "NodeSocketBool", "color": "NodeSocketColor", "vector": "NodeSocketVector",
           "point": "NodeSocketVector", "normal": "NodeSocketVector", "closure": "NodeSocketShader"}
CLASSES = []
MENUS = []


def load():
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "al_nodes.json"), encoding="utf-8") as f:
        return json.load(f)["items"]


def _is_socket(p):
    return p.get("links") and p["type"] in SOCKETS


def _property(p):
    """A parameter that cannot be linked, as a property of the node; None for structures."""
    help_text = p.get("help", "")
    if p["type"] == "enum":
        # The text in the document is the identifier: what Alder calls the choice.
        items = [(e["name"], e.get("label", e["name"]), e.get("help", "")) for e in p["enum"]]
        return bpy.props.EnumProperty(name=p["name"], description=help_text, items=items, default=p["default"])
    if p["type"] == "bool":
        return bpy.props.BoolProperty(name=p["name"], description=help_text, default=bool(p["default"]))
    if p["type"] == "int":
        return bpy.props.IntProperty(name=p["name"], description=help_text, default=int(p["default"] or 0))
    if p["type"] == "float":
        return bpy.props.FloatProperty(name=p["name"], description=help_text, default=float(p["default"] or 0))
    if p["type"] in ("string", "image"):
        return bpy.props.StringProperty(name=p["name"], description=help_text, default=p["default"] or "", subtype="FILE_PATH" if p["type"] == "image" else "NONE")
    if p["type"] == "color":
        return bpy.props.FloatVectorProperty(name=p["name"], description=help_text, default=p["default"], size=3, subtype="COLOR")
    return None


def _set_default(socket, p):
    value = p.get("default")
    if value is None or not hasattr(socket, "default_value"):
        socket.hide_value = value is None and p["type"] != "closure"
        return
    if p["type"] == "color":
        value = [*(value if isinstance(value, list) else [value] * 3), 1.0][:4]
    elif p["type"] == "bool":
        value = bool(value)
    elif p["type"] == "int":
        value = int(value)
    socket.default_value = value


def _make(item):
    settings = {p["name"]: _property(p) for p in item.get("params", []) if not _is_socket(p)}
    settings = {k: v for k, v in settings.items() if v is not None}

    def init(self, context):
        for p in item.get("params", []):
            if _is_socket(p):
                socket = self.inputs.new(SOCKETS[p["type"]], p["name"], identifier=p["name"])
                _set_default(socket, p)
        for o in item.get("outputs", []):
            self.outputs.new(SOCKETS.get(o["type"], "NodeSocketFloat"), o["name"], identifier=o["name"])
        if item.get("closure") and not item.get("outputs"):
            self.outputs.new("NodeSocketShader", "out", identifier="out")

    def draw_buttons(self, context, layout):
        for name in settings:
            layout.prop(self, name)

    name = item["name"]
    return type(name, (bpy.types.Node,), {
        "__doc__": item.get("summary", name), "bl_idname": name, "bl_label": name, "bl_icon": "NODE_MATERIAL", "bl_width_default": 220,
        "__annotations__": settings, "init": init, "draw_buttons": draw_buttons,
        "poll": classmethod(lambda cls, tree: tree.bl_idname == "ShaderNodeTree")})


def _menu(category, names):
    def draw(self, context):
        for name in names:
            op = self.layout.operator("node.add_node", text=name)
            op.type, op.use_transform = name, True
    name = "NODE_MT_alder_" + re.sub(r"[^a-z0-9]", "_", category.lower())
    return type(name, (bpy.types.Menu,), {"bl_idname": name, "bl_label": "alShaders: " + category, "draw": draw})


def _draw(self, context):
    if context.space_data is not None and getattr(context.space_data, "tree_type", "") == "ShaderNodeTree":
        self.layout.separator()
        for menu in MENUS:
            self.layout.menu(menu.bl_idname)


def register():
    categories = {}
    for item in load():
        CLASSES.append(_make(item))
        categories.setdefault(item.get("category", "other"), []).append(item["name"])
    MENUS.extend(_menu(category, names) for category, names in sorted(categories.items()))
    for cls in CLASSES + MENUS:
        bpy.utils.register_class(cls)
    bpy.types.NODE_MT_add.append(_draw)


def unregister():
    bpy.types.NODE_MT_add.remove(_draw)
    for cls in reversed(CLASSES + MENUS):
        bpy.utils.unregister_class(cls)
    CLASSES.clear()
    MENUS.clear()
