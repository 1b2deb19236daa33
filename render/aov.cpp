// AOVs: names, groups, channel layout, and the last step from sums to layers.
#include "render/aov.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "render/sampling.h"

namespace alder {
namespace {

const std::vector<std::string> kShadingNames = {
    "direct_diffuse", "indirect_diffuse", "direct_specular", "indirect_specular", "direct_specular_2", "indirect_specular_2",
    "direct_backlight", "indirect_backlight", "refraction", "sss", "single_scatter", "direct_volume", "indirect_volume",
    "emission", "background"};

/// Layers of alHair beyond the common ones.
const std::vector<std::string> kHairNames = {
    "direct_glint", "indirect_glint", "direct_transmission", "indirect_transmission", "direct_local", "indirect_local",
    "direct_global", "indirect_global"};

const std::map<std::string, ShadingLayer> kLayerByName = {
    {"direct_diffuse", kDirectDiffuse}, {"indirect_diffuse", kIndirectDiffuse}, {"direct_specular", kDirectSpecular},
    {"indirect_specular", kIndirectSpecular}, {"direct_specular_2", kDirectSpecular2}, {"indirect_specular_2", kIndirectSpecular2},
    {"direct_backlight", kDirectBacklight}, {"indirect_backlight", kIndirectBacklight}, {"direct_refraction", kDirectRefraction},
    {"indirect_refraction", kIndirectRefraction}, {"direct_glint", kDirectGlint}, {"indirect_glint", kIndirectGlint},
    {"direct_transmission", kDirectHairTransmission}, {"indirect_transmission", kIndirectHairTransmission},
    {"direct_local", kDirectLocal}, {"indirect_local", kIndirectLocal}, {"direct_global", kDirectGlobal},
    {"indirect_global", kIndirectGlobal}, {"sss", kSssLayer}, {"single_scatter", kSingleScatterLayer},
    {"direct_volume", kDirectVolume}, {"indirect_volume", kIndirectVolume}, {"emission", kEmissionLayer},
    {"background", kBackgroundLayer}};

std::vector<std::string> group_names() {
    std::vector<std::string> names;
    for (int i = 1; i < kLightGroups; ++i) names.push_back("light_group_" + std::to_string(i));
    names.push_back("light_group_default");
    return names;
}

std::vector<std::string> id_names() {
    std::vector<std::string> names{"id_object", "id_material"};
    for (int i = 1; i <= 8; ++i) names.push_back("id_" + std::to_string(i));
    return names;
}

const std::vector<std::string> kRgb{"R", "G", "B"}, kXyz{"X", "Y", "Z"}, kOne{""};

}  // namespace

ShadingLayer layer_of(LobeLabel label, bool direct) {
    switch (label) {
        case LobeLabel::Diffuse: return direct ? kDirectDiffuse : kIndirectDiffuse;
        case LobeLabel::Specular: return direct ? kDirectSpecular : kIndirectSpecular;
        case LobeLabel::Specular2: return direct ? kDirectSpecular2 : kIndirectSpecular2;
        case LobeLabel::Backlight: return direct ? kDirectBacklight : kIndirectBacklight;
        case LobeLabel::Refraction: return direct ? kDirectRefraction : kIndirectRefraction;
        case LobeLabel::Glint: return direct ? kDirectGlint : kIndirectGlint;
        case LobeLabel::HairTransmission: return direct ? kDirectHairTransmission : kIndirectHairTransmission;
        case LobeLabel::Local: return direct ? kDirectLocal : kIndirectLocal;
        case LobeLabel::Global: return direct ? kDirectGlobal : kIndirectGlobal;
        case LobeLabel::Sss: return kSssLayer;
        case LobeLabel::SingleScatter: return kSingleScatterLayer;
        case LobeLabel::Volume: return direct ? kDirectVolume : kIndirectVolume;
        default: return kEmissionLayer;
    }
}

std::vector<std::string> expand_aovs(const std::vector<std::string>& requested, const std::vector<std::string>& graph_aovs) {
    std::vector<std::string> names;
    const auto put = [&](const std::vector<std::string>& list) {
        for (const std::string& n : list)
            if (std::find(names.begin(), names.end(), n) == names.end()) names.push_back(n);
    };
    for (const std::string& r : requested) {
        if (r == "shading") put(kShadingNames);
        else if (r == "hair") put(kHairNames);
        else if (r == "data") put({"Z", "P", "N", "Ng", "uv"});
        else if (r == "denoise") put({"denoise_albedo", "denoise_normal"});
        else if (r == "quality") put({"sample_count", "variance", "error"});
        else if (r == "light_groups") put(group_names());
        else if (r == "ids") put(id_names());
        else if (r == "aovs") put(graph_aovs);
        else if (r != "rgba" && r != "beauty" && !r.empty()) put({r});
    }
    return names;
}

int AovPlan::take(int count) {
    const int first = sums;
    sums += count;
    return first;
}

AovPlan::AovPlan(const std::vector<std::string>& requested, const std::vector<std::pair<std::string, Type>>& scene_aovs) {
    layer.fill(-1);
    group.fill(-1);
    sums = 4;
    add({"", {"R", "G", "B", "A"}, false, Source::Mean, 0});
    for (const std::string& name : requested) request(name, scene_aovs);
    any_data = p >= 0 || n >= 0 || ng >= 0 || uv >= 0 || minima > 0 || firsts > 0;
    if (p >= 0 || n >= 0 || ng >= 0 || uv >= 0) hits = take(1);
    any_color = denoise_albedo >= 0 || denoise_normal >= 0 || diffuse_color >= 0 || specular_color >= 0 || refraction_color >= 0;
    // Minima and firsts were numbered from zero while the number of sums was still growing.
    if (z >= 0) z += sums;
    if (id_object >= 0) id_object += sums + minima;
    if (id_material >= 0) id_material += sums + minima;
    for (Output& o : outputs_) {
        if (o.source == Source::HalfB) film_half_b = sums + 6;
        if (o.name == "Z") o.channel = z;
        if (o.name == "id_object") o.channel = id_object;
        if (o.name == "id_material") o.channel = id_material;
    }
}

void AovPlan::request(const std::string& name, const std::vector<std::pair<std::string, Type>>& scene_aovs) {
    // What the scene's graphs call by this name comes first: their names are the user's own.
    for (const auto& [aov, type] : scene_aovs) {
        if (aov != name) continue;
        UserAov u{name, type, 0};
        u.channel = take(u.scalar() ? 1 : 3);
        add({name, u.scalar() ? kOne : type == Type::Vector ? kXyz : kRgb, type != Type::Color, Source::Mean, u.channel});
        user.push_back(u);
        return;
    }
    if (const auto it = kLayerByName.find(name); it != kLayerByName.end()) {
        layer[it->second] = take(3);
        any_layer = true;
        return add({name, kRgb, false, Source::Mean, layer[it->second]});
    }
    const auto color = [&](int& channel) {
        channel = take(3);
        add({name, kRgb, false, Source::Mean, channel});
    };
    const auto over_hits = [&](int& channel, std::vector<std::string> names) {
        channel = take(static_cast<int>(names.size()));
        add({name, std::move(names), true, Source::MeanOverHits, channel});
    };
    if (name == "refraction") {
        any_layer = true;
        return color(refraction);
    }
    const std::string prefix = "light_group_";
    if (name.compare(0, prefix.size(), prefix) == 0) {
        const std::string which = name.substr(prefix.size());
        const int g = which == "default" ? 0 : which.size() == 1 && which[0] >= '1' && which[0] <= '8' ? which[0] - '0' : -1;
        if (g >= 0) {
            any_group = true;
            return color(group[g]);
        }
    }
    if (name == "P") return over_hits(p, kXyz);
    if (name == "N") return over_hits(n, kXyz);
    if (name == "Ng") return over_hits(ng, kXyz);
    if (name == "uv") return over_hits(uv, {"U", "V"});
    if (name == "denoise_albedo") return color(denoise_albedo);
    if (name == "diffuse_color") return color(diffuse_color);
    if (name == "specular_color") return color(specular_color);
    if (name == "refraction_color") return color(refraction_color);
    if (name == "denoise_normal") {
        denoise_normal = take(3);
        return add({name, kXyz, true, Source::Mean, denoise_normal});
    }
    if (name == "Z") {
        z = minima++;
        return add({name, kOne, true, Source::Direct, 0});
    }
    if (name == "id_object") {
        id_object = firsts++;
        return add({name, kOne, true, Source::Direct, 0});
    }
    if (name == "id_material") {
        id_material = firsts++;
        return add({name, kOne, true, Source::Direct, 0});
    }
    if (name == "sample_count") return add({name, kOne, true, Source::Count, 0});
    if (name == "variance") return add({name, kRgb, true, Source::Variance, 0});
    if (name == "error") return add({name, kOne, true, Source::Error, 0});
    if (name == "half_b") return add({name, kRgb, true, Source::HalfB, 0});
    add({name, kRgb, false, Source::Black, 0});  // present, black: nothing contributes
}

void AovPlan::clear(float* r) const {
    std::fill(r, r + sums, 0.f);
    std::fill(r + sums, r + sums + minima, kNoDepth);
    std::fill(r + sums + minima, r + row(), -1.f);
}

/// Two estimates. Samples are stratified over a pixel's sequence, so their own scatter overstates the error of the mean; the
/// scatter of whole leaves (16 samples each) does so far less, once there are enough of them to have a variance.
float AovPlan::variance_of_mean(const float* r, int channel, const FilmTotals& film) const {
    const double n = static_cast<double>(film.samples);
    if (n < 2) return 0;
    const double mean = r[channel] / n;
    if (film.whole_leaves >= 8) {
        const double leaves = static_cast<double>(film.whole_leaves);
        const double square = r[film_leaf_square() + channel] / (256 * leaves);
        return static_cast<float>(std::max(square - mean * mean, 0.0) / (leaves - 1));
    }
    const double square = r[film_square() + channel] / n;
    return static_cast<float>(std::max(square - mean * mean, 0.0) / (n - 1));
}

float AovPlan::relative_error(const float* r, const FilmTotals& film) const {
    if (film.samples == 0) return 0;
    const float variance = (variance_of_mean(r, 0, film) + variance_of_mean(r, 1, film) + variance_of_mean(r, 2, film)) / 3;
    const float mean = luminance({r[0], r[1], r[2]}) / static_cast<float>(film.samples);
    return std::sqrt(variance) / (std::abs(mean) + 0.01f);
}

double AovPlan::estimated_error(const FilmTotals& film, size_t pixels) const {
    if (pixels == 0 || film.samples < 2) return 0;
    std::vector<float> errors(pixels);
    for (size_t i = 0; i < pixels; ++i) errors[i] = relative_error(film.rows.data() + i * film_row(), film);
    const size_t kept = pixels - pixels / 1000;
    std::nth_element(errors.begin(), errors.begin() + (kept - 1), errors.end());
    double sum = 0;
    for (size_t i = 0; i < kept; ++i) sum += double(errors[i]) * errors[i];
    return std::sqrt(sum / static_cast<double>(kept));
}

std::vector<std::string> AovPlan::names() const {
    std::vector<std::string> names;
    for (const Output& o : outputs_) names.push_back(o.name);
    return names;
}

std::vector<Layer> AovPlan::layers(const FilmTotals& film, size_t pixels, const std::vector<std::string>* only) const {
    std::vector<Layer> result;
    const int stride = film_row();
    const int after_sums = film_sums() - sums;  // minima and firsts lie behind the derived sums
    const float inverse = film.samples > 0 ? 1.f / static_cast<float>(film.samples) : 0.f;
    for (const Output& o : outputs_) {
        if (only && !o.name.empty() && std::find(only->begin(), only->end(), o.name) == only->end()) continue;
        Layer layer{o.name, o.channels, o.data, {}};
        for (size_t c = 0; c < o.channels.size(); ++c) {
            std::vector<float> plane(pixels, 0.f);
            for (size_t i = 0; i < pixels; ++i) {
                const float* const r = film.rows.data() + i * stride;
                const int k = o.channel + static_cast<int>(c);
                switch (o.source) {
                    case Source::Black: break;
                    case Source::Mean: plane[i] = r[k] * inverse; break;
                    case Source::MeanOverHits: plane[i] = r[hits] > 0 ? r[k] / r[hits] : 0.f; break;
                    case Source::Direct: plane[i] = r[k + after_sums]; break;
                    case Source::Count: plane[i] = static_cast<float>(film.samples); break;
                    case Source::Variance: plane[i] = variance_of_mean(r, static_cast<int>(c), film); break;
                    case Source::Error: plane[i] = relative_error(r, film); break;
                    case Source::HalfB: {
                        const float n = r[film_half_b + 3];
                        plane[i] = n > 0 ? r[film_half_b + c] / n : 0.f;
                        break;
                    }
                }
            }
            layer.planes.push_back(std::move(plane));
        }
        result.push_back(std::move(layer));
    }
    return result;
}

}  // namespace alder
