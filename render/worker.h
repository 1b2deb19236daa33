// Worker: one thread's wavefront. Traces the samples of a tile together, stage by stage, so that points with the same program
// are shaded as one batch.
//
//   for each depth:  intersect -> background, lamps met -> surfaces by program -> ways through bodies -> lights -> shadow rays
//
// All state is private to the thread and reused; nothing a sample records depends on what else is in the wavefront. Within a
// path, contributions are added in the order of its vertices, and at a vertex in the order of the stages.
#pragma once
#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "graph/program.h"
#include "render/aov.h"
#include "render/closure/bsdf.h"
#include "render/film.h"
#include "render/inputs.h"
#include "render/light/light_table.h"
#include "render/render_plan.h"
#include "render/sampler.h"

namespace alder {

struct WorkerCounters {
    uint64_t camera_rays = 0, bounce_rays = 0, shadow_rays = 0, subsurface_rays = 0, timed_paths = 0, shading_points = 0, nonfinite_samples = 0;
    uint64_t medium_segments = 0, medium_points = 0;  ///< parts of rays within media; evaluations of volume programs
    uint64_t media_ignored = 0;                       ///< boundaries crossed with no room to remember them
};

/// Boundaries of volumes without a surface that one ray may pass (Cycles' limit).
inline constexpr int kMostBoundaries = 1024;

/// The layer a lobe's light goes to; glass counts by the side it leaves on (as in Cycles).
inline LobeLabel label_of(const LobeSpec& spec, bool is_transmission) {
    if (spec.kind != LobeKind::MicrofacetGlass) return spec.label;
    return is_transmission ? LobeLabel::Refraction : spec.label == LobeLabel::Refraction ? LobeLabel::Specular : spec.label;
}

/// Lambert where subsurface light leaves, and where it stands for subsurface light.
const LobeSpec& subsurface_lambert();

class Worker {
  public:
    explicit Worker(const EvalContext& context);

    void begin(const RenderPlan& plan);
    /// Samples [first, first + count) of every pixel of the tile, within one leaf, added to `leaf` (one sum a pixel).
    /// False if stopped on the way.
    bool trace(const Tile& tile, uint64_t first, uint32_t count, std::span<LeafSum> leaf);

    const WorkerCounters& counters() const { return counters_; }
    /// Since begin().
    ExecStats executed() const {
        const ExecStats& now = executor_.stats();
        return {now.points - before_.points, now.evaluations - before_.evaluations, now.skipped - before_.skipped};
    }
    /// Buffers that the owner of the tile loop keeps between tiles.
    std::vector<LeafSum> leaf_sums;
    std::vector<std::vector<float>> tree_rows;
    std::vector<float> scratch_row;

