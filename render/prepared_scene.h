// PreparedScene: a scene revision ready to render: surfaces with their BVH, compiled programs, the light table.
// Immutable; parts are shared between revisions. Its workers (executors and buffers of a thread) are kept from render to
// render, so that a preview allocates nothing.
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "render/camera.h"
#include "render/light/light_table.h"
#include "render/programs.h"
#include "render/render.h"

namespace alder {

class Worker;  // render/worker.h: one thread's executor, wavefront and buffers

/// Hands out workers, one to a thread at a time.
class WorkerPool {
  public:
    explicit WorkerPool(const EvalContext& context);
    ~WorkerPool();
    std::unique_ptr<Worker> take();
    void give_back(std::unique_ptr<Worker> worker);
    const EvalContext& context() const { return context_; }

  private:
    EvalContext context_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Worker>> idle_;
};

class PreparedScene {
  public:
    std::shared_ptr<const Scene> scene;  ///< settings, camera, lights; its materials may be older than `materials`
    std::shared_ptr<const Surfaces> surfaces;
    std::vector<std::shared_ptr<const MaterialPrograms>> materials;
    std::vector<Light> lamps;  ///< with constant emission graphs multiplied into the colour
    std::vector<std::shared_ptr<const SceneProgram>> light_programs;  ///< by lamp; null: none left
    std::shared_ptr<const WorldLight> world;
    std::shared_ptr<const LightTable> lights;
    std::shared_ptr<WorkerPool> workers;

    std::vector<int> material_pass_index;
    bool has_transparent_shadows = false;
    double build_seconds = 0, compile_seconds = 0;
};

}  // namespace alder
