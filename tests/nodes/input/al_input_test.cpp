// alInputVector, alInputScalar, alCache and the Pref space of patterns: how they lower, seen through compiled graphs.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "graph/material.h"

namespace alder {
namespace {

using nlohmann::json;
using Inputs = std::map<std::string, std::vector<float>>;   ///< by global or attribute name; one point

/// Values of node "n"; inputs not named are 0.
std::vector<float> value(const json& nodes, const Inputs& inputs) {
    Diagnostics d;
    const auto material = build_material({{"version", 1}, {"nodes", nodes}}, {}, d);
    if (!material) return ADD_FAILURE() << d.errors[0].line(), std::vector<float>(3, NAN);
    const auto program = material->program({.outputs = {"n"}}, d);
    if (!program) return ADD_FAILURE() << d.errors[0].line(), std::vector<float>(3, NAN);
    std::vector<std::vector<float>> memory;
    std::vector<Channel<float>> channel;
    for (const ProgramInput& in : program->inputs()) {
        const char* global = in.is_attribute ? nullptr : global_name(in.global);
        const auto found = inputs.find(in.is_attribute ? in.attribute : global ? global : "");
        for (int c = 0; c < in.channels; ++c) {
            memory.emplace_back(kPadding, found == inputs.end() ? 0.f : found->second[c]);
            channel.push_back({memory.back().data(), 0});
        }
    }
    const EvalContext context;
    Executor<float> run(context);
    run.run(*program, 1, channel);
    std::vector<float> out;
    const auto& o = program->outputs()[0];
    for (int c = 0; c < channels(o.type); ++c) out.push_back(run.channel(o.register_first + c).p[0]);
    return out;
}
json node(const char* type, json params) { return {{"n", {{"type", type}, {"params", params}}}}; }

TEST(AlInputVector, a_point_is_translated_and_a_vector_is_not) {
    json params = {{"input", "Custom"}, {"vector", {1, 2, 3}}, {"matrix", {{0, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 0, 0}, {10, 20, 30, 1}}}};
    EXPECT_EQ(value(node("alInputVector", params), {}), (std::vector<float>{13, 21, 32}));
    params["type"] = "Vector";
    EXPECT_EQ(value(node("alInputVector", params), {}), (std::vector<float>{3, 1, 2}));
}
TEST(AlInputVector, spherical_coordinates_take_the_azimuth_from_z_and_x) {
    const json params = {{"input", "Custom"}, {"vector", {0.6, 0, 0.8}}, {"coordinates", "spherical"}};
    auto v = value(node("alInputVector", params), {});
    EXPECT_FLOAT_EQ(v[0], std::atan2(0.8f, 0.6f));
    EXPECT_FLOAT_EQ(v[1], std::acos(0.8f));
    EXPECT_EQ(v[2], 0);
    json unit = params;
    unit["coordinates"] = "normalized spherical";
    v = value(node("alInputVector", unit), {});
    EXPECT_FLOAT_EQ(v[0], std::atan2(0.8f, 0.6f) / (2 * float(M_PI)) + 0.5f);
    EXPECT_FLOAT_EQ(v[1], std::acos(0.8f) / float(M_PI));
    json long_vector = params;
    long_vector["vector"] = {0, 0, 2};
    EXPECT_TRUE(std::isnan(value(node("alInputVector", long_vector), {})[1]));
}
TEST(AlInputVector, user_falls_back_to_its_vector_where_the_geometry_lacks_the_attribute) {
    const json params = {{"input", "User"}, {"userName", "rest"}, {"vector", {7, 8, 9}}};
    EXPECT_EQ(value(node("alInputVector", params), {{"rest", {1, 2, 3}}, {"rest.exists", {1}}}), (std::vector<float>{1, 2, 3}));
    EXPECT_EQ(value(node("alInputVector", params), {}), (std::vector<float>{7, 8, 9}));
    const json unnamed = {{"input", "User"}, {"vector", {7, 8, 9}}};
    EXPECT_EQ(value(node("alInputVector", unnamed), {}), (std::vector<float>{7, 8, 9}));
}
TEST(AlInputScalar, reads_what_it_names) {
    const Inputs inputs = {{"fi", {3}}, {"Rl", {0.25}}, {"area", {0.5}}, {"mask", {0.75}}};
    EXPECT_EQ(value(node("alInputScalar", {{"input", "face-index"}, {"RMPclampEnable", false}}), inputs)[0], 3);
    EXPECT_EQ(value(node("alInputScalar", {{"input", "User"}, {"userName", "mask"}}), inputs)[0], 0.75);
    EXPECT_EQ(value(node("alInputScalar", {{"input", "User"}, {"userName", "missing"}}), inputs)[0], 0);
    EXPECT_EQ(value(node("alInputScalar", {{"input", "User"}}), inputs)[0], 0);
}
TEST(AlPattern, Pref_falls_back_to_object_space) {
    const json params = {{"space", "Pref"}, {"frequency", 1}, {"RMPclampEnable", false}};
    const Inputs with = {{"Po", {0.5, 0, 0}}, {"Pref", {1.25, 0, 0}}, {"Pref.exists", {1}}}, without = {{"Po", {0.5, 0, 0}}};
    EXPECT_NEAR(value(node("alPattern", params), with)[0], std::sin(1.25f), 1e-6);
    EXPECT_NEAR(value(node("alPattern", params), without)[0], std::sin(0.5f), 1e-6);
}
TEST(AlPattern, a_linked_point_replaces_the_space_and_a_constant_one_does_not) {
    const Inputs inputs = {{"P", {0.5, 0, 0}}};
    json nodes = node("alPattern", {{"frequency", 1}, {"P", {1, 0, 0}}});
    EXPECT_NEAR(value(nodes, inputs)[0], std::sin(0.5f), 1e-6);
    nodes["point"] = {{"type", "alInputVector"}, {"params", {{"input", "Custom"}, {"vector", {1, 0, 0}}}}};
    nodes["n"]["params"]["P"] = {{"node", "point"}};
    EXPECT_NEAR(value(nodes, inputs)[0], std::sin(1.0f), 1e-6);
}
TEST(AlCache, is_the_identity) {
    json nodes = node("alCache", {{"input", {{"node", "c"}}}});
    nodes["c"] = {{"type", "alCombineColor"}, {"params", {{"input1", {0.5, 2, -1}}, {"input2", {2, 2, 2}}}}};
    EXPECT_EQ(value(nodes, {}), (std::vector<float>{1, 4, -2}));
}

}  // namespace
}  // namespace alder
