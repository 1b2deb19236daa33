// glTF: buffers, views and accessors, with every offset and count checked before it is used.
#include <cmath>
#include <cstring>

#include "render/import/gltf_parts.h"

namespace alder {

using nlohmann::json;

namespace {

struct ComponentInfo {
    int type;
    size_t bytes;
    double scale;   ///< largest value, for normalised integers
};
constexpr ComponentInfo kComponents[] = {{5120, 1, 127}, {5121, 1, 255}, {5122, 2, 32767}, {5123, 2, 65535}, {5125, 4, 4294967295.0}, {5126, 4, 1}};
constexpr std::pair<const char*, size_t> kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};

template <class T>
double load(const uint8_t* p) {
    T x;
    std::memcpy(&x, p, sizeof(T));
    return double(x);
}

double component(const uint8_t* p, int type) {
    switch (type) {
        case 5120: return load<int8_t>(p);
        case 5121: return load<uint8_t>(p);
        case 5122: return load<int16_t>(p);
        case 5123: return load<uint16_t>(p);
        case 5125: return load<uint32_t>(p);
        default: return load<float>(p);
    }
}

const ComponentInfo* component_info(int type) {
    for (const ComponentInfo& c : kComponents) {
        if (c.type == type) return &c;
    }
    return nullptr;
}

int hex(char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1; }

std::string percent_decoded(const std::string& s) {
    std::string out;
    for (size_t i = 0; i < s.size(); ++i) {
        if (s[i] == '%' && i + 2 < s.size() && hex(s[i + 1]) >= 0 && hex(s[i + 2]) >= 0) {
            out += char(hex(s[i + 1]) * 16 + hex(s[i + 2]));
            i += 2;
        } else {
            out += s[i];
        }
    }
    return out;
}

}  // namespace

std::string GltfNames::take(const std::string& wanted, const std::string& otherwise) {
    const std::string base = wanted.empty() ? otherwise : wanted;
    std::string name = base;
    for (int i = 1; !used_.insert(name).second; ++i) {
        const std::string n = std::to_string(i);
        name = base + "." + std::string(n.size() < 3 ? 3 - n.size() : 0, '0') + n;
    }
    return name;
}

std::string gltf_uv_name(int set) {
    if (set == 0) return "UVMap";
    const std::string n = std::to_string(set);
    return "UVMap." + std::string(n.size() < 3 ? 3 - n.size() : 0, '0') + n;
}

const json* GltfFile::element(const char* array, int index, const std::string& referrer) {
    const auto a = json.find(array);
    const size_t size = a != json.end() && a->is_array() ? a->size() : 0;
    if (index >= 0 && size_t(index) < size) return &(*a)[size_t(index)];
    add_error(d, referrer, "out-of-range", std::to_string(index), size == 0 ? std::string("no index: the file has no ") + array : "an index from 0 to " + std::to_string(size - 1) + " of \"" + array + "\"");
    return nullptr;
}

bool GltfFile::charge(uint64_t bytes, const std::string& pointer) {
    // Several accessors may share bytes, and ones without a view are all zeros: a small file must not unpack to any size.
    const uint64_t limit = std::min<uint64_t>(options.limits.array_bytes, (uint64_t(256) << 20) + 64 * bytes_in_);
    if (bytes > limit || bytes_out_ > limit - bytes) {
        add_error(d, pointer, "limit-exceeded", std::to_string(bytes) + " more bytes", "at most " + std::to_string(limit) + " bytes of arrays in this file");
        return false;
    }
    bytes_out_ += bytes;
    return true;
}

bool GltfFile::uri(const std::string& text, const std::string& pointer, std::vector<uint8_t>& bytes) {
    if (text.starts_with("data:")) {
        const size_t comma = text.find(',');
        if (comma == std::string::npos || text.find(";base64") > comma) {
            add_error(d, pointer, "unsupported", text.substr(0, 40), "a data: URI in base64");
            return false;
        }
        return decode_base64(std::string_view(text).substr(comma + 1), bytes) ||
               (add_error(d, pointer, "wrong-value", "characters that are not base64", "base64"), false);
    }
    std::string error = "files beside the document cannot be read here";
    const std::string name = percent_decoded(text);
    if (name.find("://") == std::string::npos && read_file_ && read_file_(name, bytes, error)) return true;
    add_error(d, pointer, "asset-missing", name, "a file that can be read: " + error);
    return false;
}

