"""OpenEXR scan line files to NumPy and back: what Alder writes and what its clients need, in NumPy and zlib alone.

Reads half, float and uint channels, uncompressed, RLE, ZIPS and ZIP; other compressions through the OpenEXR package where it is
installed. Layout: "OpenEXR File Layout", openexr.com.
"""
from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np

_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_LINES = {0: 1, 1: 1, 2: 1, 3: 16}   # none, RLE, ZIPS, ZIP


class ExrError(ValueError):
    """Not an EXR file that can be read here."""


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.find(b"\0", at, at + 257)
    if end < 0:
        raise ExrError("a name without end in the header")
    return data[at:end].decode("utf-8", "replace"), end + 1


def _attribute(kind: str, raw: bytes) -> Any:
    try:
        if kind == "string":
            return raw.decode("utf-8", "replace")
        if kind == "int":
            return struct.unpack("<i", raw)[0]
        if kind == "float":
            return struct.unpack("<f", raw)[0]
        if kind == "double":
            return struct.unpack("<d", raw)[0]
        if kind in ("box2i", "v2i", "v3i"):
            return list(struct.unpack("<%di" % (len(raw) // 4), raw))
        if kind in ("v2f", "v3f", "m33f", "m44f", "chromaticities", "box2f"):
            return list(struct.unpack("<%df" % (len(raw) // 4), raw))
        if kind == "rational":
            n, d = struct.unpack("<iI", raw)
            return n / d if d else 0.0
    except struct.error:
        raise ExrError("an attribute of a wrong size") from None
    return raw


def _header(data: bytes) -> tuple[dict[str, Any], list[tuple[str, int]], int]:
    if len(data) < 8 or data[:4] != b"\x76\x2f\x31\x01":
        raise ExrError("not an EXR file")
    version = struct.unpack_from("<I", data, 4)[0]
    if version & 0x1a00:
        raise ExrError("tiled, deep and multi-part files are not read here")
    at, attributes, channels = 8, {}, []
    while True:
        name, at = _text(data, at)
        if not name:
            return attributes, channels, at
        kind, at = _text(data, at)
        if at + 4 > len(data):
            raise ExrError("the header ends too early")
        size = struct.unpack_from("<i", data, at)[0]
        at += 4
        if size < 0 or at + size > len(data):
            raise ExrError("the header ends too early")
        raw = data[at:at + size]
        at += size
        if kind == "chlist":
            p = 0
            while p < len(raw) and raw[p] != 0:
                channel, p = _text(raw, p)
                if p + 16 > len(raw):
                    raise ExrError("the list of channels ends too early")
                pixel, _, xs, ys = struct.unpack_from("<iiii", raw, p)
                p += 16
                if pixel not in _TYPES or xs != 1 or ys != 1:
                    raise ExrError("channel %s is of an unknown type or subsampled" % channel)
                channels.append((channel, pixel))
        elif kind == "compression":
            attributes[name] = raw[0] if raw else 0
        else:
            attributes[name] = _attribute(kind, raw)


def _unpredict(packed: bytes) -> bytes:
    """Undoes the delta coding and the splitting of bytes into two halves."""
    b = np.frombuffer(packed, np.uint8).astype(np.int64)
    b[1:] -= 128
    b = np.cumsum(b).astype(np.uint8)
    out = np.empty_like(b)
    half = (len(b) + 1) // 2
    out[0::2], out[1::2] = b[:half], b[half:]
    return out.tobytes()


def _unrle(data: bytes) -> bytes:
    out, at = bytearray(), 0
    while at < len(data):
        n = struct.unpack_from("b", data, at)[0]
        if n < 0:
            out += data[at + 1:at + 1 - n]
            at += 1 - n
        else:
            out += data[at + 1:at + 2] * (n + 1)
            at += 2
    return bytes(out)


def decode(data: bytes) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """({channel: (height, width) array}, attributes)."""
    attributes, channels, at = _header(data)
    window = attributes.get("dataWindow")
    if not isinstance(window, list) or len(window) != 4 or not channels:
        raise ExrError("no data window or no channels")
    x0, y0, x1, y1 = window
    width, height = x1 - x0 + 1, y1 - y0 + 1
    if not (0 < width <= 1 << 16 and 0 < height <= 1 << 16) or width * height * len(channels) > 1 << 31:
        raise ExrError("%d x %d pixels in %d channels" % (width, height, len(channels)))
    compression = attributes.get("compression", 0)
    if compression not in _LINES:
        return _with_openexr(data, attributes)
    out = {name: np.zeros((height, width), _TYPES[pixel]) for name, pixel in channels}
    row_bytes = width * sum(_TYPES[pixel].itemsize for _, pixel in channels)
    block = _LINES[compression]
    for k in range((height + block - 1) // block):
        if at + 8 * (k + 1) > len(data):
            raise ExrError("the file ends too early")
        offset = struct.unpack_from("<Q", data, at + 8 * k)[0]
        if offset + 8 > len(data):
            raise ExrError("the file ends too early")
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(block, y1 - y + 1)
        if y < y0 or y > y1 or size < 0 or offset + 8 + size > len(data):
            raise ExrError("a block of scan lines is broken")
        raw = data[offset + 8:offset + 8 + size]
        expected = row_bytes * lines
        if compression and len(raw) < expected:
            try:
                unpacked = zlib.decompressobj().decompress(raw, expected) if compression >= 2 else _unrle(raw)
            except (zlib.error, struct.error) as e:
                raise ExrError("a block of scan lines is broken: %s" % e) from None
            raw = _unpredict(unpacked)
        if len(raw) != expected:
            raise ExrError("a block of scan lines has %d bytes instead of %d" % (len(raw), expected))
        p = 0
        for line in range(lines):
            for name, pixel in channels:
                dtype = _TYPES[pixel]
                out[name][y - y0 + line] = np.frombuffer(raw, dtype, width, p)
                p += width * dtype.itemsize
    return out, attributes


def _with_openexr(data: bytes, attributes: dict[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    try:
        import OpenEXR
    except ImportError:
        raise ExrError("compression %s needs the OpenEXR package" % attributes.get("compression")) from None
    import os
    import tempfile
    with tempfile.NamedTemporaryFile(suffix=".exr", delete=False) as f:
        f.write(data)
    try:
        with OpenEXR.File(f.name, separate_channels=True) as file:
            return {n: np.array(c.pixels) for n, c in file.channels().items()}, attributes
    finally:
        os.unlink(f.name)


def encode(channels: dict[str, np.ndarray], attributes: dict[str, str] | None = None, origin: tuple[int, int] = (0, 0),
           full: tuple[int, int] | None = None) -> bytes:
    """A ZIP file of these channels: float16 as half, everything else as float. `attributes` are written as strings."""
    if not channels:
        raise ValueError("no channels")
    names = sorted(channels)
    planes = {n: np.asarray(channels[n]) for n in names}
    planes = {n: np.ascontiguousarray(p, "<f2" if p.dtype == np.float16 else "<f4") for n, p in planes.items()}
    height, width = planes[names[0]].shape
    if any(p.shape != (height, width) for p in planes.values()):
        raise ValueError("channels differ in size")
    x0, y0 = origin
    fw, fh = full or (x0 + width, y0 + height)

    def attribute(name: str, kind: str, raw: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(raw)) + raw

    chlist = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 1 if planes[n].dtype.itemsize == 2 else 2, 0, 1, 1) for n in names) + b"\0"
    head = struct.pack("<II", 20000630, 2 | (0x400 if any(len(n) > 31 for n in names) else 0))
    head += attribute("channels", "chlist", chlist) + attribute("compression", "compression", b"\3")
    head += attribute("dataWindow", "box2i", struct.pack("<4i", x0, y0, x0 + width - 1, y0 + height - 1))
    head += attribute("displayWindow", "box2i", struct.pack("<4i", 0, 0, fw - 1, fh - 1))
    head += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    for name, value in (attributes or {}).items():
        head += attribute(name, "string", str(value).encode())
    head += b"\0"
    blocks, offsets = [], []
    at = len(head) + 8 * ((height + 15) // 16)
    for y in range(0, height, 16):
        raw = b"".join(planes[n][line].tobytes() for line in range(y, min(y + 16, height)) for n in names)
        b = np.frombuffer(raw, np.uint8)
        b = np.concatenate([b[0::2], b[1::2]]).astype(np.int64)
        d = np.empty_like(b)
        d[0], d[1:] = b[0], b[1:] - b[:-1] + 128
        packed = zlib.compress((d & 255).astype(np.uint8).tobytes(), 6)
        packed = packed if len(packed) < len(raw) else raw
        offsets.append(at)
        blocks.append(struct.pack("<ii", y0 + y, len(packed)) + packed)
        at += len(blocks[-1])
    return head + struct.pack("<%dQ" % len(offsets), *offsets) + b"".join(blocks)
