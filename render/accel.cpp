// Accel: one Embree scene per mesh, instanced into a top scene.
#include "render/accel.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <unordered_map>

#include "render/accel_device.h"
#include "render/geometry/curves.h"
#include "render/geometry/motion.h"

namespace alder {
namespace {

struct FilterContext : RTCIntersectContext {
    const ShadowFilter* shadow = nullptr;
    bool passed = false;
    uint32_t self_instance, self_primitive;
    explicit FilterContext(const Ray& ray) : self_instance(ray.self_instance), self_primitive(ray.self_primitive) { rtcInitIntersectContext(this); }
};

void occlusion_filter(const RTCFilterFunctionNArguments* args) {
    auto* const context = static_cast<FilterContext*>(args->context);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const uint32_t instance = RTCHitN_instID(args->hit, args->N, i, 0);
        const uint32_t triangle = RTCHitN_primID(args->hit, args->N, i);
        if (!context->shadow->may_pass(instance, triangle)) continue;
        context->passed = true;
        args->valid[i] = 0;  // go on behind it
    }
}

/// Of threads and balls a ray meets neither what it leaves nor any inside: what happens within a thread is the lobe's business.
template <bool kHasInside>
void thread_filter(const RTCFilterFunctionNArguments* args) {
    const auto* const context = static_cast<FilterContext*>(args->context);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const unsigned n = args->N;
        const bool is_self = RTCHitN_primID(args->hit, n, i) == context->self_primitive && RTCHitN_instID(args->hit, n, i, 0) == context->self_instance;
        const float along = RTCHitN_Ng_x(args->hit, n, i) * RTCRayN_dir_x(args->ray, n, i) + RTCHitN_Ng_y(args->hit, n, i) * RTCRayN_dir_y(args->ray, n, i) +
                            RTCHitN_Ng_z(args->hit, n, i) * RTCRayN_dir_z(args->ray, n, i);
        if (is_self || (kHasInside && along > 0)) args->valid[i] = 0;
    }
}

void set_flags(RTCScene scene) {
    // Robust: watertight edges, as closed meshes must not leak light (Cycles does the same). The context filter costs nothing
    // for rays that set none, and lets a material become transparent without touching the BVH.
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
}

void* new_buffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, size_t stride, size_t count) {
    void* const p = rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count);
    if (!p) throw std::bad_alloc();
    return p;
}

RTCGeometry triangles_of(const Mesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const unsigned steps = mesh.moves() ? static_cast<unsigned>(mesh.motion_steps) : 1;
    rtcSetGeometryTimeStepCount(geometry, steps);
    // Copies: Embree reads 16 bytes at the last vertex, past the end of a packed array.
    for (unsigned step = 0; step < steps; ++step) {
        void* const vertices = new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, sizeof(Vec3f), mesh.positions.size());
        const Vec3f* const from = mesh.moves() ? mesh.motion_positions.data() + step * mesh.positions.size() : mesh.positions.data();
        std::memcpy(vertices, from, mesh.positions.size() * sizeof(Vec3f));
    }
    void* const indices = new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), mesh.triangles.size());
    std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
    return geometry;
}

struct Ball {
    float x, y, z, radius;
};
/// A point with its radius; a radius below 0 counts as none.
Ball ball(const Mesh& mesh, size_t step, size_t point) {
    const size_t at = step * mesh.positions.size() + point;
    const Vec3f p = mesh.moves() ? mesh.motion_positions[at] : mesh.positions[point];
    const float r = mesh.moves() && !mesh.motion_radii.empty() ? mesh.motion_radii[at] : mesh.radii[point];
    return {p.x, p.y, p.z, r > 0 ? r : 0.f};
}

RTCGeometry spheres_of(const Mesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
    const unsigned steps = mesh.moves() ? static_cast<unsigned>(mesh.motion_steps) : 1;
    rtcSetGeometryTimeStepCount(geometry, steps);
    for (unsigned step = 0; step < steps; ++step) {
        auto* const out = static_cast<Ball*>(new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, sizeof(Ball), mesh.positions.size()));
        for (size_t i = 0; i < mesh.positions.size(); ++i) out[i] = ball(mesh, step, i);
    }
    return geometry;
}