  private:
    enum PathFlag : uint8_t {
        kDataDone = 1,        ///< data AOVs are recorded
        kScattered = 2,       ///< has left the first surface: its layers are decided
        kDiffuseBefore = 4,   ///< scattered by a diffuse lobe somewhere
        kLastVertex = 8,      ///< bounces used up: emission and transparency only
        kWithin = 16,         ///< scatters within a medium before the surface of this depth
        kInnerDone = 32,      ///< has scattered once within an Interior: no more there
    };
    /// Independent uniform numbers.
    struct Numbers {
        uint32_t state = 0, count = 0;
        float next() { return unit_float(hash32(state + 0x9e3779b9u * ++count)); }
    };
    struct Path {
        RayHistory history;
        float t_min = 0, t_max = 0;
        float footprint = 0, spread = 0;
        Vec3f throughput{1, 1, 1};
        float min_pdf = std::numeric_limits<float>::max();  ///< smallest density of its directions, for RenderSettings::filter_glossy
        float scatter_pdf = 0;  ///< density of the direction, 0: delta or camera, so no light sample competes
        SampleKey key;
        uint32_t slot = 0;      ///< row of the sample
        uint16_t vertex = 0;
        uint8_t flags = 0;
        uint8_t media = 0;      ///< how many media it is inside of: inside_
        uint16_t boundaries = 0;  ///< of media passed that have no surface
        Hit hit;
    };
    using LabelWeights = std::array<Vec3f, kScatterLabels>;
    struct ShadowRay {
        Ray ray;
        Vec3f value;
        uint32_t path;
        uint32_t shares = 0;  ///< index into shares_, where layers are recorded
        uint16_t depth, transparent;
        uint8_t light_group;
        bool direct, scattered, casts;
        uint8_t media = 0;      ///< how many media it is inside of: shadow_inside_
        uint16_t boundaries = 0;
        uint32_t inside = 0;    ///< the first of them
        Numbers numbers;        ///< of tracking
    };
    /// A part of a ray within media that has to be tracked.
    struct Track {
        uint32_t target;        ///< path or shadow ray
        bool is_path;
        bool can_scatter;       ///< else: what passes
        bool scattered = false;
        const InsideOf* inside;
        uint8_t count;
        Vec3f origin, direction;
        float t, t_end;
        float least = 0;        ///< collisions per length that emission of constant media asks for
        float majorant = 0;
        MediumValues constant, here;  ///< of homogeneous media; of all at the collision
        Vec3f weight{1, 1, 1}, light{0, 0, 0};
        Numbers numbers;
    };
    /// A volume program wanted at a track's collision.
    struct Lookup {
        uint32_t track, medium, instance;
    };
    /// A path that scatters within media.
    struct Event {
        uint32_t path;
        float t;
        uint32_t first, count;  ///< of event_lobes_
    };
    /// A lamp that a path's ray meets.
    struct MetLamp {
        uint32_t path, lamp;
        LampSample sample;
        Vec3f factor;
    };
    /// A path that entered a body.
    struct PendingWalk {
        uint32_t path;
        ShadingPoint entry;
        Lobe<float> lobe;
    };
    /// Where it left.
    struct Leaving {
        uint32_t path;
        ShadingPoint point;
        Vec3f n;
    };
    struct PendingEmission {
        const SceneProgram* program;
        ShadingPoint point;
        RayHistory history;
        uint32_t target;  ///< a shadow ray, or an index into found_
    };
    /// Light found by a path's own ray, whose radiance is still to be evaluated.
    struct FoundLight {
        uint32_t path;
        Vec3f factor;
        int light_group;
        bool background;
    };

    // stages/camera.cpp
    void start_paths(const Tile& tile, uint64_t first, uint32_t count);
    void resolve(const Tile& tile, uint32_t count, std::span<LeafSum> leaf);
    void expose(float* row) const;
    // stages/intersect.cpp
    void intersect();
    void meet_lamps();
    void meet_background();
    void group_hits();
    // stages/media.cpp
    void find_media(Path& path, uint32_t index);
    void start_inside();
    void traverse_media();
    void traverse_homogeneous(Path& path, uint32_t index, const MediumValues& v, float t_end);
    void take_event(uint32_t track);
    void append_constant_phases(const Path& path, uint32_t index);
    void scatter_in_media();
    MediumValues constant_part(const InsideOf* inside, uint32_t count, bool& varies) const;
    MediumValues own_values(const Path* path, const InsideOf& m) const;
    void dim_lamps();
    void attenuate(std::span<const uint32_t> shadows);
    bool begin_track(Track& track, Vec3f& passed) const;
    void run_tracks();
    bool next_collision(Track& track) const;
    bool resolve_collision(Track& track);
    void look_up();
    InsideOf* inside(uint32_t path) { return inside_.data() + size_t{path} * plan_->media->depth(); }
    void cross(InsideOf* inside, uint8_t& count, const ShadingPoint& point, const Lobe<float>* interior);
    void pass_boundary(Path& path, uint32_t index);
    void start_in_media(ShadowRay& s, const Path& path, uint32_t index, const ShadingPoint& point, Vec3f wi);
    // stages/surface.cpp
    void shade_surfaces();
    void shade_batch(const SceneProgram& program, const RenderPlan::SurfacePrograms& programs, bool with_aovs, std::span<const uint32_t> paths);
    void gather_lobes(const Program& program);
    void add_interior(const Lobe<float>& lobe);
    std::span<Lobe<float>> load_lobes(const Path& path, size_t i);
    bool shade_point(Path& path, uint32_t index, const ShadingPoint& point, const RenderPlan::SurfacePrograms& programs, const Program& program, bool with_aovs, size_t i);
    void record_data(const Path& path, const ShadingPoint& point, const Bsdf<float>& bsdf, const RenderPlan::SurfacePrograms& programs, const Program& program, bool with_aovs, size_t i);
    void emit(const Path& path, const ShadingPoint& point, const Bsdf<float>& bsdf);
    bool scatter(Path& path, uint32_t index, const ShadingPoint& point, const Bsdf<float>& bsdf);
    void remember_shares(const Path& path, const Bsdf<float>& bsdf, const BsdfSample<float>& s, std::span<const Vec3f> per_lobe);
    static bool survives(Path& path, float u);
    // stages/subsurface.cpp
    void scatter_subsurface();
    void bump_leaving(std::span<const uint32_t> which);
    // stages/light.cpp
    void sample_light(const Path& path, uint32_t index, const ShadingPoint& point, const Bsdf<float>& bsdf);
    void evaluate_emission();
    // stages/shadow.cpp
    void trace_shadows();
    void shade_shadows(std::vector<uint32_t>& rays);
    void shade_shadow_batch(const SceneProgram* program, std::span<const uint32_t> rays);
    void pass_shadow_boundaries(std::span<const uint32_t> rays);
    void land(const ShadowRay& ray);

