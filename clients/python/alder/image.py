"""Pictures with all their layers, as NumPy arrays."""
from __future__ import annotations

import json
import os
import struct
import zlib
from typing import Any, Iterator, Mapping

import numpy as np

from . import exr

_ORDER = {c: i for i, c in enumerate("RGBAXYZWUV")}


def _srgb(x: np.ndarray) -> np.ndarray:
    x = np.clip(np.nan_to_num(x, nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)


def _png(pixels: np.ndarray) -> bytes:
    height, width, channels = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, width * channels)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)) \
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")


class Image(Mapping[str, np.ndarray]):
    """A mapping from layer names to float32 arrays: (h, w, 3) for colours and vectors, (h, w) for single channels.

    image["beauty"], image.alpha, image["direct_diffuse"], image["Z"]; image.samples, image.error, image.attributes.
    """

    def __init__(self, channels: dict[str, np.ndarray], attributes: dict[str, Any] | None = None, data: bytes | None = None):
        self.channels = channels
        self.attributes = attributes or {}
        self._data = data
        groups: dict[str, list[tuple[str, str]]] = {}
        for name in channels:
            layer, dot, channel = name.rpartition(".")
            if not dot:
                layer, channel = ("", name) if name in ("R", "G", "B", "A") else (name, "")
            groups.setdefault(layer, []).append((channel, name))
        self._layers = {layer or "beauty": sorted(members, key=lambda m: (_ORDER.get(m[0], 99), m[0])) for layer, members in groups.items()}

    @classmethod
    def from_bytes(cls, data: bytes) -> "Image":
        return cls(*exr.decode(data), data=data)

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> "Image":
        with open(path, "rb") as f:
            return cls.from_bytes(f.read())

    def __getitem__(self, layer: str) -> np.ndarray:
        members = self._layers.get(layer)
        if members is None:
            if layer in self.channels:
                return self.channels[layer].astype(np.float32)
            raise KeyError("no layer '%s': there are %s" % (layer, ", ".join(self)))
        wanted = [name for channel, name in members if not (channel == "A" and len(members) > 1)]
        planes = [self.channels[name].astype(np.float32) for name in wanted]
        return planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._layers, key=lambda n: (n != "beauty", n)))

    def __len__(self) -> int:
        return len(self._layers)

    @property
    def alpha(self) -> np.ndarray | None:
        return self.channels["A"].astype(np.float32) if "A" in self.channels else None

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) of what was rendered."""
        return next(iter(self.channels.values())).shape  # type: ignore[return-value]

    def _number(self, name: str) -> float | None:
        value = self.attributes.get(name)
        try:
            return None if value is None else float(value)
        except (TypeError, ValueError):
            return None

    @property
    def samples(self) -> int | None:
        value = self._number("alder/samples")
        return None if value is None else int(value)

    @property
    def error(self) -> float | None:
        """The estimated relative error."""
        return self._number("alder/estimated_error")

    @property
    def complete(self) -> bool:
        return self._number("alder/complete") != 0

    @property
    def settings(self) -> dict[str, Any]:
        """What it was rendered with."""
        text = self.attributes.get("alder/settings")
        return json.loads(text) if isinstance(text, str) else {}

    def save(self, path: str | os.PathLike[str]) -> None:
        """As .exr with all layers (the daemon's own bytes where it came from one), or as .png of the beauty."""
        if str(path).lower().endswith(".png"):
            data = self.png()
        else:
            texts = {k: v for k, v in self.attributes.items() if isinstance(v, str)}
            data = self._data or exr.encode(self.channels, texts)
        temporary = "%s.%d.part" % (path, os.getpid())
        with open(temporary, "wb") as f:
            f.write(data)
        os.replace(temporary, path)

    def png(self, layer: str = "beauty", exposure: float = 0.0, largest: int | None = None) -> bytes:
        """8-bit PNG of one layer; `largest` halves it until no side is longer."""
        x = self[layer] * np.float32(2.0 ** exposure)
        while largest and max(x.shape[:2]) > largest:
            h, w = x.shape[0] // 2 * 2, x.shape[1] // 2 * 2
            x = 0.25 * (x[0:h:2, 0:w:2] + x[1:h:2, 0:w:2] + x[0:h:2, 1:w:2] + x[1:h:2, 1:w:2])
        if x.ndim == 2:
            x = x[..., None]
        if x.shape[-1] == 2:
            x = np.concatenate([x, np.zeros_like(x[..., :1])], axis=-1)
        return _png((_srgb(x[..., :3]) * 255 + 0.5).astype(np.uint8))

    def _repr_png_(self) -> bytes:
        return self.png(largest=512)

    def __repr__(self) -> str:
        h, w = self.shape
        return "<alder.Image %d x %d, %s samples: %s>" % (w, h, self.samples, ", ".join(self))
