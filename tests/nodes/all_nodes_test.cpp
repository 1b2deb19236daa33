// Laws that every registered node obeys, checked from its schema alone: it evaluates with defaults; SIMD, scalar and double
// agree; a uniform input is a varying one with equal values; a point's result depends on neither its batch nor its place in it;
// no input whatever crashes it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "graph/material.h"
#include "nodes/schema.h"

namespace alder {
namespace {

using nlohmann::json;

constexpr uint32_t kPoints = 203;

enum class Values { Ordinary, Adversarial };

/// Deterministic values of one input channel. Directions are unit vectors, flags 0 or 1.
template <class R>
std::vector<R> values(const ProgramInput& in, int channel, Values kind, uint32_t count) {
    const std::string name = in.is_attribute ? in.attribute : std::string("g") + std::to_string(static_cast<int>(in.global));
    std::vector<R> out(count + 2 * kPadding, R(0.25));
    for (uint32_t i = 0; i < count; ++i) {
        std::mt19937 rng(static_cast<uint32_t>(std::hash<std::string>()(name)) * 31u + i);
        std::uniform_real_distribution<float> u(-1, 1);
        float v[3] = {u(rng), u(rng), u(rng)};
        const bool direction = !in.is_attribute && (in.global == Global::N || in.global == Global::Ng || in.global == Global::I || in.global == Global::Ns ||
                                                    in.global == Global::Nf || in.global == Global::Ngf || in.global == Global::Nu || in.global == Global::Ngu ||
                                                    in.global == Global::Direction || in.global == Global::Tangent || in.global == Global::Rd);
        const bool flag = !in.is_attribute && (in.global == Global::Backfacing || (in.global >= Global::IsCameraRay && in.global <= Global::IsVolumeRay));
        if (direction) {
            const float l = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 1e-20f;
            for (float& x : v) x /= l;
        } else if (in.is_attribute && in.type != Type::Vector) {
            for (float& x : v) x = std::fabs(x);  // colours and factors in 0 ... 1
        } else {
            for (float& x : v) x *= 3;
        }
        if (flag || in.type == Type::Bool) v[channel] = v[channel] > 0.5f ? 1.0f : 0.0f;
        if (kind == Values::Adversarial) {
            static const float kBad[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-40f, -1e-40f, 1e-20f, 3e38f, -3e38f, 1e10f, -1e10f, std::numeric_limits<float>::infinity(),
                                         -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 2147483648.0f, -2147483904.0f};
            if (rng() % 3) v[channel] = kBad[rng() % std::size(kBad)];
        }
        out[i] = R(v[channel]);
    }
    return out;
}

/// All result channels of a program: outputs or lobes.
std::vector<std::pair<std::string, int>> results(const Program& p) {
    std::vector<std::pair<std::string, int>> r;
    for (const auto& o : p.outputs())
        for (int c = 0; c < channels(o.type); ++c) r.emplace_back(o.name + "." + std::to_string(c), o.register_first + c);
    for (size_t l = 0; l < p.lobes().size(); ++l)
        for (int c = 0; c < p.lobes()[l].spec.channels(); ++c) r.emplace_back("lobe" + std::to_string(l) + "." + std::to_string(c), p.lobes()[l].register_first + c);
    return r;
}

template <class R>
std::vector<std::vector<R>> run(const Program& p, Values kind, uint32_t batch, bool scalar, bool uniform) {
    const EvalContext context;
    Executor<R> x(context, scalar);
    batch = std::min(batch, p.batch());
    std::vector<std::vector<R>> in;
    for (const auto& i : p.inputs())
        for (int c = 0; c < i.channels; ++c) {
            in.push_back(values<R>(i, c, kind, kPoints));
            if (uniform) in.back().assign(in.back().size(), in.back()[5]);
        }
    const auto list = results(p);
    std::vector<std::vector<R>> out(list.size());
    for (uint32_t i = 0; i < kPoints; i += batch) {
        const uint32_t n = std::min(batch, kPoints - i);
        std::vector<Channel<R>> ch;
        for (const auto& v : in) ch.push_back(uniform ? Channel<R>{v.data(), 0} : Channel<R>{v.data() + i, 1});
        x.run(p, n, ch);
        for (size_t r = 0; r < list.size(); ++r) {
            const Channel<R> c = x.channel(list[r].second);
            for (uint32_t k = 0; k < n; ++k) out[r].push_back(c.p[k * c.stride]);
        }
    }
    return out;
}

/// Graphs around one node: every dynamic parameter from an attribute, each enum item in turn.
std::vector<std::pair<std::string, json>> graphs(const NodeType& type) {
    std::vector<std::pair<std::string, json>> list;
    json params = json::object();
    for (const auto& p : type.params)
        if (channels(p.type) > 0 && p.takes_links) params[p.name] = {{"attribute", p.name}};
    const auto add = [&](const std::string& label, const json& q) {
        json g = {{"nodes", {{"n", {{"type", type.name}, {"params", q}}}}}};
        if (type.is_closure()) g["outputs"] = {{"surface", {{"node", "n"}}}};
        list.emplace_back(type.name + " " + label, g);
    };
    add("linked", params);
    add("defaults", json::object());
    for (const auto& p : type.params) {
        if (p.type != Type::Enum) continue;
        for (const auto& item : p.items) {
            json q = params;
            q[p.name] = item.name;
            add(p.name + "=" + item.name, q);
        }
    }
    return list;
}

std::shared_ptr<const Program> compile(const NodeType& type, const json& graph) {
    Diagnostics d;
    const auto m = build_material(graph, {}, d);
    if (!m) return nullptr;  // refused: a feature that is not there says so
    ProgramRequest request;
    if (type.is_closure()) request.surface = LobeFilter::Surface;
    else
        for (const auto& o : type.outputs) request.outputs.push_back("n." + o.name);
    auto p = m->program(request, d);
    EXPECT_TRUE(p) << type.name << ": " << (d.errors.empty() ? "" : d.errors[0].line());
    return p;
}

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
