// alder merge: images of disjoint sample ranges of one scene to the image that one render of all samples gives.
//
// Colour and shading layers are means over samples, so they combine weighted by sample counts, to float rounding. Depth is a
// minimum, identifiers belong to the earliest sample that hit. Variances of the mean combine by the parallel algorithm of Chan,
// Golub and LeVeque, "Updating formulae and a pairwise algorithm for computing sample variances", 1979.
// P, N, Ng and uv are means over the samples that hit something; files do not hold that number, so alpha stands for it: exact
// where a pixel is covered wholly, close along silhouettes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "clients/cli/picture.h"
#include "render/image/image.h"

namespace alder::cli {
namespace {

struct Options {
    std::vector<std::string> files;
    std::string output, pixel_type = "float";
    bool quiet = false;
};

struct Part {
    std::string file;
    Image image;
    double samples = 0, offset = 0;
};

enum class Rule { Mean, MeanOverHits, Minimum, First, Sum, Variance, Error };
Rule rule_of(const Layer& layer) {
    const std::string& n = layer.name;
    if (n == "P" || n == "N" || n == "Ng" || n == "uv") return Rule::MeanOverHits;
    if (n == "Z") return Rule::Minimum;
    if (n == "id_object" || n == "id_material") return Rule::First;
    if (n == "sample_count") return Rule::Sum;
    if (n == "variance") return Rule::Variance;
    if (n == "error") return Rule::Error;
    return Rule::Mean;
}

double number(const Part& part, const char* name) {
    const auto value = number_attribute(part.image, name);
    if (!value) fail(kWrong, fmt::format("{}: has no attribute {}: it was not written by alder", part.file, name));
    return *value;
}

std::vector<Part> read_parts(const Options& o) {
    std::vector<Part> parts;
    for (const std::string& file : o.files) {
        std::string error;
        auto image = read_exr(file, error);
        if (!image) fail(kWrong, error.find(file) == std::string::npos ? file + ": " + error : error);
        parts.push_back({file, std::move(*image), 0, 0});
        parts.back().samples = number(parts.back(), "alder/samples");
        parts.back().offset = number(parts.back(), "alder/sample_offset");
    }
    std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.offset < b.offset; });
    return parts;
}

void check_agreement(const std::vector<Part>& parts, bool quiet) {
    const Part& first = parts.front();
    const auto disagree = [&](const Part& p, const std::string& what) { fail(kWrong, fmt::format("{} and {} differ in {}", first.file, p.file, what)); };
    for (const Part& p : parts) {
        const Image &a = first.image, &b = p.image;
        if (a.width != b.width || a.height != b.height || a.full_width != b.full_width || a.full_height != b.full_height || a.crop_x != b.crop_x || a.crop_y != b.crop_y)
            disagree(p, "size or crop");
        if (number(first, "alder/seed") != number(p, "alder/seed")) disagree(p, "seed");
        for (const char* digest : {"alder/scene_digest", "alder/settings_digest"}) {
            const std::string *x = find_attribute(a, digest), *y = find_attribute(b, digest);
            if ((x == nullptr) != (y == nullptr) || (x && *x != *y)) disagree(p, digest);
        }
        if (a.layers.size() != b.layers.size()) disagree(p, "layers");
        for (const Layer& layer : a.layers) {
            const Layer* other = b.find(layer.name);
            if (!other || other->channels != layer.channels) disagree(p, fmt::format("the layer '{}'", layer.name));
        }
        if (!(p.samples > 0)) fail(kWrong, p.file + ": has no samples");
    }
    for (size_t i = 1; i < parts.size(); ++i) {
        const double end = parts[i - 1].offset + parts[i - 1].samples;
        if (parts[i].offset < end)
            fail(kWrong, fmt::format("{} and {} share samples {:.0f} to {:.0f}", parts[i - 1].file, parts[i].file, parts[i].offset, std::min(end, parts[i].offset + parts[i].samples) - 1));
        if (parts[i].offset > end && !quiet)
            std::fprintf(stderr, "alder: warning: no file has samples %.0f to %.0f\n", end, parts[i].offset - 1);
    }
}

class Merge {
  public:
    explicit Merge(const std::vector<Part>& parts) : parts_(parts) {
        bool leaves = true;   // the renderer measures the scatter of whole leaves of 16 samples once there are 8 of them
        for (const Part& p : parts) {
            total_ += p.samples;
            leaves = leaves && p.samples >= 128 && std::fmod(p.samples, 16) == 0 && std::fmod(p.offset, 16) == 0;
        }
        samples_per_unit_ = leaves ? 16 : 1;
    }

    Image run() const {
        Image out = parts_.front().image;
        for (Layer& layer : out.layers)
            if (rule_of(layer) != Rule::Error)
                for (size_t c = 0; c < layer.planes.size(); ++c)
                    for (size_t i = 0; i < layer.planes[c].size(); ++i) layer.planes[c][i] = value(layer, c, i);
        const Layer* variance = out.find("variance");
        for (Layer& layer : out.layers)
            if (rule_of(layer) == Rule::Error) set_error(layer, out, variance);
        bool complete = true;
        double nonfinite = 0;
        for (const Part& p : parts_) {
            complete = complete && number_attribute(p.image, "alder/complete").value_or(1) != 0;
            nonfinite += number_attribute(p.image, "alder/nonfinite_samples").value_or(0);
        }
        set_attribute(out, "alder/samples", fmt::format("{:.0f}", total_));
        set_attribute(out, "alder/sample_offset", fmt::format("{:.0f}", parts_.front().offset));
        set_attribute(out, "alder/complete", complete ? "1" : "0");
        set_attribute(out, "alder/nonfinite_samples", fmt::format("{:.0f}", nonfinite));
        // Errors of independent ranges add in squares, weighted like the means.
        double square = 0;
        for (const Part& p : parts_) {
            const double e = number_attribute(p.image, "alder/estimated_error").value_or(0) * p.samples / total_;
            square += e * e;
        }
        set_attribute(out, "alder/estimated_error", number_text(std::sqrt(square)));
        return out;
    }

