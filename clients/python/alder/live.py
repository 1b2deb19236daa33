"""A live render: a picture that follows edits. Parameters are set like items of a dictionary, one PATCH each.

    with client.live(scene, size=(960, 540)) as view:
        view["body/s.specular1Roughness"] = 0.2
        image = view.image()
"""
from __future__ import annotations

import threading
import time
import urllib.parse
import uuid
from typing import Any, Iterator, Sequence

from . import tiles
from ._transport import Stream, Transport
from .errors import AlderError, Conflict
from .image import Image


def split_target(target: str, materials: list[str], nodes_of: Any) -> tuple[str, str, str]:
    """MATERIAL/NODE.PARAM: the longest material that leads it, then the last dot behind a node of its graph."""
    fits = [m for m in materials if target.startswith(m + "/")]
    if not fits:
        raise KeyError("%s: no such material; there are %s" % (target, ", ".join(materials)))
    material = max(fits, key=len)
    rest = target[len(material) + 1:]
    nodes = nodes_of(material)
    at = rest.rfind(".")
    while at > 0:
        if rest[:at] in nodes:
            return material, rest[:at], rest[at + 1:]
        at = rest.rfind(".", 0, at)
    raise KeyError("%s: material %s has no such node; there are %s" % (target, material, ", ".join(nodes)))


class Live:
    def __init__(self, transport: Transport, scene: str, size: tuple[int, int] | None, members: dict[str, Any]):
        self._transport, self._scene = transport, scene
        body: dict[str, Any] = {"scene": scene, "mode": "live", **members}
        if size:
            body["resolution"] = list(size)
        self._document = transport.ask("POST", "/v1/renders", body).json()
        self.id = str(self._document["id"])
        self.latency: float | None = None   # seconds from the last edit to the first picture that shows it
        self._materials = list(transport.ask("GET", "/v1/scenes/" + scene).json().get("materials", []))
        self._graphs: dict[str, tuple[dict[str, Any], str]] = {}
        self._sent: dict[str, float] = {}
        self._shown = threading.Condition()
        self._closing = False
        self._stream: Stream | None = None
        threading.Thread(target=self._follow, daemon=True).start()

    def _follow(self) -> None:
        while not self._closing:
            try:
                self._stream = self._transport.stream("/v1/renders/%s/events" % self.id, {"Accept": "text/event-stream"})
                for event, data, _ in self._stream.events():
                    if event == "end":
                        return
                    if event == "image" and isinstance(data, dict):
                        now = time.perf_counter()
                        with self._shown:
                            for edit in data.get("edits", []):
                                if edit in self._sent:
                                    self.latency = now - self._sent.pop(edit)
                            self._document["samples"] = data.get("samples")
                            self._shown.notify_all()
            except (AlderError, OSError, ValueError, EOFError, AttributeError):
                if not self._closing:
                    time.sleep(0.5)

    def _path(self, material: str) -> str:
        return "/v1/scenes/%s/materials/%s" % (self._scene, urllib.parse.quote(material, safe=""))

    def _graph(self, material: str, again: bool = False) -> tuple[dict[str, Any], str]:
        if again or material not in self._graphs:
            answer = self._transport.ask("GET", self._path(material))
            self._graphs[material] = answer.json(), answer.headers.get("ETag", "*")
        return self._graphs[material]

    def _split(self, target: str) -> tuple[str, str, str]:
        return split_target(target, self._materials, lambda m: self._graph(m)[0].get("nodes", {}))

    def __getitem__(self, target: str) -> Any:
        material, node, param = self._split(target)
        return self._graph(material)[0]["nodes"][node].get("params", {}).get(param)

    def __setitem__(self, target: str, value: Any) -> None:
        material, node, param = self._split(target)
        if hasattr(value, "tolist"):
            value = value.tolist()
        for attempt in (0, 1):
            graph, etag = self._graph(material, attempt > 0)
            edit = uuid.uuid4().hex[:16]
            self._sent[edit] = time.perf_counter()
            try:
                answer = self._transport.ask("PATCH", self._path(material), {"nodes": {node: {"params": {param: value}}}},
                                             {"Content-Type": "application/merge-patch+json", "If-Match": etag, "Alder-Edit-Id": edit})
                break
            except Conflict:   # someone else edited it
                self._sent.pop(edit, None)
                if attempt:
                    raise
        graph["nodes"][node].setdefault("params", {})[param] = value
        self._graphs[material] = graph, answer.headers.get("ETag", "*")

    def wait(self, timeout: float = 10.0) -> float | None:
        """Until all edits have been shown; the latency of the last."""
        with self._shown:
            self._shown.wait_for(lambda: not self._sent, timeout)
        return self.latency

    def pictures(self, layers: Sequence[str] = (), half: bool = True) -> Iterator[tiles.Picture]:
        """Pictures as they come, coarse ones first, until the view is closed; what a slow reader cannot take is left out."""
        with tiles.open_stream(self._transport, self.id, layers, half) as stream:
            yield from tiles.read(stream)

    def image(self) -> Image:
        """What is there now, all layers."""
        return Image.from_bytes(self._transport.ask("GET", "/v1/renders/%s/snapshot.exr" % self.id, headers={"Accept": "image/x-exr"}).body)

    def _repr_png_(self) -> bytes:
        return self.image()._repr_png_()

    def close(self) -> None:
        if not self._closing:
            self._closing = True
            try:
                self._transport.ask("DELETE", "/v1/renders/" + self.id)
            except AlderError:
                pass
            if self._stream is not None:
                self._stream.close()

    def __enter__(self) -> "Live":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
