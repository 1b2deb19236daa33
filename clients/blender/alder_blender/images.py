"""Images of node trees: their files, packed or beside the .blend, into the container, each once."""
import hashlib
import os
import tempfile

import bpy

SUFFIXES = {"BMP": ".bmp", "PNG": ".png", "JPEG": ".jpg", "JPEG2000": ".jp2", "TARGA": ".tga", "TARGA_RAW": ".tga", "CINEON": ".cin",
            "DPX": ".dpx", "OPEN_EXR": ".exr", "OPEN_EXR_MULTILAYER": ".exr", "HDR": ".hdr", "TIFF": ".tif", "WEBP": ".webp", "IRIS": ".rgb"}


class Images:
    def __init__(self, box, report):
        self.box = box
        self.report = report
        self._done = {}

    def parameter(self, image, user, where):
        """What an image parameter says, or None: then the node shows what a missing image does."""
        frame = user.frame_current if user is not None and image.source == "SEQUENCE" else 0
        key = (image.name_full, frame)
        if key not in self._done:
            data, suffix = self._bytes(image, user, where)
            self._done[key] = self._member(image, data, suffix) if data is not None else None
        member = self._done[key]
        if member is None:
            return None
        return {**self.box.reference(member), "colorspace": image.colorspace_settings.name, "alpha_mode": image.alpha_mode}

    def file(self, path, where):
        """An IES profile outside the .blend."""
        data = self._read(bpy.path.abspath(path), where)
        if data is None:
            return None
        name = "files/" + os.path.basename(path)
        self.box.file(name, data)
        return self.box.reference(name)

    def _member(self, image, data, suffix):
        stem = os.path.splitext(bpy.path.clean_name(bpy.path.basename(image.filepath) or image.name))[0]
        name = "images/%s-%s%s" % (stem[:40] or "image", hashlib.sha256(data).hexdigest()[:12], suffix)
        if not self.box.has(name):
            self.box.file(name, data)
        return name

    def _bytes(self, image, user, where):
        suffix = SUFFIXES.get(image.file_format, ".png")
        if image.source == "TILED":
            self.report.unsupported("image of tiles (UDIM)", image.name)
            return None, None
        if image.source in ("MOVIE", "VIEWER"):
            self.report.unsupported("image from a %s" % image.source.lower(), image.name)
            return None, None
        if image.source == "GENERATED" or image.is_dirty:
            return self._pixels(image)
        if image.source == "SEQUENCE":
            path = bpy.path.abspath(image.filepath_from_user(image_user=user), library=image.library)
        else:
            if image.packed_file is not None:
                data = bytes(image.packed_file.data)
                return data, self._suffix(data, os.path.splitext(image.filepath)[1] or suffix)
            path = bpy.path.abspath(image.filepath, library=image.library)
        data = self._read(path, where)
        return data, os.path.splitext(path)[1] or suffix

    @staticmethod
    def _suffix(data, otherwise):
        """By what the bytes are: the name may be of a file that was converted since."""
        for magic, suffix in ((b"\x76\x2f\x31\x01", ".exr"), (b"\x89PNG", ".png"), (b"\xff\xd8\xff", ".jpg"), (b"#?", ".hdr")):
            if data.startswith(magic):
                return suffix
        return otherwise.lower()

    def _read(self, path, where):
        try:
            with open(path, "rb") as f:
                return f.read()
        except OSError as e:
            self.report.unsupported("file that cannot be read: %s" % (e.strerror or e), "%s: %s" % (where, path))
            return None

    def _pixels(self, image):
        """Painted or generated pixels, through Blender's own writer."""
        suffix, kind = (".exr", "OPEN_EXR") if image.is_float else (".png", "PNG")
        copy = image.copy()
        try:
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "image" + suffix)
                copy.file_format = kind
                copy.filepath_raw = path
                copy.save()
                with open(path, "rb") as f:
                    return f.read(), suffix
        except RuntimeError as e:
            self.report.unsupported("generated image that Blender cannot save: %s" % e, image.name)
            return None, None
        finally:
            bpy.data.images.remove(copy)
