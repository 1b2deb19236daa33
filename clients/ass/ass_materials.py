#!/usr/bin/env python3
"""Converts the material of an Arnold .ass file to an Alder graph document.

    python3 clients/ass/ass_materials.py test_als_goldleaf.ass > goldleaf.json
    python3 clients/ass/ass_materials.py scene.ass --root aiStandard1SG > walls.json

The root is the MayaShadingEngine called TARGET_SHADER, else the only one of the file; --root names another. alShaders' nodes keep
their names and parameters. Arnold's `standard` becomes alSurface, and mayaBump2D a ShaderNodeBump that is linked to the normals of
the surface below it. What is left out or only near is told on stderr, one line each; a node that cannot be converted is an error.
Exit status: 0 converted, 2 not. Only the standard library is used.
"""
import argparse
import json
import sys

from arnold_standard import NEUTRAL, SILENT, Standard
from ass_file import AssError, read

# Parameters of older versions of alShaders: the value with which today's node computes the same, or the name of the parameter that
# switches them.
OLDER = {
    "alSurface": {"ssStrength": 0.0, "ssBalance": "ssStrength", "ssTargetColor": "ssStrength", "ssInScattering": "ssStrength",
                  "diffuseEnableCaustics": False, "lightGroupsIndirect": False},
    "alFractal": {"ridged": False, "ridgeOffset": "ridged"},
    "alCellNoise": {"f1w": -1.0, "f2w": 1.0, "f3w": 0.0, "f4w": 0.0, "mynkowskiShape": 2.0},
}
NORMALS = ("diffuseNormal", "specular1Normal", "specular2Normal", "transmissionNormal")
TEXTS = {"name", "userName", "filename", "traceSet", "combineOp"}
# What of a shading engine and a bump node has no bearing on the material, with the value for which that holds.
ENGINE = {"beauty": None, "enable_matte": False, "matte_color": None, "mtoa_aovs": None, "mtoa_shading_groups": None}
BUMP = {"bump_map": None, "bump_height": None, "shader": None, "use_as": "bump", "swap_tangents": False, "gamma_correct": None,
        "use_derivatives": None, "flip_r": None, "flip_g": None}


MAYA_FILE = {"coverage": [1, 1], "translateFrame": [0, 0], "rotateFrame": 0, "mirrorU": None, "mirrorV": None, "wrapU": None, "wrapV": None, "stagger": False,
             "repeatUV": None, "offsetUV": None, "rotateUV": 0, "filename": None, "noiseUV": [0, 0], "mipBias": None, "filter": None, "useDefaultColor": None,
             "defaultColor": None, "colorGain": None, "colorOffset": None, "alphaGain": None, "alphaOffset": None, "alphaIsLuminance": None, "invert": False,
             "uvCoord": None}


class Failure(Exception):
    pass