/// Catmull-Rom segments reach over their neighbours: the first and last point of each curve stand there twice.
RTCGeometry curves_of(const Mesh& mesh) {
    const bool linear = mesh.curve_form == CurveForm::Linear, ribbon = mesh.curve_form == CurveForm::Ribbon;
    RTCGeometry geometry = rtcNewGeometry(embree_device(), linear   ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE
                                                           : ribbon ? RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE
                                                                    : RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE);
    if (!linear) rtcSetGeometryTessellationRate(geometry, static_cast<float>(mesh.curve_subdivisions + 1));
    const size_t curves = mesh.curve_first.size() - 1, extra = linear ? 0 : 2;
    const unsigned steps = mesh.moves() ? static_cast<unsigned>(mesh.motion_steps) : 1;
    rtcSetGeometryTimeStepCount(geometry, steps);
    for (unsigned step = 0; step < steps; ++step) {
        auto* out = static_cast<Ball*>(new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, sizeof(Ball), mesh.positions.size() + extra * curves));
        for (size_t c = 0; c < curves; ++c) {
            const uint32_t first = mesh.curve_first[c], end = mesh.curve_first[c + 1];
            if (!linear) *out++ = ball(mesh, step, first);
            for (uint32_t p = first; p < end; ++p) *out++ = ball(mesh, step, p);
            if (!linear) *out++ = ball(mesh, step, end - 1);
        }
    }
    auto* const index = static_cast<uint32_t*>(new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(uint32_t), mesh.primitive_count()));
    const std::vector<CurveSegment> segments = curve_segments(mesh);
    for (size_t i = 0; i < segments.size(); ++i) index[i] = segments[i].point + static_cast<uint32_t>(extra) * segments[i].curve;
    if (linear) {
        auto* const flags = static_cast<uint8_t*>(new_buffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, 1, segments.size()));
        for (size_t i = 0; i < segments.size(); ++i) {
            const bool before = i > 0 && segments[i - 1].curve == segments[i].curve;
            const bool after = i + 1 < segments.size() && segments[i + 1].curve == segments[i].curve;
            flags[i] = static_cast<uint8_t>((before ? RTC_CURVE_FLAG_NEIGHBOR_LEFT : 0) | (after ? RTC_CURVE_FLAG_NEIGHBOR_RIGHT : 0));
        }
    }
    return geometry;
}

