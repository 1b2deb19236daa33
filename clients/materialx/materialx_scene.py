#!/usr/bin/env python3
"""Converts MaterialX documents to graph documents, shown on spheres in an .alder scene.

    python3 clients/materialx/materialx_scene.py car.mtlx -o car.alder
    python3 clients/materialx/materialx_scene.py car.mtlx --material paint -o paint.graph.json

Needs the Python package MaterialX (pip install MaterialX). standard_surface and open_pbr_surface become a Principled BSDF; pattern nodes
their nearest of Blender's nodes. What has no counterpart is told, one line each, and stands in the scene's report.
Exit status: 0 converted, 2 not.
"""
import argparse
import json
import os
import sys

for folder in ("ass", "scene_files"):
    sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", folder))
from ass_mesh import Buffers, sphere  # noqa: E402
from report import Report, write_container  # noqa: E402


class MaterialXError(Exception):
    """The document cannot be converted; the message says why."""


# input -> (parameter of the Principled BSDF, the value that says nothing). Inputs that are not here are told where they are set.
STANDARD = {"specular": "Specular IOR Level", "specular_roughness": "Roughness", "specular_IOR": "IOR", "specular_anisotropy": "Anisotropic",
            "specular_rotation": "Anisotropic Rotation", "specular_color": "Specular Tint", "metalness": "Metallic", "diffuse_roughness": "Diffuse Roughness",
            "transmission": "Transmission Weight", "subsurface": "Subsurface Weight", "subsurface_radius": "Subsurface Radius",
            "subsurface_scale": "Subsurface Scale", "subsurface_anisotropy": "Subsurface Anisotropy", "sheen": "Sheen Weight", "sheen_color": "Sheen Tint",
            "sheen_roughness": "Sheen Roughness", "coat": "Coat Weight", "coat_color": "Coat Tint", "coat_roughness": "Coat Roughness", "coat_IOR": "Coat IOR",
            "thin_film_thickness": "Thin Film Thickness", "thin_film_IOR": "Thin Film IOR", "emission": "Emission Strength", "emission_color": "Emission Color",
            "opacity": "Alpha", "normal": "Normal", "coat_normal": "Coat Normal", "tangent": "Tangent"}
OPEN_PBR = {"specular_weight": "Specular IOR Level", "specular_roughness": "Roughness", "specular_ior": "IOR", "specular_roughness_anisotropy": "Anisotropic",
            "specular_color": "Specular Tint", "base_metalness": "Metallic", "base_diffuse_roughness": "Diffuse Roughness",
            "transmission_weight": "Transmission Weight", "subsurface_weight": "Subsurface Weight", "subsurface_radius_scale": "Subsurface Radius",
            "subsurface_radius": "Subsurface Scale", "subsurface_scatter_anisotropy": "Subsurface Anisotropy", "fuzz_weight": "Sheen Weight",
            "fuzz_color": "Sheen Tint", "fuzz_roughness": "Sheen Roughness", "coat_weight": "Coat Weight", "coat_color": "Coat Tint",
            "coat_roughness": "Coat Roughness", "coat_ior": "Coat IOR", "emission_luminance": "Emission Strength", "emission_color": "Emission Color",
            "geometry_opacity": "Alpha", "geometry_normal": "Normal", "geometry_coat_normal": "Coat Normal", "geometry_tangent": "Tangent"}
# Both systems' reflectivity 1 is Blender's level 0.5.
HALVED = {"Specular IOR Level"}
SURFACES = {"standard_surface": (STANDARD, "base", "base_color"), "open_pbr_surface": (OPEN_PBR, "base_weight", "base_color")}
DEFAULTS = {"standard_surface": {"specular": 1.0, "specular_roughness": 0.2, "specular_IOR": 1.5, "base": 1.0, "base_color": [0.8] * 3, "sheen_roughness": 0.3,
                                 "coat_roughness": 0.1, "coat_IOR": 1.5, "subsurface_radius": [1.0] * 3, "subsurface_scale": 1.0, "emission_color": [1.0] * 3,
                                 "emission": 0.0, "diffuse_roughness": 0.0},
            "open_pbr_surface": {"specular_weight": 1.0, "specular_roughness": 0.3, "specular_ior": 1.5, "base_weight": 1.0, "base_color": [0.8] * 3,
                                 "fuzz_roughness": 0.5, "coat_roughness": 0.0, "coat_ior": 1.6, "subsurface_radius": 1.0, "subsurface_radius_scale": [1.0, 0.5, 0.25],
                                 "emission_color": [1.0] * 3, "emission_luminance": 0.0, "base_diffuse_roughness": 0.0}}
