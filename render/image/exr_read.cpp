// Reading EXR files back into an Image: limits checked on the header, channels grouped into layers.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVersion.h>

#include <algorithm>
#include <cstring>

#include "render/image/exr.h"
#include "render/image/file.h"

namespace alder {
namespace {

class MemoryInput : public Imf::IStream {
  public:
    explicit MemoryInput(std::span<const uint8_t> bytes) : Imf::IStream("memory"), bytes_(bytes) {}
    bool read(char c[], int n) override {
        if (n < 0 || position_ > bytes_.size() || size_t(n) > bytes_.size() - position_) throw std::runtime_error("the file ends too early");
        std::memcpy(c, bytes_.data() + position_, size_t(n));
        position_ += size_t(n);
        return position_ < bytes_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t pos) override { position_ = pos; }

  private:
    std::span<const uint8_t> bytes_;
    uint64_t position_ = 0;
};

std::string attribute_text(const Imf::Attribute& a) {
    if (const auto* s = dynamic_cast<const Imf::StringAttribute*>(&a)) return s->value();
    if (const auto* i = dynamic_cast<const Imf::IntAttribute*>(&a)) return std::to_string(i->value());
    if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(&a)) return number_text(f->value());
    if (const auto* r = dynamic_cast<const Imf::RationalAttribute*>(&a)) return std::to_string(r->value().n) + " " + std::to_string(r->value().d);
    if (const auto* m = dynamic_cast<const Imf::M44fAttribute*>(&a)) {
        std::string text;
        for (int i = 0; i < 16; ++i) text += (i ? " " : "") + number_text(m->value()[i / 4][i % 4]);
        return text;
    }
    return {};
}

/// Empty, or why the header cannot be read into an Image.
std::string check(const Imf::Header& header, const ExrLimits& limits) {
    const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
    for (const Imath::Box2i& box : {data, display}) {
        const int64_t w = int64_t(box.max.x) - box.min.x + 1, h = int64_t(box.max.y) - box.min.y + 1;
        if (w < 1 || h < 1 || w > limits.side || h > limits.side) {
            return std::to_string(w) + " x " + std::to_string(h) + " pixels; 1 to " + std::to_string(limits.side) + " a side are accepted";
        }
    }
    const uint64_t pixels = uint64_t(int64_t(data.max.x) - data.min.x + 1) * uint64_t(int64_t(data.max.y) - data.min.y + 1);
    uint64_t channels = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        ++channels;
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1) return std::string("channel \"") + c.name() + "\" is subsampled";
    }
    if (channels == 0) return "no channels";
    if (channels > uint64_t(limits.channels)) return std::to_string(channels) + " channels; at most " + std::to_string(limits.channels) + " are accepted";
    if (pixels * channels * sizeof(float) > limits.bytes) return std::to_string(pixels * channels * sizeof(float)) + " bytes of pixels; at most " + std::to_string(limits.bytes) + " are accepted";
    return {};
}

/// "direct_diffuse.R" -> layer and channel. Without a dot: colour and alpha are the beauty, anything else a layer of its own.
std::pair<std::string, std::string> split_name(const std::string& name) {
    const size_t dot = name.rfind('.');
    if (dot != std::string::npos && dot > 0 && dot + 1 < name.size()) return {name.substr(0, dot), name.substr(dot + 1)};
    if (name == "R" || name == "G" || name == "B" || name == "A") return {"", name};
    return {name, ""};
}

std::vector<Layer> make_layers(const Imf::Header& header) {
    std::vector<Layer> layers;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        const auto [name, channel] = split_name(c.name());
        auto l = std::find_if(layers.begin(), layers.end(), [&, n = name](const Layer& x) { return x.name == n; });
        if (l == layers.end()) {
            layers.emplace_back();
            l = layers.end() - 1;
            l->name = name;
        }
        l->channels.push_back(channel);
        if (c.channel().type != Imf::HALF) l->data = true;
    }
    for (Layer& l : layers) {
        std::stable_sort(l.channels.begin(), l.channels.end(), [](const std::string& a, const std::string& b) { return channel_rank(a) < channel_rank(b); });
    }
    std::stable_sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.name.empty() > b.name.empty(); });
    return layers;
}

Image read_from(Imf::IStream& stream, uint64_t file_bytes, const ExrLimits& limits) {
    char head[8] = {};
    if (file_bytes < sizeof(head)) throw std::runtime_error("not an EXR file");
    stream.read(head, sizeof(head));
    stream.seekg(0);
    uint32_t magic = 0, version = 0;
    std::memcpy(&magic, head, 4);
    std::memcpy(&version, head + 4, 4);
    if (magic != uint32_t(Imf::MAGIC)) throw std::runtime_error("not an EXR file");
    if (Imf::isMultiPart(int(version)) || Imf::isNonImage(int(version))) throw std::runtime_error("multi-part and deep files are not read here");

    Imf::InputFile file(stream, 0);
    const Imf::Header& header = file.header();
    if (const std::string fault = check(header, limits); !fault.empty()) throw std::runtime_error(fault);
    Image image;
    const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
    image.width = data.max.x - data.min.x + 1;
    image.height = data.max.y - data.min.y + 1;
    image.full_width = display.max.x - display.min.x + 1;
    image.full_height = display.max.y - display.min.y + 1;
    image.crop_x = data.min.x - display.min.x;
    image.crop_y = data.min.y - display.min.y;
    for (auto a = header.begin(); a != header.end(); ++a) {
        const std::string text = attribute_text(a.attribute());
        // The structural ones of these types belong to the file, not to the picture.
        const std::string name = a.name();
        if (!text.empty() && name != "pixelAspectRatio" && name != "screenWindowWidth" && name != "type" && name != "name") image.attributes.emplace_back(name, text);
    }
    image.layers = make_layers(header);
    // Deflate reaches 1032 : 1 at most, times two for halves; a header that promises more is a trap, not a picture.
    const size_t pixels = size_t(image.width) * size_t(image.height);
    size_t planes = 0;
    for (const Layer& l : image.layers) planes += l.channels.size();
    if (pixels * planes > size_t(1) << 26 && pixels * planes * sizeof(float) / 2048 > file_bytes) throw std::runtime_error("the header promises far more pixels than the file can hold");
    Imf::FrameBuffer frame;
    const int64_t before = int64_t(data.min.y) * image.width + data.min.x;
    for (Layer& l : image.layers) {
        l.planes.resize(l.channels.size());
        for (size_t c = 0; c < l.channels.size(); ++c) {
            l.planes[c].assign(pixels, 0);
            char* base = reinterpret_cast<char*>(l.planes[c].data()) - before * int64_t(sizeof(float));
            frame.insert(channel_name(l, c), Imf::Slice(Imf::FLOAT, base, sizeof(float), sizeof(float) * size_t(image.width)));
        }
    }
    file.setFrameBuffer(frame);
    file.readPixels(data.min.y, data.max.y);
    return image;
}

}  // namespace

std::optional<Image> decode_exr(std::span<const uint8_t> bytes, std::string& error, const ExrLimits& limits) {
    try {
        MemoryInput stream(bytes);
        return read_from(stream, bytes.size(), limits);
    } catch (const std::exception& e) {
        error = e.what();
        return std::nullopt;
    }
}

std::optional<Image> read_exr(const std::string& path, std::string& error, const ExrLimits& limits) {
    std::vector<uint8_t> bytes;
    if (!read_file(path, limits.bytes, bytes, error)) return std::nullopt;
    std::optional<Image> image = decode_exr(bytes, error, limits);
    if (!image) error = path + ": " + error;
    return image;
}

}  // namespace alder
