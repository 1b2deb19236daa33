"""Arrays and files of a scene, and the .alder container that holds them: a ZIP archive of stored members without times."""
import json
import zipfile

import numpy as np

BUFFER = "geometry.bin"
TYPES = {np.dtype("<f4"): "f32", np.dtype("<u4"): "u32", np.dtype("<u2"): "u16", np.dtype("u1"): "u8"}
ALIGN = 16


class Container:
    def __init__(self):
        self._arrays = []
        self._bytes = 0
        self._files = {}

    def array(self, values, channels):
        """Takes the array (not a copy); gives what the document says in its place."""
        values = np.ascontiguousarray(values)
        if values.dtype.newbyteorder("<") not in TYPES:
            raise TypeError("no array type for %s" % values.dtype)
        values = values.astype(values.dtype.newbyteorder("<"), copy=False)
        self._bytes += -self._bytes % ALIGN
        offset = self._bytes
        self._arrays.append((offset, values))
        self._bytes += values.nbytes
        return {"buffer": BUFFER, "type": TYPES[values.dtype], "offset": offset, "count": values.size // channels}

    def file(self, name, data):
        self._files[name] = data

    def has(self, name):
        return name in self._files

    @staticmethod
    def reference(name):
        """How the document names a file that was given under this name."""
        return {"file": name}

    def write(self, path, document):
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as z:
            z.writestr(_member("scene.json"), json.dumps(document, separators=(",", ":"), allow_nan=False, ensure_ascii=False))
            for name, data in sorted(self._files.items()):
                z.writestr(_member(name), data)
            if not self._bytes:
                return
            at = 0
            with z.open(_member(BUFFER), "w", force_zip64=self._bytes > 1 << 30) as out:
                for offset, values in self._arrays:
                    out.write(bytes(offset - at))
                    out.write(memoryview(values).cast("B") if values.size else b"")
                    at = offset + values.nbytes


def _member(name):
    info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    info.compress_type = zipfile.ZIP_STORED
    info.external_attr = 0o644 << 16
    return info