RTCScene build_mesh(const Mesh& mesh) {
    RTCScene scene = rtcNewScene(embree_device());
    set_flags(scene);
    RTCGeometry geometry = mesh.shape == Shape::Triangles ? triangles_of(mesh) : mesh.shape == Shape::Curves ? curves_of(mesh) : spheres_of(mesh);
    if (mesh.shape != Shape::Triangles) {
        const bool ribbon = mesh.shape == Shape::Curves && mesh.curve_form == CurveForm::Ribbon;
        const RTCFilterFunctionN filter = ribbon ? thread_filter<false> : thread_filter<true>;
        rtcSetGeometryIntersectFilterFunction(geometry, filter);
        rtcSetGeometryOccludedFilterFunction(geometry, filter);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

/// Where a point of a segment lies, by the point itself: Embree's u runs evenly along the straight pieces that it cuts ribbons into.
void thread_coordinates(CurveForm form, const CurveKeys& keys, Vec3f p, Vec3f direction, Hit& hit) {
    if (form == CurveForm::Linear) {
        const Vec3f along = keys.p[2] - keys.p[1];
        const float u = dot(p - keys.p[1], along) / dot(along, along);  // beyond 0 and 1 on the round ends
        hit.u = std::isfinite(u) ? u : 0.f;
        hit.v = angle_around_curve(along, p - keys.p[1]);
        return;
    }
    hit.u = std::clamp(hit.u, 0.f, 1.f);
    CurvePoint c = curve_point(keys, form, hit.u);
    if (form == CurveForm::Round) {
        hit.v = angle_around_curve(c.tangent, p - c.center);
        return;
    }
    for (int i = 0; i < 3; ++i) {  // Newton's method
        const float step = dot(p - c.center, c.tangent) / dot(c.tangent, c.tangent);
        if (!std::isfinite(step)) break;
        hit.u = std::clamp(hit.u + step, 0.f, 1.f);
        c = curve_point(keys, form, hit.u);
    }
    const float v = dot(p - c.center, safe_normalize(cross(c.tangent, -direction))) / c.radius;
    hit.v = std::isfinite(v) ? std::clamp(v, -1.f, 1.f) : 0.f;
}

float largest_row(const Transform& t) {
    float r = 0;
    for (int row = 0; row < 3; ++row) {
        float sum = 0;
        for (int c = 0; c < 4; ++c) sum += std::abs(t.m[row * 4 + c]);
        r = sum > r || !(sum == sum) ? sum : r;  // NaN wins
    }
    return r;
}

/// Largest coordinate of a mesh's box after a transform; NaN or infinity where either is not finite.
float extent(RTCScene mesh, const Transform& t) {
    RTCBounds b;
    rtcGetSceneBounds(mesh, &b);
    float largest = 0;
    for (int k = 0; k < 8; ++k) {
        const Vec3f p = t.point({k & 1 ? b.upper_x : b.lower_x, k & 2 ? b.upper_y : b.lower_y, k & 4 ? b.upper_z : b.lower_z});
        for (const float x : {p.x, p.y, p.z})
            if (!(std::abs(x) <= largest)) largest = std::abs(x);
    }
    return largest;
}

std::span<const Transform> placements(const Instance& instance) {
    if (instance.motion.size() > 1) return instance.motion;
    return {&instance.object_to_world, 1};
}

void set_motion(RTCGeometry geometry, const std::vector<MotionKey>& keys) {
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(keys.size()));
    for (unsigned i = 0; i < keys.size(); ++i) {
        const MotionKey& k = keys[i];
        RTCQuaternionDecomposition q;
        rtcInitQuaternionDecomposition(&q);
        rtcQuaternionDecompositionSetQuaternion(&q, k.rotation[0], k.rotation[1], k.rotation[2], k.rotation[3]);
        rtcQuaternionDecompositionSetScale(&q, k.scale.x, k.scale.y, k.scale.z);
        rtcQuaternionDecompositionSetSkew(&q, k.skew.x, k.skew.y, k.skew.z);
        rtcQuaternionDecompositionSetTranslation(&q, k.translation.x, k.translation.y, k.translation.z);
        rtcSetGeometryTransformQuaternion(geometry, i, &q);
    }
}

}  // namespace

RTCDevice embree_device() {
    static const RTCDevice d = [] {
        RTCDevice made = rtcNewDevice(nullptr);
        if (!made) throw std::runtime_error("Embree cannot start on this machine");
        return made;
    }();
    return d;
}

