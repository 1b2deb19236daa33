#!/usr/bin/env python3
"""Converts the XML of Cycles' stand-alone program to a scene in an .alder container.

    python3 clients/cycles_xml/cycles_scene.py scene.xml --alder build/alder -o scene.alder

Read are camera, film size, integrator, background, shaders, meshes, lights, transforms, states and includes. The program named by
--alder tells which nodes and sockets there are. What is not understood is told, one line each, and stands in the scene's report.
Exit status: 0 converted, 2 not. Only the standard library is used; `alder render X.xml` runs this.
"""
import argparse
import json
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree

for folder in ("ass", "scene_files"):
    sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", folder))
from ass_mesh import Buffers  # noqa: E402
from report import Report, write_container  # noqa: E402

IDENTITY = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
FILES = {"image_texture", "environment_texture", "ies_light"}
VISIBILITY_BOUNCES = {"max_bounce": "max_bounces", "max_diffuse_bounce": "diffuse_bounces", "max_glossy_bounce": "glossy_bounces",
                      "max_transmission_bounce": "transmission_bounces", "transparent_max_bounce": "transparent_bounces"}


class XmlError(Exception):
    """The file cannot be converted; the message says where."""


def plain(name):
    """Cycles compares names without regard to case; its sockets and their labels differ in spaces and underscores."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def numbers(text, what):
    try:
        out = [float(w) for w in text.replace(",", " ").split()]
    except ValueError:
        raise XmlError("%s: found '%s', expected numbers" % (what, text[:40])) from None
    if not all(math.isfinite(x) for x in out):
        raise XmlError("%s: numbers that are not finite" % what)
    return out


def product(a, b):
    return tuple(sum(a[r * 4 + k] * b[k * 4 + c] for k in range(4)) for r in range(4) for c in range(4))


def rotation(degrees, x, y, z):
    length = math.sqrt(x * x + y * y + z * z) or 1.0
    x, y, z = x / length, y / length, z / length
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    t = 1 - c
    return (x * x * t + c, x * y * t - z * s, x * z * t + y * s, 0, y * x * t + z * s, y * y * t + c, y * z * t - x * s, 0,
            z * x * t - y * s, z * y * t + x * s, z * z * t + c, 0, 0, 0, 0, 1)


class State:
    def __init__(self, transform=IDENTITY, shader=None, smooth=False, folder="."):
        self.transform, self.shader, self.smooth, self.folder = transform, shader, smooth, folder

    def copy(self):
        return State(self.transform, self.shader, self.smooth, self.folder)


class Catalogue:
    def __init__(self, items):
        self.types = {}
        for item in items:
            if item["system"] == "cycles":
                for name in [item["name"], *item.get("aliases", [])]:
                    self.types.setdefault(name, item)

    def node(self, name):
        return self.types.get("background_shader" if name == "background" else name) or self.types.get(name)

    @staticmethod
    def find(entries, name):
        for e in entries:
            if plain(name) in {plain(n) for n in [e["name"], *e.get("aliases", [])]}:
                return e
        return None


class Converter:
    def __init__(self, path, catalogue, report):
        self.path, self.catalogue, self.report = path, catalogue, report
        self.buffers, self.files = Buffers(), {}
        self.document = {"alder_scene": 1, "name": os.path.splitext(os.path.basename(path))[0], "settings": {"resolution": [1024, 512]}, "cameras": {}, "materials": {},
                         "meshes": {}, "instances": {}, "lights": {}}
        self.camera = {"fov": math.pi / 4, "type": "perspective", "transform": IDENTITY}
        self.depth = 0

    def convert(self):
        self.file(self.path, State(folder=os.path.dirname(self.path)))
        self.finish_camera()
        if not self.document["instances"] and "world" not in self.document:
            raise XmlError("%s: there is nothing to see: no mesh and no background" % self.path)
        self.document["report"] = self.report.document()

    def file(self, path, state):
        self.depth += 1
        if self.depth > 32:
            raise XmlError("%s: includes nest deeper than 32" % path)
        try:
            root = xml.etree.ElementTree.parse(path).getroot()
        except (OSError, xml.etree.ElementTree.ParseError) as e:
            raise XmlError("%s: %s" % (path, e)) from None
        if root.tag != "cycles":
            raise XmlError("%s: found <%s>, expected <cycles>" % (path, root.tag))
        self.elements(root, state)
        self.depth -= 1

    def elements(self, parent, state):
        for e in parent:
            handler = getattr(self, "on_" + e.tag, None)
            if handler is None:
                self.report("element <%s>" % e.tag, e.get("name"))
            else:
                handler(e, state)

    # ---- structure ----

    def on_include(self, e, state):
        inner = state.copy()
        path = os.path.join(state.folder, e.get("src", ""))
        if not os.path.isfile(path):
            return self.report("include %s is not there" % e.get("src"))
        inner.folder = os.path.dirname(path)
        self.file(path, inner)

    def on_transform(self, e, state):
        inner = state.copy()
        what = "<transform>"
        if e.get("matrix"):
            m = numbers(e.get("matrix"), what)
            if len(m) != 16:
                raise XmlError("%s: the matrix has %d numbers" % (what, len(m)))
            inner.transform = product(inner.transform, [m[c * 4 + r] for r in range(4) for c in range(4)])   # as written: columns
        if e.get("translate"):
            x, y, z = numbers(e.get("translate"), what)
            inner.transform = product(inner.transform, (1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1))
        if e.get("rotate"):
            inner.transform = product(inner.transform, rotation(*numbers(e.get("rotate"), what)))
        if e.get("scale"):
            x, y, z = numbers(e.get("scale"), what)
            inner.transform = product(inner.transform, (x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1))
        self.elements(e, inner)

    def on_state(self, e, state):
        inner = state.copy()
        if e.get("shader"):
            inner.shader = e.get("shader")
            if inner.shader not in self.document["materials"]:
                self.report("shader that is not there", inner.shader)
        inner.smooth = e.get("interpolation", "smooth" if inner.smooth else "flat") == "smooth"
        for name in set(e.keys()) - {"shader", "interpolation"}:
            self.report("state %s" % name)
        self.elements(e, inner)

    def on_integrator(self, e, state):
        for name, value in e.items():
            if name in VISIBILITY_BOUNCES:
                self.document["settings"][VISIBILITY_BOUNCES[name]] = int(value)
            elif name == "seed":
                self.document["settings"]["seed"] = int(value)
            else:
                self.report("integrator setting %s" % name)

    def on_film(self, e, state):
        for name in e.keys():
            self.report("film setting %s" % name)

    # ---- camera ----

    def on_camera(self, e, state):
        c, s = self.camera, self.document["settings"]
        if e.get("width") and e.get("height"):
            s["resolution"] = [int(e.get("width")), int(e.get("height"))]
        for name, value in e.items():
            if name == "fov":
                c["fov"] = float(value)
            elif name in ("type", "camera_type"):
                c["type"] = value
            elif name in ("nearclip", "farclip", "aperturesize", "focaldistance"):
                c[name] = float(value)
            elif name not in ("width", "height", "name"):
                self.report("camera setting %s" % name)
        c["transform"] = state.transform

    def finish_camera(self):
        c, (w, h) = self.camera, self.document["settings"]["resolution"]
        m = list(c["transform"])
        for row in range(3):   # Cycles looks along +Z, Alder along -Z
            m[row * 4 + 2] = -m[row * 4 + 2]
        out = {"transform": m}
        if c["type"] == "orthographic":
            out.update(type="orthographic", ortho_scale=2 * max(w, h) / min(w, h))
        else:
            if c["type"] != "perspective":
                self.report("camera type %s (perspective stands in)" % c["type"])
            # Cycles' angle is that of the smaller side.
            out["fov_degrees"] = math.degrees(2 * math.atan(math.tan(c["fov"] / 2) * max(w, h) / min(w, h)))
        for name, ours in (("nearclip", "near_clip"), ("farclip", "far_clip"), ("aperturesize", "aperture_radius"), ("focaldistance", "focus_distance")):
            if name in c:
                out[ours] = c[name]
        self.document["cameras"]["camera"], self.document["camera"] = out, "camera"

    # ---- shaders ----

    def graph(self, e, where, state):
        graph, kinds = {"version": 1, "nodes": {}, "outputs": {}}, {}
        for n in e:
            if n.tag == "connect":
                continue
            name, item = n.get("name") or n.tag, self.catalogue.node(n.tag)
            if item is None:
                self.report("node %s" % n.tag, where)
                continue
            kinds[name] = item
            graph["nodes"][name] = {"type": item["name"], "params": self.params(n, item, where, state)}
        for n in e.findall("connect"):
            source, target = n.get("from", "").split(), n.get("to", "").split()
            if len(source) != 2 or len(target) != 2:
                raise XmlError("%s: <connect from=\"%s\" to=\"%s\">: expected NODE SOCKET" % (where, n.get("from"), n.get("to")))
            if source[0] not in kinds or (target[0] not in kinds and target[0] != "output"):
                self.report("link from %s to %s" % (n.get("from"), n.get("to")), where)
                continue
            output = Catalogue.find(kinds[source[0]]["outputs"], source[1])
            if output is None:
                self.report("output %s of %s" % (source[1], kinds[source[0]]["name"]), where)
                continue
            link = {"node": source[0], "output": output["name"]}
            if target[0] == "output":
                if plain(target[1]) in ("surface", "volume", "displacement"):
                    graph["outputs"][plain(target[1])] = link
                continue
            param = Catalogue.find(kinds[target[0]]["params"], target[1])
            if param is None:
                self.report("socket %s of %s" % (target[1], kinds[target[0]]["name"]), where)
                continue
            graph["nodes"][target[0]]["params"][param["name"]] = link
        for name in ("volume", "displacement"):
            if graph["outputs"].pop(name, None) is not None:
                self.report("%s of a shader" % name, where)
        return graph

    def params(self, n, item, where, state):
        out = {}
        for name, text in n.items():
            if name == "name":
                continue
            if name == "filename" and n.tag in FILES:
                image = self.image(text, state)
                if image is not None:
                    image["colorspace"] = {"__builtin_raw": "Non-Color", "raw": "Non-Color", "non-color": "Non-Color"}.get(n.get("colorspace", "").lower(), "sRGB" if n.tag == "image_texture" else "Linear Rec.709")
                    out["image"] = image
                continue
            if name == "colorspace" and n.tag in FILES:
                continue
            param = Catalogue.find(item["params"], name)
            if param is None:
                self.report("parameter %s of %s" % (name, item["name"]), where)
                continue
            out[param["name"]] = self.value(param, text, "%s, %s %s" % (where, item["name"], name))
        return out

    def value(self, param, text, what):
        kind = param["type"]
        if kind == "enum":
            for choice in param["enum"]:
                if plain(text) in (plain(choice["name"]), plain(choice.get("cycles", ""))):
                    return choice["name"]
            raise XmlError("%s: found '%s', expected one of %s" % (what, text, ", ".join(c.get("cycles", c["name"]) for c in param["enum"])))
        if kind == "bool":
            return text.lower() in ("true", "1", "on")
        if kind == "string":
            return text
        values = numbers(text, what)
        if kind in ("color", "vector", "point", "normal"):
            if len(values) not in (3, 4):
                raise XmlError("%s: found %d numbers, expected 3" % (what, len(values)))
            return values[:3] if kind != "color" else [*values[:3], 1.0]
        if len(values) != 1:
            raise XmlError("%s: found %d numbers, expected one" % (what, len(values)))
        return int(values[0]) if kind == "int" else values[0]

    def image(self, name, state):
        path = os.path.join(state.folder, name)
        if not os.path.isfile(path):
            self.report("image file that is not there", name)
            return None
        member = "images/" + os.path.basename(path)
        with open(path, "rb") as f:
            self.files[member] = f.read()
        return {"file": member}

    def on_shader(self, e, state):
        name = e.get("name")
        if not name:
            raise XmlError("%s: a shader without name" % self.path)
        self.document["materials"][name] = self.graph(e, "shader " + name, state)

    def on_background(self, e, state):
        self.document["world"] = {"graph": self.graph(e, "background", state)}

    # ---- things ----

    def free(self, table, name):
        n, free = 1, name
        while free in table:
            n += 1
            free = "%s.%d" % (name, n)
        return free

    def on_mesh(self, e, state):
        name = self.free(self.document["meshes"], e.get("name") or "mesh")
        what = "mesh " + name
        points, verts, sides = numbers(e.get("P", ""), what), [int(v) for v in numbers(e.get("verts", ""), what)], [int(v) for v in numbers(e.get("nverts", ""), what)]
        if sum(sides) > len(verts) or any(not 0 <= v < len(points) // 3 for v in verts):
            raise XmlError("%s: verts and nverts do not fit its %d points" % (what, len(points) // 3))
        corners, at = [], 0
        for n in sides:
            for k in range(1, n - 1):
                corners += [at, at + k, at + k + 1]
            at += n
        if not corners:
            return self.report("mesh without faces", name)
        mesh = {"positions": self.buffers.array(points, 3), "triangles": self.buffers.array([verts[c] for c in corners], 3, "u32"), "smooth": state.smooth}
        uv = numbers(e.get("UV", ""), what)
        if uv:
            if len(uv) < 2 * at:
                raise XmlError("%s: UV has %d of %d numbers" % (what, len(uv), 2 * at))
            mesh["uv"] = self.buffers.array([uv[c * 2 + k] for c in corners for k in (0, 1)], 2)
        normals = numbers(e.get("N", ""), what)
        if normals and len(normals) == len(points):
            mesh["normals"] = self.buffers.array(normals, 3)
        if e.get("subdivision", "none") != "none":
            self.report("subdivision of a mesh (its cage is shown)", name)
        for other in set(e.keys()) - {"name", "P", "verts", "nverts", "UV", "N", "subdivision", "dicing_rate"}:
            self.report("mesh attribute %s" % other, name)
        self.document["meshes"][name] = mesh
        member = {"mesh": name, "transform": list(state.transform)}
        if state.shader in self.document["materials"]:
            member["material"] = state.shader
        self.document["instances"][self.free(self.document["instances"], name)] = member

    def on_light(self, e, state):
        kind = {"point": "point", "distant": "sun", "sun": "sun", "spot": "spot", "area": "area"}.get(e.get("light_type", e.get("type", "point")))
        if kind is None:
            return self.report("light of type %s" % e.get("light_type", e.get("type")), e.get("name"))
        strength = numbers(e.get("strength", "1 1 1"), "<light>")
        strength = strength * 3 if len(strength) == 1 else strength
        # What Blender divides by when it hands a lamp's watts to Cycles.
        factor = {"point": 4 * math.pi, "spot": 4 * math.pi, "area": 4.0, "sun": 1.0}[kind]
        largest = max(max(strength), 1e-20)
        m = list(state.transform)
        for row in range(3):   # Cycles' lights shine along +Z of their transform, Alder's along -Z
            m[row * 4], m[row * 4 + 2] = -m[row * 4], -m[row * 4 + 2]
        out = {"type": kind, "color": [s / largest for s in strength], "strength": largest * factor, "transform": m}
        for name, value in e.items():
            if name == "size" and kind in ("point", "spot"):
                out["radius"] = float(value)
            elif name in ("sizeu", "sizev") and kind == "area":
                out.setdefault("size", [1, 1])["uv".index(name[-1])] = float(value)
            elif name == "angle" and kind == "sun":
                out["angle_degrees"] = math.degrees(float(value))
            elif name == "spot_angle" and kind == "spot":
                out["spot_angle_degrees"] = math.degrees(float(value))
            elif name == "spot_smooth" and kind == "spot":
                out["spot_blend"] = float(value)
            elif name == "cast_shadow":
                out["cast_shadow"] = value.lower() in ("true", "1")
            elif name not in ("light_type", "type", "strength", "name", "use_mis"):
                self.report("light setting %s" % name, e.get("name"))
        if state.shader in self.document["materials"]:
            out["graph"] = self.document["materials"][state.shader]
        self.document["lights"][self.free(self.document["lights"], e.get("name") or "light")] = out

    def write(self, path):
        write_container(path, self.document, self.files, self.buffers)


def catalogue(program):
    run = subprocess.run([program, "nodes", "--json"], capture_output=True, text=True)
    if run.returncode != 0:
        raise XmlError("%s nodes --json: %s" % (program, run.stderr.strip()))
    return Catalogue(json.loads(run.stdout)["items"])


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="the .xml file")
    parser.add_argument("-o", "--output", help="OUT.alder; default: the file's name")
    parser.add_argument("--alder", default="alder", help="the program alder; default: found on PATH")
    parser.add_argument("--quiet", action="store_true", help="errors only; the report is in the scene all the same")
    args = parser.parse_args(argv)
    report = Report()
    try:
        scene = Converter(args.file, catalogue(args.alder), report)
        scene.convert()
        scene.write(args.output or os.path.splitext(args.file)[0] + ".alder")
    except (XmlError, OSError, ValueError) as error:
        print("cycles_scene: %s" % error, file=sys.stderr)
        return 2
    if not args.quiet:
        for line in report.lines():
            print(line, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