MATH = {"add": "ADD", "subtract": "SUBTRACT", "multiply": "MULTIPLY", "divide": "DIVIDE", "power": "POWER", "min": "MINIMUM", "max": "MAXIMUM", "modulo": "FLOORED_MODULO",
        "absval": "ABSOLUTE", "sin": "SINE", "cos": "COSINE", "tan": "TANGENT", "floor": "FLOOR", "ceil": "CEIL", "sqrt": "SQRT", "sign": "SIGN", "exp": "EXPONENT"}
VECTOR_MATH = {"add": "ADD", "subtract": "SUBTRACT", "multiply": "MULTIPLY", "divide": "DIVIDE", "min": "MINIMUM", "max": "MAXIMUM", "absval": "ABSOLUTE", "floor": "FLOOR",
               "ceil": "CEIL", "normalize": "NORMALIZE", "crossproduct": "CROSS_PRODUCT"}
IDENTITY_SECOND = {"add": 0.0, "subtract": 0.0, "multiply": 1.0, "divide": 1.0, "power": 1.0, "modulo": 1.0, "min": 0.0, "max": 0.0}
COMPONENTS = "rgb"


class Converter:
    def __init__(self, path, report):
        try:
            import MaterialX
        except ImportError:
            raise MaterialXError("this Python has no MaterialX: pip install MaterialX") from None
        self.mx, self.path, self.report = MaterialX, path, report
        self.files = {}
        self.document = MaterialX.createDocument()
        try:
            MaterialX.readFromXmlFile(self.document, path, MaterialX.FileSearchPath(os.path.dirname(os.path.abspath(path))))
        except Exception as e:   # MaterialX' own kinds
            raise MaterialXError("%s: %s" % (path, e)) from None

    def materials(self):
        """{name: graph} of every surface of the document, under its material's name where it has one."""
        out = {}
        shaders = [(n.getName(), n.getConnectedNode("surfaceshader")) for n in self.document.getNodes("surfacematerial")]
        seen = {s.getName() for _, s in shaders if s is not None}
        shaders += [(n.getName(), n) for kind in SURFACES for n in self.document.getNodes(kind) if n.getName() not in seen]
        for name, shader in shaders:
            if shader is None or shader.getCategory() not in SURFACES:
                self.report("surface shader %s" % (shader.getCategory() if shader is not None else "that is not there"), name)
                continue
            self.nodes, self.made, self.place = {}, {}, name
            surface = self.surface(shader)
            out[name] = {"version": 1, "nodes": self.nodes, "outputs": {"surface": {"node": surface, "output": "BSDF"}}}
        if not out:
            raise MaterialXError("%s: there is no standard_surface and no open_pbr_surface" % self.path)
        return out

    def surface(self, shader):
        kind = shader.getCategory()
        table, weight, color = SURFACES[kind]
        values = dict(DEFAULTS[kind])
        for i in shader.getInputs():
            v = self.input(i)
            if v is not None:
                values[i.getName()] = v
        base = self.product(values.pop(weight), values.pop(color))
        params = {"Base Color": self.rgba(base)}
        for name, v in values.items():
            target = table.get(name)
            if target is None:
                self.report("input %s of %s" % (name, kind), self.place)
                continue
            if target in HALVED:
                v = self.product(0.5, v)
            if target == "Alpha" and isinstance(v, list):
                v = sum(v) / 3
            if target.endswith(("Tint", "Color")):
                v = self.rgba(v)
            params[target] = v
        if kind == "standard_surface" and "Subsurface Weight" in params or kind == "open_pbr_surface" and params.get("Subsurface Weight"):
            self.report("subsurface colour (the base colour is used)", self.place, True)
        if params.get("Transmission Weight"):
            self.report("colour of the transmission (the base colour tints it)", self.place, True)
        return self.add("surface", "ShaderNodeBsdfPrincipled", params)

    # ---- values ----

    def add(self, name, kind, params):
        free, n = name, 1
        while free in self.nodes:
            n += 1
            free = "%s.%d" % (name, n)
        self.nodes[free] = {"type": kind, "params": params}
        return free

    @staticmethod
    def rgba(v):
        return [*v, 1.0] if isinstance(v, list) and len(v) == 3 else [v, v, v, 1.0] if isinstance(v, float) else v

    def product(self, a, b):
        if not isinstance(a, dict) and not isinstance(b, dict):
            if isinstance(a, list) or isinstance(b, list):
                a, b = (x if isinstance(x, list) else [x] * 3 for x in (a, b))
                return [x * y for x, y in zip(a, b)]
            return a * b
        if a == 1.0 or b == 1.0:
            return b if a == 1.0 else a
        vector = [x if isinstance(x, (dict, list)) else [x] * 3 for x in (a, b)]
        return {"node": self.add("product", "ShaderNodeVectorMath", {"operation": "MULTIPLY", "Vector": vector[0], "Vector_001": vector[1]}), "output": "Vector"}

    def input(self, i):
        """A constant or a link; None where nothing is said or what is linked has no counterpart."""
        interface = i.getInterfaceInput()
        if interface is not None and not i.getNodeName():
            i = interface
        node, output = i.getConnectedNode(), i.getConnectedOutput()
        if node is None and output is not None:
            node = output.getConnectedNode()
        if node is not None:
            link = self.node(node)
            channel = i.getChannels() if hasattr(i, "getChannels") else ""
            if isinstance(link, dict) and len(channel) == 1 and channel in "rgb":
                link = {**link, "component": channel}
            return link
        if i.getNodeName() or i.getNodeGraphString():
            self.report("link to a node that is not there", "%s/%s" % (self.place, i.getName()))
            return None
        return self.constant(i.getValue(), i.getType())

    def constant(self, value, kind):
        if value is None:
            return None
        if kind in ("float", "integer"):
            return float(value)
        if kind == "boolean":
            return 1.0 if value else 0.0
        if kind.startswith(("color", "vector")):
            numbers = [float(value[k]) for k in range(int(kind[-1]))]
            return (numbers + [0.0])[:3]
        return value if isinstance(value, str) else None

    def get(self, node, name, default):
        i = node.getActiveInput(name) if hasattr(node, "getActiveInput") else node.getInput(name)
        v = self.input(i) if i is not None else None
        return default if v is None else v

    # ---- pattern nodes ----

    def node(self, node):
        key = node.getNamePath()
        if key not in self.made:
            self.made[key] = None   # a circle of links ends here
            handler = getattr(self, "on_" + node.getCategory(), None)
            category, kind = node.getCategory(), node.getType()
            if handler is not None:
                self.made[key] = handler(node)
            elif category in MATH and kind in ("float", "integer"):
                self.made[key] = self.math(node, "ShaderNodeMath", MATH[category], "Value", float)
            elif category in VECTOR_MATH and kind in ("color3", "vector3", "vector2"):
                self.made[key] = self.math(node, "ShaderNodeVectorMath", VECTOR_MATH[category], "Vector", list)
            else:
                self.report("node %s (%s)" % (category, kind), "%s/%s" % (self.place, node.getName()))
        return self.made[key]

    def math(self, node, kind, operation, output, shape):
        def value(name, default):
            v = self.get(node, name, default)
            return [v] * 3 if shape is list and isinstance(v, float) else v
        category = node.getCategory()
        params = {"operation": operation}
        if category in IDENTITY_SECOND or category == "crossproduct":
            params[output], params[output + "_001"] = value("in1", 0.0), value("in2", IDENTITY_SECOND.get(category, 0.0))
        else:
            params[output] = value("in", 0.0)
        return {"node": self.add(node.getName(), kind, params), "output": output}

    def on_constant(self, node):
        return self.get(node, "value", 0.0)

    def on_dot(self, node):
        return self.get(node, "in", 0.0)

    on_convert = on_dot

    def on_texcoord(self, node):
        return {"node": self.add(node.getName(), "ShaderNodeTexCoord", {}), "output": "UV"}

    def on_position(self, node):
        space = node.getInputValue("space") if node.getInput("space") else "object"
        output = ("ShaderNodeNewGeometry", "Position") if space == "world" else ("ShaderNodeTexCoord", "Object")
        return {"node": self.add(node.getName(), output[0], {}), "output": output[1]}

    def on_normal(self, node):
        return {"node": self.add(node.getName(), "ShaderNodeNewGeometry", {}), "output": "Normal"}

    def on_image(self, node):
        i = node.getInput("file")
        name = i.getResolvedValueString() if i is not None else ""
        path = os.path.join(os.path.dirname(os.path.abspath(self.path)), name)
        if not name or not os.path.isfile(path):
            self.report("image file that is not there", name or node.getName())
            return None
        member = "images/" + os.path.basename(name)
        with open(path, "rb") as f:
            self.files[member] = f.read()
        space = i.getActiveColorSpace()
        raw = node.getType() in ("float", "vector2", "vector3") or space in ("none", "raw", "lin_rec709", "")
        params = {"image": {"file": member, "colorspace": "Non-Color" if raw else "sRGB"},
                  "extension": {"clamp": "EXTEND", "constant": "CLIP", "mirror": "MIRROR"}.get(node.getInputValue("uaddressmode") if node.getInput("uaddressmode") else "", "REPEAT")}
        if space not in ("", "none", "raw", "lin_rec709", "srgb_texture"):
            self.report("colour space %s of an image (sRGB is used)" % space, name)
        vector = self.get(node, "texcoord", None)
        scale = self.get(node, "uvtiling", None) if node.getCategory() == "tiledimage" else None
        if isinstance(scale, list) and scale[:2] != [1, 1]:
            source = vector or {"node": self.add("uv", "ShaderNodeTexCoord", {}), "output": "UV"}
            vector = {"node": self.add("tiling", "ShaderNodeVectorMath", {"operation": "MULTIPLY", "Vector": source, "Vector_001": [*scale[:2], 1.0]}), "output": "Vector"}
        if isinstance(vector, dict):
            params["Vector"] = vector
        link = {"node": self.add(node.getName(), "ShaderNodeTexImage", params), "output": "Color"}
        return {**link, "component": "r"} if node.getType() == "float" else link

    on_tiledimage = on_image

    def on_mix(self, node):
        is_float = node.getType() == "float"
        suffix = "Float" if is_float else "Color"
        zero = 0.0 if is_float else [0.0] * 3
        a, b = self.get(node, "bg", zero), self.get(node, "fg", zero)
        params = {"data_type": "FLOAT" if is_float else "RGBA", "Factor_Float": self.get(node, "mix", 0.0), "clamp_factor": False,
                  "A_" + suffix: a if is_float else self.rgba(a), "B_" + suffix: b if is_float else self.rgba(b)}
        return {"node": self.add(node.getName(), "ShaderNodeMix", params), "output": "Result_" + suffix}

    def on_clamp(self, node):
        if node.getType() != "float":
            return self.report("node clamp (%s)" % node.getType(), "%s/%s" % (self.place, node.getName()))
        return {"node": self.add(node.getName(), "ShaderNodeClamp", {"Value": self.get(node, "in", 0.0), "Min": self.get(node, "low", 0.0), "Max": self.get(node, "high", 1.0)}),
                "output": "Result"}

    def on_remap(self, node):
        if node.getType() != "float":
            return self.report("node remap (%s)" % node.getType(), "%s/%s" % (self.place, node.getName()))
        params = {"clamp": False, "Value": self.get(node, "in", 0.0), "From Min": self.get(node, "inlow", 0.0), "From Max": self.get(node, "inhigh", 1.0),
                  "To Min": self.get(node, "outlow", 0.0), "To Max": self.get(node, "outhigh", 1.0)}
        return {"node": self.add(node.getName(), "ShaderNodeMapRange", params), "output": "Result"}

    def on_invert(self, node):
        if node.getType() == "float":
            return {"node": self.add(node.getName(), "ShaderNodeMath", {"operation": "SUBTRACT", "Value": self.get(node, "amount", 1.0), "Value_001": self.get(node, "in", 0.0)}), "output": "Value"}
        a, b = (v if isinstance(v, (list, dict)) else [v] * 3 for v in (self.get(node, "amount", [1.0] * 3), self.get(node, "in", [0.0] * 3)))
        return {"node": self.add(node.getName(), "ShaderNodeVectorMath", {"operation": "SUBTRACT", "Vector": a, "Vector_001": b}), "output": "Vector"}

    def on_extract(self, node):
        link, index = self.get(node, "in", [0.0] * 3), int(self.get(node, "index", 0.0))
        if index > 2:
            return self.report("fourth channel of extract", "%s/%s" % (self.place, node.getName()))
        return {**link, "component": COMPONENTS[index]} if isinstance(link, dict) else float(link[index])

    def on_combine3(self, node):
        params = {axis: self.get(node, "in%d" % (k + 1), 0.0) for k, axis in enumerate("XYZ")}
        return {"node": self.add(node.getName(), "ShaderNodeCombineXYZ", params), "output": "Vector"}

    def on_normalmap(self, node):
        link = self.get(node, "in", [0.5, 0.5, 1.0])
        return {"node": self.add(node.getName(), "ShaderNodeNormalMap", {"Color": self.rgba(link), "Strength": self.get(node, "scale", 1.0)}), "output": "Normal"}


