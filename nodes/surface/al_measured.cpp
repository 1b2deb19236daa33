// alMeasured: reflectance from a file of the MERL database. alshaders specification, section 8.
// How the table is read and sampled: nodes/surface/merl.h, render/closure/measured.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/surface/al_measured.cpp"
#include "hwy/foreach_target.h"

#include <nlohmann/json.hpp>

#include "nodes/kernel-inl.h"
#include "nodes/surface/merl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

struct AlMeasured {  // globals: Nf 0
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        // An unreadable file is refused when the graph is compiled; without a file the surface is black.
        const bool there = k.statics().prepared != nullptr;
        k.set(0, Vec3<F>(there ? F(1) : F(0)));
        k.set(3, k.v(0));
    }
};
template <class F>
void al_measured(const Call<F>& c) { c.template each<AlMeasured>(); }
ALDER_KERNEL(al_measured)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alder {
ALDER_KERNEL_EXPORT(al_measured)

namespace {
std::shared_ptr<const Prepared> prepare_measured(const Statics& s, std::vector<std::string>& errors) {
    const nlohmann::json file = nlohmann::json::parse(s.text[0], nullptr, false);
    const std::string path = file.is_object() && file.contains("file") && file["file"].is_string() ? file["file"].get<std::string>() : "";
    if (path.empty()) return nullptr;
    std::string error;
    auto table = read_merl(path, error);
    if (!table) errors.push_back("filename: " + error);
    return table;
}
}  // namespace

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alMeasured";
    n.system = System::AlShaders;
    n.category = "surface";
    n.summary = "MERL measured reflectance under direct light";
    n.help = "An isotropic table of 90 x 90 x 180 values per channel, by half and difference angles, without interpolation; negative values "
             "count as 0. Unlike the original it scatters indirect light too, and refuses a file that it cannot read.";
    n.params = {image("filename").doc("a .binary file of the MERL database")};
    n.outputs = {{"out", Type::Closure}};
    n.globals = {Global::Nf};
    n.kernel = al_measured_kernel();
    n.cost_ns = 1;
    n.prepare = prepare_measured;
    n.lobes = [](const Statics&) -> std::vector<LobeSpec> { return {{.kind = LobeKind::Measured, .label = LobeLabel::Specular}}; };
    return n;
}
}  // namespace alder
#endif
