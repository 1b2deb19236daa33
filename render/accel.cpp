// Accel: one Embree scene per mesh, instanced into a top scene.
#include "render/accel.h"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace alder {
namespace {

/// One device for the process: Embree's devices carry thread state and are meant to be few.
RTCDevice device() {
    static const RTCDevice d = [] {
        RTCDevice made = rtcNewDevice(nullptr);
        if (!made) throw std::runtime_error("Embree cannot start on this machine");
        return made;
    }();
    return d;
}

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

RTCRay to_embree(const Ray& ray, uint32_t mask) {
    RTCRay r;
    r.org_x = ray.origin.x;
    r.org_y = ray.origin.y;
    r.org_z = ray.origin.z;
    r.tnear = ray.t_min;
    r.dir_x = ray.direction.x;
    r.dir_y = ray.direction.y;
    r.dir_z = ray.direction.z;
    r.time = 0;
    r.tfar = ray.t_max;
    r.mask = mask;
    r.id = 0;
    r.flags = 0;
    return r;
}

void set_flags(RTCScene scene) {
    // Robust: watertight edges, as closed meshes must not leak light (Cycles does the same). The context filter costs nothing
    // for rays that set none, and lets a material become transparent without touching the BVH.
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
}

RTCScene build_mesh(const Mesh& mesh) {
    RTCScene scene = rtcNewScene(device());
    set_flags(scene);
    RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
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

bool is_finite(const Transform& t) {
    for (float x : t.m)
        if (!std::isfinite(x)) return false;
    return true;
}

}  // namespace

struct Accel::Impl {
    std::vector<RTCScene> meshes;
    RTCScene top = nullptr;
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

    impl_->top = rtcNewScene(device());
    set_flags(impl_->top);
    for (size_t i = 0; i < instances.size(); ++i) {
        const Instance& instance = instances[i];
        RTCScene mesh = impl_->meshes[instance.mesh];
        if (!mesh || instance.visibility == 0 || !is_finite(instance.object_to_world)) continue;
        RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, mesh);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance.object_to_world.m.data());
        rtcSetGeometryMask(geometry, instance.visibility);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->top, geometry, static_cast<unsigned>(i));
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(impl_->top);
    if (const RTCError e = rtcGetDeviceError(device()); e == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
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
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit r;
    r.ray = to_embree(ray, visibility);
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->top, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        hit.instance = kNothing;
        return false;
    }
    hit = {r.ray.tfar, r.hit.u, r.hit.v, r.hit.instID[0], r.hit.primID};
    return true;
}

Occlusion Accel::occluded(const Ray& ray, const ShadowFilter* filter) const {
    FilterContext context;
    rtcInitIntersectContext(&context);
    if (filter) {
        context.shadow = filter;
        context.filter = occlusion_filter;
    }
    RTCRay r = to_embree(ray, kVisibleShadow);
    rtcOccluded1(impl_->top, &context, &r);
    if (r.tfar < 0) return Occlusion::Blocked;
    return context.passed ? Occlusion::Filtered : Occlusion::Clear;
}

}  // namespace alder