def scene_of(name, graphs, report):
    """Spheres in a row, one for each material, in a plain white world."""
    buffers = Buffers()
    n = len(graphs)
    document = {"alder_scene": 1, "name": name, "settings": {"resolution": [min(256 * n, 4096), 256], "samples": 64},
                "cameras": {"camera": {"look_at": {"from": [0, -20, 0], "to": [0, 0, 0]}, "type": "orthographic", "ortho_scale": 2.4 * n}}, "materials": graphs,
                "meshes": {"sphere": sphere([0, 0, 0], 1.0, buffers)},
                "instances": {m: {"mesh": "sphere", "material": m, "transform": [1, 0, 0, 2.4 * (k - (n - 1) / 2), 0, 1, 0, 0, 0, 0, 1, 0]} for k, m in enumerate(graphs)},
                "lights": {}, "world": {"graph": {"version": 1, "nodes": {"sky": {"type": "ShaderNodeBackground", "params": {"Color": [1, 1, 1, 1], "Strength": 1.0}}},
                                                  "outputs": {"surface": {"node": "sky", "output": "Background"}}}}, "report": report.document()}
    return document, buffers


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="the .mtlx file")
    parser.add_argument("-o", "--output", help="OUT.alder, or OUT.json for one material's graph; default: the file's name with .alder")
    parser.add_argument("--material", help="only this one")
    parser.add_argument("--quiet", action="store_true", help="errors only; the report is in the scene all the same")
    args = parser.parse_args(argv)
    output = args.output or os.path.splitext(args.file)[0] + ".alder"
    report = Report()
    try:
        converter = Converter(args.file, report)
        graphs = converter.materials()
        if args.material:
            if args.material not in graphs:
                raise MaterialXError("no material %s: there are %s" % (args.material, ", ".join(graphs)))
            graphs = {args.material: graphs[args.material]}
        if output.endswith(".json"):
            if len(graphs) != 1:
                raise MaterialXError("there are several materials, choose one with --material: %s" % ", ".join(graphs))
            with open(output, "w") as f:
                json.dump(next(iter(graphs.values())), f, indent=1)
        else:
            document, buffers = scene_of(os.path.splitext(os.path.basename(args.file))[0], graphs, report)
            write_container(output, document, converter.files, buffers)
    except (MaterialXError, OSError) as error:
        print("materialx_scene: %s" % error, file=sys.stderr)
        return 2
    if not args.quiet:
        for line in report.lines():
            print(line, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
