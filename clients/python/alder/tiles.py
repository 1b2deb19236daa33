"""Pictures of a live render as they come, from its stream of tiles: the newest first, without waiting for files."""
from __future__ import annotations

import json
import struct
import urllib.parse
from typing import Any, Iterator, Sequence

import numpy as np

from ._transport import Stream, Transport

_HEAD_MOST = 1 << 20
_PIXELS_MOST = 1 << 30


class Picture:
    """layers: float arrays (h, w, channels), rows from the top, at 1 / 2**level of the full size; edits: tokens of the edits it shows first."""

    def __init__(self, head: dict[str, Any]):
        self.number, self.samples, self.level = int(head["pass"]), int(head["samples"]), int(head["level"])
        self.width, self.height = int(head["width"]), int(head["height"])
        self.edits: list[str] = list(head.get("edits", []))
        self.layers = {str(entry["name"]): np.zeros((self.height, self.width, len(entry["channels"])), np.float32) for entry in head["layers"]}
        self._missing = self.width * self.height

    def put(self, head: dict[str, Any], pixels: bytes) -> bool:
        """Takes one tile; True when it was the last."""
        x, y, w, h = (int(head[k]) for k in "xywh")
        values = np.frombuffer(pixels, "<f2" if head["type"] == "half" else "<f4").reshape(-1, h, w)
        first = 0
        for layer in self.layers.values():
            count = layer.shape[-1]
            layer[y:y + h, x:x + w] = np.moveaxis(values[first:first + count], 0, -1)
            first += count
        self._missing -= w * h
        return self._missing <= 0


def read(stream: Stream) -> Iterator[Picture]:
    """Whole pictures; ends when the render does."""
    picture: Picture | None = None
    while True:
        try:
            lead = stream.read_exactly(12)
        except EOFError:
            return
        magic, head_bytes, pixel_bytes = struct.unpack("<4sII", lead)
        if magic != b"ALDT" or head_bytes > _HEAD_MOST or pixel_bytes > _PIXELS_MOST:
            raise ValueError("this is no stream of tiles")
        head, pixels = json.loads(stream.read_exactly(head_bytes)), stream.read_exactly(pixel_bytes)
        if picture is None or picture.number != head["pass"]:
            picture = Picture(head)
        if picture.put(head, pixels):
            yield picture
            picture = None


def open_stream(transport: Transport, render: str, layers: Sequence[str] = (), half: bool = True, timeout: float = 30.0) -> Stream:
    query = {"type": "half" if half else "float", **({"aovs": ",".join(layers)} if layers else {})}
    return transport.stream("/v1/renders/%s/tiles?%s" % (render, urllib.parse.urlencode(query)), {"Accept": "*/*"}, timeout)
