// Colour spaces of an OpenColorIO configuration: those without a formula of their own (color_space.h). Part of the loader module.
#pragma once
#include <memory>
#include <string>

#include "nodes/texture/image_load.h"

namespace alder {

/// One space's way to linear Rec.709. Immutable, thread safe.
class ConfiguredSpace {
  public:
    virtual ~ConfiguredSpace() = default;
    bool is_data = false;
    virtual void to_linear_rec709(float (&rgb)[3]) const = 0;
};

/// By name, alias or role; null and a reason where the configuration does not have it or cannot be used.
std::shared_ptr<const ConfiguredSpace> find_configured_space(const std::string& configuration, const std::string& name, std::string& fault);

}  // namespace alder
