// Writing EXR files: header and attributes, channels as half or float, to memory or to a file.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>

#include "render/image/exr.h"
#include "render/image/file.h"

namespace alder {
namespace {

class MemoryStream : public Imf::OStream {
  public:
    explicit MemoryStream(std::vector<uint8_t>& bytes) : Imf::OStream("memory"), bytes_(bytes) {}
    void write(const char c[], int n) override {
        if (position_ + n > bytes_.size()) bytes_.resize(position_ + n);
        std::memcpy(bytes_.data() + position_, c, size_t(n));
        position_ += n;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t pos) override { position_ = pos; }

  private:
    std::vector<uint8_t>& bytes_;
    uint64_t position_ = 0;
};

class FileStream : public Imf::OStream {
  public:
    explicit FileStream(AtomicFile& file) : Imf::OStream("file"), file_(file) {}
    void write(const char c[], int n) override {
        if (!file_.write(c, size_t(n))) throw std::runtime_error(file_.error());
    }
    uint64_t tellp() override { return file_.position(); }
    void seekp(uint64_t pos) override {
        if (!file_.seek(pos)) throw std::runtime_error(file_.error());
    }

  private:
    AtomicFile& file_;
};

Imf::Compression compression(ExrOptions::Compression c) {
    switch (c) {
        case ExrOptions::Compression::None: return Imf::NO_COMPRESSION;
        case ExrOptions::Compression::Zip: return Imf::ZIP_COMPRESSION;
        case ExrOptions::Compression::Zips: return Imf::ZIPS_COMPRESSION;
        case ExrOptions::Compression::Piz: return Imf::PIZ_COMPRESSION;
        case ExrOptions::Compression::Rle: return Imf::RLE_COMPRESSION;
    }
    return Imf::ZIP_COMPRESSION;
}

/// All numbers of a text separated by spaces or commas, with none left over.
std::vector<double> numbers(const std::string& text) {
    std::vector<double> out;
    const char *p = text.data(), *end = p + text.size();
    while (p != end) {
        if (*p == ' ' || *p == ',') {
            ++p;
            continue;
        }
        double x = 0;
        const auto [next, fault] = std::from_chars(p, end, x);
        if (fault != std::errc()) return {};
        out.push_back(x);
        p = next;
    }
    return out;
}

enum class AttributeKind { Int, Float, Matrix, Rational };
struct TypedAttribute {
    const char* name;
    AttributeKind kind;
};
// Attributes that other programs read as numbers. A value that does not fit its type (a seed above 2^31) stays a text.
constexpr TypedAttribute kTyped[] = {
    {"alder/samples", AttributeKind::Int},       {"alder/seed", AttributeKind::Int},
    {"alder/sample_offset", AttributeKind::Int}, {"alder/complete", AttributeKind::Int},
    {"alder/nonfinite_samples", AttributeKind::Int}, {"alder/estimated_error", AttributeKind::Float},
    {"expTime", AttributeKind::Float},           {"worldToCamera", AttributeKind::Matrix},
    {"worldToNDC", AttributeKind::Matrix},       {"framesPerSecond", AttributeKind::Rational},
};

bool insert_typed(Imf::Header& header, const std::string& name, const std::string& value) {
    const auto* typed = std::find_if(std::begin(kTyped), std::end(kTyped), [&](const TypedAttribute& t) { return name == t.name; });
    if (typed == std::end(kTyped)) return false;
    const std::vector<double> x = numbers(value);
    const auto is_int = [](double v) { return std::abs(v) <= 2147483647.0 && v == std::trunc(v); };
    switch (typed->kind) {
        case AttributeKind::Int:
            if (x.size() != 1 || !is_int(x[0])) return false;
            header.insert(name, Imf::IntAttribute(int(x[0])));
            return true;
        case AttributeKind::Float:
            if (x.size() != 1) return false;
            header.insert(name, Imf::FloatAttribute(float(x[0])));
            return true;
        case AttributeKind::Matrix: {
            if (x.size() != 16) return false;
            Imath::M44f m;
            for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = float(x[i]);
            header.insert(name, Imf::M44fAttribute(m));
            return true;
        }
        case AttributeKind::Rational:
            if (x.size() == 1) {
                header.insert(name, Imf::RationalAttribute(Imf::Rational(x[0])));
                return true;
            }
            if (x.size() != 2 || !is_int(x[0]) || !is_int(x[1]) || x[1] < 0) return false;
            header.insert(name, Imf::RationalAttribute(Imf::Rational(int(x[0]), unsigned(x[1]))));
            return true;
    }
    return false;
}

// What the header itself decides: an attribute of the image may not contradict it.
bool is_structural(const std::string& name) {
    static constexpr const char* kNames[] = {"channels", "compression", "dataWindow", "displayWindow", "lineOrder",
        "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "tiles", "type", "name", "version", "chunkCount",
        "maxSamplesPerPixel", "preview", "chromaticities"};
    return std::any_of(std::begin(kNames), std::end(kNames), [&](const char* n) { return name == n; });
}

Imf::Header make_header(const Image& image, const ExrOptions& options) {
    using Imath::Box2i, Imath::V2f, Imath::V2i;
    const int full_w = image.full_width > 0 ? image.full_width : image.width;
    const int full_h = image.full_height > 0 ? image.full_height : image.height;
    const Box2i display(V2i(0, 0), V2i(full_w - 1, full_h - 1));
    const Box2i data(V2i(image.crop_x, image.crop_y), V2i(image.crop_x + image.width - 1, image.crop_y + image.height - 1));
    Imf::Header header(display, data, 1, V2f(0, 0), 1, Imf::INCREASING_Y, compression(options.compression));
    Imf::addChromaticities(header, Imf::Chromaticities());   // the default is Rec. 709 with a D65 white
    for (const auto& [name, value] : image.attributes) {
        if (name.empty() || is_structural(name)) continue;
        if (!insert_typed(header, name, value)) header.insert(name, Imf::StringAttribute(value));
    }
    return header;
}

struct Plane {
    std::string name;
    const float* pixels;
    bool as_float;
};

/// Out-of-range values become the largest half, not infinity: an infinite pixel spoils every filter behind it.
half to_half(float x) {
    if (std::isfinite(x)) x = std::clamp(x, -65504.0f, 65504.0f);
    return half(x);
}

void write_pixels(Imf::OutputFile& file, const Image& image, const std::vector<Plane>& planes, int rows_at_once) {
    const size_t width = size_t(image.width), halves = size_t(std::count_if(planes.begin(), planes.end(), [](const Plane& p) { return !p.as_float; }));
    std::vector<half> buffer(halves * width * size_t(rows_at_once));
    for (int y = 0; y < image.height; y += rows_at_once) {
        const int rows = std::min(rows_at_once, image.height - y);
        Imf::FrameBuffer frame;
        half* free = buffer.data();
        for (const Plane& p : planes) {
            const float* from = p.pixels + size_t(y) * width;
            // OpenEXR addresses pixels by their place in the window: the base lies that much before the first of them.
            const int64_t before = int64_t(y + image.crop_y) * int64_t(width) + image.crop_x;
            if (p.as_float) {
                char* base = reinterpret_cast<char*>(const_cast<float*>(from)) - before * int64_t(sizeof(float));
                frame.insert(p.name, Imf::Slice(Imf::FLOAT, base, sizeof(float), sizeof(float) * width));
            } else {
                for (size_t i = 0; i < width * size_t(rows); ++i) free[i] = to_half(from[i]);
                frame.insert(p.name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(free) - before * int64_t(sizeof(half)), sizeof(half), sizeof(half) * width));
                free += width * size_t(rows_at_once);
            }
        }
        file.setFrameBuffer(frame);
        file.writePixels(rows);
    }
}

void write_to(Imf::OStream& stream, const Image& image, const ExrOptions& options) {
    static std::once_flag once;
    std::call_once(once, [] {
        if (Imf::globalThreadCount() == 0) Imf::setGlobalThreadCount(int(std::max(1u, std::thread::hardware_concurrency())));
    });
    Imf::Header header = make_header(image, options);
    std::vector<Plane> planes;
    for (const Layer& layer : image.layers) {
        for (size_t c = 0; c < layer.planes.size(); ++c) {
            const bool as_float = options.all_float || layer.data;
            planes.push_back({channel_name(layer, c), layer.planes[c].data(), as_float});
            header.channels().insert(planes.back().name, Imf::Channel(as_float ? Imf::FLOAT : Imf::HALF));
        }
    }
    // A tiny picture is not worth waking other threads for.
    const bool large = size_t(image.width) * size_t(image.height) * planes.size() > size_t(1) << 19;
    const int threads = large ? Imf::globalThreadCount() : 0;
    Imf::OutputFile file(stream, header, threads);
    write_pixels(file, image, planes, 32 * std::max(1, threads));   // 16 lines are one zip block
}

}  // namespace

std::vector<uint8_t> encode_exr(const Image& image, const ExrOptions& options, std::string& error) {
    std::vector<uint8_t> bytes;
    error = image_fault(image);
    if (!error.empty()) return bytes;
    try {
        MemoryStream stream(bytes);
        write_to(stream, image, options);
    } catch (const std::exception& e) {
        error = e.what();
        bytes.clear();
    }
    return bytes;
}

bool write_exr(const std::string& path, const Image& image, const ExrOptions& options, std::string& error) {
    error = image_fault(image);
    if (!error.empty()) return false;
    AtomicFile file(path);
    try {
        if (file.error().empty()) {
            FileStream stream(file);
            write_to(stream, image, options);
        }
    } catch (const std::exception& e) {
        error = file.error().empty() ? path + ": " + e.what() : file.error();
        return false;
    }
    if (file.commit()) return true;
    error = file.error();
    return false;
}

}  // namespace alder
