// Closure nodes of Cycles: the same lobes from every path, weights that vanish, what the schema promises.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "nodes/schema.h"
#include "tests/render/closure/material_lobes.h"

namespace alder {
namespace {

using nlohmann::json;
using testing::MaterialLobes;

const char* const kNodes[] = {"ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfTranslucent", "ShaderNodeBsdfSheen",
                              "ShaderNodeBsdfToon", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfMetallic", "ShaderNodeBsdfGlass",
                              "ShaderNodeBsdfRefraction", "ShaderNodeEmission", "ShaderNodeBackground", "ShaderNodeBsdfTransparent"};

ShadingView<double> view_from(double x, double z) {
    return {normalize(Vec3d(x, 0.2, z)), Vec3d(0, 0, 1), Vec3d(0, 0, 1)};
}

/// One kernel run on random operands; returns all output channels of all points.
template <class R>
std::vector<std::vector<R>> run_kernel(const NodeType& type, const Statics& statics, void (*kernel)(const OpCall<R>&),
                                       const std::vector<std::vector<double>>& in, uint32_t n) {
    const size_t padded = (n + kPadding - 1) / kPadding * kPadding;
    std::vector<std::vector<R>> operands, out;
    std::vector<Channel<R>> channels;
    for (const auto& c : in) {
        operands.emplace_back(padded, std::numeric_limits<R>::quiet_NaN());
        for (size_t i = 0; i < n; ++i) operands.back()[i] = static_cast<R>(c[i]);
        channels.push_back({operands.back().data(), 1});
    }
    int count = 0;
    for (const LobeSpec& l : statics.lobes) count += l.channels();
    out.assign(count, std::vector<R>(padded, R(0)));
    std::vector<R*> p;
    for (auto& o : out) p.push_back(o.data());
    const EvalContext context;
    kernel({channels.data(), p.data(), &statics, &context, n});
    (void)type;
    return out;
}

Statics statics_of(const NodeType& type, int choice) {
    Statics s;
    s.type = &type;
    for (const Param& p : type.params) {
        s.enums.push_back(p.items.empty() ? 0 : choice % static_cast<int>(p.items.size()));
        s.text.push_back(p.text);
        s.linked.push_back(channels(p.type) > 0);
        s.zero.push_back(false);
        s.one.push_back(false);
        s.at_default.push_back(false);
    }
    s.lobes = type.lobes(s);
    int offset = 0;
    for (const LobeSpec& l : s.lobes) {
        s.lobe_offset.push_back(offset);
        offset += l.channels();
    }
    return s;
}

/// Random operands: parameters in and around their range, globals as a shading point has them.
std::vector<std::vector<double>> random_operands(const NodeType& type, uint32_t n, unsigned seed, double spread) {
    std::mt19937 engine(seed);
    const auto uniform = [&](double lo, double hi) { return lo + (hi - lo) * (engine() * 0x1p-32); };
    std::vector<std::vector<double>> in;
    const auto add = [&](auto value) {
        in.emplace_back(n);
        for (double& x : in.back()) x = static_cast<float>(value());
    };
    for (const Param& p : type.params)
        for (int c = 0; c < channels(p.type); ++c) {
            if (p.type == Type::Vector) add([&] { return uniform(-1, 1); });
            else if (p.soft_max > 10) add([&] { return uniform(0.5, 3); });
            else add([&] { return uniform(p.soft_min - spread, p.soft_max + spread); });
        }
    for (Global g : type.globals) {
        if (g == Global::Backfacing) {
            add([&] { return uniform(0, 1) < 0.5 ? 0.0 : 1.0; });
            continue;
        }
        const size_t first = in.size();
        for (int c = 0; c < 3; ++c) in.emplace_back(n);
        for (uint32_t i = 0; i < n; ++i) {
            Vec3d v(uniform(-1, 1), uniform(-1, 1), 1);
            if (g != Global::I) v = Vec3d(0, 0, 1) + v * 0.2;
            v = normalize(v);
            for (int c = 0; c < 3; ++c) in[first + c][i] = static_cast<float>(v[c]);
        }
    }
    return in;
}

TEST(closure_nodes, lanes_scalar_and_double_agree) {
    const uint32_t n = 199;
    for (const char* name : kNodes) {
        const NodeType& type = *find_node(name);
        for (int choice = 0; choice < 4; ++choice) {
            const Statics s = statics_of(type, choice);
            const auto in = random_operands(type, n, 3 + choice, 0.2);
            const auto lanes = run_kernel<float>(type, s, type.kernel.lanes, in, n);
            const auto scalar = run_kernel<float>(type, s, type.kernel.scalar, in, n);
            const auto exact = run_kernel<double>(type, s, type.kernel.f64, in, n);
            for (size_t l = 0; l < s.lobes.size(); ++l)
                for (uint32_t i = 0; i < n; ++i) {
                    const int first = s.lobe_offset[l];
                    const bool absent = exact[first][i] == 0 && exact[first + 1][i] == 0 && exact[first + 2][i] == 0;
                    for (int c = 0; c < s.lobes[l].channels(); ++c) {
                        if (absent && c >= 3) continue;
                        const double want = exact[first + c][i], scale = std::max(std::abs(want), 0.05);
                        EXPECT_NEAR(lanes[first + c][i], want, 2e-4 * scale) << name << " lobe " << l << " channel " << c << " point " << i;
                        EXPECT_NEAR(scalar[first + c][i], want, 2e-4 * scale) << name << " lobe " << l << " channel " << c << " point " << i;
                    }
                }
        }
    }
}

TEST(closure_nodes, any_operand_gives_finite_lobes_or_none) {
    const uint32_t n = 256;
    const double extremes[] = {0, -0.0, 1e-38, 1e-7, 1, -1, 1e9, -1e9, 1e38, -1e38, INFINITY, -INFINITY, NAN};
    std::mt19937 engine(5);
    for (const char* name : kNodes) {
        const NodeType& type = *find_node(name);
        if (type.lobes(statics_of(type, 0))[0].kind == LobeKind::Emission) continue;  // radiance is what it is
        for (int choice = 0; choice < 4; ++choice) {
            const Statics s = statics_of(type, choice);
            auto in = random_operands(type, n, 40 + choice, 1);
            const int parameters = type.channel_of(static_cast<int>(type.params.size()));
            for (int c = 0; c < parameters; ++c)
                for (uint32_t i = 0; i < n; ++i)
                    if (engine() % 5 == 0) in[c][i] = static_cast<float>(extremes[engine() % std::size(extremes)]);
            const auto out = run_kernel<float>(type, s, type.kernel.lanes, in, n);
            for (size_t l = 0; l < s.lobes.size(); ++l)
                for (uint32_t i = 0; i < n; ++i)
                    for (int c = 0; c < 3; ++c) EXPECT_FALSE(out[s.lobe_offset[l] + c][i] < 0 && s.lobes[l].kind != LobeKind::Emission) << name;
        }
    }
}

TEST(closure_nodes, principled_channels_are_where_the_kernel_reads_them) {
    // Each number the kernel takes shows in the lobes: a wrong offset would move one parameter into another.
    MaterialLobes m("ShaderNodeBsdfPrincipled", {{"distribution", "GGX"}, {"Base Color", {0.1, 0.2, 0.3}}, {"Roughness", 0.6}, {"IOR", 1.7},
                                                 {"Metallic", 0.25}, {"Transmission Weight", 0.5}, {"Diffuse Roughness", 0.4},
                                                 {"Coat Weight", 0.125}, {"Coat Roughness", 0.3}, {"Coat IOR", 1.6}, {"Sheen Weight", 0.2},
                                                 {"Sheen Roughness", 0.7}, {"Sheen Tint", {0.5, 0.6, 0.7}}, {"Emission Color", {1, 2, 3}},
                                                 {"Emission Strength", 2}, {"Thin Film Thickness", 400}, {"Thin Film IOR", 1.4},
                                                 {"Alpha", 0.75}, {"Specular IOR Level", 0.25}, {"Anisotropic", 0.5}, {"Anisotropic Rotation", 0.25}});
    const std::vector<Lobe<double>> lobes = m.at(view_from(0.5, 1));
    ASSERT_EQ(lobes.size(), 8u);
    const double ior_level = std::sqrt(std::pow(0.7 / 2.7, 2) * 0.5), aspect = std::sqrt(1 - 0.45);
    EXPECT_EQ(lobes[0].spec->kind, LobeKind::SheenMicrofiber);
    EXPECT_NEAR(lobes[0].weight.y / lobes[0].weight.x, 1.2, 1e-6);
    EXPECT_NEAR(lobes[1].p[0], 0.09, 1e-7);
    EXPECT_NEAR(lobes[1].p[1], 1.6, 1e-7);
    EXPECT_EQ(lobes[2].spec->kind, LobeKind::Emission);
    EXPECT_NEAR(lobes[2].weight.z / lobes[2].weight.x, 3, 1e-6);
    EXPECT_NEAR(lobes[3].p[0], 0.36 / aspect, 1e-6);
    EXPECT_NEAR(lobes[3].p[1], 0.36 * aspect, 1e-6);
    EXPECT_NEAR(lobes[3].p[4], 0.3, 1e-7);
    EXPECT_NEAR(lobes[3].t.y, 1, 1e-6);
    EXPECT_NEAR(lobes[4].p[1], 1.7, 1e-6);
    EXPECT_NEAR(lobes[4].p[5], std::sqrt(0.1), 1e-7);
    EXPECT_NEAR(lobes[4].p[8], 400, 1e-4);
    EXPECT_NEAR(lobes[4].p[9], 1.4, 1e-6);
    EXPECT_NEAR(lobes[5].p[2], (1 + ior_level) / (1 - ior_level), 1e-6);
    EXPECT_NEAR(lobes[6].p[0], 0.4, 1e-7);
    EXPECT_EQ(lobes[7].spec->kind, LobeKind::Transparent);
    EXPECT_NEAR(lobes[7].weight.x, 0.25, 1e-7);
    // The kernel's offsets count the parameters' channels in this order.
    const NodeType& type = *find_node("ShaderNodeBsdfPrincipled");
    EXPECT_EQ(type.channel_of_global(0), 49);
}

TEST(closure_nodes, constants_decide_which_lobes_exist) {
    const auto kinds = [](const json& params) {
        std::string s;
        MaterialLobes material("ShaderNodeBsdfPrincipled", params);
        for (const auto& l : material.at(view_from(0, 1))) s += std::to_string(static_cast<int>(l.spec->kind)) + " ";
        return s;
    };
    const auto k = [](auto... kind) { return ((std::to_string(static_cast<int>(kind)) + " ") + ...); };
    EXPECT_EQ(kinds(json::object()), k(LobeKind::MicrofacetReflection, LobeKind::Diffuse));
    EXPECT_EQ(kinds({{"Specular IOR Level", 0}}), k(LobeKind::Diffuse));
    EXPECT_EQ(kinds({{"Specular IOR Level", 0}, {"Base Color", {0, 0, 0}}}), "");
    EXPECT_EQ(kinds({{"Alpha", 0}}), k(LobeKind::Transparent));
    EXPECT_EQ(kinds({{"Metallic", 1}}), k(LobeKind::MicrofacetReflection));
    EXPECT_EQ(kinds({{"Transmission Weight", 1}}), k(LobeKind::MicrofacetGlass));
    MaterialLobes plain("ShaderNodeBsdfPrincipled", json::object());
    EXPECT_TRUE(plain.at(view_from(0, 1))[1].spec->smooth);
    EXPECT_FALSE(plain.at(view_from(0, 1))[0].spec->has_tangent());
}

TEST(closure_nodes, subsurface_shares_the_base_with_diffuse) {
    for (const auto& [weight, deep, diffuse] : {std::tuple{0.0, 0.0, 0.5}, {0.25, 0.125, 0.375}, {1.0, 0.5, 0.0}}) {
        MaterialLobes m("ShaderNodeBsdfPrincipled", {{"Subsurface Weight", weight}, {"Base Color", {0.5, 0.5, 0.5}}, {"Specular IOR Level", 0},
                                                             {"Subsurface Scale", 2}, {"Subsurface Radius", {1, 0.5, 0}}});
        double walks[3] = {}, matte[3] = {};
        for (const Lobe<double>& l : m.at(view_from(0.5, 1)))
            for (int c = 0; c < 3; ++c) {
                if (l.spec->kind == LobeKind::RandomWalk) walks[c] += l.weight[c];
                if (l.spec->kind == LobeKind::Diffuse) matte[c] += l.weight[c];
            }
        EXPECT_NEAR(walks[0], deep, 1e-6);
        EXPECT_NEAR(walks[1], deep, 1e-6);
        EXPECT_EQ(walks[2], 0) << "no radius, no walk";
        EXPECT_NEAR(matte[0], diffuse, 1e-6);
        EXPECT_NEAR(matte[2], diffuse + deep, 1e-6) << "what cannot walk is Lambert";
    }
}

json mix(json fac) {
    return {{"version", 1},
            {"nodes",
             {{"red", {{"type", "ShaderNodeEmission"}, {"params", {{"Color", {1, 0, 0}}}}}},
              {"matte", {{"type", "ShaderNodeBsdfDiffuse"}, {"params", {{"Color", {0, 1, 0}}}}}},
              {"mix", {{"type", "ShaderNodeMixShader"}, {"params", {{"Fac", fac}, {"Shader", {{"node", "red"}}}, {"Shader_001", {{"node", "matte"}}}}}}},
              {"out", {{"type", "ShaderNodeOutputMaterial"}, {"params", {{"Surface", {{"node", "mix"}}}}}}}}},
            {"outputs", {{"surface", {{"node", "out"}}}}}};
}

TEST(closure_nodes, mix_ends_keep_one_side) {
    MaterialLobes quarter(mix(0.25)), first(mix(0)), beyond(mix(3.5));
    const auto both = quarter.at(view_from(0, 1)), red = first.at(view_from(0, 1)), matte = beyond.at(view_from(0, 1));
    ASSERT_EQ(both.size(), 2u);
    for (const auto& l : both) EXPECT_NEAR(l.weight.x + l.weight.y, l.spec->kind == LobeKind::Emission ? 0.75 : 0.25, 1e-7);
    ASSERT_EQ(red.size(), 1u);
    EXPECT_EQ(red[0].spec->kind, LobeKind::Emission);
    ASSERT_EQ(matte.size(), 1u);  // the factor is limited to 1
    EXPECT_EQ(matte[0].spec->kind, LobeKind::Diffuse);
    EXPECT_NEAR(matte[0].weight.y, 1, 1e-7);
}

}  // namespace
}  // namespace alder