std::span<const uint8_t> GltfFile::buffer(int index, const std::string& referrer) {
    const nlohmann::json* j = element("buffers", index, referrer);
    if (!j) return {};
    JsonReader r = reader(*j, "/buffers/" + std::to_string(index));
    const nlohmann::json* text = r.member("uri");
    if (!text && index == 0) {
        bytes_in_ = std::max<uint64_t>(bytes_in_, bin_.size());
        return bin_;
    }
    const auto known = buffers_.find(index);
    if (known != buffers_.end()) return known->second;
    std::vector<uint8_t>& bytes = buffers_[index];
    if (!text || !text->is_string()) add_error(d, r.pointer_to("uri"), "missing-member", "nothing", "a URI: only the first buffer of a .glb is in the file");
    else uri(text->get_ref<const std::string&>(), r.pointer_to("uri"), bytes);
    bytes_in_ += bytes.size();
    return bytes;
}

bool GltfFile::view(int index, const std::string& referrer, std::span<const uint8_t>& bytes, size_t& stride) {
    const nlohmann::json* j = element("bufferViews", index, referrer);
    if (!j) return false;
    const size_t faults = d.errors.size();
    JsonReader r = reader(*j, "/bufferViews/" + std::to_string(index));
    int buffer_index = -1, step = 0;
    uint32_t offset = 0, length = 0;
    r.integer("buffer", buffer_index, 0, INT32_MAX);
    r.integer("byteOffset", offset, 0, UINT32_MAX);
    r.integer("byteLength", length, 0, UINT32_MAX);
    r.integer("byteStride", step, 0, 252);
    if (d.errors.size() > faults) return false;
    const std::span<const uint8_t> all = buffer(buffer_index, r.pointer_to("buffer"));
    if (d.errors.size() > faults) return false;
    if (offset > all.size() || length > all.size() - offset) {
        add_error(d, r.pointer(), "out-of-range", std::to_string(offset) + " + " + std::to_string(length) + " bytes", "a part of the buffer, which has " + std::to_string(all.size()) + " bytes");
        return false;
    }
    bytes = all.subspan(offset, length);
    stride = size_t(step);
    return true;
}

