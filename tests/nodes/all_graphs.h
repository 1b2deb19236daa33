// Graphs around each registered node, made from its schema alone, and values to run them on: for the laws that all nodes obey and
// for the accuracy report.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "graph/material.h"
#include "nodes/schema.h"

namespace alder::test {

using nlohmann::json;

inline constexpr uint32_t kPoints = 203;

enum class Values {
    Ordinary,     ///< what a scene gives
    Extreme,      ///< finite: zeros, equal operands, denormal, tiny, up to 1e10
    Adversarial   ///< anything: infinities, NaN, the ends of float and int
};

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
        if (kind == Values::Extreme) {
            // At two points of three; at every fourth point all operands are one and the same value.
            static const float kFinite[] = {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, 1e-40f, -1e-40f, 1e-20f, -1e-20f, 1e-6f, 1e5f, -1e5f, 1e10f, -1e10f};
            const bool equal = i % 4 == 0;
            const uint32_t pick = equal ? i / 4 : static_cast<uint32_t>(rng()) + static_cast<uint32_t>(channel);
            if ((equal || rng() % 3) && !direction && !flag && in.type != Type::Bool) v[channel] = kFinite[pick % std::size(kFinite)];
            if (direction && i % 8 == 5) v[channel] = channel == static_cast<int>(i / 8 % 3) ? 1.0f : 0.0f;  // along an axis
        }
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
inline std::vector<std::pair<std::string, int>> results(const Program& p) {
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
inline std::vector<std::pair<std::string, json>> graphs(const NodeType& type) {
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

/// Null where the node refuses these settings: a feature that is not there.
inline std::shared_ptr<const Program> compile(const NodeType& type, const json& graph) {
    Diagnostics d;
    const auto m = build_material(graph, {}, d);
    if (!m) return nullptr;
    ProgramRequest request;
    if (type.is_closure()) request.surface = LobeFilter::Surface;
    else
        for (const auto& o : type.outputs) request.outputs.push_back("n." + o.name);
    return m->program(request, d);
}

}  // namespace alder::test
