// The image that an alShaders texture node opens when its graph is compiled.
#pragma once
#include "nodes/resource_faults.h"
#include "nodes/schema.h"
#include "nodes/texture/image_store.h"

namespace alder {

struct AlTexture : Prepared, ResourceFaults {
    std::string parameter;
    std::shared_ptr<const StoredImage> image;  ///< null: none named
    std::vector<Fault> late_faults() const override {
        const std::string reason = image ? image->broken() : std::string();
        return reason.empty() ? std::vector<Fault>() : std::vector<Fault>{{parameter, image->path(), reason}};
    }
};
inline std::shared_ptr<const Prepared> open_al_texture(const Statics& s, int param, std::vector<std::string>& errors) {
    auto texture = std::make_shared<AlTexture>();
    texture->parameter = s.type->params[param].name;
    const size_t faults = errors.size();
    const ImageRequest request = parse_image_request(s.text[param], errors);
    if (!request.path.empty() && errors.size() == faults) texture->image = ImageStore::shared().open(request);
    if (texture->image && !texture->image->readable()) texture->faults.push_back({texture->parameter, request.path, texture->image->fault});
    return texture;
}
inline const StoredImage* opened_image(const Statics& s) {
    const auto* const texture = static_cast<const AlTexture*>(s.prepared.get());
    return texture ? texture->image.get() : nullptr;
}

}  // namespace alder
