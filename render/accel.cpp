// Accel: one Embree scene per mesh, instanced into a top scene.
#include "render/accel.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "render/accel_device.h"

namespace alder {
namespace {

struct FilterContext : RTCIntersectContext {
    const ShadowFilter* shadow = nullptr;
    bool passed = false;
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

void set_flags(RTCScene scene) {
    // Robust: watertight edges, as closed meshes must not leak light (Cycles does the same). The context filter costs nothing
    // for rays that set none, and lets a material become transparent without touching the BVH.
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
}

RTCScene build_mesh(const Mesh& mesh) {
    RTCScene scene = rtcNewScene(embree_device());
    set_flags(scene);
    RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    // Copies: Embree reads 16 bytes at the last vertex, past the end of a packed array.
    void* const vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                                   mesh.positions.size());
    void* const indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                  3 * sizeof(uint32_t), mesh.triangles.size());
    if (!vertices || !indices) throw std::bad_alloc();
    std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(Vec3f));
    std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
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
    r.ray.time = 0;
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
    std::vector<Transform> to_object;       ///< of each instance
    std::vector<RTCScene> scene_of;         ///< of each instance; null where it is not in the top scene
    RTCScene top = nullptr;
    float largest_origin = kLargestCoordinate;  ///< of rays that stay within Embree's range in every instance
    bool takes(const Ray& r) const { return embree_takes(r, largest_origin); }
    ~Impl() {
        if (top) rtcReleaseScene(top);
        for (RTCScene s : meshes)
            if (s) rtcReleaseScene(s);
    }
};

Accel::Accel(const std::vector<std::shared_ptr<const Mesh>>& meshes, const std::vector<Instance>& instances)
    : impl_(std::make_unique<Impl>()) {
    const auto start = std::chrono::steady_clock::now();
    impl_->meshes.resize(meshes.size(), nullptr);
    std::vector<bool> used(meshes.size(), false);
    for (const Instance& i : instances) used[i.mesh] = true;
    tbb::parallel_for(size_t{0}, meshes.size(), [&](size_t i) {
        if (used[i] && !meshes[i]->triangles.empty()) impl_->meshes[i] = build_mesh(*meshes[i]);
    });

    impl_->top = rtcNewScene(embree_device());
    set_flags(impl_->top);
    impl_->scene_of.assign(instances.size(), nullptr);
    float scene_extent = 1;
    std::vector<float> extents(instances.size(), -1.f);
    for (size_t i = 0; i < instances.size(); ++i) {
        RTCScene mesh = impl_->meshes[instances[i].mesh];
        if (!mesh || instances[i].visibility == 0) continue;
        const float e = extent(mesh, instances[i].object_to_world);
        if (!(e < 0.1f * kLargestCoordinate) || instances[i].object_to_world.determinant() == 0) continue;
        extents[i] = e;
        scene_extent = std::max(scene_extent, e);
    }
    for (size_t i = 0; i < instances.size(); ++i) {
        const Instance& instance = instances[i];
        RTCScene mesh = impl_->meshes[instance.mesh];
        if (extents[i] < 0) continue;
        // So small that the scene around it would overflow in its coordinates: nothing of it could be seen.
        const float inverse = largest_row(instance.object_to_world.inverse());
        if (!(inverse * scene_extent < 0.01f * kLargestCoordinate)) continue;
        impl_->largest_origin = std::min(impl_->largest_origin, 0.1f * kLargestCoordinate / std::max(inverse, 1.f));
        RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, mesh);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance.object_to_world.m.data());
        rtcSetGeometryMask(geometry, instance.visibility);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->top, geometry, static_cast<unsigned>(i));
        impl_->scene_of[i] = mesh;
        rtcReleaseGeometry(geometry);
    }
    impl_->to_object.resize(instances.size());
    for (size_t i = 0; i < instances.size(); ++i)
        if (impl_->scene_of[i]) impl_->to_object[i] = instances[i].object_to_world.inverse();
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
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit r = embree_ray(ray, visibility);
    rtcIntersect1(impl_->top, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit = {r.ray.tfar, r.hit.u, r.hit.v, r.hit.instID[0], r.hit.primID};
    return true;
}

bool Accel::intersect_instance(uint32_t instance, const Ray& ray, Hit& hit) const {
    hit.instance = kNothing;
    RTCScene scene = instance < impl_->scene_of.size() ? impl_->scene_of[instance] : nullptr;
    if (!scene || !impl_->takes(ray)) return false;
    // The direction is not normalised, as within the top scene: distances mean the same on both sides, bit for bit, so that a ray
    // that goes on behind a hit does not meet it again.
    const Transform& t = impl_->to_object[instance];
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit r = embree_ray({t.point(ray.origin), t.vector(ray.direction), ray.t_min, ray.t_max}, ~0u);
    rtcIntersect1(scene, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit = {r.ray.tfar, r.hit.u, r.hit.v, instance, r.hit.primID};
    return true;
}

Occlusion Accel::occluded(const Ray& ray, const ShadowFilter* filter) const {
    if (!impl_->takes(ray)) return Occlusion::Clear;
    FilterContext context;
    rtcInitIntersectContext(&context);
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
