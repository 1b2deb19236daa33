// Voronoi Texture: distances, colours and positions of random points scattered one a cell. Follows Cycles' SVM; the mathematics
// is in noise/voronoi-inl.h, the kernels in tex_voronoi_1d.cpp to tex_voronoi_4d.cpp.
#include "nodes/texture/tex_voronoi.h"

#include <array>

#include "nodes/texture/texture_mapping.h"

namespace alder {
namespace {
using namespace tex_voronoi;

const Kernel& kernel_of(const Statics& s) {
    static const std::array<Kernel, 4> kernels = {tex_voronoi_1d(), tex_voronoi_2d(), tex_voronoi_3d(), tex_voronoi_4d()};
    return kernels[s.e(kDimensions)];
}

enum Feature { kF1, kF2, kSmoothF1, kDistanceToEdge, kSphereRadius };
constexpr int kMinkowski = 3;

bool uses(const Statics& s, int p) {
    const int dimensions = s.e(kDimensions) + 1, feature = s.e(kFeature);
    const bool points = feature == kF1 || feature == kF2 || feature == kSmoothF1;
    const bool metric = points && dimensions > 1;
    switch (p) {
        case kVector: case kMapping: return dimensions > 1;
        case kW: return dimensions == 1 || dimensions == 4;
        case kDistance: return metric;
        case kExponent: return metric && s.e(kDistance) == kMinkowski;
        case kSmoothness: return feature == kSmoothF1;
        case kDetail: case kRoughness: case kLacunarity: case kNormalize: return feature != kSphereRadius;
        default: return true;
    }
}
}  // namespace

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "ShaderNodeTexVoronoi";
    n.aliases = {"voronoi_texture"};
    n.system = System::Cycles;
    n.category = "texture";
    n.summary = "cells around random points: distance, colour, position";
    n.help = "One random point a cell of a unit grid. F1 and F2 measure to the nearest and the second nearest point, Smooth F1 blends them, "
             "Distance to Edge measures to the border between cells, N-Sphere Radius gives half the distance between neighbouring points. "
             "Detail adds octaves as in the Noise Texture.";
    n.params = {
        texture_mapping_param(),
        choice("voronoi_dimensions", {{"1D", "1D", "1D"}, {"2D", "2D", "2D"}, {"3D", "3D", "3D"}, {"4D", "4D", "4D"}}, "3D")
            .alias("dimensions").doc("which coordinates are read: W; Vector's x, y; Vector; Vector and W"),
        choice("distance",
               {{"EUCLIDEAN", "Euclidean", "euclidean"}, {"MANHATTAN", "Manhattan", "manhattan"}, {"CHEBYCHEV", "Chebychev", "chebychev"},
                {"MINKOWSKI", "Minkowski", "minkowski"}},
               "EUCLIDEAN").alias("metric").doc("how distance is measured; Distance to Edge and N-Sphere Radius are always Euclidean"),
        choice("feature",
               {{"F1", "F1", "f1"}, {"F2", "F2", "f2"}, {"SMOOTH_F1", "Smooth F1", "smooth_f1"},
                {"DISTANCE_TO_EDGE", "Distance to Edge", "distance_to_edge"}, {"N_SPHERE_RADIUS", "N-Sphere Radius", "n_sphere_radius"}},
               "F1").doc("what is measured"),
        vector("Vector", 0, 0, 0).unlinked(Global::Generated).doc("where the cells are read; unlinked: generated coordinates"),
        f("W").range(-1000, 1000).doc("coordinate of 1D, fourth coordinate of 4D"),
        f("Scale", 5).range(-1000, 1000).doc("frequency of the first octave"),
        f("Detail", 0).range(0, 15).doc("octaves beyond the first; clamped to 0 to 15"),
        f("Roughness", 0.5).range(0, 1).doc("strength of an octave relative to the one before; clamped to 0 to 1"),
        f("Lacunarity", 2).range(0, 1000).doc("frequency of an octave relative to the one before"),
        f("Smoothness", 1).range(0, 1).doc("width of the blend of Smooth F1; clamped to 0 to 1"),
        f("Exponent", 0.5).range(0, 32).doc("exponent of the Minkowski distance"),
        f("Randomness", 1).range(0, 1).doc("0 puts the points on a grid; clamped to 0 to 1"),
        b("normalize").no_link().alias("use_normalize").doc("divide by the largest possible distance"),
        color_mapping_param(),
    };
    n.outputs = {{"Distance", Type::Float}, {"Color", Type::Color}, {"Position", Type::Vector}, {"W", Type::Float}, {"Radius", Type::Float}};
    n.kernel.lanes = [](const OpCall<float>& c) { kernel_of(*c.statics).lanes(c); };
    n.kernel.scalar = [](const OpCall<float>& c) { kernel_of(*c.statics).scalar(c); };
    n.kernel.f64 = [](const OpCall<double>& c) { kernel_of(*c.statics).f64(c); };
    n.cost_ns = 200;
    n.uses = uses;
    n.prepare = prepare_texture_mapping;
    return n;
}
}  // namespace alder
