// Opens the image of an Image or Environment Texture when its graph is compiled.
#include "nodes/texture/prepared_image.h"

namespace alder {

std::shared_ptr<const Prepared> prepare_image_texture(const Statics& statics, std::vector<std::string>& errors) {
    auto prepared = std::make_shared<PreparedImage>();
    prepared->mapping = parse_texture_mapping(statics.text[statics.type->param_index("texture_mapping")], errors);
    const size_t faults = errors.size();
    const ImageRequest request = parse_image_request(statics.text[statics.type->param_index("image")], errors);
    if (!request.path.empty() && errors.size() == faults) {
        prepared->image = ImageStore::shared().open(request);
        if (!prepared->image->readable()) prepared->faults.push_back({"image", request.path, prepared->image->fault});
    }
    return prepared;
}

Param image_user_param() {
    return param::json("image_user").doc("Blender's choice of frame, layer and pass: has no effect on a single image");
}

}  // namespace alder
