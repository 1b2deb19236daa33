// Emission of many points at once; the world's importance map.
#include "render/emission.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

#include "render/light/light_table.h"
#include "render/sampling.h"

namespace alder {

ShadingPoint lamp_point(const Lamp& lamp, const LampSample& s, Vec3f p) {
    ShadingPoint r;
    r.lamp = &lamp.frame();
    const bool at_infinity = !std::isfinite(s.distance);
    r.p = at_infinity ? -s.wi : p + s.wi * s.distance;
    r.wo = -s.wi;
    r.ng = dot(s.ng, r.wo) < 0 ? -s.ng : s.ng;
    r.n = r.ng;
    r.u = s.u;
    r.v = s.v;
    r.distance = at_infinity ? std::numeric_limits<float>::max() : s.distance;
    return r;
}

ShadingPoint world_point(Vec3f direction) {
    ShadingPoint r;
    r.p = direction;
    r.n = r.ng = r.wo = -direction;
    r.distance = std::numeric_limits<float>::max();
    return r;
}

Vec3f emission_of(const Program& program, const Executor<float>& executor, size_t i) {
    Vec3f sum(0.f);
    for (const ProgramLobe& lobe : program.lobes()) {
        if (lobe.spec.kind != LobeKind::Emission) continue;
        for (int c = 0; c < 3; ++c) {
            const Channel<float> w = executor.channel(lobe.register_first + c);
            sum[c] += w.p[i * w.stride];
        }
    }
    return sum;
}

std::vector<Vec3f> EmissionEvaluator::operator()(const SceneProgram& program, std::span<const ShadingPoint> points) {
    RayHistory history;
    history.kinds = 0;
    history.depth = 1;
    std::vector<Vec3f> radiance(points.size());
    const size_t batch = program.program->batch();
    const std::vector<const RayHistory*> histories(std::min(batch, points.size()), &history);
    for (size_t first = 0; first < points.size(); first += batch) {
        const size_t n = std::min(batch, points.size() - first);
        const auto inputs = gather_.gather(program.plan, scene_, points.subspan(first, n), histories.data());
        executor_.run(*program.program, static_cast<uint32_t>(n), inputs);
        for (size_t i = 0; i < n; ++i) radiance[first + i] = emission_of(*program.program, executor_, i);
    }
    return radiance;
}

std::shared_ptr<const WorldLight> build_world(const World& world, const Surfaces& surfaces, const CameraModel& camera,
                                              const EvalContext& context, Diagnostics& d) {
    auto light = std::make_shared<WorldLight>();
    light->light_group = world.light_group;
    light->visibility = world.visibility;
    const auto compiled = compile_material({"world", world.graph, 0}, surfaces, RenderSettings{}, d);
    if (compiled) light->volume = compiled->volume;
    if (!compiled || !compiled->emission) return light;
    if (compiled->emission_constant) {
        light->constant = compiled->emission_value;
        return light;
    }
    light->program = compiled->emission;
    const int width = std::clamp(world.importance_resolution, 4, 8192), height = width / 2;
    std::vector<Vec3f> radiance(size_t(width) * height);
    const InputScene scene{&surfaces, &camera, {}};
    tbb::enumerable_thread_specific<EmissionEvaluator> evaluators([&] { return EmissionEvaluator(scene, context); });
    tbb::parallel_for(0, height, [&](int y) {
        std::vector<ShadingPoint> points;
        points.reserve(width);
        for (int x = 0; x < width; ++x) points.push_back(world_point(EnvironmentMap::cell_direction(width, height, x, y)));
        const std::vector<Vec3f> row = evaluators.local()(*light->program, points);
        std::copy(row.begin(), row.end(), radiance.begin() + size_t(y) * width);
    });
    light->map = EnvironmentMap(width, height, radiance);
    return light;
}

}  // namespace alder
