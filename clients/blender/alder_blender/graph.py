"""Node trees as graph documents.

A tree is walked from its output node against the links, so that what nothing uses is left out. Nodes keep Blender's names, types
and socket identifiers. Reroutes and muted nodes are passed through; groups go under "groups" of the document, each once.
"""
from . import values

OUTPUTS = {"material": "ShaderNodeOutputMaterial", "world": "ShaderNodeOutputWorld", "light": "ShaderNodeOutputLight"}
# Cycles does not render these either, or only with a compiler that Alder does not have.
REFUSED = {"ShaderNodeScript": "OSL scripts", "ShaderNodeCustomGroup": "custom node groups", "ShaderNodeEeveeSpecular": "an EEVEE node",
           "ShaderNodeShaderToRGB": "an EEVEE node", "ShaderNodeOutputLineStyle": "a line style", "ShaderNodeSqueeze": "an obsolete node",
           "ShaderNodeTexPointDensity": "point densities", "ShaderNodeUVAlongStroke": "a line style",
           "ShaderNodeRadialTiling": "new in Blender 5.0"}
# Sockets of Blender 5.0 that Alder's nodes do not have; without effect while the first of them is 0.
NEWER = {"ShaderNodeBsdfGlass": ("Thin Film Thickness", "Thin Film IOR"), "ShaderNodeBsdfMetallic": ("Thin Film Thickness", "Thin Film IOR")}
SOCKET_TYPES = ("NodeSocketFloat", "NodeSocketInt", "NodeSocketBool", "NodeSocketColor", "NodeSocketVector", "NodeSocketShader")
# Constants that Blender keeps on output sockets.
ON_OUTPUT = {"ShaderNodeValue": "Value", "ShaderNodeRGB": "Color", "ShaderNodeNormal": "Normal"}
# Settings of pictures and of the editor, which do not change what a node gives.
INERT = {"image_user", "color_mapping", "show_texture", "is_active_output", "bytecode", "bytecode_hash", "use_auto_update", "use_alpha"}


def is_on(socket):
    """Whether the node's settings show the socket; links to hidden ones stay in the file and mean nothing."""
    return getattr(socket, "enabled", True) and not getattr(socket, "is_unavailable", False)


def output_node(tree, bl_idname):
    """As Blender chooses: one for Cycles goes before one for all renderers, and the active one before the first."""
    best, rank = None, -1
    for n in tree.nodes:
        target = getattr(n, "target", "ALL")
        if n.bl_idname != bl_idname or target not in ("ALL", "CYCLES") or n.mute:
            continue
        r = 2 * (target == "CYCLES") + bool(n.is_active_output)
        if r > rank:
            best, rank = n, r
    return best


