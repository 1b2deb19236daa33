// RenderPlan: what all workers of one render share: the scene, camera, filter, AOV layout, programs and limits. Immutable
// while workers run, apart from the stop flag.
#pragma once
#include <atomic>
#include <memory>
#include <vector>

#include "render/aov.h"
#include "render/camera.h"
#include "render/filter.h"
#include "render/prepared_scene.h"
#include "render/scene_query.h"
#include "render/shutter.h"
#include "render/volume/media.h"

namespace alder {

struct RenderPlan {
    RenderPlan(const PreparedScene& s, const RenderRequest& r);

    const PreparedScene& scene;
    RenderSettings settings;  ///< the scene's, with the request's resolution and samples
    uint32_t seed = 0;
    int crop_x = 0, crop_y = 0, width = 0, height = 0;  ///< data window
    CameraModel camera;
    PixelFilter filter;
    Shutter shutter;
    bool moves = false;  ///< whether rays need a time
    std::shared_ptr<const AovPlan> aovs;           ///< shared with pictures, which outlive the render
    std::vector<std::string> graph_aovs;             ///< what the materials compute
    InputScene inputs;
    std::unique_ptr<const MediaPlan> media;  ///< null: the scene has none
    SurfaceQuery query;  ///< for nodes that cast rays

    /// Of each material: the surface program, and the one with AOVs for what the camera sees (the same where it has none).
    struct SurfacePrograms {
        const SceneProgram* plain = nullptr;
        const SceneProgram* with_aovs = nullptr;
        std::vector<int> aov_user;  ///< output index of with_aovs -> index into AovPlan::user
    };
    std::vector<SurfacePrograms> surface;

    const std::atomic<bool>* cancel = nullptr;
    std::atomic<bool> out_of_time{false};
    bool stopped() const { return out_of_time.load(std::memory_order_relaxed) || (cancel && cancel->load(std::memory_order_relaxed)); }

  private:
    std::vector<std::shared_ptr<const SceneProgram>> owned_;
};

/// A rectangle of pixels of the data window.
struct Tile {
    int x0, y0, x1, y1;
    int pixels() const { return (x1 - x0) * (y1 - y0); }
};

}  // namespace alder
