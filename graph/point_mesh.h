// PointMesh: a mesh in oracle-mesh/1 form, from which the shading points of an evaluation request may be derived.
//
// Object space; triangle t has the corners 3t, 3t+1, 3t+2. Immutable after loading. Everything is interpolated in double from
// the file's float32 numbers, so that rounding here stays far below that of a kernel.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "nodes/num/vec.h"

namespace alder {

struct PointMesh {
    enum class Domain : uint8_t { Point, Face, Corner };
    struct Attribute {
        Domain domain = Domain::Point;
        int channels = 1;
        std::vector<float> values;
    };
    std::vector<Vec3d> positions, vertex_normals;  ///< normals are empty where the file has none
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<uint8_t> smooth;  ///< per triangle; empty = all flat
    std::string active_uv, active_color;  ///< first of the file; empty = none
    std::map<std::string, Attribute> attributes;  ///< UV maps too (2 channels a corner)
    Vec3d texspace_location{0, 0, 0}, texspace_size{1, 1, 1};

    /// Up to four numbers of an attribute at a barycentric position of a triangle (weights of corners 0 and 1).
    std::array<double, 4> interpolate(const Attribute& a, uint32_t triangle, double w0, double w1) const;
    const Attribute* find(const std::string& name) const;
};

/// Null + message where the structure is wrong.
std::shared_ptr<const PointMesh> parse_point_mesh(const nlohmann::json& mesh, std::string& error);
/// Reads a file (gzip or plain JSON). The few meshes used last are kept for the process. Thread safe.
std::shared_ptr<const PointMesh> load_point_mesh(const std::string& path, std::string& error);

}  // namespace alder