class GraphWriter:
    """Writes the graphs of one scene. What needs Blender comes as functions:

    image(image, image_user, where) -> the parameter's value or None;  text(text) and file(path, where) likewise;
    object_matrix(object) -> 4 rows of 4.
    """

    def __init__(self, report, image=None, file=None, object_matrix=None, version=None):
        self.report = report
        self.image = image
        self.file = file
        self.object_matrix = object_matrix or (lambda o: o.matrix_world)
        self.version = version
        self._groups = {}   # name -> (graph, names of the groups it uses)

    def document(self, tree, kind, where):
        """(graph document, what of "Surface", "Displacement" and "Volume" is linked); a graph without surface where nothing is."""
        walk = _Walk(self, tree, where)
        out = output_node(tree, OUTPUTS[kind])
        graph = {"version": 1, "nodes": walk.nodes, "outputs": {}}
        if self.version:
            graph["blender_version"] = list(self.version)
        linked = {}
        if out is not None:
            for socket in out.inputs:
                if is_on(socket) and socket.identifier in ("Surface", "Displacement", "Volume"):
                    value = walk.linked(out, socket)
                    if value is not None:
                        linked[socket.identifier] = value
        surface = linked.get("Surface")
        if surface is not None:
            # A colour in place of a shader shines.
            if not isinstance(surface, dict) or walk.type_of(surface) != "SHADER":
                surface = {"node": walk.add("Surface as light", "ShaderNodeEmission", {"Color": surface, "Strength": 1.0}), "output": "Emission"}
            graph["outputs"]["surface"] = surface
        volume = linked.get("Volume")
        if isinstance(volume, dict) and walk.type_of(volume) == "SHADER":
            graph["outputs"]["volume"] = volume
        if isinstance(linked.get("Displacement"), dict):
            graph["outputs"]["displacement"] = linked["Displacement"]
        if kind == "material":
            for n in tree.nodes:
                if n.bl_idname == "ShaderNodeOutputAOV" and not n.mute:
                    walk.node(n)
        walk.run()
        used = self._all_groups(walk.groups)
        if used:
            graph["groups"] = {name: self._groups[name][0] for name in sorted(used)}
        return graph, linked

    def _all_groups(self, names):
        done, todo = set(), list(names)
        while todo:
            name = todo.pop()
            if name not in done:
                done.add(name)
                todo.extend(self._groups[name][1])
        return done

    def group(self, tree, where):
        """The name under "groups" of a group's tree, written if it was not yet."""
        name = getattr(tree, "name_full", tree.name)
        if name in self._groups:
            return name
        walk = _Walk(self, tree, "group " + name)
        graph = {"inputs": {}, "outputs": {}, "nodes": walk.nodes}
        self._groups[name] = (graph, walk.groups)
        out = None
        for n in tree.nodes:
            if n.bl_idname == "NodeGroupOutput" and (out is None or n.is_active_output):
                out = n
            if n.bl_idname == "NodeGroupInput":
                for s in n.outputs:
                    self._declare(graph["inputs"], s, where)
        if out is not None:
            for s in out.inputs:
                self._declare(graph["outputs"], s, where)
            walk.node(out)
        walk.run()
        # The parameters of the output node are what the group gives; "outputs" would say the same a second time.
        graph.pop("outputs")
        return name

    def _declare(self, table, socket, where):
        if socket.bl_idname == "NodeSocketVirtual":
            return
        if not socket.bl_idname.startswith(SOCKET_TYPES):
            self.report.unsupported("group sockets of type " + socket.bl_idname, where)
            return
        table[socket.identifier] = {"type": socket.bl_idname}
        value = values.socket_value(socket)
        if value is not None:
            table[socket.identifier]["default"] = value


