#!/usr/bin/env python3
"""Converts Arnold .ass files to a scene in an .alder container: cameras, lights, meshes, materials, options.

    python3 clients/ass/ass_scene.py shot.ass -o shot.alder
    python3 clients/ass/ass_scene.py test_als_glass.ass --base test_header.ass -o glass.alder

A file of materials alone is shown on a sphere: in the scene of --base, or of a test_header.ass beside it, at the point that the
camera looks at, else in a plain white world. What is not understood is told, one line each, and stands in the scene's report.
Exit status: 0 converted, 2 not. Only the standard library is used; `alder render X.ass` runs this.
"""
import argparse
import io
import math
import os
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scene_files"))
from ass_file import AssError, array, read, read_all  # noqa: E402
from ass_materials import Converter, Failure  # noqa: E402
from ass_mesh import Buffers, convert_mesh, sphere  # noqa: E402
from report import Report, write_container  # noqa: E402

# Node types that say nothing about the picture's content.
SILENT = {"driver_exr", "driver_jpeg", "driver_png", "driver_tiff", "driver_deepexr", "gaussian_filter", "box_filter", "triangle_filter", "blackman_harris_filter",
          "catrom_filter", "mitnet_filter", "closest_filter", "heatmap_filter", "sinc_filter", "variance_filter", "contour_filter", "cook_filter", "disk_filter",
          "MayaShadingEngine", "override", "color_manager_syncolor", "color_manager_ocio"}
CAMERAS = {"persp_camera", "ortho_camera"}
LIGHTS = {"quad_light", "point_light", "spot_light", "distant_light", "disk_light", "skydome_light"}
OTHER_SHAPES = {"curves", "points", "procedural", "volume", "implicit", "nurbs", "cylinder", "cone", "disk", "plane", "box", "ginstance", "usd", "alembic"}
BITS = {"camera": 1, "shadow": 2, "glossy": 4 | 64, "transmission": 8 | 128, "diffuse": 16 | 32}


