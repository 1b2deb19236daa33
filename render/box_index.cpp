// BoxIndex: boxes as user geometry of Embree, whose intersection only takes note.
#include "render/box_index.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "render/accel_device.h"

namespace alder {
namespace {

struct QueryContext : RTCIntersectContext {
    std::vector<uint32_t>* found;
};

void bounds(const RTCBoundsFunctionArguments* a) {
    const auto& box = (*static_cast<const std::vector<BoxIndex::Box>*>(a->geometryUserPtr))[a->primID];
    *a->bounds_o = {box[0].x, box[0].y, box[0].z, 0, box[1].x, box[1].y, box[1].z, 0};
}

void take_note(const RTCIntersectFunctionNArguments* a) {
    static_cast<QueryContext*>(a->context)->found->push_back(a->primID);
}
void no_occlusion(const RTCOccludedFunctionNArguments*) {}

}  // namespace

struct BoxIndex::Impl {
    std::vector<Box> boxes;
    RTCScene scene = nullptr;
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
    }
};

BoxIndex::BoxIndex(std::vector<Box> boxes) : impl_(std::make_unique<Impl>()) {
    impl_->boxes = std::move(boxes);
    impl_->scene = rtcNewScene(embree_device());
    RTCGeometry g = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(g, static_cast<unsigned>(impl_->boxes.size()));
    rtcSetGeometryUserData(g, &impl_->boxes);
    rtcSetGeometryBoundsFunction(g, bounds, nullptr);
    rtcSetGeometryIntersectFunction(g, take_note);
    rtcSetGeometryOccludedFunction(g, no_occlusion);
    rtcCommitGeometry(g);
    rtcAttachGeometry(impl_->scene, g);
    rtcReleaseGeometry(g);
    rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(impl_->scene);
}

BoxIndex::~BoxIndex() = default;
BoxIndex::BoxIndex(BoxIndex&&) noexcept = default;

void BoxIndex::query(const Ray& ray, std::vector<uint32_t>& found) const {
    found.clear();
    if (!embree_takes(ray)) return;
    QueryContext context;
    rtcInitIntersectContext(&context);
    context.found = &found;
    RTCRayHit r = embree_ray(ray, ~0u);
    rtcIntersect1(impl_->scene, &context, &r);
    std::sort(found.begin(), found.end());
}

}  // namespace alder