class _Walk:
    """One tree on its way into one "nodes" object."""

    def __init__(self, writer, tree, where):
        self.w = writer
        self.where = where
        self.nodes = {}
        self.groups = set()
        self._taken = {n.name for n in tree.nodes}
        self._todo = []
        self._done = {}   # name -> node
        self._links = {}
        for l in tree.links:
            if not getattr(l, "is_muted", False) and getattr(l, "is_valid", True):
                self._links[(l.to_node.name, l.to_socket.identifier)] = (l.from_node, l.from_socket)

    def run(self):
        while self._todo:
            self._write(self._todo.pop())

    def node(self, node):
        if node.name not in self._done:
            self._done[node.name] = node
            self._todo.append(node)

    def add(self, name, bl_idname, params):
        while name in self._taken:
            name += "'"
        self._taken.add(name)
        self.nodes[name] = {"type": bl_idname, "params": params}
        return name

    def type_of(self, link):
        for s in self._done[link["node"]].outputs:
            if s.identifier == link["output"]:
                return s.type
        return None

    def linked(self, node, socket):
        """What is linked to an input: a link, or the constant that a muted node passes on; None where nothing is."""
        found = self.source(node, socket)
        if not isinstance(found, tuple):
            return found
        self.node(found[0])
        return {"node": found[0].name, "output": found[1].identifier}

    def source(self, node, socket):
        """The same as (node, socket), or the constant, without the node becoming part of the document."""
        for _ in range(100000):   # more than any chain of reroutes; a circle of them ends here
            if (node.name, socket.identifier) not in self._links:
                return None
            node, socket = self._links[(node.name, socket.identifier)]
            if node.bl_idname == "NodeReroute":
                socket = node.inputs[0]
            elif node.mute:
                through = [l.from_socket for l in node.internal_links if l.to_socket.identifier == socket.identifier]
                if not through:
                    return None
                socket = through[0]
                if (node.name, socket.identifier) not in self._links:
                    return values.socket_value(socket)
            elif node.bl_idname in REFUSED or (node.bl_idname == "ShaderNodeGroup" and node.node_tree is None):
                what = REFUSED.get(node.bl_idname, "a group without its tree")
                self.w.report.unsupported("node %s: %s" % (node.bl_idname, what), "%s/%s" % (self.where, node.name))
                return None
            elif not is_on(socket):
                return None
            else:
                return node, socket
        return None

    def _write(self, node):
        place = "%s/%s" % (self.where, node.name)
        params = {}
        out = {"type": node.bl_idname, "params": params}
        is_group = node.bl_idname == "ShaderNodeGroup"
        if is_group:
            out["group"] = self.w.group(node.node_tree, place)
            self.groups.add(out["group"])
        elif not node.bl_idname.startswith("NodeGroup"):
            self._settings(node, params, place)
        if node.bl_idname in ON_OUTPUT:
            socket = node.outputs[0]
            if node.bl_idname == "ShaderNodeNormal":
                params["Direction"] = values.numbers(socket.default_value)
            else:
                params[ON_OUTPUT[node.bl_idname]] = values.socket_value(socket)
        for socket in node.inputs:
            if not is_on(socket) or getattr(socket, "bl_idname", "") == "NodeSocketVirtual":
                continue
            newer = NEWER.get(node.bl_idname, ())
            if socket.identifier in newer:
                if socket.identifier == newer[0] and (self.source(node, socket) is not None or socket.default_value != 0):
                    self.w.report.unsupported("socket %s of %s" % (socket.identifier, node.bl_idname), place)
                continue
            value = self.linked(node, socket)
            # A socket without a field in the editor means "the usual": its stored number is not one that somebody set.
            if value is None and (is_group or node.bl_idname == "NodeGroupOutput" or not getattr(socket, "hide_value", False)):
                value = values.socket_value(socket)
            if value is not None:
                params[socket.identifier] = value
        if node.bl_idname == "ShaderNodeTexSky":
            self._sky(params, place)
        self.nodes[node.name] = out

    def _sky(self, params, place):
        """Blender 5.0's names of what was Nishita's model."""
        if params.get("sky_type") == "MULTIPLE_SCATTERING":
            self.w.report.unsupported("sky with multiple scattering (written with single scattering)", place)
        if params.get("sky_type") in ("MULTIPLE_SCATTERING", "SINGLE_SCATTERING"):
            params["sky_type"] = "NISHITA"
        if "aerosol_density" in params:
            params["dust_density"] = params.pop("aerosol_density")

    def _settings(self, node, params, place):
        for p in own_properties(node):
            if p.identifier in INERT:
                continue
            value = getattr(node, p.identifier)
            if p.type == "POINTER":
                value = self._pointer(node, p.identifier, value, place)
            elif p.type == "FLOAT":
                value = values.numbers(value) if getattr(p, "is_array", False) else values.number(value)
            elif p.type == "ENUM" and getattr(p, "is_enum_flag", False):
                value = sorted(value)
            elif p.type not in ("ENUM", "BOOLEAN", "INT", "STRING"):
                continue
            elif getattr(p, "is_array", False):
                value = list(value)
            if p.identifier == "filepath" and value:
                value = self.w.file(value, place) if self.w.file else None
            if value is not None and value != "" or p.type == "STRING" and p.identifier != "filepath":
                params[p.identifier] = value

    def _pointer(self, node, name, value, place):
        if value is None:
            return None
        if name == "image":
            return self.w.image(value, getattr(node, "image_user", None), place) if self.w.image else None
        if name == "color_ramp":
            return values.color_ramp(value)
        if name == "mapping":
            return values.curve_mapping(value)
        if name == "texture_mapping":
            return values.texture_mapping(value)
        if name == "object":
            return values.matrix(self.w.object_matrix(value))
        if name == "ies":
            return {"text": value.as_string()}
        self.w.report.unsupported("setting %s of %s" % (name, node.bl_idname), place)
        return None


def own_properties(node):
    """The settings that a node's type adds to those of every node."""
    rna = node.bl_rna
    base = rna.base
    while base is not None and base.identifier != "Node":
        base = base.base
    common = {p.identifier for p in base.properties} if base is not None else set()
    return [p for p in rna.properties if p.identifier not in common and p.identifier != "rna_type"]
