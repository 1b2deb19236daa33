// Curves Info, Point Info, Particle Info and Volume Info: data of hair, point clouds, particles and volumes (Blender's nodes).
//
// The geometry supplies them as attributes of these names, so that anything else reads as zero, as in Cycles:
//   curve:is_strand, curve:intercept (0 at the root, 1 at the tip), curve:length, curve:thickness, curve:tangent_normal, curve:random
//   point:position (world space), point:radius, point:random
//   particle:index, particle:random, particle:age, particle:lifetime, particle:location, particle:size, particle:velocity,
//   particle:angular_velocity
//   density, flame, temperature, color (grids of a volume)
#include "graph/lowering.h"

namespace alder {
namespace {

struct Source {
    const char* output;
    Type type;
    const char* attribute;
};

constexpr Source kCurve[] = {{"Is Strand", Type::Float, "curve:is_strand"},
                             {"Intercept", Type::Float, "curve:intercept"},
                             {"Length", Type::Float, "curve:length"},
                             {"Thickness", Type::Float, "curve:thickness"},
                             {"Tangent Normal", Type::Vector, "curve:tangent_normal"},
                             {"Random", Type::Float, "curve:random"}};
constexpr Source kPoint[] = {{"Position", Type::Vector, "point:position"}, {"Radius", Type::Float, "point:radius"}, {"Random", Type::Float, "point:random"}};
constexpr Source kParticle[] = {{"Index", Type::Float, "particle:index"},
                                {"Random", Type::Float, "particle:random"},
                                {"Age", Type::Float, "particle:age"},
                                {"Lifetime", Type::Float, "particle:lifetime"},
                                {"Location", Type::Vector, "particle:location"},
                                {"Size", Type::Float, "particle:size"},
                                {"Velocity", Type::Vector, "particle:velocity"},
                                {"Angular Velocity", Type::Vector, "particle:angular_velocity"}};
constexpr Source kVolume[] = {{"Color", Type::Color, "color"},
                              {"Density", Type::Float, "density"},
                              {"Flame", Type::Float, "flame"},
                              {"Temperature", Type::Float, "temperature"}};

template <const auto& kSources>
NodeType info_node(const char* name, const char* alias, const char* summary) {
    NodeType n;
    n.name = name;
    n.category = "Input";
    n.summary = summary;
    n.help = "Zero on geometry that has no such data.";
    n.aliases = {alias};
    for (const Source& s : kSources) n.outputs.push_back({s.output, s.type});
    n.lower = [](Lowering& l, int output) { l.result(l.attribute(kSources[output].attribute, kSources[output].type)); };
    return n;
}

}  // namespace

ALDER_NODE { return info_node<kCurve>("ShaderNodeHairInfo", "hair_info", "position along a hair, its length, thickness and a random number"); }
ALDER_NODE { return info_node<kPoint>("ShaderNodePointInfo", "point_info", "centre, radius and a random number of a point of a point cloud"); }
ALDER_NODE { return info_node<kParticle>("ShaderNodeParticleInfo", "particle_info", "age, size, motion and numbers of the particle that an instance stands for"); }
ALDER_NODE { return info_node<kVolume>("ShaderNodeVolumeInfo", "volume_info", "density, temperature, flame and colour of a volume"); }

}  // namespace alder