    // contributions
    float* row(uint32_t slot) { return rows_.data() + size_t{slot} * row_stride_; }
    Vec3f clamped(Vec3f value, bool direct) const;
    void add_light(uint32_t slot, Vec3f value, int light_group);
    void add_layer(uint32_t slot, ShadingLayer layer, Vec3f value);
    void add_by_labels(uint32_t slot, const LabelWeights& weights, bool direct, Vec3f value);
    void add_path_light(const Path& path, Vec3f value, int light_group, bool background);
    uint32_t ray_visibility(const RayHistory& h) const;
    /// Weights of the two ways to find a light: sampled with light_pdf, met by a ray scattered with scatter_pdf (0: delta).
    float sampled_weight(float light_pdf, float scatter_pdf, bool is_delta_light) const;
    float met_weight(float light_pdf, float scatter_pdf) const;

    const RenderPlan* plan_ = nullptr;
    Executor<float> executor_;
    InputGather gather_;
    WorkerCounters counters_;
    ExecStats before_;

    std::vector<Path> paths_;
    std::vector<uint32_t> active_, next_, missed_, hits_;
    std::vector<uint32_t> keys_, key_count_;
    std::vector<LabelWeights> path_weights_, shares_;
    std::vector<float> rows_;
    std::vector<uint8_t> bad_;
    int row_stride_ = 0;

    // of the batch being shaded
    std::vector<ShadingPoint> points_;
    std::vector<const RayHistory*> histories_;
    std::vector<Channel<float>> lobe_channels_;
    std::vector<size_t> lobe_first_;
    std::vector<Lobe<float>> lobes_;
    std::vector<Vec3f> per_lobe_;
    const std::vector<ProgramLobe>* current_lobes_ = nullptr;

    // of media; empty where the scene has none
    std::vector<InsideOf> inside_, shadow_inside_;
    std::vector<Track> tracks_;
    std::vector<uint32_t> tracks_alive_, media_rays_;
    std::vector<Lookup> lookups_;
    std::vector<Event> events_;
    std::vector<Lobe<float>> event_lobes_, looked_up_;
    std::vector<uint32_t> looked_up_track_;  ///< by lobe of looked_up_
    std::vector<RayHistory> media_history_;
    Lobe<float> interior_;           ///< of the point being shaded
    bool has_interior_ = false;

    std::vector<MetLamp> met_;
    std::vector<ShadowRay> shadows_;
    std::vector<PendingEmission> pending_;
    std::vector<FoundLight> found_;
    std::vector<PendingWalk> walks_;
    std::vector<Leaving> leaving_;
    std::vector<uint32_t> bumped_;
    std::vector<uint32_t> order_, order_by_program_, alive_, filtered_, lamps_;
    std::vector<Vec3f> emission_;
    std::vector<RayHistory> shadow_history_;
    std::vector<Hit> shadow_hits_;
};

}  // namespace alder
