// What an image file says about itself: version, settings to render it again, camera matrices. Nothing of time, host or path.
#pragma once
#include "render/image/image.h"

namespace alder {

/// Adds software, alder/version, alder/settings, worldToCamera and worldToNDC, as far as they are not there.
void add_metadata(Image& image, const Scene& scene, const RenderRequest& request);

}  // namespace alder
