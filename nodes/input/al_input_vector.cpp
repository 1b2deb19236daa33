// alInputVector: a vector known at the shading point, transformed, optionally as spherical coordinates.
// alshaders specification, section 3.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes/input/al_input_vector.cpp"
#include "hwy/foreach_target.h"

#include "nodes/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

/// Operands: a row vector and the four rows of a matrix, the last being the translation (zero for directions).
struct TransformRow {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> p = k.v(0);
        k.set(0, k.v(3) * p.x + k.v(6) * p.y + k.v(9) * p.z + k.v(12));
    }
};
/// (azimuth, inclination, 0). The azimuth is taken from z and x, as in the original; |z| > 1 gives NaN.
struct Spherical {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> p = k.v(0);
        k.set(0, Vec3<F>(atan2(p.z, p.x), acos(p.z), F(0)));
    }
};
struct UnitSpherical {
    template <class F>
    static HWY_INLINE void run(Lanes<F> k) {
        const Vec3<F> p = k.v(0);
        k.set(0, Vec3<F>(atan2(p.z, p.x) * F(0.15915494309189533577) + F(0.5), acos(p.z) * F(0.31830988618379067154), F(0)));
    }
};
template <class F>
void transform_row(const Call<F>& c) { c.template each<TransformRow>(); }
template <class F>
void spherical(const Call<F>& c) { c.template each<Spherical>(); }
template <class F>
void unit_spherical(const Call<F>& c) { c.template each<UnitSpherical>(); }
ALDER_KERNEL(transform_row)
ALDER_KERNEL(spherical)
ALDER_KERNEL(unit_spherical)

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <nlohmann/json.hpp>

#include "graph/lowering.h"

namespace alder {
ALDER_KERNEL_EXPORT(transform_row)
ALDER_KERNEL_EXPORT(spherical)
ALDER_KERNEL_EXPORT(unit_spherical)

enum InputVectorParam { kInput, kVectorType, kUserName, kVector, kMatrix, kCoordinates };
enum { kUser = 12, kCustom = 13 };
static constexpr Global kSources[] = {Global::P,  Global::Po,   Global::Nu,   Global::Nf, Global::Ngu, Global::Ngf,
                                      Global::Ns, Global::Dpdu, Global::Dpdv, Global::Ld, Global::Rd,  Global::Uv};

static ValueRef vector_of(Lowering& l) {
    const int source = l.statics().e(kInput);
    if (source < kUser) return l.global(kSources[source]);
    const std::string& name = l.statics().text[kUserName];
    if (source == kCustom || name.empty()) return l.input(kVector);
    return l.attribute_or(name, Type::Vector, l.input(kVector));
}
static std::array<double, 16> matrix_of(const Statics& s) {
    std::array<double, 16> m{};
    const auto numbers = nlohmann::json::parse(s.text[kMatrix], nullptr, false);
    for (size_t i = 0; i < 16 && numbers.is_array() && i < numbers.size(); ++i)
        m[i] = numbers[i].is_number() ? numbers[i].get<double>() : std::numeric_limits<double>::quiet_NaN();
    return m;
}
static void lower_input_vector(Lowering& l, int) {
    static constexpr std::array<double, 16> kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    ValueRef v = vector_of(l);
    std::array<double, 16> m = matrix_of(l.statics());
    if (l.statics().e(kVectorType) == 1) m[12] = m[13] = m[14] = 0;
    m[3] = m[7] = m[11] = 0, m[15] = 1;   // there is no division by w
    if (m != kIdentity) {
        const ValueRef operands[] = {v, l.constant(Type::Vector, m[0], m[1], m[2]), l.constant(Type::Vector, m[4], m[5], m[6]),
                                     l.constant(Type::Vector, m[8], m[9], m[10]), l.constant(Type::Vector, m[12], m[13], m[14])};
        v = l.op("transform_row", transform_row_kernel(), operands, Type::Vector);
    }
    const ValueRef operand[] = {v};
    switch (l.statics().e(kCoordinates)) {
        case 1: v = l.op("spherical", spherical_kernel(), operand, Type::Vector); break;
        case 2: v = l.op("unit_spherical", unit_spherical_kernel(), operand, Type::Vector); break;
        default: break;
    }
    l.result(v);
}
static bool input_vector_uses(const Statics& s, int param) {
    if (param == kUserName) return s.e(kInput) == kUser;
    return param != kVector || s.e(kInput) >= kUser;
}

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alInputVector";
    n.system = System::AlShaders;
    n.category = "geometry";
    n.summary = "shading vectors, transformed and optionally made spherical";
    n.help = "Row vectors: the matrix's last row is the translation, left out for type Vector. Spherical coordinates are (azimuth, inclination, 0) "
             "with the azimuth from z and x, as in the original; the vector is not normalised first.";
    n.params = {choice("input", {"P", "Po", "N", "Nf", "Ng", "Ngf", "Ns", "dPdu", "dPdv", "Ld", "Rd", "uv", "User", "Custom"}, "P").doc("which vector"),
                choice("type", {"Point", "Vector"}, "Point").doc("whether the matrix's translation applies"),
                string("userName").doc("User: name of a point attribute; `vector` where it is missing"),
                vector("vector", 0, 0, 0).doc("the vector of Custom"), matrix("matrix").in("Transform").doc("row-vector transform"),
                choice("coordinates", {"cartesian", "spherical", "normalized spherical"}, "cartesian").in("Transform").doc("form of the result")};
    n.outputs = {{"out", Type::Vector}};
    n.cost_ns = 2;
    n.uses = input_vector_uses;
    n.lower = lower_input_vector;
    return n;
}
}  // namespace alder
#endif
