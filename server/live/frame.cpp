// Frame: one picture of a live render as its readers see it.
#include "server/live/frame.h"

#include <algorithm>

namespace alder::live {

bool Mix::is_neutral() const {
    return std::all_of(weight.begin(), weight.end(), [](const Vec3f& w) { return w.x == 1 && w.y == 1 && w.z == 1; });
}

std::vector<int> used_groups(const Scene& scene) {
    std::array<bool, kLightGroups> used{};
    const auto mark = [&](int g) { used[g > 0 && g < kLightGroups ? g : 0] = true; };
    mark(scene.world.light_group);
    for (const Light& l : scene.lights) mark(l.light_group);
    for (const Instance& i : scene.instances) mark(i.light_group);
    std::vector<int> groups;
    for (int g = 0; g < kLightGroups; ++g)
        if (used[g]) groups.push_back(g);
    return groups;
}

std::string group_name(int group) { return group == 0 ? "light_group_default" : "light_group_" + std::to_string(group); }

Image Frame::image(const std::vector<std::string>& aovs) const {
    // A name that nobody records stands for "beauty alone": an empty list would be everything.
    Image im = film->image(aovs);
    if (mix.is_neutral() || film->samples() == 0) return im;
    const AovPlan& plan = film->aovs();
    const size_t stride = plan.film_row(), pixels = size_t(im.width) * im.height;
    const float inverse = 1.f / static_cast<float>(film->samples());
    for (Layer& layer : im.layers) {
        if (layer.name.empty()) {
            for (size_t i = 0; i < pixels; ++i) {
                const float* const row = film->rows().data() + i * stride;
                Vec3f sum(0, 0, 0);
                for (int g = 0; g < kLightGroups; ++g)
                    if (const int c = plan.group[g]; c >= 0) sum += mix.weight[g] * Vec3f(row[c], row[c + 1], row[c + 2]);
                for (int c = 0; c < 3; ++c) layer.planes[c][i] = sum[c] * inverse;
            }
            continue;
        }
        for (int g = 0; g < kLightGroups; ++g)
            if (layer.name == group_name(g))
                for (int c = 0; c < 3 && c < static_cast<int>(layer.planes.size()); ++c)
                    for (float& x : layer.planes[c]) x *= mix.weight[g][c];
    }
    return im;
}

std::shared_ptr<const std::string> Frame::encoded(const std::string& key, const std::function<std::string()>& make) const {
    std::shared_ptr<Slot> slot;
    {
        const std::lock_guard lock(mutex_);
        auto& found = slots_[key];
        if (!found) found = std::make_shared<Slot>();
        slot = found;
    }
    const std::lock_guard lock(slot->mutex);
    if (!slot->bytes) slot->bytes = std::make_shared<const std::string>(make());
    return slot->bytes;
}

Image enlarged(const Image& image, int width, int height) {
    if (image.width == width && image.height == height) return image;
    Image out = image;
    out.width = out.full_width = width;
    out.height = out.full_height = height;
    out.crop_x = out.crop_y = 0;
    for (Layer& layer : out.layers)
        for (auto& plane : layer.planes) {
            std::vector<float> large(size_t(width) * height);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    large[size_t(y) * width + x] = plane[size_t(int64_t(y) * image.height / height) * image.width + int64_t(x) * image.width / width];
            plane = std::move(large);
        }
    return out;
}

}  // namespace alder::live
