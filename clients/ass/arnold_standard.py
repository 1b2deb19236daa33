"""Arnold's `standard` surface as alSurface: what has a counterpart is carried over, and what is only near is reported.

Both square their roughness and both use Cook-Torrance with a Beckmann distribution, so `specular_roughness` carries over as it
is: alShaders' own test pair (ai_bplastic, als_bplastic) sets the same value in both.
"""
import math

# Used with the values on the right they do nothing, so there is nothing to carry over.
NEUTRAL = {
    "direct_specular": 1, "direct_diffuse": 1, "reflection_exit_use_environment": False,
    "refraction_exit_use_environment": False, "bounce_factor": 1, "dispersion_abbe": 0,
}
# Read only together with others that are handled, or names of AOVs, which a render request chooses.
SILENT = {"Phong_exponent", "reflection_exit_color", "refraction_exit_color"}
# Parts and the parameters (by prefix) that only they read.
PARTS = {
    "Ks": ("specular_", "Ksn", "Fresnel_affect_diff", "indirect_specular", "enable_glossy_caustics"),
    "Kr": ("Kr", "Fresnel", "enable_reflective_caustics"),
    "Kt": ("Kt", "refraction_", "IOR", "transmittance", "enable_refractive_caustics"),
    "Ksss": ("Ksss", "sss_radius"),
}
METAL_IOR = 1000.0  # reflectance 0.996 at every angle: how alShaders' own scenes say "metal"


def ior_of(f0):
    """Index of refraction with the reflectance f0 seen straight on."""
    root = max(0.0, min(f0, 0.99)) ** 0.5
    return (1 + root) / (1 - root)


class Standard:
    def __init__(self, get, report):
        """get(name, default) gives a constant or a link (a dict); report(name, text) tells the user."""
        self.get, self.report, self.out = get, report, {}

    def is_off(self, name, default=0):
        return self.get(name, default) == 0

    def constant(self, name, default):
        value = self.get(name, default)
        if isinstance(value, dict):
            self.report(name, "linked; its default %s is used" % default)
            return default
        return value

    def convert(self):
        self.diffuse()
        self.specular()
        self.mirror()
        self.transmission()
        get, out = self.get, self.out
        out["emissionStrength"] = get("emission", 0)
        out["emissionColor"] = get("emission_color", [1, 1, 1])
        out["opacity"] = get("opacity", [1, 1, 1])
        for name, neutral in NEUTRAL.items():
            if get(name, neutral) != neutral:
                self.report(name, "has no counterpart in alSurface and is left out")
        return out

    def diffuse(self):
        get, out = self.get, self.out
        out["diffuseStrength"], out["diffuseColor"] = get("Kd", 0.7), get("Kd_color", [1, 1, 1])
        out["diffuseRoughness"] = get("diffuse_roughness", 0)
        out["diffuseIndirectStrength"] = get("indirect_diffuse", 1)
        if not self.is_off("Kb"):
            out["backlightStrength"], out["backlightColor"] = get("Kb", 0), get("Kd_color", [1, 1, 1])
        if not self.is_off("Ksss"):
            kd, ksss = self.constant("Kd", 0.7), self.constant("Ksss", 0)
            self.report("Ksss", "becomes a share of the diffuse colour (sssMix)")
            out["diffuseStrength"], out["sssMix"] = kd + ksss, ksss / (kd + ksss) if kd + ksss else 0
            if kd == 0:
                out["diffuseColor"] = get("Ksss_color", [1, 1, 1])
            out["sssRadius"], out["sssRadiusColor"] = 1, get("sss_radius", [0.1, 0.1, 0.1])

    def specular(self):
        get, out = self.get, self.out
        out["specular1Strength"], out["specular1Color"] = get("Ks", 0), get("Ks_color", [1, 1, 1])
        if self.is_off("Ks"):
            return
        out["specular1Roughness"] = get("specular_roughness", 0.466905)
        out["specular1Anisotropy"], out["specular1Rotation"] = get("specular_anisotropy", 0.5), get("specular_rotation", 0)
        out["specular1IndirectStrength"] = get("indirect_specular", 1)
        out["specular1CausticPaths"] = self.constant("enable_glossy_caustics", False)
        out["specular1Distribution"] = "beckmann"
        if self.constant("specular_brdf", "cook_torrance") != "cook_torrance":
            self.report("specular_brdf", "Beckmann takes the place of %s" % get("specular_brdf", ""))
        out["specular1Ior"] = self.fresnel("specular_Fresnel", "Ksn")
        if not self.constant("Fresnel_affect_diff", True):
            self.report("Fresnel_affect_diff", "off has no counterpart: what the specular reflects is taken from diffuse")

    def mirror(self):
        """Mirror reflection Kr goes to the second specular, below the first."""
        get, out = self.get, self.out
        if self.is_off("Kr"):
            return
        self.report("Kr", "becomes specular 2 with roughness 0")
        out["specular2Strength"], out["specular2Color"] = get("Kr", 0), get("Kr_color", [1, 1, 1])
        out["specular2Roughness"] = 0
        out["specular2CausticPaths"] = self.constant("enable_reflective_caustics", False)
        out["specular2Ior"] = self.fresnel("Fresnel", "Krn")

    def fresnel(self, switch, straight):
        if not self.constant(switch, False):
            self.report(switch, "off: reflectance that does not depend on the angle becomes index %g" % METAL_IOR)
            return METAL_IOR
        if self.constant("Fresnel_use_IOR", False):
            return self.get("IOR", 1)
        f0 = self.constant(straight, 0)
        self.report(straight, "Schlick's curve from %g becomes the exact one of index %.4g" % (f0, ior_of(f0)))
        return ior_of(f0)

    def transmission(self):
        get, out = self.get, self.out
        out["transmissionEnableCaustics"] = self.constant("enable_internal_reflections", True)
        if self.is_off("Kt"):
            return
        out["transmissionStrength"], out["transmissionColor"] = get("Kt", 0), get("Kt_color", [1, 1, 1])
        out["transmissionLinkToSpecular1"] = False
        out["transmissionRoughness"], out["transmissionIor"] = get("refraction_roughness", 0), get("IOR", 1)
        out["transmissionCausticPaths"] = self.constant("enable_refractive_caustics", False)
        transmittance = self.constant("transmittance", [1, 1, 1])
        if transmittance != [1, 1, 1]:
            self.report("transmittance", "becomes absorption coefficients (per unit of length)")
            out["ssSpecifyCoefficients"], out["ssScattering"] = True, [0, 0, 0]
            out["ssAbsorption"] = [-math.log(max(c, 1e-6)) for c in transmittance]


    def without_effect(self, param):
        """Whether a parameter that the conversion did not ask for belongs to a part that is off, or to a switch that is."""
        return any(param.startswith(prefix) for prefixes in PARTS.values() for prefix in prefixes)
