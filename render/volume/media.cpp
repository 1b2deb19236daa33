// Media: constants, bounds and boundaries.
#include "render/volume/media.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/sampling.h"

namespace alder {
namespace {

constexpr int kCellsOfLongestSide = 32;
constexpr int kSamplesPerCellSide = 2;
/// Bounds are measured, so they are raised a little; what exceeds them all the same is noise, not bias.
constexpr float kHeadroom = 1.1f;
/// Collisions tried while crossing a box that seems to be empty: what hides between the samples is found now and then.
constexpr float kLeastCollisions = 0.25f;

Vec3f usable(Vec3f v) {
    for (int c = 0; c < 3; ++c) v[c] = v[c] > 0 && std::isfinite(v[c]) ? v[c] : 0.f;
    return v;
}

/// Runs a volume's program at points of one instance.
class VolumeEvaluator {
  public:
    VolumeEvaluator(const InputScene& inputs, const EvalContext& context) : inputs_(inputs), executor_(context) {}

    template <class Take>
    void run(const SceneProgram& program, std::span<const ShadingPoint> points, Take take) {
        RayHistory history;
        history.kinds = 0;
        const size_t batch = program.program->batch();
        const std::vector<const RayHistory*> histories(std::min(batch, points.size()), &history);
        std::vector<Channel<float>> channels;
        for (size_t first = 0; first < points.size(); first += batch) {
            const size_t n = std::min(batch, points.size() - first);
            const auto in = gather_.gather(program.plan, inputs_, points.subspan(first, n), histories.data());
            executor_.run(*program.program, static_cast<uint32_t>(n), in);
            for (const ProgramLobe& lobe : program.program->lobes()) {
                channels.clear();
                for (int c = 0; c < lobe.spec.channels(); ++c) channels.push_back(executor_.channel(lobe.register_first + c));
                for (size_t i = 0; i < n; ++i) take(first + i, load_lobe(lobe.spec, channels.data(), i));
            }
        }
    }

