// What a node may ask of the scene around a shading point (Ambient Occlusion, Bevel). Whoever executes a program on points of a
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

}  // namespace alder
