"""A Blender scene, evaluated for rendering, as a scene document in a container.

Geometry comes from the dependency graph: every instance it lists counts, meshes are written once however many instances show them.
"""
import bpy
import numpy as np

from . import hair, meshes, motion, objects, values
from .container import Container
from .graph import GraphWriter, output_node
from .images import Images
from .report import ExportError, Report

MESH_TYPES = {"MESH"}
CONVERTED_TYPES = {"META"}
# Curves, surfaces and texts are listed a second time, as instances of the meshes they become.
INVISIBLE_TYPES = {"EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE", "CAMERA", "CURVE", "SURFACE", "FONT"}
THREAD_TYPES = {"CURVES": "curves", "POINTCLOUD": "points"}
UNSUPPORTED_TYPES = {"VOLUME": "volume objects", "GPENCIL": "grease pencil",
                     "GREASEPENCIL": "grease pencil"}
MOST_LIGHT_GROUPS = 8


class SceneExporter:
    def __init__(self, depsgraph, engine=None, box=None):
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.view_layer = depsgraph.view_layer
        self.report = Report()
        self.box = box or Container()
        self.images = Images(self.box, self.report)
        version = bpy.app.version[:2]
        self.graphs = GraphWriter(self.report, self.images.parameter, self.images.file, self._object_matrix,
                                  version if version < (4, 5) else None)
        self.motion = motion.Motion(depsgraph, engine)
        self.document = {"alder_scene": 1, "name": self.scene.name, "settings": {}, "cameras": {}, "materials": {}, "meshes": {}, "curves": {}, "points": {},
                         "instances": {}, "lights": {}}
        self.meshes = {}       # pointer of the data -> (name in the document or None, material slots its faces need)
        self.materials = {}    # name_full -> name in the document
        self.light_graphs = {}
        self.groups = {}       # what instances have in common -> [name, members, transforms, randoms]
        self.light_groups = {}

    def export(self):
        self.motion.go_to_center()
        self._light_groups()
        self._settings()
        self._cameras()
        self._geometry()
        self._world()
        self.motion.write(self.groups.values(), self.document, self.box, self.report)
        self._instances()
        self.motion.come_back()
        self.document["report"] = self.report.document()
        return self.document

    # ---- the whole ------------------------------------------------------------------------------------------------

    def _light_groups(self):
        for i, g in enumerate(getattr(self.view_layer, "lightgroups", ())):
            if i < MOST_LIGHT_GROUPS:
                self.light_groups[g.name] = i + 1
                self.report.note("light group %d is \"%s\"" % (i + 1, g.name))
            else:
                self.report.unsupported("more than %d light groups" % MOST_LIGHT_GROUPS, g.name)

    def _settings(self):
        s, r = self.scene, self.scene.render
        scale = r.resolution_percentage / 100.0
        out = self.document["settings"]
        out["resolution"] = [max(1, int(r.resolution_x * scale)), max(1, int(r.resolution_y * scale))]
        out["film_transparent"] = bool(r.film_transparent)
        where = "scene " + s.name
        c = getattr(s, "cycles", None)
        if c is None:
            self.report.unsupported("Cycles' settings: its add-on is off", where)
        else:
            out["samples"] = max(1, c.samples)
            out["seed"] = c.seed & 0xffffffff
            out["max_bounces"] = c.max_bounces
            out["diffuse_bounces"] = c.diffuse_bounces
            out["glossy_bounces"] = c.glossy_bounces
            out["transmission_bounces"] = c.transmission_bounces
            out["volume_bounces"] = c.volume_bounces
            out["transparent_bounces"] = c.transparent_max_bounces
            out["clamp_direct"] = values.number(c.sample_clamp_direct)
            out["clamp_indirect"] = values.number(c.sample_clamp_indirect)
            out["filter"] = c.pixel_filter_type.lower()
            out["filter_width"] = 1 if c.pixel_filter_type == "BOX" else values.number(c.filter_width)
            out["caustics_reflective"] = bool(c.caustics_reflective)
            out["caustics_refractive"] = bool(c.caustics_refractive)
            out["exposure"] = values.number(c.film_exposure)
            out["filter_glossy"] = values.number(c.blur_glossy)
            if c.film_transparent_glass and r.film_transparent:
                self.report.unsupported("transparent glass of the film", where)
            if c.use_denoising:
                self.report.note("denoising", where)
            if c.use_adaptive_sampling:
                self.report.note("adaptive sampling: a fixed number of samples is written", where)
        if r.use_motion_blur and c is not None:
            curve = r.motion_blur_shutter_curve
            curve.initialize()
            samples = [max(0.0, curve.evaluate(curve.curves[0], k / 64)) for k in range(65)]
            if max(samples) - min(samples) > 1e-6:
                out["shutter_curve"] = values.numbers(samples)
            if getattr(c, "rolling_shutter_type", "NONE") != "NONE":
                self.report.unsupported("rolling shutter", where)
        if r.use_border:
            self.report.unsupported("render region", where)
        if s.world is not None and getattr(s.world.light_settings, "use_ambient_occlusion", False) and c is not None and c.use_fast_gi:
            self.report.unsupported("fast global illumination", where)

    def _cameras(self):
        active = self.scene.camera
        if active is None:
            raise ExportError("scene %s has no camera" % self.scene.name)
        for o in self.scene.objects:
            if o.type == "CAMERA" and (o == active or o.original == active.original):
                self._camera(o, True)
        if active.name_full not in self.document["cameras"]:
            self._camera(active, True)
        for o in self.scene.objects:
            if o.type == "CAMERA" and o.name_full not in self.document["cameras"]:
                self._camera(o, False)
        self.document["camera"] = active.name_full

    def _camera(self, o, is_active):
        camera = objects.export_camera(o.evaluated_get(self.depsgraph), self.scene, self.report)
        if camera is not None:
            self.document["cameras"][o.name_full] = camera
        elif is_active:
            raise ExportError("camera %s: type %s is not supported" % (o.name, o.data.type))

    def _world(self):
        w = self.scene.world
        if w is None:
            return
        out = {}
        if w.use_nodes and w.node_tree is not None:
            graph, linked = self.graphs.document(w.node_tree, "world", "world " + w.name)
            if graph["outputs"]:
                out["graph"] = graph
        else:
            out["graph"] = {"version": 1, "nodes": {"Background": {"type": "ShaderNodeBackground", "params": {"Color": values.numbers(w.color)}}},
                            "outputs": {"surface": {"node": "Background", "output": "Background"}}}
        seen_by = getattr(w, "cycles_visibility", None)
        if seen_by is not None:
            off = {k: False for k, name in (("camera", "camera"), ("diffuse", "diffuse"), ("glossy", "glossy"), ("transmission", "transmission"),
                                            ("volume", "scatter")) if not getattr(seen_by, name)}
            if off:
                out["visibility"] = off
        if getattr(w, "lightgroup", "") in self.light_groups:
            out["light_group"] = self.light_groups[w.lightgroup]
        c = getattr(w, "cycles", None)
        if c is not None and c.sampling_method == "MANUAL":
            out["importance_resolution"] = min(max(c.sample_map_resolution, 4), 16384)
        self.document["world"] = out

    # ---- geometry ---------------------------------------------------------------------------------------------------

    def _geometry(self):
        known = {}   # (data, original object, parent) -> group, None: nothing to show
        for i in self.depsgraph.object_instances:
            o = i.object
            kind = o.type
            if kind == "LIGHT":
                if i.show_self:
                    self._light(o, i)
                continue
            if kind in INVISIBLE_TYPES:
                continue
            if not self._is_shown(i):
                self._particles(o, i)
                continue
            data = o.data
            parent = i.parent
            key = (data.as_pointer() if data is not None else 0, o.original.as_pointer(), parent.as_pointer() if parent is not None else 0)
            if key in known:
                group = known[key]
            else:
                self._particles(o, i)
                group = known[key] = self._group(o, parent, i.is_instance)
            if group is not None:
                self.motion.add_instance(i, group, len(group[3]), group[4])
                group[2].extend(motion.matrix_of(i))
                group[3].append(i.random_id if i.is_instance else values.random_id(o.original.name))

    @staticmethod
    def _is_shown(instance):
        return instance.show_self

    def _particles(self, o, instance):
        if instance.is_instance:
            return
        for p in getattr(o, "particle_systems", ()):
            if p.settings.type == "HAIR" and p.settings.render_type == "PATH":
                self.report.unsupported("hair of particle systems", o.name)
            elif p.settings.render_type in ("HALO", "LINE", "PATH"):
                self.report.unsupported("particles drawn as %s" % p.settings.render_type.lower(), o.name)

    def _group(self, o, parent, is_instance):
        """The list that instances of this object go to; None where there is nothing to show."""
        name = o.original.name_full
        if o.type in UNSUPPORTED_TYPES:
            self.report.unsupported(UNSUPPORTED_TYPES[o.type], name)
            return None
        if o.type not in MESH_TYPES and o.type not in CONVERTED_TYPES and o.type not in THREAD_TYPES:
            self.report.unsupported("objects of type " + o.type, name)
            return None
        kind = THREAD_TYPES.get(o.type, "meshes")
        mesh, slots = self._threads(o, name, kind) if o.type in THREAD_TYPES else self._mesh(o, name)
        if mesh is None:
            return None
        hidden = objects.visibility(o)
        if is_instance and parent is not None:
            hidden.update(objects.visibility(parent))
        self._object_warnings(o, name)
        materials = self._slots(o)
        member = {"mesh" if kind == "meshes" else kind: mesh}
        if materials:
            # Faces beyond the last slot show the last material.
            materials += [materials[-1]] * (slots - len(materials))
            member["materials"] = materials
        elif slots > 1:
            member["materials"] = [self._default_material()] * slots
        if hidden:
            member["visibility"] = hidden
        if o.is_holdout:
            member["holdout"] = True
        if o.pass_index:
            member["pass_index"] = o.pass_index
        color = values.numbers(o.color)
        if color != [1, 1, 1, 1]:
            member["color"] = color[:3]
            if color[3] != 1:
                self.report.note("alpha of an object's colour", name)
        group = getattr(o, "lightgroup", "")
        if group in self.light_groups:
            member["light_group"] = self.light_groups[group]
        by = parent.original.name_full if is_instance and parent is not None else name
        label = "%s/%s" % (by, name) if by != name else name
        label = self._free(label, self.document["instances"])
        self.document["instances"][label] = member
        group = self.groups[label] = [label, member, [], [], (kind, mesh)]
        return group

    def _object_warnings(self, o, name):
        if o.is_shadow_catcher:
            self.report.unsupported("shadow catchers", name)
        linking = getattr(o, "light_linking", None)
        if linking is not None and (linking.receiver_collection or linking.blocker_collection):
            self.report.unsupported("light linking", name)
        c = getattr(o, "cycles", None)
        if c is not None and getattr(c, "use_adaptive_subdivision", False):
            self.report.unsupported("adaptive subdivision", name)

    def _instances(self):
        for label, member, transforms, randoms, _ in self.groups.values():
            # As Cycles: the id as a fraction of the largest one.
            fractions = np.asarray(randoms, np.int64).astype(np.uint32).astype(np.float32) * np.float32(1 / 0xffffffff)
            fractions = np.minimum(fractions, np.float32(1))
            if len(randoms) == 1:
                member["transform"] = values.numbers(transforms)
                member["random"] = values.number(fractions[0])
            else:
                member["transforms"] = self.box.array(np.asarray(transforms, np.float32), 12)
                member["randoms"] = self.box.array(fractions, 1)

    def _mesh(self, o, name):
        converted = o.type in CONVERTED_TYPES
        key = o.original.as_pointer() if converted else o.data.as_pointer()
        if key in self.meshes:
            return self.meshes[key]
        mesh = o.to_mesh() if converted else o.data
        label, slots = None, 1
        if mesh is not None:
            out = meshes.export_mesh(mesh, self.box, self.report, name, self._deformed if self._uses_generated(o) else None)
            if out is not None:
                slots = meshes.slots_needed(mesh)
                # What modifiers made has a name of its own that says nothing.
                original = o.original.data
                label = self._free(original.name_full if original is not None and not converted else name, self.document["meshes"])
                self.document["meshes"][label] = out
        if converted and mesh is not None:
            o.to_mesh_clear()
        self.meshes[key] = (label, slots)
        return label, slots

    def _threads(self, o, name, kind):
        """Hair curves or a point cloud."""
        key = o.data.as_pointer()
        if key in self.meshes:
            return self.meshes[key]
        if kind == "curves":
            out = hair.export_curves(o.data, self.scene, self.box, self.report, name, self._has_elliptical_hair(o))
        else:
            out = hair.export_points(o.data, self.box, self.report, name)
        label = None
        if out is not None:
            label = self._free(o.original.data.name_full, self.document[kind])
            self.document[kind][label] = out
        self.meshes[key] = (label, 1)
        return label, 1

    @staticmethod
    def _has_elliptical_hair(o):
        for slot in o.material_slots:
            tree = slot.material.node_tree if slot.material is not None and slot.material.use_nodes else None
            for n in tree.nodes if tree is not None else ():
                if n.bl_idname == "ShaderNodeBsdfHairPrincipled" and getattr(n, "model", "CHIANG") == "HUANG" \
                        and (n.inputs["Aspect Ratio"].is_linked or n.inputs["Aspect Ratio"].default_value != 1):
                    return True
        return False

    def _deformed(self, where):
        self.report.unsupported("generated coordinates of a deformed mesh (taken from the deformed one)", where)

    @staticmethod
    def _uses_generated(o):
        for slot in o.material_slots:
            tree = slot.material.node_tree if slot.material is not None and slot.material.use_nodes else None
            if tree is None:
                continue
            for l in tree.links:
                if l.from_node.bl_idname == "ShaderNodeTexCoord" and l.from_socket.identifier == "Generated":
                    return True
        return False

    @staticmethod
    def _free(name, table):
        """The name, with a number where another thing has it already (data of several libraries, results of modifiers)."""
        name = name or "unnamed"
        n, free = 1, name
        while free in table:
            n += 1
            free = "%s #%d" % (name, n)
        return free

    def _object_matrix(self, o):
        return o.evaluated_get(self.depsgraph).matrix_world

    # ---- materials and lamps ------------------------------------------------------------------------------------------

    def _slots(self, o):
        slots = [s.material for s in o.material_slots]
        if not slots and (o.type in MESH_TYPES or o.type in THREAD_TYPES):
            slots = list(o.data.materials)
        return [self._material(m) for m in slots]

    def _default_material(self):
        if None not in self.materials:
            name = self.materials[None] = self._free("Default Surface", self.document["materials"])
            self.document["materials"][name] = _diffuse([0.8, 0.8, 0.8])
        return self.materials[None]

    def _material(self, m):
        if m is None:
            return self._default_material()
        key = m.original.name_full if m.original is not None else m.name_full
        if key in self.materials:
            return self.materials[key]
        name = self.materials[key] = self._free(key, self.document["materials"])
        self.document["materials"][name] = {}   # keeps the name
        self.document["materials"][name] = self._material_graph(m, name)
        if m.pass_index:
            self.document["materials"][name]["pass_index"] = m.pass_index
        return name

    def _material_graph(self, m, name):
        if not m.use_nodes or m.node_tree is None:
            return _diffuse(values.numbers(m.diffuse_color)[:3])
        graph, linked = self.graphs.document(m.node_tree, "material", "material " + name)
        if "displacement" in graph["outputs"]:
            method = getattr(m, "displacement_method", None) or getattr(getattr(m, "cycles", None), "displacement_method", "BUMP")   # Blender 4.1
            if method != "BUMP":
                graph["displacement"] = {"DISPLACEMENT": "displacement", "BOTH": "both"}[method]
            if method != "DISPLACEMENT":
                self.report.unsupported("displacement of a material as bump", name)
        if output_node(m.node_tree, "ShaderNodeOutputMaterial") is None:
            self.report.note("material without output", name)
        return graph

    def _light(self, o, instance):
        light = o.data
        if light.type == "AREA" and getattr(getattr(light, "cycles", None), "is_portal", False):
            self.report.note("light portal", o.original.name_full)
            return
        out = objects.export_light(o, light, self.report)
        if instance.is_instance:
            out["transform"] = objects.transform(instance.matrix_world)
            parent = instance.parent
            if parent is not None:
                hidden = {**out.get("visibility", {}), **objects.visibility(parent)}
                if hidden:
                    out["visibility"] = hidden
        key = light.as_pointer()
        if key not in self.light_graphs:
            self.light_graphs[key] = self._light_graph(light)
        if self.light_graphs[key] is not None:
            out["graph"] = self.light_graphs[key]
        group = getattr(o, "lightgroup", "")
        if group in self.light_groups:
            out["light_group"] = self.light_groups[group]
        linking = getattr(o, "light_linking", None)
        if linking is not None and (linking.receiver_collection or linking.blocker_collection):
            self.report.unsupported("light linking", o.original.name_full)
        self.document["lights"][self._free(o.original.name_full, self.document["lights"])] = out

    def _light_graph(self, light):
        if not light.use_nodes or light.node_tree is None:
            return None
        graph, linked = self.graphs.document(light.node_tree, "light", "light " + light.name)
        if "surface" not in graph["outputs"]:
            # Nothing linked: the lamp is dark.
            graph["nodes"] = {"dark": {"type": "ShaderNodeEmission", "params": {"Color": [0, 0, 0], "Strength": 0.0}}}
            graph["outputs"] = {"surface": {"node": "dark", "output": "Emission"}}
            return graph
        node = graph["nodes"].get(linked["Surface"].get("node")) if isinstance(linked.get("Surface"), dict) else None
        if node is not None and node["type"] == "ShaderNodeEmission" and node["params"].get("Strength") == 1 \
                and node["params"].get("Color") == [1, 1, 1, 1]:
            return None   # what a lamp is without a graph
        return graph


def _diffuse(color):
    return {"version": 1, "nodes": {"Diffuse BSDF": {"type": "ShaderNodeBsdfDiffuse", "params": {"Color": color}}},
            "outputs": {"surface": {"node": "Diffuse BSDF", "output": "BSDF"}}}
