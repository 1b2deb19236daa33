// PointSet: the shading points of an evaluation request. Parses the request's `points` object and supplies the globals and
// attributes that a program reads, one array of doubles per channel; what the request does not give is derived as the renderer
// would derive it (from the mesh, the matrices, the camera), or has the default of the interface description.
//
//   auto points = PointSet::parse(request["points"], domain, "/points", options, diagnostics);
//   std::vector<ChannelValues> channels;
//   for (const ProgramInput& in : program.inputs()) points->append(in, channels);
//
// Immutable after parsing; append() is thread safe. Numbers are rounded to float32 on reading: a request says what a renderer's
// single-precision registers hold, and the double kernels are to be judged on the same inputs.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/program.h"

namespace alder {

inline constexpr uint32_t kMaxPoints = uint32_t{1} << 24;

/// One channel: `count` values, or one value where it is the same for all points.
struct ChannelValues {
    std::vector<double> values;
    bool uniform = false;
};

struct PointOptions {
    /// Turns the request's mesh_file into a readable path; empty + message where it may not be read. Unset: no files.
    std::function<std::string(const std::string& file, std::string& error)> resolve_file;
};

struct PointData;
struct PointMesh;

class PointSet {
  public:
    /// Nothing where the request is wrong (all faults are in `d`). `domain`: "surface" (or empty) or "world".
    static std::optional<PointSet> parse(const nlohmann::json& points, const std::string& domain, const std::string& pointer_prefix,
                                         const PointOptions& options, Diagnostics& d);
    uint32_t count() const;
    /// Appends in.channels entries.
    void append(const ProgramInput& in, std::vector<ChannelValues>& channels) const;
    /// The same in the form of the interface description.
    void fill(const ProgramInput& in, std::vector<std::vector<double>>& channels, std::vector<bool>& uniform) const;
    /// The mesh that the points lie on, in object space, and its matrix (row-major 3x4); null: none, or a world.
    std::shared_ptr<const PointMesh> mesh() const;
    std::array<double, 12> object_to_world() const;
    /// Whether the request or its mesh has an attribute of that name (a program reads zeros where not).
    bool has_attribute(const std::string& name) const;

  private:
    std::shared_ptr<const PointData> data_;
};

}  // namespace alder