class SceneConverter:
    def __init__(self, path, report):
        self.path, self.report = path, report
        self.buffers = Buffers()
        self.files = {}
        self.nodes = {}
        self.document = {"alder_scene": 1, "name": os.path.splitext(os.path.basename(path))[0], "settings": {}, "cameras": {}, "materials": {}, "meshes": {},
                         "instances": {}, "lights": {}}
        self.made = {}

    # ---- values ----

    def get(self, node, name, default):
        value = node.params.get(name)
        if value is None or not value.words:
            return default
        numbers = value.numbers()
        if numbers is not None:
            return numbers[0] if len(numbers) == 1 else numbers
        if str(value.words[0]) in self.nodes and not isinstance(default, str):
            self.report("linked %s" % name, node.name)
            return default
        found = array(value)
        if found is not None:
            return found
        if len(value.words) == 1 and not value.words[0].quoted and value.words[0] in ("on", "off", "true", "false"):
            return value.words[0] in ("on", "true")
        return str(value.words[0])

    def matrix(self, node):
        """Rows that are the images of the axes, translation last: the transpose of a scene document's."""
        m = self.get(node, "matrix", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        value = node.params.get("matrix")
        if value is not None and getattr(value, "keys", 1) > 1:
            self.report("motion of the transformation (its first key counts)", node.name)
        if not isinstance(m, list) or len(m) < 16:
            raise AssError("%s: the matrix of %s has %d numbers" % (self.path, node.name, len(m) if isinstance(m, list) else 1))
        return m[:16]

    @staticmethod
    def transform(m):
        return [m[c * 4 + r] for r in range(3) for c in range(4)] + [0, 0, 0, 1]

    # ---- the whole ----

    def convert(self, nodes, target=None):
        self.nodes = nodes
        for node in nodes.values():
            if node.kind == "options":
                self.options(node)
            elif node.kind in CAMERAS:
                self.camera(node)
            elif node.kind in LIGHTS:
                self.light(node)
            elif node.kind == "polymesh":
                self.mesh(node)
            elif node.kind == "sphere":
                self.ball(node.name, self.get(node, "center", [0, 0, 0]), float(self.get(node, "radius", 0.5)), self.shaders(node), self.matrix(node))
            elif node.kind in OTHER_SHAPES or node.kind.endswith("_camera") or node.kind.endswith("_light"):
                self.report("%s nodes" % node.kind, node.name)
        cameras = self.document["cameras"]
        options = next((n for n in nodes.values() if n.kind == "options"), None)
        chosen = self.get(options, "camera", "") if options is not None else ""
        if cameras:
            self.document["camera"] = chosen if chosen in cameras else next(iter(cameras))
        if target is not None:
            self.stand_in(target)
        if not self.document["instances"]:
            raise AssError("%s: there is nothing to see: no mesh, no sphere and no material" % self.path)

    def options(self, node):
        s = self.document["settings"]
        s["resolution"] = [max(1, int(self.get(node, "xres", 320))), max(1, int(self.get(node, "yres", 240)))]
        s["samples"] = max(1, int(self.get(node, "AA_samples", 1)) ** 2)
        s["seed"] = int(self.get(node, "AA_seed", 0)) & 0xFFFFFFFF
        s["max_bounces"] = int(self.get(node, "GI_total_depth", 10))
        s["diffuse_bounces"] = int(self.get(node, "GI_diffuse_depth", 0))
        s["glossy_bounces"] = max(int(self.get(node, "GI_glossy_depth", 0)), int(self.get(node, "GI_reflection_depth", 2)))
        s["transmission_bounces"] = int(self.get(node, "GI_refraction_depth", 2))
        s["transparent_bounces"] = int(self.get(node, "auto_transparency_depth", 10))
        clamp = float(self.get(node, "AA_sample_clamp", 0))
        if 0 < clamp < 1e6:
            s["clamp_direct"] = s["clamp_indirect"] = clamp
        for name in ("background", "atmosphere"):
            if str(self.get(node, name, "")) in self.nodes:
                self.report("the %s shader of the options" % name, str(self.get(node, name, "")))

    def camera(self, node):
        out = {"transform": self.transform(self.matrix(node)), "near_clip": max(1e-6, float(self.get(node, "near_clip", 1e-4))), "far_clip": float(self.get(node, "far_clip", 1e30))}
        out["far_clip"] = min(out["far_clip"], 1e10)
        low, high = self.get(node, "screen_window_min", [-1, -1]), self.get(node, "screen_window_max", [1, 1])
        if node.kind == "ortho_camera":
            out.update(type="orthographic", ortho_scale=high[0] - low[0])
        else:
            fov = self.get(node, "fov", 60.0)
            out["fov_degrees"] = fov[0] if isinstance(fov, list) else fov
            if [low, high] != [[-1, -1], [1, 1]]:
                self.report("the screen window of a camera", node.name)
            aperture = float(self.get(node, "aperture_size", 0))
            if aperture > 0:
                out.update(aperture_radius=aperture, focus_distance=float(self.get(node, "focus_distance", 1)))
        if self.get(node, "exposure", 0) != 0:
            self.report("exposure of a camera", node.name)
        self.document["cameras"][node.name] = out

    # ---- lights ----

    def light(self, node):
        m = self.matrix(node)
        color = self.get(node, "color", [1, 1, 1])
        power = float(self.get(node, "intensity", 1)) * 2 ** float(self.get(node, "exposure", 0))
        if node.kind == "skydome_light":
            return self.skydome(node, color, power)
        normalize = self.get(node, "normalize", True) is not False
        if self.get(node, "decay_type", "quadratic") not in ("quadratic", "constant"):
            self.report("decay \"%s\" of a light (it decays with the square)" % self.get(node, "decay_type", ""), node.name)
        out = {"color": color}
        if node.kind == "quad_light":
            frame, size = self.quad(node, m)
            out.update(type="area", shape="rectangle", size=size, transform=frame)
        elif node.kind == "disk_light":
            scale = math.sqrt(sum(v * v for v in m[0:3]))
            diameter = 2 * float(self.get(node, "radius", 0.5)) * scale
            out.update(type="area", shape="ellipse", size=[diameter, diameter], transform=self.rigid(m))
        elif node.kind == "distant_light":
            out.update(type="sun", angle_degrees=float(self.get(node, "angle", 0)), transform=self.rigid(m), strength=power)
        else:
            out.update(type="point" if node.kind == "point_light" else "spot", radius=float(self.get(node, "radius", 0)), transform=self.rigid(m))
            # A candela for each of Arnold's units: the flux of a point light is 4 pi times that.
            out["strength"] = power * 4 * math.pi
            if node.kind == "spot_light":
                cone, blend = float(self.get(node, "cone_angle", 65)), float(self.get(node, "penumbra_angle", 0))
                out.update(spot_angle_degrees=min(cone, 179.9), spot_blend=min(1.0, blend / cone if cone > 0 else 0))
        if out["type"] == "area":
            # Normalised: intensity over area is the radiance, which is flux / (pi area).
            out["normalize"] = normalize
            out["strength"] = power * math.pi if normalize else power
        elif not normalize and node.kind != "distant_light":
            self.report("a light that is not normalised", node.name)
        if self.get(node, "cast_shadows", True) is False:
            out["cast_shadow"] = False
        group = self.get(node, "lightGroup", 0)
        if isinstance(group, float) and 1 <= group <= 8:
            out["light_group"] = int(group)
        hidden = {}
        for name, ray in (("diffuse", "diffuse"), ("specular", "glossy"), ("affect_diffuse", "diffuse"), ("affect_specular", "glossy")):
            value = self.get(node, name, 1)
            if value in (0, False):
                hidden[ray] = False
            elif isinstance(value, float) and value != 1:
                self.report("%s %g of a light (1 is used)" % (name, value), node.name)
        if hidden:
            out["visibility"] = hidden
        self.document["lights"][node.name] = out

    def rigid(self, m):
        """The matrix without its scale."""
        out = list(m)
        for row in range(3):
            length = math.sqrt(sum(v * v for v in m[row * 4:row * 4 + 3])) or 1.0
            for k in range(3):
                out[row * 4 + k] = m[row * 4 + k] / length
        return self.transform(out)

    def quad(self, node, m):
        """A frame whose -Z is the side that shines, and the lengths of the edges along its X and Y."""
        v = self.get(node, "vertices", [1, 1, 0, 1, -1, 0, -1, -1, 0, -1, 1, 0])
        if len(v) < 12:
            raise AssError("%s: the vertices of %s are not four points" % (self.path, node.name))
        points = [[sum(v[k * 3 + i] * m[i * 4 + c] for i in range(3)) + m[12 + c] for c in range(3)] for k in range(4)]
        x = [(points[0][c] + points[1][c] - points[2][c] - points[3][c]) / 2 for c in range(3)]
        y = [(points[0][c] + points[3][c] - points[1][c] - points[2][c]) / 2 for c in range(3)]
        lx, ly = (math.sqrt(sum(a * a for a in e)) for e in (x, y))
        if lx <= 0 or ly <= 0:
            raise AssError("%s: %s has no area" % (self.path, node.name))
        x, y = [a / lx for a in x], [a / ly for a in y]
        if abs(sum(a * b for a, b in zip(x, y))) > 1e-3:
            self.report("a quad light that is no rectangle (a rectangle of its edges stands in)", node.name)
        z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
        lz = math.sqrt(sum(a * a for a in z)) or 1.0
        z = [a / lz for a in z]
        if sum(a * b for a, b in zip(z, m[8:11])) < 0:   # light leaves along -Z of the light's own space
            x, z = [-a for a in x], [-a for a in z]
        y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
        center = [sum(p[c] for p in points) / 4 for c in range(3)]
        return [x[0], y[0], z[0], center[0], x[1], y[1], z[1], center[1], x[2], y[2], z[2], center[2], 0, 0, 0, 1], [lx, ly]

    def skydome(self, node, color, power):
        link = node.params.get("color")
        if link is not None and link.words and str(link.words[0]) in self.nodes:
            self.report("the linked colour of a skydome light (white is used)", node.name)
        if not isinstance(color, list):
            color = [1, 1, 1]
        if "world" in self.document:
            return self.report("a second skydome light", node.name)
        self.document["world"] = {"graph": _world(color, power)}
        group = self.get(node, "lightGroup", 0)
        if isinstance(group, float) and 1 <= group <= 8:
            self.document["world"]["light_group"] = int(group)

    # ---- geometry ----

    def mesh(self, node):
        mesh, materials = convert_mesh(node, self, self.buffers)
        if mesh is None:
            return
        self.document["meshes"][node.name] = mesh
        member = {"mesh": node.name, "transform": self.transform(self.matrix(node))}
        names = [self.material(s) for s in materials]
        if names:
            member["materials"] = names
        mask = int(self.get(node, "visibility", 255))
        hidden = {ray: False for ray, bits in BITS.items() if not mask & bits}
        if hidden:
            member["visibility"] = hidden
        if str(self.get(node, "disp_map", "")) in self.nodes:
            self.report("displacement", node.name)
        self.document["instances"][node.name] = member

    def ball(self, name, center, radius, shaders, m=None):
        self.document["meshes"][name] = sphere(center, radius, self.buffers)
        self.document["instances"][name] = {"mesh": name, "materials": [self.material(s) for s in shaders[:1]] or [self.material(None)]}
        if m is not None:
            self.document["instances"][name]["transform"] = self.transform(m)

    def shaders(self, node):
        value = node.params.get("shader")
        if value is None or not value.words:
            return []
        words = value.words
        if len(words) > 3 and words[0].isdigit() and words[1].isdigit():
            words = words[3:]
        return [str(w) for w in words]

    def stand_in(self, target):
        """The sphere that shows a material which no geometry of the file uses."""
        cameras = self.document["cameras"]
        if not cameras:
            self.document["settings"].setdefault("resolution", [512, 512])
            cameras["camera"] = {"look_at": {"from": [0, 3, 15], "to": [0, 0, 0], "up": [0, 1, 0]}, "fov_degrees": 40}
            self.document["world"] = {"graph": _world([1, 1, 1], 1.0)}
            center = [0.0, 0.0, 0.0]
        else:
            # The point on the camera's axis that is as high above the floor as the sphere is large.
            t = cameras[self.document["camera"]]["transform"]
            eye, back = [t[3], t[7], t[11]], [t[2], t[6], t[10]]
            distance = (eye[1] - 4) / back[1] if abs(back[1]) > 0.05 else 25.0
            center = [e - b * distance for e, b in zip(eye, back)] if distance > 5 else [0.0, 4.0, 0.0]
        self.report("no shape uses %s: a sphere of radius 4 shows it" % target, None, True)
        self.ball("stand-in", center, 4.0, [target])

    # ---- materials ----

    def material(self, shader):
        if shader in self.made:
            return self.made[shader]
        name = self.made[shader] = shader if shader is not None else "no shader"
        graph = None
        if shader is None or shader not in self.nodes:
            self.report("shader that is not there" if shader is not None else "shape without shader", shader)
        else:
            told = io.StringIO()
            try:
                graph = Converter(self.nodes, self.path, told, self.image).root(shader)
            except Failure as e:
                self.report("a material (grey stands in): %s" % e, shader)
            for line in told.getvalue().splitlines():
                self.report(line.split(": ", 1)[-1], None, True)
        self.document["materials"][name] = graph or {"version": 1, "nodes": {"grey": {"type": "alSurface", "params": {"diffuseColor": [0.5, 0.5, 0.5], "specular1Strength": 0}}},
                                                     "outputs": {"surface": {"node": "grey"}}}
        return name

    def image(self, name):
        """An image value for a file name of the .ass, or None where there is no such file."""
        folder = os.path.dirname(self.path)
        for path in (name, os.path.join(folder, name), os.path.join(folder, os.path.basename(name))):
            if os.path.isfile(path):
                member = "images/" + os.path.basename(path)
                with open(path, "rb") as f:
                    self.files[member] = f.read()
                return {"file": member, "colorspace": "Non-Color"}
        self.report("image file that is not there", name)
        return None

    def write(self, path):
        write_container(path, self.document, self.files, self.buffers)


def _world(color, power):
    return {"version": 1, "nodes": {"sky": {"type": "ShaderNodeBackground", "params": {"Color": [*color[:3], 1], "Strength": power}}},
            "outputs": {"surface": {"node": "sky", "output": "Background"}}}


def convert(path, base=None):
    """(SceneConverter, Report) of a file."""
    report = Report()
    nodes = read_all(path, lambda text: report(text))
    target = None
    if not any(n.kind in CAMERAS or n.kind == "polymesh" or n.kind == "sphere" for n in nodes.values()):
        engines = [n.name for n in nodes.values() if n.kind == "MayaShadingEngine"]
        surfaces = [n.name for n in nodes.values() if n.kind in ("alSurface", "alLayer", "alHair", "standard")]
        target = "TARGET_SHADER" if "TARGET_SHADER" in nodes else engines[0] if engines else surfaces[0] if surfaces else None
        beside = os.path.join(os.path.dirname(path), "test_header.ass")
        if target is not None and base is None and os.path.isfile(beside):
            base = beside
    if base is not None:
        report("the scene around it is that of %s" % os.path.basename(base), None, True)
        around = read_all(base, lambda text: report(text))
        around.update(nodes)
        nodes = around
    scene = SceneConverter(path, report)
    scene.convert(nodes, target)
    scene.document["report"] = report.document()
    return scene, report


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="the .ass file, plain or gzip")
    parser.add_argument("--base", help="the scene around a file of materials; default: a test_header.ass beside it")
    parser.add_argument("-o", "--output", help="OUT.alder; default: the file's name")
    parser.add_argument("--quiet", action="store_true", help="errors only; the report is in the scene all the same")
    args = parser.parse_args(argv)
    output = args.output or os.path.splitext(args.file)[0] + ".alder"
    try:
        scene, report = convert(args.file, args.base)
        scene.write(output)
    except (AssError, Failure, OSError) as error:
        print("ass_scene: %s" % error, file=sys.stderr)
        return 2
    if not args.quiet:
        for line in report.lines():
            print(line, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
