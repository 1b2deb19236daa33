// Frame: one picture of a live render as its readers see it: the film's sums at one number of samples, the weights of the light
// groups, and what it shows of edits. Immutable; encoded once for all readers that want the same bytes.
#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "render/progressive.h"

namespace alder::live {

/// What each light group is multiplied by: a re-mix needs no ray.
struct Mix {
    std::array<Vec3f, kLightGroups> weight;
    Mix() { weight.fill(Vec3f(1, 1, 1)); }
    bool is_neutral() const;
};

/// Light groups that something in the scene is in; 0 = ungrouped lights and the world.
std::vector<int> used_groups(const Scene& scene);
std::string group_name(int group);   ///< light_group_default, light_group_1 ...

class Frame {
  public:
    std::shared_ptr<const FilmPicture> film;
    Mix mix;
    int divisor = 1;           ///< of the resolution
    int width = 0, height = 0; ///< at full resolution
    uint64_t number = 0;       ///< grows with each picture
    uint64_t version = 0;      ///< grows with each edit
    std::string revision;      ///< of the scene or graph shown

    uint64_t samples() const { return film->samples(); }
    /// The layers, mixed; none named: all.
    Image image(const std::vector<std::string>& aovs) const;
    /// What make() gives for this key; it is called once, by whoever comes first.
    std::shared_ptr<const std::string> encoded(const std::string& key, const std::function<std::string()>& make) const;

  private:
    struct Slot {
        std::mutex mutex;
        std::shared_ptr<const std::string> bytes;
    };
    mutable std::mutex mutex_;
    mutable std::map<std::string, std::shared_ptr<Slot>> slots_;
};

/// The image at `width` x `height`, every pixel the nearest one's.
Image enlarged(const Image& image, int width, int height);

}  // namespace alder::live
