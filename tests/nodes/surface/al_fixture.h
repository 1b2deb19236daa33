// Runs alSurface's kernel on given parameters and shading globals, and reads reference tables, for the tests beside this.
#pragma once
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "nodes/schema.h"
#include "render/closure/bsdf.h"

namespace alder::testing {

using json = nlohmann::json;

inline std::filesystem::path reference_folder() {
    const char* env = std::getenv("ALDER_REFERENCE");
    return env ? std::filesystem::path(env) : std::filesystem::path(ALDER_SOURCE_DIR) / "tests/reference";
}
/// A table, plain or compressed; null where it is not there.
inline json load_table(const std::string& name) {
    for (const char* end : {".json", ".json.gz"}) {
        const auto path = reference_folder() / "alshaders" / (name + end);
        gzFile f = gzopen(path.c_str(), "rb");
        if (!f) continue;
        std::string text;
        char block[65536];
        for (int n; (n = gzread(f, block, sizeof block)) > 0;) text.append(block, n);
        gzclose(f);
        return json::parse(text);
    }
    return nullptr;
}
inline double number(const json& j) {
    if (!j.is_string()) return j.get<double>();
    const std::string s = j;
    return s == "nan" ? std::nan("") : s == "inf" ? INFINITY : -INFINITY;
}
inline Vec3d vec3(const json& j) { return {number(j[0]), number(j[1]), number(j[2])}; }

/// One alSurface with its compile-time facts, as the graph compiler would set them.
class SurfaceNode {
  public:
    explicit SurfaceNode(const json& params, const std::set<std::string>& links = {}) : type_(*find_node("alSurface")) {
        statics_.type = &type_;
        for (const Param& p : type_.params) {
            const bool given = params.contains(p.name), linked = links.count(p.name) > 0;
            std::array<double, 3> v{p.number[0], p.number[1], p.number[2]};
            if (given && channels(p.type) == 3) v = {number(params[p.name][0]), number(params[p.name][1]), number(params[p.name][2])};
            if (given && channels(p.type) == 1) v[0] = params[p.name].is_boolean() ? params[p.name].get<bool>() : number(params[p.name]);
            std::string text = given && params[p.name].is_string() && channels(p.type) == 0 ? params[p.name].get<std::string>() : p.text;
            int item = p.type == Type::Bool ? v[0] != 0 : 0;
            for (size_t k = 0; k < p.items.size(); ++k)
                if (p.items[k].name == text) item = static_cast<int>(k);
            statics_.enums.push_back(item);
            statics_.text.push_back(text);
            statics_.linked.push_back(linked);
            bool zero = !linked && channels(p.type) > 0, at_default = !linked;
            for (int c = 0; c < channels(p.type); ++c) {
                zero = zero && v[c] == 0;
                at_default = at_default && v[c] == p.number[c];
                operands_.push_back(v[c]);
            }
            statics_.zero.push_back(zero);
            statics_.at_default.push_back(at_default && text == p.text);
            values_.push_back(v);
            is_linked_.push_back(linked);
        }
        statics_.lobes = type_.lobes(statics_);
        for (const LobeSpec& l : statics_.lobes) {
            statics_.lobe_offset.push_back(outputs_);
            outputs_ += l.channels();
        }
        for (Global g : type_.globals) {
            first_channel_.push_back(static_cast<int>(operands_.size()));
            for (int c = 0; c < channels(g); ++c) operands_.push_back(0);
        }
        set(Global::I, {0, 0, 1});
        set(Global::N, {0, 0, 1});
        set(Global::Dpdu, {1, 0, 0});
    }

    void set(Global g, Vec3d v) {
        for (size_t k = 0; k < type_.globals.size(); ++k)
            if (type_.globals[k] == g)
                for (int c = 0; c < channels(g); ++c) operands_[first_channel_[k] + c] = v[c];
    }
    void set(Global g, double x) { set(g, Vec3d(x, 0, 0)); }

    /// The lobes by the double kernel; index: al_surface::LobeIndex.
    std::vector<Lobe<double>> run() const { return evaluate<double>(type_.kernel.f64); }
    std::vector<Lobe<float>> run_lanes() const { return evaluate<float>(type_.kernel.lanes); }

    std::vector<std::string> faults() const {
        std::vector<const double*> constant;
        for (size_t p = 0; p < values_.size(); ++p) constant.push_back(is_linked_[p] ? nullptr : values_[p].data());
        std::vector<std::string> errors;
        type_.check(statics_, constant, errors);
        return errors;
    }
    bool uses(const char* param) const { return type_.uses(statics_, type_.param_index(param)); }
    const Statics& statics() const { return statics_; }

  private:
    template <class R, class Fn>
    std::vector<Lobe<R>> evaluate(Fn kernel) const {
        std::vector<std::array<R, kPadding>> in(operands_.size());
        std::vector<Channel<R>> channels;
        for (size_t k = 0; k < in.size(); ++k) {
            in[k].fill(static_cast<R>(operands_[k]));
            channels.push_back({in[k].data(), 0});
        }
        std::vector<std::array<R, kPadding>> out(outputs_);
        std::vector<R*> pointers;
        for (auto& o : out) {
            o.fill(R(-7));
            pointers.push_back(o.data());
        }
        kernel(OpCall<R>{channels.data(), pointers.data(), &statics_, nullptr, 1});
        std::vector<Channel<R>> results;
        for (auto& o : out) results.push_back({o.data(), 1});
        std::vector<Lobe<R>> lobes;
        for (size_t k = 0; k < statics_.lobes.size(); ++k)
            lobes.push_back(load_lobe(statics_.lobes[k], results.data() + statics_.lobe_offset[k], 0));
        return lobes;
    }

    const NodeType& type_;
    Statics statics_;
    std::vector<std::array<double, 3>> values_;
    std::vector<bool> is_linked_;
    std::vector<double> operands_;
    std::vector<int> first_channel_;
    int outputs_ = 0;
};

inline SurfaceNode surface(const json& params, const std::set<std::string>& links = {}) { return SurfaceNode(params, links); }

inline double largest(Vec3d c) { return std::max({c.x, c.y, c.z}); }

}  // namespace alder::testing