class Converter:
    def __init__(self, nodes, path, stderr=sys.stderr, image=None):
        """image(name) gives the image value for a file name of the .ass, or None where there is none; left out: the name itself."""
        self.nodes, self.path, self.stderr = nodes, path, stderr
        self.image = image or (lambda name: {"file": name, "colorspace": "Non-Color"})
        self.graph = {}
        self.made = {}       # (node, bump) -> name in the graph
        self.visiting = []
        self.told = set()

    # ---- telling the user ----

    def warn(self, node, param, text):
        value = node.params.get(param)
        line = "%s:%d: %s %s: %s: %s" % (self.path, value.line if value else node.line, node.kind, node.name, param, text)
        if line not in self.told:
            self.told.add(line)
            print(line, file=self.stderr)

    def fail(self, node, text):
        raise Failure("%s:%d: %s %s: %s" % (self.path, node.line, node.kind, node.name, text))

    # ---- values ----

    def link(self, word):
        """(node name, component) if the word names a node of the file, with or without a channel; else None."""
        if word in self.nodes:
            return str(word), None
        base, dot, channel = word.rpartition(".")
        return (base, channel) if dot and base in self.nodes and channel in ("r", "g", "b", "a", "x", "y", "z") else None

    def constant(self, node, param):
        """A parameter's constant as JSON would have it."""
        words = node.params[param].words
        numbers = node.params[param].numbers()
        if numbers is not None:
            return numbers[0] if len(numbers) == 1 else numbers
        if len(words) == 1 and not words[0].quoted and words[0] in ("on", "off", "true", "false"):
            return words[0] in ("on", "true")
        if len(words) == 1 and words[0].quoted:
            return str(words[0])
        self.fail(node, "%s: cannot read %s" % (param, " ".join(words) or "an empty value"))

    def value(self, node, param, bump):
        """A parameter as a graph document has it: a constant or a link."""
        words = node.params[param].words
        link = self.link(words[0]) if len(words) == 1 and param not in TEXTS and not param.startswith("aov_") else None
        if not link:
            return self.constant(node, param)
        result = {"node": self.convert(link[0], bump)}
        if link[1]:
            result["component"] = link[1]
        return result

    # ---- nodes ----

    def root(self, name=None):
        engines = [n for n in self.nodes.values() if n.kind == "MayaShadingEngine"]
        if name is None:
            name = "TARGET_SHADER" if "TARGET_SHADER" in self.nodes else engines[0].name if len(engines) == 1 else None
        if name is None:
            raise Failure("%s: %d shading engines (%s); name one with --root"
                          % (self.path, len(engines), ", ".join(e.name for e in engines) or "none"))
        if name not in self.nodes:
            raise Failure("%s: no node called %s" % (self.path, name))
        node = self.nodes[name]
        if node.kind == "MayaShadingEngine":
            self.only_neutral(node, ENGINE)
            link = self.link(node.params["beauty"].words[0]) if node.params.get("beauty") else None
            if not link or link[1]:
                self.fail(node, "beauty is not linked to a surface")
            name = link[0]
        surface = self.convert(name, None)
        for include in self.nodes.includes:
            print("%s: include %s: not read, only the materials of the file itself" % (self.path, include), file=self.stderr)
        return {"version": 1, "nodes": self.graph, "outputs": {"surface": {"node": surface}}}

    def only_neutral(self, node, known):
        """Tells of parameters that are unknown, or known but not at the value without effect."""
        for param in node.params:
            if param not in known:
                self.warn(node, param, "unknown, left out")
            elif known[param] is not None and self.constant(node, param) != known[param]:
                self.warn(node, param, "%s has no counterpart, left out" % " ".join(node.params[param].words))

    def convert(self, name, bump):
        """Name in the graph of node `name` as seen below the bump node `bump`; surfaces differ by it, patterns do not."""
        node = self.nodes[name]
        is_surface = node.kind in ("alSurface", "alLayer", "standard", "mayaBump2D")
        key = (name, bump if is_surface else None)
        if key in self.made:
            return self.made[key]
        if key in self.visiting:
            self.fail(node, "is linked to itself")
        self.visiting.append(key)
        if node.kind == "mayaBump2D":
            made = self.bump(node, bump)
        else:
            made = name if name not in self.graph else "%s@%s" % (name, bump or "plain")
            while made in self.graph:
                made += "'"
            self.graph[made] = {}  # holds the place, so that a surface comes before what feeds it
            if node.kind == "standard":
                self.graph[made] = {"type": "alSurface", "params": self.normals(self.standard(node, bump), bump)}
            elif node.kind == "MayaFile":
                self.maya_file(node, made)
            elif node.kind.startswith("al"):
                self.graph[made] = {"type": node.kind, "params": self.al_params(node, bump if is_surface else None)}
            else:
                self.fail(node, "this node type has no counterpart in Alder")
        self.visiting.pop()
        self.made[key] = made
        return made

    def al_params(self, node, bump):
        params, older = {}, OLDER.get(node.kind, {})
        for param in node.params:
            if param in older:
                switch = older[param] if isinstance(older[param], str) else param
                same = switch in node.params and self.constant_or_link(node, switch) == older[switch]
                self.warn(node, param, "of an older version: left out, %s"
                          % ("today's node computes the same" if same else "today's node has no counterpart, so the look may differ"))
            else:
                params[param] = self.value(node, param, bump)
        for name, kind in node.declared.items():
            self.warn(node, name, "user data (%s), left out" % kind)
            params.pop(name, None)
        if node.kind in ("alInputVector", "alInputScalar") and params.get("input") in ("N", "Nf", "facing-ratio"):
            self.warn(node, "input", "%s is that of the surface without bump" % params["input"])
        return self.normals(params, bump) if node.kind == "alSurface" else params

    def maya_file(self, node, made):
        """A Maya file texture: repeated, offset and mirrored in uv, then times a gain plus an offset. The result is called `made`."""
        self.only_neutral(node, MAYA_FILE)

        def get(param, default):
            return self.constant(node, param) if param in node.params else default

        color, picture = made + "/color", made + "/picture"
        image = self.image(get("filename", ""))
        if image is None:
            self.graph[color] = {"type": "alCombineColor", "params": {"input1": get("defaultColor", [0.5, 0.5, 0.5]), "input2": [1, 1, 1], "combineOp": "multiply 1*2"}}
            source = {"node": color}
        else:
            repeat, offset = get("repeatUV", [1, 1]), get("offsetUV", [0, 0])
            mirrors, wraps = [get("mirror" + a, False) for a in "UV"], [get("wrap" + a, True) for a in "UV"]
            if not all(wraps):
                self.warn(node, "wrapU", "off: the picture ends at its edges, and is black beyond")
            extension = "CLIP" if not all(wraps) else "MIRROR" if all(mirrors) else "REPEAT"
            place = {"node": made + "/placement"}
            self.graph[made + "/uv"] = {"type": "ShaderNodeTexCoord", "params": {}}
            self.graph[made + "/placement"] = {"type": "ShaderNodeMapping", "params": {
                "Vector": {"node": made + "/uv", "output": "UV"}, "Scale": [*repeat, 1], "Location": [*offset, 0]}}
            if mirrors[0] != mirrors[1]:   # along one axis only: that coordinate goes to and fro
                axis = "xy"[mirrors.index(True)]
                self.graph[made + "/mirror"] = {"type": "ShaderNodeMath", "params": {"operation": "PINGPONG", "Value": {**place, "component": axis}, "Value_001": 1.0}}
                self.graph[made + "/mirrored"] = {"type": "ShaderNodeCombineXYZ", "params": {
                    a.upper(): {"node": made + "/mirror"} if a == axis else {**place, "component": a} for a in "xyz"}}
                place = {"node": made + "/mirrored"}
            self.graph[picture] = {"type": "ShaderNodeTexImage", "params": {"image": image, "extension": extension, "Vector": place}}
            source = {"node": picture, "output": "Color"}
        gained = made + "/gained"
        self.graph[gained] = {"type": "alCombineColor", "params": {"input1": source, "input2": self.value(node, "colorGain", None) if "colorGain" in node.params else [1, 1, 1],
                                                                   "combineOp": "multiply 1*2"}}
        self.graph[made] = {"type": "alCombineColor", "params": {"input1": {"node": gained}, "combineOp": "add 1+2",
                                                                 "input2": self.value(node, "colorOffset", None) if "colorOffset" in node.params else [0, 0, 0]}}

    def constant_or_link(self, node, param):
        words = node.params[param].words
        return None if len(words) == 1 and self.link(words[0]) else self.constant(node, param)

    def normals(self, params, bump):
        """Below a bump node every lobe that has no normal of its own takes the bumped one."""
        if bump:
            for name in NORMALS:
                if not isinstance(params.get(name), dict):
                    params[name] = {"node": bump, "output": "Normal"}
        return params

    def standard(self, node, bump):
        used = set()

        def get(param, default):
            used.add(param)
            return self.value(node, param, bump) if param in node.params else default

        standard = Standard(get, lambda param, text: self.warn(node, param, text))
        params = standard.convert()
        for param in node.params:
            if param in used or param in SILENT or param in NEUTRAL or param.startswith("aov_") or standard.without_effect(param):
                continue
            self.warn(node, param, "unknown, left out")
        return params

    def bump(self, node, outer):
        """mayaBump2D wraps a surface: height in scene units along the normal. Returns the surface's name in the graph."""
        self.only_neutral(node, BUMP)
        link = self.link(node.params["shader"].words[0]) if node.params.get("shader") and node.params["shader"].words else None
        if not link:
            self.fail(node, "shader is not linked to a surface")
        made = node.name
        while made in self.graph:
            made += "'"
        self.graph[made] = {}
        height = self.value(node, "bump_map", None) if "bump_map" in node.params else 0.0
        distance = self.value(node, "bump_height", None) if "bump_height" in node.params else 1.0
        params = {"Strength": 1.0, "Distance": distance, "Height": height}
        if outer:
            params["Normal"] = {"node": outer, "output": "Normal"}
        self.graph[made] = {"type": "ShaderNodeBump", "params": params}
        if not isinstance(height, dict):
            self.warn(node, "bump_map", "not linked: there is no bump")
        return self.convert(link[0], made)


def main(argv=None, stdout=sys.stdout, stderr=sys.stderr):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="the .ass file, plain or gzip")
    parser.add_argument("--root", help="node whose surface is converted")
    args = parser.parse_args(argv)
    try:
        document = Converter(read(args.file), args.file, stderr).root(args.root)
    except (AssError, Failure, OSError) as error:
        print("ass_materials: %s" % error, file=stderr)
        return 2
    json.dump(document, stdout, indent=1)
    stdout.write("\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
