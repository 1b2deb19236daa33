"""Motion blur: the scene at the times of the shutter that Cycles looks at, as keys of instances, shapes and the camera."""
import math

import numpy as np

from . import hair
from .meshes import read


def steps_of(o, parent=None):
    """Keys of an object over the shutter, as Cycles has it: an odd number, so that one of them is the frame itself; 1: at rest."""
    c = getattr(o, "cycles", None)
    if c is None or not getattr(c, "use_motion_blur", True):
        return 1
    steps = max(1, getattr(c, "motion_steps", 1))
    other = getattr(parent, "cycles", None) if parent is not None and parent != o else None
    if other is not None:
        if not getattr(other, "use_motion_blur", True):
            return 1
        steps = max(steps, getattr(other, "motion_steps", 1))
    return (2 << (min(steps, 7) - 1)) + 1


def instance_key(i):
    """The same for an instance at all times."""
    parent = i.parent.original.name_full if i.is_instance and i.parent is not None else ""
    return (i.object.original.name_full, parent, tuple(i.persistent_id) if i.is_instance else ())


def matrix_of(i):
    a, b, c, _ = i.matrix_world
    return (*a, *b, *c)


class Motion:
    """Wants to know, while the scene is read, which instances and shapes there are; then reads them at the other times."""

    def __init__(self, depsgraph, engine):
        self.depsgraph = depsgraph
        self.engine = engine
        self.scene = depsgraph.scene
        r = self.scene.render
        self.on = bool(r.use_motion_blur) and engine is not None and hasattr(self.scene, "cycles")
        self.frame = self.scene.frame_current + self.scene.frame_subframe
        self.shutter = r.motion_blur_shutter
        self.center = self.frame
        if self.on:
            position = r.motion_blur_position
            self.center += {"START": 0.5, "END": -0.5}.get(position, 0.0) * self.shutter
        self.instances = {}   # key of an instance -> (group, index in it, steps)
        self.shapes = {}      # key of an instance -> (kind, name, steps): of one that shows the shape
        self.wanted = set()   # steps that occur

    def go_to_center(self):
        if self.on and self.center != self.frame:
            self._go_to(self.center)

    def come_back(self):
        if self.on:
            self._go_to(self.frame)

    def add_instance(self, i, group, index, shape):
        if not self.on:
            return
        o = i.object
        parent = i.parent if i.is_instance else None
        steps = steps_of(o, parent)
        if steps == 1:
            return
        key = instance_key(i)
        self.wanted.add(steps)
        self.instances[key] = (group, index, steps)
        if shape is not None and shape not in {s[:2] for s in self.shapes.values()} and getattr(getattr(o, "cycles", None), "use_deform_motion", True):
            self.shapes[key] = (*shape, steps)

    def write(self, groups, document, box, report):
        """Adds what moves to the document."""
        if not self.on:
            return
        camera = self.scene.camera
        camera_steps = steps_of(camera)
        if camera_steps > 1:
            self.wanted.add(camera_steps)
        times = sorted({2.0 * k / (steps - 1) - 1.0 for steps in self.wanted for k in range(steps)})
        places = {key: {0.0: tuple(group[2][12 * index:12 * index + 12])} for key, (group, index, _) in self.instances.items()}
        points = {key: {} for key in self.shapes}
        cameras = {}
        lens = set()
        for time in times:
            self._go_to(self.center + 0.5 * self.shutter * time)
            for i in self.depsgraph.object_instances:
                key = instance_key(i)
                if key in places and time != 0.0:
                    places[key][time] = matrix_of(i)
                if key in points:
                    points[key][time] = self._points(i.object, self.shapes[key][0])
            evaluated = camera.evaluated_get(self.depsgraph)
            cameras[time] = tuple(x for row in tuple(evaluated.matrix_world)[:3] for x in row)
            lens.add((evaluated.data.lens, evaluated.data.ortho_scale, evaluated.data.dof.focus_distance))
        self._write_instances(groups, places, box)
        self._write_shapes(document, points, box, report)
        keys = [cameras[2.0 * k / (camera_steps - 1) - 1.0] for k in range(camera_steps)] if camera_steps > 1 else []
        if len(set(keys)) > 1:
            document["cameras"][camera.name_full]["motion"] = [float("%.9g" % x) for key in keys for x in key]
        if len(lens) > 1 and camera_steps > 1:
            report.unsupported("a lens that changes while the shutter is open", camera.name_full)

    def _write_instances(self, groups, places, box):
        for group in groups:
            count = len(group[3])
            mine = {index: (key, steps) for key, (g, index, steps) in self.instances.items() if g is group}
            if not mine:
                continue
            steps = max(s for _, s in mine.values())
            keys = np.empty((count, steps, 12), np.float32)
            for index in range(count):
                rest = tuple(group[2][12 * index:12 * index + 12])
                at = places[mine[index][0]] if index in mine else {}
                for k in range(steps):
                    keys[index, k] = at.get(2.0 * k / (steps - 1) - 1.0, rest)
            if (keys != keys[:, :1]).any():
                group[1]["motion"] = box.array(keys.reshape(-1), 12)

    def _write_shapes(self, document, points, box, report):
        for key, (kind, name, steps) in self.shapes.items():
            shape = document[kind][name]
            at = [points[key].get(2.0 * k / (steps - 1) - 1.0) for k in range(steps)]
            count = shape["positions"]["count"]
            if any(p is None or len(p["positions"]) != 3 * count for p in at):
                report.unsupported("motion of a shape whose points change in number", name)
                continue
            if all(np.array_equal(p["positions"], at[0]["positions"]) for p in at):
                continue
            motion = shape["motion"] = {"steps": steps}
            for field, channels in (("positions", 3), ("normals", 3), ("radii", 1)):
                if all(field in p for p in at) and not (field == "normals" and "normals" not in shape):
                    motion[field] = box.array(np.concatenate([p[field] for p in at]), channels)

    @staticmethod
    def _points(o, kind):
        if kind == "meshes":
            if o.type != "MESH":
                return None
            mesh = o.data
            normals = mesh.vertex_normals if hasattr(mesh, "vertex_normals") else None
            out = {"positions": read(mesh.vertices, "co", 3)}
            out["normals"] = read(normals, "vector", 3) if normals is not None else read(mesh.vertices, "normal", 3)
            return out
        positions, radii = hair.points_of(o.data)
        return {"positions": positions, "radii": radii}

    def _go_to(self, time):
        frame = math.floor(time)
        self.engine.frame_set(int(frame), subframe=time - frame)
