"""Node trees that look like Blender's to the exporter, without Blender."""
from types import SimpleNamespace

SHADER, VALUE, RGBA, VECTOR = "SHADER", "VALUE", "RGBA", "VECTOR"
CLASSES = {SHADER: "NodeSocketShader", VALUE: "NodeSocketFloat", RGBA: "NodeSocketColor", VECTOR: "NodeSocketVector"}


class Socket:
    def __init__(self, identifier, kind, value=None, **more):
        self.identifier = self.name = identifier
        self.type = kind
        self.bl_idname = CLASSES[kind]
        self.enabled = True
        self.hide_value = False
        if value is not None:
            self.default_value = value
        self.__dict__.update(more)


def prop(identifier, kind, **more):
    return SimpleNamespace(identifier=identifier, type=kind, is_array=False, is_enum_flag=False, **more)


BASE = SimpleNamespace(identifier="Node", base=None, properties=[prop("rna_type", "POINTER"), prop("name", "STRING"), prop("mute", "BOOLEAN")])


class Node:
    def __init__(self, tree, name, bl_idname, inputs, outputs, settings):
        self.name, self.bl_idname, self.mute = name, bl_idname, False
        self.inputs, self.outputs, self.internal_links = inputs, outputs, []
        own = []
        for k, (kind, value) in settings.items():
            own.append(prop(k, kind))
            setattr(self, k, value)
        self.bl_rna = SimpleNamespace(identifier=bl_idname, base=BASE, properties=BASE.properties + own)
        tree.nodes.append(self)

    def __getitem__(self, identifier):
        return next(s for s in [*self.outputs, *self.inputs] if s.identifier == identifier)


class Tree:
    def __init__(self, name="tree"):
        self.name, self.nodes, self.links = name, [], []

    def add(self, name, bl_idname, inputs=(), outputs=(), **settings):
        return Node(self, name, bl_idname, list(inputs), list(outputs), settings)

    def link(self, a, output, b, input_, muted=False):
        self.links.append(SimpleNamespace(from_node=a, to_node=b, is_muted=muted, is_valid=True,
                                          from_socket=next(s for s in a.outputs if s.identifier == output),
                                          to_socket=next(s for s in b.inputs if s.identifier == input_)))

    def output(self, name="Material Output", bl_idname="ShaderNodeOutputMaterial", target="ALL", active=True):
        n = self.add(name, bl_idname, [Socket("Surface", SHADER), Socket("Volume", SHADER), Socket("Displacement", VECTOR, [0, 0, 0], hide_value=True)])
        n.target, n.is_active_output = target, active
        return n

    def diffuse(self, name="Diffuse BSDF"):
        return self.add(name, "ShaderNodeBsdfDiffuse",
                        [Socket("Color", RGBA, [0.8, 0.7, 0.6, 1.0]), Socket("Roughness", VALUE, 0.0), Socket("Normal", VECTOR, [0, 0, 0], hide_value=True)],
                        [Socket("BSDF", SHADER)])

    def value(self, x, name="Value"):
        return self.add(name, "ShaderNodeValue", [], [Socket("Value", VALUE, x)])

    def reroute(self, name="Reroute", kind=VALUE):
        return self.add(name, "NodeReroute", [Socket("Input", kind)], [Socket("Output", kind)])
