// Colour spaces of an OpenColorIO configuration.
#include "nodes/texture/color_configuration.h"

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <map>
#include <mutex>

#include "nodes/texture/color_space.h"

namespace OCIO = OCIO_NAMESPACE;

namespace alder {
namespace {

struct Configuration {
    OCIO::ConstConfigRcPtr config;
    std::string rec709;         ///< its name for linear Rec.709; empty: go by ACES2065-1
    ConfigurationNames names;
};

/// What a configuration may call linear Rec.709. No roles: scene_linear is another space in many.
constexpr const char* kRec709Names[] = {"Linear Rec.709", "Linear Rec.709 (sRGB)", "lin_rec709", "lin_rec709_srgb", "lin_srgb", "lin_rec709_scene",
                                        "Linear BT.709", "Utility - Linear - sRGB", "Utility - Linear - Rec.709"};

Configuration read_configuration(const std::string& path) {
    Configuration c;
    try {
        c.config = OCIO::Config::CreateFromFile(path.c_str());
        for (const char* name : kRec709Names)
            if (c.rec709.empty() && c.config->getColorSpace(name)) c.rec709 = c.config->getColorSpace(name)->getName();
        if (c.rec709.empty() && !c.config->getColorSpace(OCIO::ROLE_INTERCHANGE_SCENE)) {
            c.names.fault = fmt::format("{}: has neither Linear Rec.709 nor the role {}", path, OCIO::ROLE_INTERCHANGE_SCENE);
            return c;
        }
        for (int i = 0; i < c.config->getNumColorSpaces(); ++i) {
            const auto space = c.config->getColorSpace(c.config->getColorSpaceNameByIndex(i));
            c.names.names.emplace_back(space->getName());
            for (size_t k = 0; k < space->getNumAliases(); ++k) c.names.aliases.emplace_back(space->getAlias(k));
        }
        for (int i = 0; i < c.config->getNumRoles(); ++i) c.names.aliases.emplace_back(c.config->getRoleName(i));
    } catch (const std::exception& e) {
        c.config = nullptr;
        c.names.fault = fmt::format("{}: {}", path, e.what());
    }
    return c;
}

const Configuration& configuration_at(const std::string& path) {
    static std::mutex mutex;
    static auto* const known = new std::map<std::string, Configuration>;
    const std::lock_guard lock(mutex);
    const auto it = known->find(path);
    return it != known->end() ? it->second : known->emplace(path, read_configuration(path)).first->second;
}

class OcioSpace final : public ConfiguredSpace {
  public:
    OcioSpace(OCIO::ConstCPUProcessorRcPtr processor, bool gives_aces) : processor_(std::move(processor)), gives_aces_(gives_aces) {}
    void to_linear_rec709(float (&rgb)[3]) const override {
        static const ColorSpace aces = *find_color_space("ACES2065-1");
        processor_->applyRGB(rgb);
        if (gives_aces_) aces.to_linear_rec709(rgb);
    }

  private:
    OCIO::ConstCPUProcessorRcPtr processor_;
    bool gives_aces_;
};

}  // namespace

std::shared_ptr<const ConfiguredSpace> find_configured_space(const std::string& path, const std::string& name, std::string& fault) {
    const Configuration& c = configuration_at(path);
    if (!c.names.fault.empty()) return fault = c.names.fault, nullptr;
    try {
        const auto space = c.config->getColorSpace(name.c_str());
        if (!space) return fault = fmt::format("colour space \"{}\" is not one of {}", name, path), nullptr;
        const bool by_aces = c.rec709.empty();
        const auto processor = c.config->getProcessor(space->getName(), by_aces ? OCIO::ROLE_INTERCHANGE_SCENE : c.rec709.c_str());
        auto result = std::make_shared<OcioSpace>(processor->getDefaultCPUProcessor(), by_aces);
        result->is_data = space->isData();
        return result;
    } catch (const std::exception& e) {
        return fault = fmt::format("colour space \"{}\" of {}: {}", name, path, e.what()), nullptr;
    }
}

}  // namespace alder

extern "C" const alder::ConfigurationNames* alder_color_names(const std::string& configuration) {
    return &alder::configuration_at(configuration).names;
}