  private:
    float plane(const Part& p, const Layer& layer, size_t c, size_t i) const { return p.image.find(layer.name)->planes[c][i]; }

    float value(const Layer& layer, size_t c, size_t i) const {
        double sum = 0, weight = 0;
        switch (rule_of(layer)) {
            case Rule::Minimum: {
                float least = plane(parts_.front(), layer, c, i);
                for (const Part& p : parts_) least = std::min(least, plane(p, layer, c, i));
                return least;
            }
            case Rule::First:
                for (const Part& p : parts_)
                    if (const float id = plane(p, layer, c, i); id > 0) return id;
                return plane(parts_.front(), layer, c, i);
            case Rule::Sum:
                for (const Part& p : parts_) sum += plane(p, layer, c, i);
                return static_cast<float>(sum);
            case Rule::Variance: return variance(layer, c, i);
            case Rule::MeanOverHits:
                for (const Part& p : parts_) {
                    const Layer* beauty = p.image.find("");
                    const double alpha = beauty && beauty->planes.size() > 3 ? std::clamp(beauty->planes[3][i], 0.f, 1.f) : 1;
                    const bool hit = is_hit(p, i);
                    sum += plane(p, layer, c, i) * p.samples * alpha * hit;
                    weight += p.samples * alpha * hit;
                }
                return weight > 0 ? static_cast<float>(sum / weight) : 0.f;
            default:
                for (const Part& p : parts_) sum += static_cast<double>(plane(p, layer, c, i)) * p.samples;
                return static_cast<float>(sum / total_);
        }
    }

    /// Whether any data layer of the part says that something was hit.
    static bool is_hit(const Part& p, size_t i) {
        for (const char* name : {"N", "Ng", "P", "uv"})
            if (const Layer* layer = p.image.find(name))
                for (const auto& plane : layer->planes)
                    if (plane[i] != 0) return true;
        return false;
    }

    float variance(const Layer& layer, size_t c, size_t i) const {
        const double units = total_ / samples_per_unit_;
        double mean = 0, scatter = 0;
        const auto beauty = [&](const Part& p) { return static_cast<double>(p.image.find("")->planes[c][i]); };
        for (const Part& p : parts_) mean += beauty(p) * p.samples / total_;
        for (const Part& p : parts_) {
            const double n = p.samples / samples_per_unit_, d = beauty(p) - mean;
            scatter += plane(p, layer, c, i) * n * (n - 1) + n * d * d;
        }
        return units > 1 ? static_cast<float>(scatter / (units * (units - 1))) : 0.f;
    }

    void set_error(Layer& layer, const Image& out, const Layer* variance) const {
        const Layer* beauty = out.find("");
        for (size_t i = 0; i < layer.planes[0].size(); ++i) {
            if (!variance || !beauty) {   // without variances: independent errors, weighted like the means
                double square = 0;
                for (const Part& p : parts_) square += std::pow(plane(p, layer, 0, i) * p.samples / total_, 2);
                layer.planes[0][i] = static_cast<float>(std::sqrt(square));
                continue;
            }
            const auto rgb = [&](const Layer& l, size_t c) { return static_cast<double>(l.planes[c][i]); };
            const double mean = 0.2126 * rgb(*beauty, 0) + 0.7152 * rgb(*beauty, 1) + 0.0722 * rgb(*beauty, 2);
            layer.planes[0][i] = static_cast<float>(std::sqrt((rgb(*variance, 0) + rgb(*variance, 1) + rgb(*variance, 2)) / 3) / (std::abs(mean) + 0.01));
        }
    }

    const std::vector<Part>& parts_;
    double total_ = 0, samples_per_unit_ = 1;
};

int run(const Options& o) {
    check_image_name(o.output);
    const std::vector<Part> parts = read_parts(o);
    check_agreement(parts, o.quiet);
    const Image merged = Merge(parts).run();
    ExrOptions exr;
    exr.all_float = o.pixel_type == "float";
    write_image(o.output, merged, exr, {});
    if (!o.quiet) fmt::print("{}: {} samples of {} files\n", o.output, *find_attribute(merged, "alder/samples"), parts.size());
    return kDone;
}

}  // namespace

Run add_merge(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("merge", "images of disjoint sample ranges to one");
    c->add_option("FILE", o->files, "images written by alder render with different --sample-offset")->required();
    c->add_option("-o,--output", o->output, "OUT.exr, .png or .jpg")->required();
    c->add_option("--pixel-type", o->pixel_type, "of colour layers in an .exr")->check(CLI::IsMember({"float", "half"}))->capture_default_str();
    c->add_flag("--quiet", o->quiet, "errors only");
    return [o] { return run(*o); };
}

}  // namespace alder::cli
