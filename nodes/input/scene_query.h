// What a node may ask of the scene around a shading point (Ambient Occlusion, Bevel, alCurvature). Whoever executes a program on points of a
// scene puts its answerer in place for the thread and the time of the run; without one there is nothing around the point.
#pragma once
#include <cstdint>

namespace alder {

class SceneQuery {
  public:
    virtual ~SceneQuery() = default;
    /// World space; ng and n are turned towards the viewer.
    struct Point {
        float p[3], ng[3], n[3];
        int instance;           ///< of the surface; negative: none
        float position_error;   ///< bound of the rounding error of p
        bool backfacing;
        uint32_t seed;          ///< decides the directions of the rays
    };
    /// Share of `samples` cosine-weighted rays about `normal` that meet nothing within `distance`.
    virtual float unoccluded(const Point& point, const float normal[3], float distance, int samples, bool only_local) const = 0;
    /// Normal averaged over the surface of the same object within `radius`.
    virtual void bevel(const Point& point, float radius, int samples, float normal[3]) const = 0;
    /// Sphere through the surfaces around the point, by side² probes along `view`: its curvature, positive where the surface bulges
    /// towards its normal. False where nothing was found or what was found fits no sphere.
    virtual bool curvature(const Point& point, const float view[3], float radius, int side, float& value) const = 0;
};

namespace scene_query_detail {
inline thread_local const SceneQuery* current = nullptr;
}
inline const SceneQuery* current_scene_query() { return scene_query_detail::current; }

/// Puts `query` in place for this thread while it lives.
class SceneQueryScope {
  public:
    explicit SceneQueryScope(const SceneQuery* query) : before_(scene_query_detail::current) { scene_query_detail::current = query; }
    ~SceneQueryScope() { scene_query_detail::current = before_; }
    SceneQueryScope(const SceneQueryScope&) = delete;
    SceneQueryScope& operator=(const SceneQueryScope&) = delete;

  private:
    const SceneQuery* before_;
};

/// Names under which programs read, as attributes, what Point needs beyond globals.
inline constexpr const char* kSceneInstance = "scene:instance";
inline constexpr const char* kScenePositionError = "scene:position_error";

/// Algebraic sphere fit to points with normals, relative to the point looked at (Guennebaud and Gross, "Algebraic Point Set
/// Surfaces", 2007; alshaders specification, section 3). Sums in double: points far away differ in their last digits.
class SphereFit {
  public:
    explicit SphereFit(double radius) : radius2_(radius * radius) {}
    /// q: from the point looked at. Points beyond the radius do not count.
    void add(const double q[3], const double n[3]) {
        const double d2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
        if (!(d2 <= radius2_)) return;
        const double s = d2 / radius2_ - 1, w = s * s;
        weights_ += w;
        for (int c = 0; c < 3; ++c) {
            q_[c] += w * q[c];
            n_[c] += w * n[c];
            qn_ += w * q[c] * n[c];
        }
        qq_ += w * d2;
    }
    bool curvature(float& value) const {
        if (!(weights_ > 0)) return false;
        double a = qn_, b = qq_;
        for (int c = 0; c < 3; ++c) {
            a -= q_[c] / weights_ * n_[c];
            b -= q_[c] / weights_ * q_[c];
        }
        if (!(b > 1e-6 * qq_)) return false;  // one place only
        value = static_cast<float>(a / (2 * b));
        return value == value && value - value == 0;
    }

  private:
    double radius2_, weights_ = 0, qn_ = 0, qq_ = 0, q_[3] = {}, n_[3] = {};
};

}  // namespace alder
