// What the Image and the Environment Texture prepare: the placement and the opened image.
#pragma once
#include "nodes/resource_faults.h"
#include "nodes/texture/image_store.h"
#include "nodes/texture/texture_mapping.h"

namespace alder {

struct PreparedImage : PreparedTexture, ResourceFaults {
    std::shared_ptr<const StoredImage> image;  ///< null: none chosen, or the file is not there
    std::vector<Fault> late_faults() const override {
        const std::string reason = image ? image->broken() : std::string();
        return reason.empty() ? std::vector<Fault>() : std::vector<Fault>{{"image", image->path(), reason}};
    }
};

/// NodeType::prepare of nodes with parameters `image` and `texture_mapping`.
std::shared_ptr<const Prepared> prepare_image_texture(const Statics& statics, std::vector<std::string>& errors);

/// Blender's image user (frame of a sequence, layer): accepted, a single image has none of these.
Param image_user_param();

}  // namespace alder
