// alCel: passes a surface on. The ramp over its direct diffuse light, which the original applies on camera rays, is refused.
// alshaders specification, section 8.
#include "graph/lowering.h"
#include "nodes/surface/al_params.h"

namespace alder {
namespace al_cel {
using namespace al;

constexpr std::string_view kNoEffect = "no effect: it belongs to the ramp, which is not available";
inline constexpr std::array kRows{
    closure("surfaceShader", "Shading", "Surface shader", "surface to pass on; a colour is light emitted"),
    f("diffuseDirectStrength", 0.75, "Shading", "Diffuse strength", kNoEffect),
    color("diffuseRamp", 0, 0, 0, "Shading", "Diffuse ramp",
        "a link would replace the direct diffuse light by a ramp of it: not available, since light arrives one sample at a time; a constant has no effect"),
    f("diffuseIndirectStrength", 1, "Shading", "Indirect diffuse strength", kNoEffect),
    f("diffuseIndirectSaturation", 1, "Shading", "Indirect diffuse saturation", kNoEffect),
    color("diffuseIndirectTint", 1, 1, 1, "Shading", "Indirect diffuse tint", kNoEffect),
    string("aov_direct_diffuse_cel", "direct_diffuse_cel", "AOVs", "Cel Diffuse", kNoEffect),
    string("aov_direct_diffuse_raw_cel", "direct_diffuse_raw_cel", "AOVs", "Cel Raw Diffuse", kNoEffect),
    string("aov_indirect_diffuse_cel", "indirect_diffuse_cel", "AOVs", "Cel Indirect Diffuse", kNoEffect),
    b("aiEnableMatte", false, "", "", "for exporters; no effect").fixed(),
    color("aiMatteColor", 0, 0, 0, "", "", "for exporters; no effect").fixed(),
    f("aiMatteColorA", 0, "", "", "for exporters; no effect").fixed(),
};
constexpr int kSurface = index_of(kRows, "surfaceShader"), kRamp = index_of(kRows, "diffuseRamp");

void lower(Lowering& l, int) { l.pass_closure(kSurface, {}); }

void check(const Statics& s, const std::vector<const double*>&, std::vector<std::string>& errors) {
    if (s.linked[kRamp]) errors.push_back("diffuseRamp: no link: a ramp over the direct diffuse light is not available");
}
}  // namespace al_cel

ALDER_NODE {
    NodeType n;
    n.name = "alCel";
    n.system = System::AlShaders;
    n.category = "surface-post";
    n.summary = "replaces a surface shader's direct diffuse by a ramp look-up on camera rays";
    n.help = "Without a ramp the original passes its surface on unchanged, and so does this. A linked ramp is refused.";
    for (const AlParam& row : al_cel::kRows) n.params.push_back(al::make_param(row));
    n.outputs = {{"out", Type::Closure}};
    n.lower = al_cel::lower;
    n.check = al_cel::check;
    n.uses = [](const Statics&, int p) { return p == al_cel::kSurface || p == al_cel::kRamp; };
    return n;
}
}  // namespace alder
