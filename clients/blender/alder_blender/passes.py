"""Blender's passes from Alder's layers: which layers each needs, and how it is made of them. Without Blender in it.

Light passes are divided by their colour pass, as Cycles' are, so that Blender's compositor puts the picture together again.
"""

# pass -> (channels, letters, layers that are added, layer that divides or None)
LIGHT = {
    "DiffDir": (["direct_diffuse"], "diffuse_color"), "DiffInd": (["indirect_diffuse", "sss"], "diffuse_color"),
    "GlossDir": (["direct_specular", "direct_specular_2"], "specular_color"), "GlossInd": (["indirect_specular", "indirect_specular_2"], "specular_color"),
    "TransDir": (["direct_refraction", "direct_backlight"], "refraction_color"), "TransInd": (["indirect_refraction", "indirect_backlight"], "refraction_color"),
    "VolumeDir": (["direct_volume", "single_scatter"], None), "VolumeInd": (["indirect_volume"], None),
    "Emit": (["emission"], None), "Env": (["background"], None),
    "DiffCol": (["diffuse_color"], None), "GlossCol": (["specular_color"], None), "TransCol": (["refraction_color"], None),
}
DATA = {"Depth": "Z", "Normal": "N", "Position": "P", "UV": "uv", "Denoising Albedo": "denoise_albedo", "Denoising Normal": "denoise_normal",
        "Debug Sample Count": "sample_count"}
# Passes that a renderer may make by Blender's own name. One that does not know the name answers with three channels of black.
NAMED = {"Mist": (1, "Z"), "Vector": (4, "XYZW"), "IndexOB": (1, "X"), "IndexMA": (1, "X")}
NAMED_SWITCHES = {"use_pass_mist": "Mist", "use_pass_vector": "Vector", "use_pass_object_index": "IndexOB", "use_pass_material_index": "IndexMA"}
MATTES = {"use_pass_cryptomatte_object": "CryptoObject", "use_pass_cryptomatte_material": "CryptoMaterial", "use_pass_cryptomatte_asset": "CryptoAsset"}
UNSUPPORTED = {"use_pass_shadow": "Shadow", "use_pass_ambient_occlusion": "AO"}
SWITCHES = {"use_pass_z": "Depth", "use_pass_normal": "Normal", "use_pass_position": "Position", "use_pass_uv": "UV",
            "use_pass_diffuse_direct": "DiffDir", "use_pass_diffuse_indirect": "DiffInd", "use_pass_diffuse_color": "DiffCol",
            "use_pass_glossy_direct": "GlossDir", "use_pass_glossy_indirect": "GlossInd", "use_pass_glossy_color": "GlossCol",
            "use_pass_transmission_direct": "TransDir", "use_pass_transmission_indirect": "TransInd", "use_pass_transmission_color": "TransCol",
            "use_pass_emit": "Emit", "use_pass_environment": "Env"}
CYCLES_SWITCHES = {"use_pass_volume_direct": "VolumeDir", "use_pass_volume_indirect": "VolumeInd", "pass_debug_sample_count": "Debug Sample Count"}


NOISY = "Noisy Image"   # Combined before it is denoised


def channels(name):
    """(number, letters, type) of a pass as Blender's register_pass and add_pass want them."""
    if name.startswith("Combined") or name == NOISY:
        return (4, "RGBA", "COLOR") if name in ("Combined", NOISY) else (3, "RGB", "COLOR")
    if name in NAMED:
        return (*NAMED[name], "VALUE" if NAMED[name][0] == 1 else "VECTOR")
    if name.startswith("Crypto"):
        return (4, "RGBA", "COLOR")
    if name in ("Depth", "Debug Sample Count"):
        return (1, "Z" if name == "Depth" else "X", "VALUE")
    if name in ("Normal", "Position", "Denoising Normal"):
        return (3, "XYZ", "VECTOR")
    if name == "UV":
        return (3, "UVA", "VECTOR")
    return (3, "RGB", "COLOR")


def wanted(view_layer, light_groups=()):
    """(passes of the view layer that Alder makes, those that it does not)."""
    names = ["Combined"]
    names += [p for switch, p in SWITCHES.items() if getattr(view_layer, switch, False)]
    cycles = getattr(view_layer, "cycles", None)
    names += [p for switch, p in CYCLES_SWITCHES.items() if getattr(cycles, switch, False)]
    names += [p for switch, p in NAMED_SWITCHES.items() if getattr(view_layer, switch, False)]
    for switch, name in MATTES.items():
        if getattr(view_layer, switch, False):
            names += [name + "%02d" % i for i in range((getattr(view_layer, "pass_cryptomatte_depth", 6) + 1) // 2)]
    if getattr(cycles, "denoising_store_passes", False):
        names += ["Denoising Normal", "Denoising Albedo", NOISY]
    names += ["Combined_" + g for g in light_groups]
    missing = [p for switch, p in UNSUPPORTED.items() if getattr(view_layer, switch, False)]
    return names, missing


# Passes that Blender adds by itself where the view layer asks for them; others an engine has to add.
def is_own(name):
    return name == "Combined" or name in SWITCHES.values() or name in NAMED


def layers(names, light_groups=()):
    """Alder's layers that these passes need, for --aov or "aovs"."""
    groups = {"Combined_" + g: "light_group_%d" % (i + 1) for i, g in enumerate(light_groups)}
    out = []
    for name in names:
        if name in LIGHT:
            parts, divisor = LIGHT[name]
            out += parts + ([divisor] if divisor else [])
        elif name in DATA:
            out.append(DATA[name])
        elif name in groups:
            out.append(groups[name])
        elif name in NAMED:
            out.append(name)
        elif name.startswith("Crypto"):
            out.append(name[:-2])
    return list(dict.fromkeys(out))


def compose(name, image, light_groups=()):
    """The pass as an array (height, width, channels), rows from the top; None where the image lacks what it needs."""
    import numpy as np
    count = channels(name)[0]

    def layer(key):
        return image[key] if key in image else None
    if name in NAMED or name.startswith("Crypto"):
        x = layer(name)
        x = x[..., None] if x is not None and x.ndim == 2 else x
        if name.startswith("Crypto") and x is not None and x.shape[-1] == 3:   # Image leaves out what is called A
            x = np.concatenate([x, image.channels[name + (".a" if name + ".a" in image.channels else ".A")][..., None]], axis=-1)
        return x if x is not None and x.shape[-1] == count else None
    if name in ("Combined", NOISY):
        alpha = image.alpha
        rgb = image["beauty"]
        return np.concatenate([rgb, (np.ones(rgb.shape[:2], np.float32) if alpha is None else alpha)[..., None]], axis=-1)
    if name in LIGHT:
        parts, divisor = LIGHT[name]
        found = [x for x in (layer(p) for p in parts) if x is not None]
        if not found:
            return None
        total = sum(found)
        if divisor:
            color = layer(divisor)
            if color is None:
                return None
            total = np.where(color > 1e-7, total / np.maximum(color, 1e-7), 0).astype(np.float32)
        return total
    key = DATA.get(name)
    if key is None and name.startswith("Combined_") and name[9:] in light_groups:
        key = "light_group_%d" % (list(light_groups).index(name[9:]) + 1)
    x = layer(key) if key else None
    if x is None:
        return None
    if x.ndim == 2:
        x = x[..., None]
    if x.shape[-1] < count:   # uv: Blender's third channel says that something is there
        hit = (np.abs(x).max(axis=-1, keepdims=True) > 0).astype(np.float32)
        x = np.concatenate([x, np.repeat(hit, count - x.shape[-1], axis=-1)], axis=-1)
    return x[..., :count]
