// Laws that every registered node obeys, checked from its schema alone: it evaluates with defaults; SIMD, scalar and double
// agree; a uniform input is a varying one with equal values; a point's result depends on neither its batch nor its place in it;
// no input whatever crashes it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/nodes/all_graphs.h"

namespace alder {
namespace {

using namespace test;

template <class Fn>
void for_all_graphs(Fn fn) {
    int compiled = 0;
    for (const NodeType* type : all_nodes()) {
        for (const auto& [label, graph] : graphs(*type))
            if (const auto p = compile(*type, graph)) {
                fn(*type, label, *p);
                ++compiled;
            }
    }
    EXPECT_GT(compiled, 50);
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST(AllNodes, results_do_not_depend_on_batch_or_place) {
    for_all_graphs([](const NodeType&, const std::string& label, const Program& p) {
        const auto a = run<float>(p, Values::Ordinary, 512, false, false), b = run<float>(p, Values::Ordinary, 19, false, false);
        for (size_t r = 0; r < a.size(); ++r)
            for (uint32_t i = 0; i < kPoints; ++i)
                ASSERT_TRUE(same(a[r][i], b[r][i])) << label << " " << results(p)[r].first << " point " << i << ": " << a[r][i] << " and " << b[r][i];
    });
}

TEST(AllNodes, uniform_inputs_are_varying_inputs_with_equal_values) {
    for_all_graphs([](const NodeType&, const std::string& label, const Program& p) {
        const auto u = run<float>(p, Values::Ordinary, 512, false, true);
        const auto v = run<float>(p, Values::Ordinary, 512, false, false);
        for (size_t r = 0; r < u.size(); ++r) ASSERT_TRUE(same(u[r][7], v[r][5])) << label << " " << results(p)[r].first << ": " << u[r][7] << " and " << v[r][5];
    });
}

TEST(AllNodes, simd_scalar_and_double_agree) {
    for (const char* isa : {"sse4", "avx2", "avx512"}) {
        if (!choose_isa(isa)) continue;
        for_all_graphs([&](const NodeType&, const std::string& label, const Program& p) {
            const auto simd = run<float>(p, Values::Ordinary, 512, false, false), scalar = run<float>(p, Values::Ordinary, 512, true, false);
            const auto exact = run<double>(p, Values::Ordinary, 512, false, false);
            for (size_t r = 0; r < simd.size(); ++r) {
                int off_scalar = 0, off_double = 0;
                double worst = 0;
                for (uint32_t i = 0; i < kPoints; ++i) {
                    const double e = exact[r][i], scale = std::max(1.0, std::fabs(e));
                    const double ds = std::fabs(simd[r][i] - scalar[r][i]) / scale, de = std::fabs(simd[r][i] - e) / scale;
                    if (std::isnan(simd[r][i]) != std::isnan(scalar[r][i]) || ds > 1e-4) ++off_scalar;
                    if (std::isnan(simd[r][i]) != std::isnan(e) || de > 2e-4) ++off_double;
                    worst = std::max(worst, std::isnan(de) ? 0 : de);
                }
                // Cell borders, texel borders and hue sextants flip with rounding: a few points may.
                EXPECT_LE(off_scalar, 4) << isa << " " << label << " " << results(p)[r].first << ": SIMD against scalar";
                EXPECT_LE(off_double, 6) << isa << " " << label << " " << results(p)[r].first << ": SIMD against double, worst " << worst;
            }
        });
    }
    choose_isa("");
}

TEST(AllNodes, no_value_crashes_a_node) {
    for_all_graphs([](const NodeType&, const std::string&, const Program& p) {
        run<float>(p, Values::Adversarial, 512, false, false);
        run<float>(p, Values::Adversarial, 512, true, false);
        run<double>(p, Values::Adversarial, 512, false, false);
    });
}

/// Where the original gives infinity or NaN for finite input, and why: nodes, or nodes with one setting. What is not here gives numbers.
const std::map<std::string, std::string>& defined_not_finite() {
    static const std::string kOverflow = "Cycles' formula in floats: the result, or a quotient on its way, is beyond their range";
    static const std::string kZero = "Cycles normalises without a guard: the zero vector has no direction (NaN in the reference tables)";
    static const std::string kPlain = "alShaders, specification 1.1: nothing is clamped, x/0 is infinity, 0/0 is NaN";
    static const std::string kRemap = "alShaders' remap block (specification 1.4): equal ends of the input range, or a gain on values above 1, without clampEnable";
    static const std::map<std::string, std::string> kList = {
        {"ShaderNodeMath operation=DIVIDE", kOverflow}, {"ShaderNodeMath operation=POWER", kOverflow}, {"ShaderNodeMath operation=EXPONENT", kOverflow},
        {"ShaderNodeMath operation=SINH", kOverflow}, {"ShaderNodeMath operation=COSH", kOverflow}, {"ShaderNodeMath operation=SNAP", kOverflow},
        {"ShaderNodeMath operation=FLOORED_MODULO", kOverflow}, {"ShaderNodeMath operation=PINGPONG", kOverflow},
        {"ShaderNodeVectorMath operation=DIVIDE", kOverflow}, {"ShaderNodeVectorMath operation=POWER", kOverflow}, {"ShaderNodeVectorMath operation=SNAP", kOverflow},
        {"ShaderNodeVectorMath operation=WRAP", kOverflow}, {"ShaderNodeVectorMath operation=REFRACT", kOverflow},
        {"ShaderNodeGamma linked", kOverflow}, {"ShaderNodeMixRGB blend_type=DIVIDE", kOverflow},
        {"ShaderNodeSeparateColor mode=HSL", "Cycles divides by the sum of the largest and the smallest component, or by what it lacks to 2: 0 for components of both signs"},
        {"ShaderNodeNormal", kZero}, {"ShaderNodeNormalMap", kZero}, {"ShaderNodeVectorTransform", kZero},
        {"ShaderNodeNewGeometry", kZero + ": on the axis of the generated coordinates"}, {"ShaderNodeTangent", kZero + ": on the axis, or along the normal"},
        {"ShaderNodeCameraData", kZero + ": a point at the camera"},
        {"ShaderNodeTexGabor gabor_type=3D", kZero + "; an orientation along z has no azimuth"},
        {"alColorSpace sourceSpace=Cineon", kPlain}, {"alColorSpace sourceSpace=LogC", kPlain}, {"alCombineColor combineOp=divide 1/2", kPlain},
        {"alCombineFloat combineOp=divide 1/2", kPlain}, {"alLayerColor", kPlain}, {"alLayerFloat", kPlain},
        {"alInputVector coordinates=", kPlain + "; the inclination of |z| > 1"},
        {"alRemapColor", kRemap}, {"alRemapFloat", kRemap}, {"alInputScalar", kRemap}, {"alCellNoise", kRemap}, {"alFlowNoise", kRemap}, {"alFractal", kRemap},
        {"alGaborNoise", kRemap}, {"alPattern", kRemap},
        {"ShaderNodeBsdfPrincipled", "weights of lobes are products of the parameters, in floats; the renderer drops samples that are not finite"},
    };
    return kList;
}

TEST(AllNodes, finite_values_give_finite_results) {
    std::string faults;
    std::map<std::string, int> met;
    const auto listed = [](const std::string& label) {
        for (const auto& [key, why] : defined_not_finite())
            if (label.starts_with(key) && (key.back() == '=' || key.find('=') != std::string::npos || label.size() == key.size() || label[key.size()] == ' ')) return key;
        return std::string();
    };
    for_all_graphs([&](const NodeType&, const std::string& label, const Program& p) {
        const auto list = results(p);
        for (const bool scalar : {false, true}) {
            const auto out = run<float>(p, Values::Extreme, 512, scalar, false);
            for (size_t r = 0; r < out.size(); ++r) {
                const auto bad = std::find_if(out[r].begin(), out[r].end(), [](float v) { return !std::isfinite(v); });
                if (bad == out[r].end()) continue;
                const std::string key = listed(label);
                ++met[key];
                if (!key.empty()) continue;
                faults += label + " " + list[r].first + (scalar ? " scalar" : "") + ": " + std::to_string(*bad) + " at point " + std::to_string(bad - out[r].begin()) + "\n";
            }
        }
    });
    EXPECT_EQ(faults, "");
    for (const auto& [key, why] : defined_not_finite()) EXPECT_TRUE(met.count(key)) << key << " (" << why << ") gives numbers now: take it off the list";
}

TEST(AllNodes, schema_is_complete) {
    for (const NodeType* type : all_nodes()) {
        EXPECT_FALSE(type->summary.empty()) << type->name;
        EXPECT_FALSE(type->outputs.empty()) << type->name;
        EXPECT_TRUE(type->kernel.lanes || type->lower) << type->name;
        std::vector<std::string> names;
        for (const auto& p : type->params) {
            EXPECT_EQ(std::count(names.begin(), names.end(), p.name), 0) << type->name << "." << p.name << " twice";
            names.push_back(p.name);
            if (p.type != Type::Enum) continue;
            EXPECT_TRUE(std::any_of(p.items.begin(), p.items.end(), [&](auto& i) { return i.name == p.text; }))
                << type->name << "." << p.name << ": default " << p.text << " is no item";
        }
        EXPECT_EQ(find_node(type->name), type);
    }
}

}  // namespace
}  // namespace alder