RTCRayHit embree_ray(const Ray& ray, uint32_t mask) {
    RTCRayHit r;
    r.ray.org_x = ray.origin.x;
    r.ray.org_y = ray.origin.y;
    r.ray.org_z = ray.origin.z;
    r.ray.tnear = ray.t_min;
    r.ray.dir_x = ray.direction.x;
    r.ray.dir_y = ray.direction.y;
    r.ray.dir_z = ray.direction.z;
    r.ray.time = ray.time;
    r.ray.tfar = ray.t_max;
    r.ray.mask = mask;
    r.ray.id = 0;
    r.ray.flags = 0;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

bool embree_takes(const Ray& r, float largest_origin) {
    // Written so that NaN fails.
    const auto within = [](Vec3f v, float limit) { return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit; };
    return within(r.origin, largest_origin) && within(r.direction, 2.f) && r.t_min <= r.t_max;
}

struct Accel::Impl {
    std::vector<RTCScene> meshes;
    std::vector<std::shared_ptr<const Mesh>> shapes;
    std::vector<std::vector<CurveSegment>> segments;  ///< of each mesh of curves
    std::vector<uint32_t> mesh_of;          ///< of each instance
    std::vector<Transform> to_object;       ///< of each instance
    std::vector<std::vector<MotionKey>> motion;  ///< of each instance; empty: at rest
    std::vector<RTCScene> scene_of;         ///< of each instance; null where it is not in the top scene
    RTCScene top = nullptr;
    float largest_origin = kLargestCoordinate;  ///< of rays that stay within Embree's range in every instance
    bool takes(const Ray& r) const { return embree_takes(r, largest_origin); }
    Transform world_to_object(uint32_t instance, float time) const {
        return motion[instance].empty() ? to_object[instance] : transform_at(motion[instance], time).inverse();
    }
    Hit hit_of(const RTCRayHit& r, uint32_t instance, const Ray& ray) const;
    ~Impl() {
        if (top) rtcReleaseScene(top);
        for (RTCScene s : meshes)
            if (s) rtcReleaseScene(s);
    }
};

/// On threads and balls the coordinates that a point follows from; the others Embree gives.
Hit Accel::Impl::hit_of(const RTCRayHit& r, uint32_t instance, const Ray& ray) const {
    Hit hit{r.ray.tfar, r.hit.u, r.hit.v, instance, r.hit.primID};
    const Mesh& mesh = *shapes[mesh_of[instance]];
    if (mesh.shape == Shape::Triangles) return hit;
    const Transform m = world_to_object(instance, ray.time);
    const Vec3f direction = m.vector(ray.direction), p = m.point(ray.origin) + direction * hit.t;
    if (mesh.shape == Shape::Spheres) encode_direction(p - position_at(mesh, hit.triangle, ray.time), hit.u, hit.v);
    else thread_coordinates(mesh.curve_form, curve_keys(mesh, segments[mesh_of[instance]][hit.triangle], ray.time), p, direction, hit);
    return hit;
}

Accel::Accel(const std::vector<std::shared_ptr<const Mesh>>& meshes, const std::vector<Instance>& instances, const Accel* previous)
    : impl_(std::make_unique<Impl>()) {
    const auto start = std::chrono::steady_clock::now();
    impl_->meshes.resize(meshes.size(), nullptr);
    impl_->shapes = meshes;
    impl_->segments.resize(meshes.size());
    std::vector<bool> used(meshes.size(), false);
    for (const Instance& i : instances) used[i.mesh] = true;
    std::unordered_map<const Mesh*, size_t> known;
    if (previous)
        for (size_t i = 0; i < previous->impl_->shapes.size(); ++i)
            if (previous->impl_->meshes[i]) known.emplace(previous->impl_->shapes[i].get(), i);
    std::atomic<size_t> built{0};
    tbb::parallel_for(size_t{0}, meshes.size(), [&](size_t i) {
        if (!used[i] || meshes[i]->primitive_count() == 0) return;
        if (const auto it = known.find(meshes[i].get()); it != known.end()) {
            impl_->meshes[i] = previous->impl_->meshes[it->second];
            rtcRetainScene(impl_->meshes[i]);
            impl_->segments[i] = previous->impl_->segments[it->second];
            return;
        }
        impl_->meshes[i] = build_mesh(*meshes[i]);
        if (meshes[i]->shape == Shape::Curves) impl_->segments[i] = curve_segments(*meshes[i]);
        ++built;
    });
    meshes_built_ = built;

    impl_->top = rtcNewScene(embree_device());
    set_flags(impl_->top);
    impl_->scene_of.assign(instances.size(), nullptr);
    impl_->motion.resize(instances.size());
    impl_->mesh_of.resize(instances.size());
    impl_->to_object.resize(instances.size());
    float scene_extent = 1;
    std::vector<float> extents(instances.size(), -1.f);
    for (size_t i = 0; i < instances.size(); ++i) {
        const Instance& instance = instances[i];
        impl_->mesh_of[i] = instance.mesh;
        RTCScene mesh = impl_->meshes[instance.mesh];
        if (!mesh || instance.visibility == 0) continue;
        if (instance.motion.size() > 1) impl_->motion[i] = motion_keys(instance.motion);
        float e = 0, flattest = std::numeric_limits<float>::infinity();
        for (const Transform& t : placements(instance)) {
            if (const float x = extent(mesh, t); !(x <= e)) e = x;
            flattest = std::min(flattest, std::abs(t.determinant()));
        }
        if (!(e < 0.1f * kLargestCoordinate) || flattest == 0) continue;
        extents[i] = e;
        scene_extent = std::max(scene_extent, e);
    }
    for (size_t i = 0; i < instances.size(); ++i) {
        const Instance& instance = instances[i];
        RTCScene mesh = impl_->meshes[instance.mesh];
        if (extents[i] < 0) continue;
        // So small that the scene around it would overflow in its coordinates: nothing of it could be seen.
        float inverse = 0;
        for (const Transform& t : placements(instance)) inverse = std::max(inverse, largest_row(t.inverse()));
        if (!(inverse * scene_extent < 0.01f * kLargestCoordinate)) continue;
        impl_->largest_origin = std::min(impl_->largest_origin, 0.1f * kLargestCoordinate / std::max(inverse, 1.f));
        RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, mesh);
        if (impl_->motion[i].empty()) rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance.object_to_world.m.data());
        else set_motion(geometry, impl_->motion[i]);
        rtcSetGeometryMask(geometry, instance.visibility);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->top, geometry, static_cast<unsigned>(i));
        impl_->scene_of[i] = mesh;
        impl_->to_object[i] = instance.object_to_world.inverse();
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(impl_->top);
    if (const RTCError e = rtcGetDeviceError(embree_device()); e == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    RTCBounds b;
    rtcGetSceneBounds(impl_->top, &b);
    if (b.lower_x <= b.upper_x) {
        bounds_min_ = {b.lower_x, b.lower_y, b.lower_z};
        bounds_max_ = {b.upper_x, b.upper_y, b.upper_z};
    }
    build_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Accel::~Accel() = default;

bool Accel::intersect(const Ray& ray, uint32_t visibility, Hit& hit) const {
    hit.instance = kNothing;
    if (!impl_->takes(ray)) return false;
    FilterContext context(ray);
    RTCRayHit r = embree_ray(ray, visibility);
    rtcIntersect1(impl_->top, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit = impl_->hit_of(r, r.hit.instID[0], ray);
    return true;
}

bool Accel::intersect_instance(uint32_t instance, const Ray& ray, Hit& hit) const {
    hit.instance = kNothing;
    RTCScene scene = instance < impl_->scene_of.size() ? impl_->scene_of[instance] : nullptr;
    if (!scene || !impl_->takes(ray)) return false;
    // The direction is not normalised, as within the top scene: distances mean the same on both sides, bit for bit, so that a ray
    // that goes on behind a hit does not meet it again.
    const Transform t = impl_->world_to_object(instance, ray.time);
    FilterContext context(ray);
    context.self_instance = RTC_INVALID_GEOMETRY_ID;  // what Embree says within one mesh
    if (ray.self_instance != instance) context.self_primitive = kNothing;
    RTCRayHit r = embree_ray({t.point(ray.origin), t.vector(ray.direction), ray.t_min, ray.t_max, ray.time}, ~0u);
    rtcIntersect1(scene, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit = impl_->hit_of(r, instance, ray);
    return true;
}

Occlusion Accel::occluded(const Ray& ray, const ShadowFilter* filter) const {
    if (!impl_->takes(ray)) return Occlusion::Clear;
    FilterContext context(ray);
    if (filter) {
        context.shadow = filter;
        context.filter = occlusion_filter;
    }
    RTCRay r = embree_ray(ray, kVisibleShadow).ray;
    rtcOccluded1(impl_->top, &context, &r);
    if (r.tfar < 0) return Occlusion::Blocked;
    return context.passed ? Occlusion::Filtered : Occlusion::Clear;
}

}  // namespace alder