  private:
    InputScene inputs_;
    Executor<float> executor_;
    InputGather gather_;
};

ShadingPoint point_within(uint32_t instance, Vec3f p) {
    ShadingPoint s;
    s.p = p;
    s.n = s.ng = s.wo = Vec3f(0, 0, 1);
    s.instance = instance;
    s.triangle = kNothing;
    return s;
}

std::unique_ptr<const MajorantGrid> measure(const SceneProgram& program, uint32_t instance, Vec3f low, Vec3f high, const InputScene& inputs,
                                            const EvalContext& context) {
    const Vec3f size = high - low;
    const float longest = std::max({size.x, size.y, size.z, 1e-20f});
    std::array<int, 3> cells, samples;
    for (int c = 0; c < 3; ++c) {
        cells[c] = std::clamp(static_cast<int>(std::ceil(kCellsOfLongestSide * size[c] / longest)), 1, kCellsOfLongestSide);
        samples[c] = cells[c] * kSamplesPerCellSide;
    }
    std::vector<float> density(size_t(samples[0]) * samples[1] * samples[2], 0.f);
    tbb::enumerable_thread_specific<VolumeEvaluator> evaluators([&] { return VolumeEvaluator(inputs, context); });
    std::vector<uint8_t> emits(samples[2], 0);
    tbb::parallel_for(0, samples[2], [&](int z) {
        std::vector<ShadingPoint> points;
        for (int y = 0; y < samples[1]; ++y)
            for (int x = 0; x < samples[0]; ++x) {
                const Vec3f at((x + 0.5f) / samples[0], (y + 0.5f) / samples[1], (z + 0.5f) / samples[2]);
                points.push_back(point_within(instance, low + size * at));
            }
        std::vector<MediumValues> values(points.size());
        evaluators.local().run(program, points, [&](size_t i, const Lobe<float>& lobe) { add_lobe(values[i], lobe); });
        for (size_t i = 0; i < values.size(); ++i) {
            const Vec3f e = values[i].extinction();
            density[size_t(z) * points.size() + i] = std::max({e.x, e.y, e.z});
            emits[z] |= !is_black(values[i].emission);
        }
    });
    // A cell's bound covers its own samples and the next ones around it.
    const float diagonal = std::max(length(size), 1e-20f);
    const bool glows = std::any_of(emits.begin(), emits.end(), [](uint8_t e) { return e != 0; });
    const float least = (glows ? 8 : kLeastCollisions) / diagonal;
    std::vector<float> bounds(size_t(cells[0]) * cells[1] * cells[2]);
    for (int z = 0; z < cells[2]; ++z)
        for (int y = 0; y < cells[1]; ++y)
            for (int x = 0; x < cells[0]; ++x) {
                float most = 0;
                const auto range = [&](int cell, int axis) {
                    return std::pair{std::max(cell * kSamplesPerCellSide - 1, 0), std::min((cell + 1) * kSamplesPerCellSide + 1, samples[axis])};
                };
                const auto [x0, x1] = range(x, 0);
                const auto [y0, y1] = range(y, 1);
                const auto [z0, z1] = range(z, 2);
                for (int k = z0; k < z1; ++k)
                    for (int j = y0; j < y1; ++j)
                        for (int i = x0; i < x1; ++i) most = std::max(most, density[(size_t(k) * samples[1] + j) * samples[0] + i]);
                bounds[(size_t(z) * cells[1] + y) * cells[0] + x] = std::max(most * kHeadroom, least);
            }
    return std::make_unique<MajorantGrid>(low, high, cells, std::move(bounds));
}

Medium make_medium(const SceneProgram* program, const InputScene& inputs, const EvalContext& context) {
    Medium m;
    m.program = program;
    if (!program || !program->program->facts().spatially_constant) return m;
    m.homogeneous = true;
    const ShadingPoint anywhere = point_within(kNothing, Vec3f(0.f));
    VolumeEvaluator(inputs, context).run(*program, std::span(&anywhere, 1), [&](size_t, Lobe<float> lobe) {
        add_lobe(m.values, lobe);
        lobe.weight = usable(lobe.weight);
        if (lobe.spec->is_phase() && !is_black(lobe.weight)) m.phases.push_back(lobe);
    });
    return m;
}

bool has_interior(const MaterialPrograms& m) {
    if (!m.surface) return false;
    const auto& lobes = m.surface->program->lobes();
    return std::any_of(lobes.begin(), lobes.end(), [](const ProgramLobe& l) { return l.spec.kind == LobeKind::Interior; });
}

}  // namespace

void add_lobe(MediumValues& sum, const Lobe<float>& lobe) {
    if (lobe.spec->kind == LobeKind::Absorption) sum.absorption += usable(lobe.weight);
    else if (lobe.spec->is_phase()) sum.scattering += usable(lobe.weight);
    else if (lobe.spec->kind == LobeKind::Emission && is_finite(lobe.weight)) sum.emission += lobe.weight;
}

Vec3f transmittance(Vec3f extinction, float length) {
    Vec3f t;
    for (int c = 0; c < 3; ++c) t[c] = extinction[c] > 0 ? std::exp(-extinction[c] * length) : 1.f;
    return t;
}

Vec3f emitted_along(const MediumValues& v, float length) {
    const Vec3f extinction = v.extinction();
    Vec3f sum;
    for (int c = 0; c < 3; ++c) {
        const float depth = extinction[c] * length;
        // (1 - exp(-x)) / x, whose limit at 0 is 1
        if (depth > 0) sum[c] = v.emission[c] * (std::isfinite(depth) ? -std::expm1(-depth) : 1.f) / extinction[c];
        else sum[c] = std::isfinite(length) ? v.emission[c] * length : 0.f;
    }
    return sum;
}

MajorantGrid::MajorantGrid(Vec3f low, Vec3f high, std::array<int, 3> cells, std::vector<float> bounds)
    : low_(low), high_(high), cells_(cells), bounds_(std::move(bounds)) {
    for (int c = 0; c < 3; ++c) cell_[c] = std::max((high[c] - low[c]) / static_cast<float>(cells[c]), 1e-30f);
}

MajorantGrid::Cell MajorantGrid::at(Vec3f origin, Vec3f direction, float t) const {
    constexpr float kForever = std::numeric_limits<float>::infinity();
    // The part of the ray within the box.
    float enter = 0, leave = kForever;
    for (int c = 0; c < 3; ++c) {
        if (direction[c] == 0) {
            if (origin[c] < low_[c] || origin[c] > high_[c]) return {0, kForever};
            continue;
        }
        const float a = (low_[c] - origin[c]) / direction[c], b = (high_[c] - origin[c]) / direction[c];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    if (!(leave > t) || !(leave > enter)) return {0, kForever};
    if (t < enter) return {0, enter};
    const Vec3f p = origin + direction * t;
    size_t index = 0;
    float exit = leave;
    for (int c = 2; c >= 0; --c) {
        int i = std::clamp(static_cast<int>((p[c] - low_[c]) / cell_[c]), 0, cells_[c] - 1);
        if (direction[c] != 0) {
            const auto wall = [&](int cell) { return (low_[c] + static_cast<float>(direction[c] > 0 ? cell + 1 : cell) * cell_[c] - origin[c]) / direction[c]; };
            float w = wall(i);
            // On a wall, by rounding: the cell beyond it.
            if (!(w > t)) {
                const int next = direction[c] > 0 ? i + 1 : i - 1;
                if (next >= 0 && next < cells_[c]) w = wall(i = next);
                else w = leave;
            }
            exit = std::min(exit, w);
        }
        index = index * cells_[c] + i;
    }
    exit = std::max(exit, std::nextafter(t, kForever));
    return {bounds_[index], exit};
}

std::unique_ptr<const MediaPlan> MediaPlan::make(std::span<const std::shared_ptr<const MaterialPrograms>> materials, const SceneProgram* world,
                                                 const InputScene& inputs, Vec3f camera, const EvalContext& context) {
    const auto inside = [](const auto& m) { return m->volume || has_interior(*m); };
    if (!world && std::none_of(materials.begin(), materials.end(), inside)) return nullptr;
    auto plan = std::make_unique<MediaPlan>();
    for (const auto& m : materials) plan->media_.push_back(make_medium(m->volume.get(), inputs, context));
    plan->media_.push_back(make_medium(world, inputs, context));

    const Surfaces& surfaces = *inputs.surfaces;
    uint32_t bodies = 0;
    for (uint32_t i = 0; i < surfaces.instances().size(); ++i) {
        plan->first_of_instance_.push_back(static_cast<uint32_t>(plan->bounded_.size()));
        bool counts = false;
        for (const uint32_t m : surfaces.instances()[i].materials) {
            counts |= inside(materials[m]);
            if (!plan->has(m)) continue;
            const Transform& to_world = surfaces.instances()[i].object_to_world;
            Vec3f low(std::numeric_limits<float>::infinity()), high = -low;
            for (const Vec3f& p : surfaces.mesh_of(i).positions) {
                const Vec3f q = to_world.point(p);
                for (int c = 0; c < 3; ++c) {
                    low[c] = std::min(low[c], q[c]);
                    high[c] = std::max(high[c], q[c]);
                }
            }
            if (!is_finite(low) || !is_finite(high)) continue;
            const Vec3f margin = (high - low) * 1e-5f;
            Bounded b{i, m, low - margin, high + margin, nullptr};
            const Medium& medium = plan->media_[m];
            if (!medium.homogeneous) b.grid = measure(*medium.program, i, b.low, b.high, inputs, context);
            plan->bounded_.push_back(std::move(b));
        }
        bodies += counts;
    }
    plan->first_of_instance_.push_back(static_cast<uint32_t>(plan->bounded_.size()));
    plan->depth_ = std::clamp<uint32_t>(bodies + (world ? 1 : 0), 1, 32);
    if (world) {
        const uint32_t index = static_cast<uint32_t>(materials.size());
        plan->world_ = {kNothing, index};
        if (!plan->media_[index].homogeneous) {
            // Endless, but measured around the scene only: beyond that there is nothing.
            Vec3f low = camera, high = camera;
            if (!surfaces.instances().empty())
                for (int c = 0; c < 3; ++c) {
                    low[c] = std::min(low[c], surfaces.accel().bounds_min()[c]);
                    high[c] = std::max(high[c], surfaces.accel().bounds_max()[c]);
                }
            const Vec3f middle = (low + high) * 0.5f;
            const float reach = std::max(2 * length(high - low), 1.f);
            Bounded b{kNothing, index, middle - Vec3f(reach), middle + Vec3f(reach), nullptr};
            b.grid = measure(*world, kNothing, b.low, b.high, inputs, context);
            plan->world_.grid = b.grid.get();
            plan->bounded_.push_back(std::move(b));
        }
    }
    return plan;
}

const MajorantGrid* MediaPlan::grid(uint32_t instance, uint32_t medium) const {
    for (uint32_t k = first_of_instance_[instance]; k < first_of_instance_[instance + 1]; ++k)
        if (bounded_[k].medium == medium) return bounded_[k].grid.get();
    return nullptr;
}

bool MediaPlan::may_contain(Vec3f p) const {
    return std::any_of(bounded_.begin(), bounded_.end(), [&](const Bounded& b) {
        return b.instance != kNothing && p.x >= b.low.x && p.y >= b.low.y && p.z >= b.low.z && p.x <= b.high.x && p.y <= b.high.y && p.z <= b.high.z;
    });
}

bool cross_boundary(InsideOf* inside, uint8_t& count, uint32_t depth, const InsideOf& medium, bool leaving) {
    const auto same = [&](const InsideOf& m) { return m.instance == medium.instance && m.medium == medium.medium; };
    InsideOf* const end = inside + count;
    InsideOf* const found = std::find_if(inside, end, same);
    if (leaving) {
        if (found == end) return true;
        std::copy(found + 1, end, found);
        --count;
        return true;
    }
    if (found != end) return true;
    if (count >= depth) return false;
    *end = medium;
    ++count;
    return true;
}

}  // namespace alder
