// Curves and spheres: where a hit lies on a thread or a ball, and what hair nodes ask of it.
//
// A hit on a thread keeps how far along its segment it lies (u) and the angle about the thread (v); on a ribbon v runs from -1 to 1
// across it; on a sphere u and v are the direction from the centre. So a point follows from its hit alone, exactly on the surface.
#pragma once
#include <array>
#include <vector>

#include "render/scene.h"

namespace alder {

/// A segment's two ends and their neighbours along the curve, which count twice where it begins or ends.
struct CurveKeys {
    std::array<Vec3f, 4> p;
    std::array<float, 4> radius;
};
/// First point of a segment, and the curve it belongs to.
struct CurveSegment {
    uint32_t point = 0, curve = 0;
};
/// Segments in the order of their curves.
std::vector<CurveSegment> curve_segments(const Mesh& mesh);
CurveKeys curve_keys(const Mesh& mesh, CurveSegment segment, float time);

struct CurvePoint {
    Vec3f center, tangent;  ///< the tangent is the derivative by u, not normalised
    float radius = 0;
};
CurvePoint curve_point(const CurveKeys& keys, CurveForm form, float u);

/// Direction from the axis (unit, across the tangent) by its angle, and back.
Vec3f around_curve(Vec3f tangent, float angle);
float angle_around_curve(Vec3f tangent, Vec3f direction);
/// Unit directions on the square [-1, 1]^2: Cigolle et al., "A Survey of Efficient Representations for Independent Unit
/// Vectors", JCGT 2014, section 3.2.
void encode_direction(Vec3f direction, float& u, float& v);
Vec3f decode_direction(float u, float v);

/// What Curves Info says, made when the first program asks.
struct ThreadTable {
    std::vector<CurveSegment> segments;
    std::vector<float> intercepts;  ///< per point: 0 at the root .. 1 at the tip
    std::vector<float> lengths;     ///< per curve, object space
    static ThreadTable make(const Mesh& mesh);
};

/// Cycles' random number of a curve or a point by its index.
float element_random(uint32_t index);

}  // namespace alder
