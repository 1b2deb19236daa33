// Lobes of a closure node at one point, through the graph compiler and in double.
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "graph/material.h"
#include "render/closure/bsdf.h"

namespace alder::testing {

class MaterialLobes {
  public:
    explicit MaterialLobes(const std::string& node, const nlohmann::json& params) {
        const nlohmann::json document = {{"version", 1},
                                         {"nodes", {{"node", {{"type", node}, {"params", params}}}}},
                                         {"outputs", {{"surface", {{"node", "node"}}}}}};
        init(document);
    }
    explicit MaterialLobes(const nlohmann::json& document) { init(document); }

    /// The lobes seen from view.wo. `backfacing`: the surface is seen from inside.
    std::vector<Lobe<double>> at(const ShadingView<double>& view, bool backfacing = false) {
        std::vector<Channel<double>> in;
        std::vector<std::vector<double>> values;
        for (const ProgramInput& input : program_->inputs())
            for (int c = 0; c < input.channels; ++c) {
                double v = 0;
                switch (input.global) {
                    case Global::N: v = view.ns[c]; break;
                    case Global::Ng: v = view.ng[c]; break;
                    case Global::I: v = view.wo[c]; break;
                    case Global::Tangent: v = c == 0; break;
                    case Global::Backfacing: v = backfacing; break;
                    default: ADD_FAILURE() << "input " << global_name(input.global);
                }
                values.push_back(std::vector<double>(kPadding, v));
            }
        for (const auto& v : values) in.push_back({v.data(), 0});
        executor_.run(*program_, 1, in);
        std::vector<Lobe<double>> lobes;
        for (const ProgramLobe& l : program_->lobes()) {
            std::vector<Channel<double>> channels;
            for (int c = 0; c < l.spec.channels(); ++c) channels.push_back(executor_.channel(l.register_first + c));
            lobes.push_back(load_lobe(l.spec, channels.data(), 0));
        }
        return lobes;
    }

  private:
    void init(const nlohmann::json& document) {
        Diagnostics d;
        material_ = build_material(document, {}, d);
        if (!material_) throw std::runtime_error(d.errors.empty() ? "no material" : d.errors[0].line());
        program_ = material_->program({.surface = LobeFilter::Surface}, d);
        if (!program_) throw std::runtime_error("no program");
    }
    std::shared_ptr<const Material> material_;
    std::shared_ptr<const Program> program_;
    Executor<double> executor_{EvalContext{}};
};

}  // namespace alder::testing