bool GltfFile::open(int index, const std::string& referrer, Accessor& a) {
    a.json = element("accessors", index, referrer);
    if (!a.json) return false;
    a.pointer = "/accessors/" + std::to_string(index);
    const size_t faults = d.errors.size();
    JsonReader r = reader(*a.json, a.pointer);
    uint32_t count = 0, offset = 0;
    int view_index = -1;
    std::string type;
    if (r.required("count", "a number of elements")) r.integer("count", count, 0, 1u << 31);
    r.integer("byteOffset", offset, 0, UINT32_MAX);
    r.integer("componentType", a.component_type, 0, INT32_MAX);
    r.integer("bufferView", view_index, 0, INT32_MAX);
    r.boolean("normalized", a.normalized);
    r.text("type", type);
    a.count = count;
    a.components = 0;
    for (const auto& [name, n] : kTypes) {
        if (type == name) a.components = n;
    }
    const ComponentInfo* info = component_info(a.component_type);
    if (a.components == 0) add_error(d, r.pointer_to("type"), "unknown-value", type, "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
    if (!info) add_error(d, r.pointer_to("componentType"), "unknown-value", std::to_string(a.component_type), "5120 to 5123, 5125 or 5126");
    if (d.errors.size() > faults) return false;
    a.component_bytes = info->bytes;
    const size_t element_bytes = a.components * a.component_bytes;
    a.stride = element_bytes;
    if (view_index < 0) return true;
    size_t stride = 0;
    std::span<const uint8_t> bytes;
    if (!view(view_index, r.pointer_to("bufferView"), bytes, stride)) return false;
    if (stride != 0) a.stride = stride;
    const bool fits = a.count == 0 || (offset <= bytes.size() && element_bytes <= bytes.size() - offset && (a.count - 1) <= (bytes.size() - offset - element_bytes) / a.stride);
    if (!fits || a.stride < element_bytes) {
        add_error(d, a.pointer, "out-of-range", std::to_string(a.count) + " elements of " + std::to_string(element_bytes) + " bytes", "elements inside the buffer view of " + std::to_string(bytes.size()) + " bytes");
        return false;
    }
    if (a.count > 0) a.bytes = bytes.subspan(offset);
    return true;
}

bool GltfFile::values(const Accessor& a, std::vector<double>& out) {
    if (!charge(uint64_t(a.count) * a.components * sizeof(double), a.pointer)) return false;
    out.assign(a.count * a.components, 0);
    const ComponentInfo* info = component_info(a.component_type);
    const double scale = a.normalized ? 1 / info->scale : 1;
    for (size_t i = 0; !a.bytes.empty() && i < a.count; ++i) {
        for (size_t k = 0; k < a.components; ++k) {
            const double x = component(a.bytes.data() + i * a.stride + k * a.component_bytes, a.component_type) * scale;
            out[i * a.components + k] = a.normalized ? std::max(x, -1.0) : x;
        }
    }
    return sparse(a, out);
}

bool GltfFile::sparse(const Accessor& a, std::vector<double>& values) {
    const auto s = a.json->find("sparse");
    if (s == a.json->end()) return true;
    const size_t faults = d.errors.size();
    JsonReader r = reader(*s, a.pointer + "/sparse");
    uint32_t count = 0;
    r.integer("count", count, 0, int64_t(a.count));
    struct Part {
        int view = -1, type = 5125;
        uint32_t offset = 0;
        std::span<const uint8_t> bytes;
    } where, what;
    what.type = a.component_type;
    for (const auto& [key, part, each] : {std::tuple{"indices", &where, size_t(1)}, std::tuple{"values", &what, a.components}}) {
        const nlohmann::json* j = r.required(key, "an object");
        if (!j) return false;
        JsonReader p = reader(*j, r.pointer_to(key));
        p.integer("bufferView", part->view, 0, INT32_MAX);
        p.integer("byteOffset", part->offset, 0, UINT32_MAX);
        if (part == &where) p.integer("componentType", part->type, 0, INT32_MAX);
        const ComponentInfo* info = component_info(part->type);
        size_t stride = 0;
        if (d.errors.size() > faults || !view(part->view, p.pointer_to("bufferView"), part->bytes, stride)) return false;
        const size_t need = info ? info->bytes * each * count : SIZE_MAX;
        if (part->offset > part->bytes.size() || need > part->bytes.size() - part->offset) {
            add_error(d, p.pointer(), "out-of-range", std::to_string(count) + " elements", "elements inside the buffer view");
            return false;
        }
        part->bytes = part->bytes.subspan(part->offset);
    }
    const size_t index_bytes = component_info(where.type)->bytes;
    const double scale = a.normalized ? 1 / component_info(a.component_type)->scale : 1;
    for (size_t i = 0; i < count; ++i) {
        const double at = component(where.bytes.data() + i * index_bytes, where.type);
        if (!(at >= 0 && at < double(a.count))) {
            add_error(d, r.pointer_to("indices"), "out-of-range", nlohmann::json(at).dump(), "an element of the accessor");
            return false;
        }
        for (size_t k = 0; k < a.components; ++k) {
            values[size_t(at) * a.components + k] = component(what.bytes.data() + (i * a.components + k) * a.component_bytes, a.component_type) * scale;
        }
    }
    return true;
}

bool GltfFile::floats(int accessor, const std::string& referrer, int channels, size_t count, std::vector<float>& out, bool pad_with_one) {
    Accessor a;
    std::vector<double> v;
    if (!open(accessor, referrer, a)) return false;
    const bool pads = pad_with_one && a.components + 1 == size_t(channels);
    if (a.components != size_t(channels) && !pads) {
        add_error(d, referrer, "wrong-type", std::to_string(a.components) + " numbers an element", std::to_string(channels));
        return false;
    }
    if (count != SIZE_MAX && a.count != count) {
        add_error(d, referrer, "wrong-length", std::to_string(a.count) + " elements", std::to_string(count));
        return false;
    }
    if (!values(a, v)) return false;
    out.resize(a.count * size_t(channels), 1);
    for (size_t i = 0; i < a.count; ++i) {
        for (size_t k = 0; k < a.components; ++k) {
            const float x = float(v[i * a.components + k]);
            if (!std::isfinite(x)) {
                add_error(d, a.pointer, "nonfinite", "element " + std::to_string(i) + " is " + (std::isnan(x) ? "nan" : "inf"), "finite numbers");
                return false;
            }
            out[i * size_t(channels) + k] = x;
        }
    }
    return true;
}

bool GltfFile::indices(int accessor, const std::string& referrer, size_t limit, std::vector<uint32_t>& out) {
    Accessor a;
    std::vector<double> v;
    if (!open(accessor, referrer, a)) return false;
    if (a.components != 1 || a.component_type == 5126 || a.component_type == 5120 || a.component_type == 5122) {
        add_error(d, referrer, "wrong-type", "an accessor of another type", "unsigned whole numbers");
        return false;
    }
    a.normalized = false;
    if (!values(a, v)) return false;
    out.resize(v.size());
    for (size_t i = 0; i < v.size(); ++i) {
        if (!(v[i] < double(limit))) {
            add_error(d, a.pointer, "out-of-range", "element " + std::to_string(i) + " is " + nlohmann::json(v[i]).dump(), "indices below " + std::to_string(limit) + ", the number of vertices");
            return false;
        }
        out[i] = uint32_t(v[i]);
    }
    return true;
}

size_t GltfFile::count(int accessor, const std::string& referrer) {
    Accessor a;
    return open(accessor, referrer, a) ? a.count : 0;
}

}  // namespace alder
