// The image that an alShaders texture node opens when its graph is compiled.
#pragma once
#include "nodes/schema.h"
#include "nodes/texture/image_store.h"

namespace alder {

struct AlTexture : Prepared {
    std::shared_ptr<const StoredImage> image;  ///< null: none named
};
inline std::shared_ptr<const Prepared> open_al_texture(const Statics& s, int param, std::vector<std::string>& errors) {
    auto texture = std::make_shared<AlTexture>();
    const size_t faults = errors.size();
    const ImageRequest request = parse_image_request(s.text[param], errors);
    if (!request.path.empty() && errors.size() == faults) texture->image = ImageStore::shared().open(request);
    return texture;
}
inline const StoredImage* opened_image(const Statics& s) {
    const auto* const texture = static_cast<const AlTexture*>(s.prepared.get());
    return texture ? texture->image.get() : nullptr;
}

}  // namespace alder
