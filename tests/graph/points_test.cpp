// Shading points of evaluation requests: parsing, faults, and what is derived against what the reference renderer had.
#include "graph/points.h"


#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "nodes/num/vec.h"

namespace alder {
namespace {

using nlohmann::json;

ProgramInput global_input(Global g) {
    ProgramInput in;
    in.global = g;
    in.channels = channels(g);
    in.type = in.channels == 1 ? Type::Float : Type::Vector;
    return in;
}
ProgramInput attribute_input(const std::string& name, int channels) {
    ProgramInput in;
    in.is_attribute = true;
    in.attribute = name;
    in.channels = channels;
    in.type = channels == 1 ? Type::Float : Type::Vector;
    return in;
}

std::optional<PointSet> parse(const json& points, Diagnostics& d, const std::string& domain = "surface") {
    PointOptions options;
    options.resolve_file = [](const std::string& f, std::string&) { return f; };
    return PointSet::parse(points, domain, "/points", options, d);
}

/// Value of channel c at point i.
double at(const std::vector<ChannelValues>& v, int c, size_t i) { return v[c].uniform ? v[c].values.at(0) : v[c].values.at(i); }

std::vector<ChannelValues> values(const json& points, const ProgramInput& in, const std::string& domain = "surface") {
    Diagnostics d;
    const auto set = parse(points, d, domain);
    EXPECT_TRUE(set) << (d.errors.empty() ? "" : d.errors[0].pointer + " " + d.errors[0].found);
    std::vector<ChannelValues> out;
    if (set) set->append(in, out);
    return out;
}

std::string first_fault(const json& points) {
    Diagnostics d;
    EXPECT_FALSE(parse(points, d));
    return d.errors.empty() ? "" : d.errors[0].code + " " + d.errors[0].pointer;
}

TEST(points, defaults_are_those_of_the_interface) {
    const json p = {{"count", 3}};
    const struct { Global g; Vec3d v; } rows[] = {{Global::P, {0, 0, 0}}, {Global::N, {0, 0, 1}}, {Global::Ng, {0, 0, 1}}, {Global::I, {0, 0, 1}},
                                                  {Global::Uv, {0, 0, 0}}, {Global::Tangent, {1, 0, 0}}, {Global::Rd, {0, 0, -1}}, {Global::Nf, {0, 0, 1}},
                                                  {Global::Reflection, {0, 0, 1}}};
    for (const auto& row : rows) {
        const auto v = values(p, global_input(row.g));
        ASSERT_EQ(v.size(), 3u);
        for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(v[c].uniform) << static_cast<int>(row.g);
            EXPECT_EQ(at(v, c, 2), row.v[c]) << static_cast<int>(row.g) << " channel " << c;
        }
    }
}

TEST(points, a_field_is_one_value_or_one_a_point) {
    const json p = {{"count", 3}, {"P", {1, 2, 3}}, {"ray_length", {4, "inf", "nan"}}, {"uv", {{1, 2}, {3, 4}, {5, 6}}}};
    EXPECT_EQ(at(values(p, global_input(Global::P)), 1, 2), 2);
    const auto r = values(p, global_input(Global::RayLength));
    EXPECT_EQ(at(r, 0, 0), 4);
    EXPECT_TRUE(std::isinf(at(r, 0, 1)));
    EXPECT_TRUE(std::isnan(at(r, 0, 2)));
    EXPECT_EQ(at(values(p, global_input(Global::Uv)), 1, 2), 6);
    EXPECT_EQ(at(values({{"count", 1}, {"u", {0.5}}, {"v", 0.25}}, global_input(Global::Uv)), 0, 0), 0.5);
}

TEST(points, attributes_convert_to_what_is_asked) {
    const json p = {{"count", 2}, {"attributes", {{"f", {1, 2}}, {"c", {{1, 2, 6}, {3, 4, 5}}}, {"rgba", {0.5, 0.25, 0, 1}}, {"uv", {{1, 2}, {3, 4}}}}}};
    EXPECT_EQ(at(values(p, attribute_input("f", 3)), 2, 1), 2);
    EXPECT_EQ(at(values(p, attribute_input("c", 1)), 0, 0), 3);
    EXPECT_EQ(at(values(p, attribute_input("rgba", 3)), 1, 1), 0.25);
    EXPECT_EQ(at(values(p, attribute_input("uv", 1)), 0, 1), 3);
    EXPECT_EQ(at(values(p, attribute_input("uv", 3)), 2, 1), 0);
    EXPECT_EQ(at(values(p, attribute_input("absent", 3)), 2, 1), 0);
}

TEST(points, names_with_a_suffix_say_more_of_an_attribute) {
    const json p = {{"count", 1}, {"attributes", {{"rgba", {0.5, 0.25, 0, 0.75}}, {"rgb", {1, 2, 3}}}}};
    EXPECT_EQ(at(values(p, attribute_input("rgba.alpha", 1)), 0, 0), 0.75);
    EXPECT_EQ(at(values(p, attribute_input("rgb.alpha", 1)), 0, 0), 1);
    EXPECT_EQ(at(values(p, attribute_input("absent.alpha", 1)), 0, 0), 1);
    EXPECT_EQ(at(values(p, attribute_input("rgb.exists", 1)), 0, 0), 1);
    EXPECT_EQ(at(values(p, attribute_input("absent.exists", 1)), 0, 0), 0);
    const json properties = {{"count", 1}, {"surface", {{"object_custom_properties", {{"wear", 0.5}}}, {"scene_custom_properties", {{"sun", {1, 2, 3}}}}}}};
    EXPECT_EQ(at(values(properties, attribute_input("object:wear", 1)), 0, 0), 0.5);
    EXPECT_EQ(at(values(properties, attribute_input("view_layer:sun", 3)), 2, 0), 3);
}

TEST(points, a_triangle_gives_position_normal_and_distance_to_its_edges) {
    const json mesh = {{"positions", {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}}, {"triangles", {{0, 1, 2}}},
                       {"uv", {{"map", {{0, 0}, {1, 0}, {0, 1}}}}}, {"attributes", {{"heat", {{"domain", "POINT"}, {"values", {0, 1, 3}}}}}}};
    const json p = {{"count", 1}, {"triangle", 0}, {"barycentric", {0.5, 0.25}}, {"I", {0, 0, -1}},
                    {"surface", {{"mesh", mesh}, {"object_to_world", {1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}}};
    EXPECT_EQ(at(values(p, global_input(Global::P)), 0, 0), 11);
    EXPECT_EQ(at(values(p, global_input(Global::Po)), 0, 0), 1);
    EXPECT_EQ(at(values(p, global_input(Global::Ng)), 2, 0), -1) << "turned towards the viewer below";
    EXPECT_EQ(at(values(p, global_input(Global::Ngu)), 2, 0), 1);
    EXPECT_EQ(at(values(p, global_input(Global::Backfacing)), 0, 0), 1);
    EXPECT_EQ(at(values(p, global_input(Global::EdgeDistance)), 0, 0), 1);
    EXPECT_EQ(at(values(p, global_input(Global::Uv)), 1, 0), 0.25);
    EXPECT_EQ(at(values(p, global_input(Global::Dpdu)), 0, 0), 4);
    EXPECT_EQ(at(values(p, attribute_input("heat", 1)), 0, 0), 1);
}

TEST(points, a_reference_object_gives_its_space_to_object_coordinates) {
    const json p = {{"count", 1}, {"P", {3, 0, 0}}, {"surface", {{"reference_object_to_world", {2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}}}}};
    EXPECT_EQ(at(values(p, global_input(Global::Po)), 0, 0), 1);
}

TEST(points, numbers_are_rounded_to_single_precision) {
    EXPECT_EQ(at(values({{"count", 1}, {"P", {0.1, 0, 0}}}, global_input(Global::P)), 0, 0), static_cast<double>(0.1f));
}

TEST(points, faults_name_the_place) {
    EXPECT_EQ(first_fault(json::array()), "wrong-type /points");
    EXPECT_EQ(first_fault({{"P", {0, 0, 0}}}), "missing /points/count");
    EXPECT_EQ(first_fault({{"count", -1}}), "wrong-type /points/count");
    EXPECT_EQ(first_fault({{"count", 1e9}}), "wrong-type /points/count");
    EXPECT_EQ(first_fault({{"count", 1 << 25}}), "limit /points/count");
    EXPECT_EQ(first_fault({{"count", 2}, {"P", {{0, 0, 0}}}}), "wrong-length /points/P");
    EXPECT_EQ(first_fault({{"count", 2}, {"P", {{0, 0, 0}, {0, 0}}}}), "wrong-type /points/P/1");
    EXPECT_EQ(first_fault({{"count", 2}, {"P", "nan"}}), "wrong-type /points/P");
    EXPECT_EQ(first_fault({{"count", 2}, {"Pp", {0, 0, 0}}}), "unknown-field /points/Pp");
    EXPECT_EQ(first_fault({{"count", 2}, {"attributes", {{"a/b", {{1, 2}, {"x", 2}}}}}}), "wrong-type /points/attributes/a~1b/1");
    EXPECT_EQ(first_fault({{"count", 2}, {"object_to_world", {1, 2, 3}}}), "wrong-type /points/object_to_world");
    EXPECT_EQ(first_fault({{"count", 2}, {"surface", {{"mesh_file", "/nonexistent/mesh.json"}}}}), "wrong-mesh /points/surface/mesh_file");
    EXPECT_EQ(first_fault({{"count", 2}, {"surface", {{"camera", {{"type", "PANO"}}}}}}), "unsupported /points/surface/camera/type");
    const json mesh = {{"positions", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {"triangles", {{0, 1, 2}}}};
    EXPECT_EQ(first_fault({{"count", 1}, {"triangle", 1}, {"barycentric", {0.3, 0.3}}, {"surface", {{"mesh", mesh}}}}), "out-of-range /points/triangle");
    Diagnostics d;
    EXPECT_FALSE(PointSet::parse({{"count", 1}, {"surface", {{"mesh_file", "m.json"}}}}, "", "/points", {}, d));
    EXPECT_EQ(d.errors.at(0).code, "file-refused");
}

TEST(points, a_world_point_is_its_direction) {
    const json p = {{"count", 2}, {"direction", {{0, 0, 1}, {0, 1, 0}}}};
    EXPECT_EQ(at(values(p, global_input(Global::P), "world"), 1, 1), 1);
    EXPECT_EQ(at(values(p, global_input(Global::N), "world"), 1, 1), -1);
    EXPECT_EQ(at(values(p, global_input(Global::Reflection), "world"), 2, 0), -1);
    EXPECT_EQ(at(values(p, global_input(Global::RayDepth), "world"), 0, 0), 1);
}

// ---- against the reference renderer ---------------------------------------------------------------------------------

std::filesystem::path reference() {
    const char* env = std::getenv("ALDER_REFERENCE");
    return env ? std::filesystem::path(env) : std::filesystem::path(ALDER_SOURCE_DIR) / "tests/reference";
}

json load(const std::filesystem::path& path) {
    gzFile f = gzopen(path.c_str(), "rb");
    if (!f) return nullptr;
    std::string text;
    char block[65536];
    for (int n; (n = gzread(f, block, sizeof block)) > 0;) text.append(block, n);
    gzclose(f);
    return json::parse(text, nullptr, false);
}

TEST(points, what_is_derived_from_the_mesh_is_what_the_renderer_had) {
    const auto folder = reference() / "cycles_nodes";
    const json table = load(folder / "ShaderNodeNewGeometry.json.gz");
    if (table.is_null()) GTEST_SKIP() << "no reference tables in " << folder;
    int compared = 0;
    for (const json& c : table["cases"]) {
        const json& context = c["context"];
        if (context.value("tree", "") == "world") continue;
        json p = {{"count", c["points"]}, {"triangle", context["fields"]["triangle"]}, {"barycentric", context["fields"]["barycentric"]}};
        p["surface"] = {{"mesh_file", (folder / context["mesh"].get<std::string>()).string()}, {"camera", context["camera"]},
                        {"camera_to_world", context["camera_to_world"]}, {"object_to_world", context["object_to_world"]}};
        const struct { const char* name; Global g; double limit; } rows[] = {{"P", Global::P, 1e-5}, {"Ng", Global::Ng, 4e-6}, {"N", Global::N, 4e-6},
                                                                             {"I", Global::I, 1e-6}, {"uv", Global::Uv, 2e-6}, {"backfacing", Global::Backfacing, 0}};
        for (const auto& row : rows) {
            const auto v = values(p, global_input(row.g));
            const json& want = context["fields"][row.name];
            for (size_t i = 0; i < want.size(); ++i)
                for (size_t k = 0; k < (want[i].is_array() ? want[i].size() : 1); ++k) {
                    const double w = want[i].is_array() ? want[i][k].get<double>() : want[i].get<double>();
                    ASSERT_NEAR(at(v, static_cast<int>(k), i), w, row.limit) << row.name << " at point " << i;
                    ++compared;
                }
        }
        const auto length = values(p, global_input(Global::RayLength));
        const auto window = values(p, global_input(Global::Window));
        for (size_t i = 0; i < c["points"].get<size_t>(); ++i) {
            ASSERT_GT(at(length, 0, i), 0);
            // One sample in the middle of each pixel of 20 x 20.
            for (int k = 0; k < 2; ++k) {
                const double pixel = at(window, k, i) * 20;
                ASSERT_NEAR(pixel - std::floor(pixel), 0.5, 0.02) << "point " << i << ", raster position " << pixel;
                ASSERT_TRUE(pixel > 0 && pixel < 20) << "point " << i << ", raster position " << pixel;
            }
        }
    }
    EXPECT_GT(compared, 0);
}

}  // namespace
}  // namespace alder
