"""Graphs built in code, checked and completed from the daemon's catalogue.

    g = client.graph()
    noise = g.ShaderNodeTexNoise(Scale=5)
    body = g.alSurface(diffuseColor=(0.8, 0.2, 0.1), specular1Roughness=noise.Fac)
    g.surface = body
"""
from __future__ import annotations

import difflib
from typing import Any, Iterable

from .errors import Invalid


def _near(name: str, names: Iterable[str]) -> str:
    found = difflib.get_close_matches(name, list(names), 1, 0.5)
    return "; did you mean '%s'?" % found[0] if found else ""


def _fault(pointer: str, found: Any, expected: str, suggest: str = "") -> Invalid:
    error = {"pointer": pointer, "code": "unknown", "found": found, "expected": expected, "suggest": suggest}
    return Invalid("%s: found '%s', expected %s%s" % (pointer, found, expected, suggest), problem={"type": "/problems/graph-invalid", "errors": [error]})


class Catalogue:
    """Node types by name and alias, as GET /v1/nodes lists them."""

    def __init__(self, items: list[dict[str, Any]]):
        self.types = {i["name"]: i for i in items}
        self.aliases = {a: i["name"] for i in items for a in i.get("aliases", [])}

    def __getitem__(self, name: str) -> dict[str, Any]:
        found = self.types.get(self.aliases.get(name, name))
        if found is None:
            raise _fault("/nodes", name, "a node type", _near(name, self.types))
        return found

    def __contains__(self, name: object) -> bool:
        return name in self.types or name in self.aliases

    def __dir__(self) -> list[str]:
        return sorted(self.types)

    def stub(self) -> str:
        """Text of a .pyi for editors: one typed method for each node type that has a Python name."""
        kinds = {"float": "float | Link", "int": "int | Link", "bool": "bool | Link", "string": "str | Link", "enum": "str"}
        lines = ["from typing import Any, Sequence", "from alder.graph import Graph, Link, Node", "", "class Graph(Graph):  # type: ignore[no-redef]"]
        for name in sorted(self.types):
            item = self.types[name]
            args = ["%s: %s = ..." % (p["name"], kinds.get(p["type"], "Any")) for p in item.get("params", []) if p["name"].isidentifier()]
            lines.append("    def %s(self, name: str | None = ..., %s**params: Any) -> Node:" % (name, "".join(a + ", " for a in args)))
            lines.append("        %r" % item.get("summary", ""))
        return "\n".join(lines) + "\n"


class Link:
    """An output of a node, or one channel of it: link.r, link.g, link.b, link.x ..."""

    def __init__(self, node: "Node", output: str | None = None, component: str | None = None):
        self.node, self.output, self.component = node, output, component

    def __getattr__(self, name: str) -> "Link":
        if name in ("r", "g", "b", "a", "x", "y", "z") and self.component is None:
            return Link(self.node, self.output, name)
        raise AttributeError(name)

    def document(self) -> dict[str, str]:
        out = {"node": self.node.name}
        if self.output is not None:
            out["output"] = self.output
        if self.component:
            out["component"] = self.component
        return out


class Node:
    """A node of a graph. node["Param"] = value; node.Output or node["Output"] is a link."""

    def __init__(self, graph: "Graph", name: str, item: dict[str, Any], params: dict[str, Any]):
        self.__dict__.update(graph=graph, name=name, item=item, params={})
        for key, value in params.items():
            self[key] = value

    def _param(self, key: str) -> str:
        names = [p["name"] for p in self.item.get("params", [])]
        aliases = {a: p["name"] for p in self.item.get("params", []) for a in p.get("aliases", [])}
        # Blender's names have spaces, which keyword arguments cannot have: Base_Color is "Base Color" where nothing else is.
        for candidate in (key, aliases.get(key), key.replace("_", " ")):
            if candidate in names:
                return str(candidate)
        raise _fault("/nodes/%s/params/%s" % (self.name, key), key, "a parameter of " + self.item["name"], _near(key, names))

    def __setitem__(self, key: str, value: Any) -> None:
        self.params[self._param(key)] = value

    def __setattr__(self, key: str, value: Any) -> None:
        self[key] = value

    def __getitem__(self, output: str) -> Link:
        outputs = [o["name"] for o in self.item.get("outputs", [])]
        aliases = {a: o["name"] for o in self.item.get("outputs", []) for a in o.get("aliases", [])}
        for candidate in (output, aliases.get(output), output.replace("_", " ")):
            if candidate in outputs:
                return Link(self, candidate)
        raise _fault("/nodes/%s" % self.name, output, "an output of %s: %s" % (self.item["name"], ", ".join(outputs)), _near(output, outputs))

    def __getattr__(self, name: str) -> Link:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in ("r", "g", "b", "a", "x", "y", "z") and name not in [o["name"] for o in self.item.get("outputs", [])]:
            return Link(self, None, name)
        try:
            return self[name]
        except Invalid as e:
            raise AttributeError(str(e)) from None

    def __dir__(self) -> list[str]:
        return sorted({o["name"].replace(" ", "_") for o in self.item.get("outputs", [])} | {p["name"].replace(" ", "_") for p in self.item.get("params", [])})

    def __repr__(self) -> str:
        return "<%s '%s'>" % (self.item["name"], self.name)


def value_document(value: Any) -> Any:
    if isinstance(value, Node):
        return {"node": value.name}
    if isinstance(value, Link):
        return value.document()
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [value_document(v) for v in value]
    if isinstance(value, dict):
        return {k: value_document(v) for k, v in value.items()}
    return value


class Graph:
    """A graph document in the making; every node type of the catalogue is a method."""

    def __init__(self, catalogue: Catalogue):
        self.__dict__.update(catalogue=catalogue, nodes={}, outputs={}, aovs={})

    def add(self, type: str, name: str | None = None, /, **params: Any) -> Node:
        item = self.catalogue[type]
        base = name or item["name"]
        free, n = base, 1
        while free in self.nodes:
            if name:
                raise ValueError("the graph has a node '%s' already" % name)
            n += 1
            free = "%s.%d" % (base, n)
        node = Node(self, free, item, params)
        self.nodes[free] = node
        return node

    def __getattr__(self, type: str) -> Any:
        if type.startswith("_"):
            raise AttributeError(type)
        if type not in self.catalogue:
            raise AttributeError("no node type '%s'%s" % (type, _near(type, self.catalogue.types)))

        def make(name: str | None = None, /, **params: Any) -> Node:
            return self.add(type, name, **params)
        make.__name__ = type
        make.__doc__ = self.catalogue[type].get("help") or self.catalogue[type].get("summary")
        return make

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in ("surface", "displacement", "volume"):
            raise AttributeError("'%s' is no output: surface, displacement and volume are; AOVs by graph.aovs[NAME]" % name)
        self.outputs[name] = value

    def __dir__(self) -> list[str]:
        return ["add", "aovs", "document", "nodes", "surface", "displacement", "volume", *sorted(self.catalogue.types)]

    def document(self) -> dict[str, Any]:
        nodes = {n.name: {"type": n.item["name"], "params": {k: value_document(v) for k, v in n.params.items()}} for n in self.nodes.values()}
        outputs: dict[str, Any] = {k: value_document(v) for k, v in self.outputs.items()}
        if self.aovs:
            outputs["aovs"] = {k: value_document(v) for k, v in self.aovs.items()}
        return {"version": 1, "nodes": nodes, "outputs": outputs}
