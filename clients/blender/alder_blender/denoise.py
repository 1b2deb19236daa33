"""Denoising of a finished picture with the OpenImageDenoise that Blender itself brings, through its C interface. Without Blender in it.

Versions 1 and 2 of the library are understood. Some builds of Blender, Debian's among them, come without it.
"""
import ctypes
import ctypes.util
import glob
import os

FLOAT3 = 3   # OIDN_FORMAT_FLOAT3
NAMES = ("libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "OpenImageDenoise.dll", "libOpenImageDenoise.dylib")


class DenoiseError(Exception):
    """The picture stays as it was; the message says why."""


def find_library(folders=()):
    """The library, or None. A Blender that is linked with it has it in memory already, found by its name alone."""
    paths = list(NAMES)
    for folder in folders:
        for pattern in ("libOpenImageDenoise.so.?", "*/OpenImageDenoise.dll", "OpenImageDenoise.dll", "libOpenImageDenoise*.dylib"):
            paths += sorted(glob.glob(os.path.join(folder, pattern)))
    for path in [*paths, ctypes.util.find_library("OpenImageDenoise") or ""]:
        if path:
            try:
                return _declared(ctypes.CDLL(path))
            except (OSError, AttributeError):
                continue
    return None


def blender_folders(bpy):
    """Where Blender, or Blender as a Python module, keeps its libraries."""
    places = [os.path.dirname(p) for p in (bpy.app.binary_path, getattr(bpy, "__file__", "") or "") if p]
    return [os.path.join(p, f) for p in places for f in ("lib", "", "../Resources/lib", "blender.shared")]


def _declared(lib):
    handle, text = ctypes.c_void_p, ctypes.c_char_p
    for name, result, arguments in (
            ("oidnNewDevice", handle, [ctypes.c_int]), ("oidnCommitDevice", None, [handle]), ("oidnReleaseDevice", None, [handle]),
            ("oidnGetDeviceError", ctypes.c_int, [handle, ctypes.POINTER(text)]), ("oidnNewFilter", handle, [handle, text]),
            ("oidnSetSharedFilterImage", None, [handle, text, ctypes.c_void_p, ctypes.c_int] + [ctypes.c_size_t] * 5),
            ("oidnCommitFilter", None, [handle]), ("oidnExecuteFilter", None, [handle]), ("oidnReleaseFilter", None, [handle])):
        function = getattr(lib, name)
        function.restype, function.argtypes = result, arguments
    lib.set_bool = lib.oidnSetFilterBool if hasattr(lib, "oidnSetFilterBool") else lib.oidnSetFilter1b   # version 2 | 1
    lib.set_bool.restype, lib.set_bool.argtypes = None, [handle, text, ctypes.c_bool]
    return lib


class Denoiser:
    CPU = 1   # OIDN_DEVICE_TYPE_CPU: the same picture on every machine

    def __init__(self, library):
        self.lib = library
        self.device = library.oidnNewDevice(self.CPU)
        if not self.device:
            raise DenoiseError("OpenImageDenoise has no device on this machine")
        library.oidnCommitDevice(self.device)
        self._check()

    def _check(self):
        message = ctypes.c_char_p()
        if self.lib.oidnGetDeviceError(self.device, ctypes.byref(message)):
            raise DenoiseError("OpenImageDenoise: %s" % (message.value or b"unknown error").decode("utf-8", "replace"))

    def _filter(self, images, **flags):
        import numpy as np
        lib = self.lib
        height, width = next(iter(images.values())).shape[:2]
        # Where the input is not finite the filter would spread it.
        inputs = {k: np.ascontiguousarray(np.nan_to_num(v[..., :3], nan=0, posinf=0, neginf=0), np.float32) for k, v in images.items()}
        output = np.empty((height, width, 3), np.float32)
        handle = lib.oidnNewFilter(self.device, b"RT")
        self._check()
        try:
            for name, pixels in [*inputs.items(), ("output", output)]:
                lib.oidnSetSharedFilterImage(handle, name.encode(), pixels.ctypes.data, FLOAT3, width, height, 0, 12, 12 * width)
            for name, on in flags.items():
                lib.set_bool(handle, name.encode(), on)
            lib.oidnCommitFilter(handle)
            lib.oidnExecuteFilter(handle)
            self._check()
        finally:
            lib.oidnReleaseFilter(handle)
        return output

    def denoise(self, color, albedo=None, normal=None, prefilter=True):
        """The colour (h, w, 3) without noise; albedo and normal keep its edges, and are denoised themselves first where they are noisy."""
        images = {"color": color}
        if albedo is not None:
            images["albedo"] = self._filter({"albedo": albedo}) if prefilter else albedo
            if normal is not None:   # the filter takes none without albedo
                images["normal"] = self._filter({"normal": normal}) if prefilter else normal
        return self._filter(images, hdr=True, cleanAux=prefilter and "albedo" in images)

    def close(self):
        if self.device:
            self.lib.oidnReleaseDevice(self.device)
            self.device = None
