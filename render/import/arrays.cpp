// Arrays of numbers in a scene document.
#include "render/import/arrays.h"

#include <Imath/half.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/import/json_reader.h"

namespace alder {

using nlohmann::json;

namespace {

enum ElementType { kF32, kF64, kF16, kU8, kU16, kU32, kI32 };
struct ElementInfo {
    const char* name;
    size_t bytes;
    bool whole;
};
constexpr ElementInfo kElements[] = {{"f32", 4, false}, {"f64", 8, false}, {"f16", 2, false}, {"u8", 1, true},
                                     {"u16", 2, true},  {"u32", 4, true},  {"i32", 4, true}};
constexpr const char* kElementNames[] = {"f32", "f64", "f16", "u8", "u16", "u32", "i32"};

/// Little-endian, any alignment.
double element(const uint8_t* p, int type) {
    const auto load = [p](auto x) {
        std::memcpy(&x, p, sizeof(x));
        return x;
    };
    switch (type) {
        case kF32: return load(float{});
        case kF64: return load(double{});
        case kF16: {
            half h;
            h.setBits(load(uint16_t{}));
            return float(h);
        }
        case kU8: return *p;
        case kU16: return load(uint16_t{});
        case kU32: return load(uint32_t{});
        default: return load(int32_t{});
    }
}

/// 0 or more, also when a client writes 3.0; below 2^53, so that the double is exact.
bool is_whole(const json& j) {
    if (j.is_number_unsigned()) return true;
    if (!j.is_number()) return false;
    const double x = j.get<double>();
    return x >= 0 && x <= 9007199254740992.0 && x == std::trunc(x);
}

int sextet(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

std::string encode_base64(const void* data, size_t bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const auto* p = static_cast<const uint8_t*>(data);
    std::string out;
    out.reserve((bytes + 2) / 3 * 4);
    for (size_t i = 0; i < bytes; i += 3) {
        const uint32_t v = uint32_t(p[i]) << 16 | (i + 1 < bytes ? uint32_t(p[i + 1]) << 8 : 0) | (i + 2 < bytes ? p[i + 2] : 0);
        out += kDigits[v >> 18];
        out += kDigits[v >> 12 & 63];
        out += i + 1 < bytes ? kDigits[v >> 6 & 63] : '=';
        out += i + 2 < bytes ? kDigits[v & 63] : '=';
    }
    return out;
}

bool decode_base64(std::string_view text, std::vector<uint8_t>& bytes) {
    size_t n = text.size();
    while (n > 0 && text[n - 1] == '=') --n;
    if (n % 4 == 1 || text.size() - n > 2) return false;
    bytes.reserve(n / 4 * 3 + 2);
    uint32_t v = 0;
    for (size_t i = 0; i < n; ++i) {
        const int s = sextet(text[i]);
        if (s < 0) return false;
        v = v << 6 | uint32_t(s);
        if (i % 4 == 1) bytes.push_back(uint8_t(v >> 4));
        if (i % 4 == 2) bytes.push_back(uint8_t(v >> 2));
        if (i % 4 == 3) bytes.push_back(uint8_t(v));
    }
    return true;
}

bool ArrayReader::charge(uint64_t bytes, const std::string& pointer) {
    if (bytes > bytes_left_) {
        add_error(d_, pointer, "limit-exceeded", std::to_string(bytes) + " bytes", "arrays of less than the limit of this document in all");
        return false;
    }
    bytes_left_ -= bytes;
    return true;
}

bool ArrayReader::buffer(const std::string& name, const std::string& pointer, Span& span) {
    auto& known = buffers_[name];
    if (!known) {
        auto bytes = std::make_shared<std::vector<uint8_t>>();
        std::string error = "this document has no buffers";
        if (!read_ || !read_(name, *bytes, error)) {
            add_error(d_, pointer, "asset-missing", name, "a buffer that can be read: " + error);
            return false;
        }
        known = std::move(bytes);
    }
    span.bytes = known;
    return true;
}

bool ArrayReader::locate(const json& j, const std::string& pointer, int channels, Span& span) {
    JsonReader r(j, pointer, d_, false);
    const size_t faults = d_.errors.size();
    r.choice("type", kElementNames, span.type);
    const json *inline_text = r.member("base64"), *name = r.member("buffer"), *offset = r.member("offset"), *count = r.member("count");
    r.finish();
    if (d_.errors.size() > faults) return false;
    if ((inline_text != nullptr) == (name != nullptr)) {
        add_error(d_, pointer, "wrong-value", describe(j), "either \"buffer\" or \"base64\"");
        return false;
    }
    const json& source = inline_text ? *inline_text : *name;
    const std::string source_pointer = pointer + (inline_text ? "/base64" : "/buffer");
    if (!source.is_string()) {
        add_error(d_, source_pointer, "wrong-type", describe(source), "a string");
        return false;
    }
    const std::string& text = source.get_ref<const std::string&>();
    if (inline_text) {
        auto bytes = std::make_shared<std::vector<uint8_t>>();
        if (!decode_base64(text, *bytes)) {
            add_error(d_, source_pointer, "wrong-value", describe(source), "base64");
            return false;
        }
        span.bytes = std::move(bytes);
    } else if (!buffer(text, source_pointer, span)) {
        return false;
    }
    for (const auto& [value, key] : {std::pair{offset, "/offset"}, std::pair{count, "/count"}}) {
        if (value && !is_whole(*value)) {
            add_error(d_, pointer + key, "wrong-type", describe(*value), "a whole number, 0 or more");
            return false;
        }
    }
    const size_t size = span.bytes->size(), bytes = kElements[span.type].bytes * size_t(channels);
    const uint64_t start = offset ? offset->get<uint64_t>() : 0;
    if (start > size) {
        add_error(d_, pointer + "/offset", "out-of-range", std::to_string(start), "at most " + std::to_string(size) + ", the buffer's size");
        return false;
    }
    const size_t fits = (size - size_t(start)) / bytes;
    const uint64_t elements = count ? count->get<uint64_t>() : fits;
    if (elements > fits) {
        add_error(d_, pointer + "/count", "out-of-range", std::to_string(elements), "at most " + std::to_string(fits) + ": the buffer ends there");
        return false;
    }
    if (!count && (size - size_t(start)) % bytes != 0) {
        add_error(d_, pointer, "wrong-value", std::to_string(size - size_t(start)) + " bytes", "a multiple of " + std::to_string(bytes) + ", or \"count\"");
        return false;
    }
    span.offset = size_t(start);
    span.numbers = size_t(elements) * size_t(channels);
    return true;
}

bool ArrayReader::flatten(const json& j, const std::string& pointer, int channels, std::vector<double>& out) {
    const auto number = [&](const json& x, const std::string& where) {
        if (!x.is_number()) {
            add_error(d_, where, "wrong-type", describe(x), "a number");
            return false;
        }
        out.push_back(x.get<double>());
        return true;
    };
    for (size_t i = 0; i < j.size(); ++i) {
        const json& x = j[i];
        const auto here = [&] { return pointer + "/" + std::to_string(i); };
        if (!x.is_array()) {
            if (!number(x, x.is_number() ? std::string() : here())) return false;
            continue;
        }
        if (x.size() != size_t(channels)) {
            add_error(d_, here(), "wrong-type", describe(x), std::to_string(channels) + " numbers");
            return false;
        }
        for (size_t k = 0; k < x.size(); ++k) {
            if (!number(x[k], x[k].is_number() ? std::string() : here() + "/" + std::to_string(k))) return false;
        }
    }
    return true;
}

bool ArrayReader::check_count(size_t numbers, const std::string& pointer, int channels, size_t count) {
    const size_t elements = numbers / size_t(channels);
    if (numbers % size_t(channels) != 0) {
        add_error(d_, pointer, "wrong-length", std::to_string(numbers) + " numbers", "a multiple of " + std::to_string(channels));
        return false;
    }
    if (count != SIZE_MAX && elements != count) {
        const std::string each = channels == 1 ? "" : " of " + std::to_string(channels) + " numbers";
        add_error(d_, pointer, "wrong-length", std::to_string(elements) + " elements", std::to_string(count) + " elements" + each);
        return false;
    }
    return true;
}

bool ArrayReader::floats(const json& j, const std::string& pointer, int channels, size_t count, std::vector<float>& out) {
    std::vector<double> written;
    Span span;
    size_t n = 0;
    if (j.is_array()) {
        if (!flatten(j, pointer, channels, written)) return false;
        n = written.size();
    } else if (j.is_object()) {
        if (!locate(j, pointer, channels, span)) return false;
        n = span.numbers;
    } else {
        add_error(d_, pointer, "wrong-type", describe(j), "an array of numbers, or an object with \"buffer\" or \"base64\"");
        return false;
    }
    if (!check_count(n, pointer, channels, count) || !charge(uint64_t(n) * sizeof(float), pointer)) return false;
    out.resize(n);
    const uint8_t* p = span.bytes ? span.bytes->data() + span.offset : nullptr;
    if (p && span.type == kF32) {
        if (n > 0) std::memcpy(out.data(), p, n * sizeof(float));
    } else {
        for (size_t i = 0; i < n; ++i) out[i] = float(p ? element(p + i * kElements[span.type].bytes, span.type) : written[i]);
    }
    for (size_t i = 0; i < n; ++i) {
        if (std::isfinite(out[i])) continue;
        add_error(d_, pointer + "/" + std::to_string(i / size_t(channels)), "nonfinite", std::isnan(out[i]) ? "nan" : "inf", "a finite number");
        return false;
    }
    return true;
}

bool ArrayReader::indices(const json& j, const std::string& pointer, int channels, size_t count, uint64_t limit, std::vector<uint32_t>& out) {
    std::vector<double> written;
    Span span;
    span.type = kU32;
    size_t n = 0;
    if (j.is_array()) {
        if (!flatten(j, pointer, channels, written)) return false;
        n = written.size();
    } else if (j.is_object()) {
        if (!locate(j, pointer, channels, span)) return false;
        n = span.numbers;
        if (!kElements[span.type].whole) {
            add_error(d_, pointer + "/type", "wrong-type", kElements[span.type].name, "u8, u16, u32 or i32");
            return false;
        }
    } else {
        add_error(d_, pointer, "wrong-type", describe(j), "an array of whole numbers, or an object with \"buffer\" or \"base64\"");
        return false;
    }
    if (!check_count(n, pointer, channels, count) || !charge(uint64_t(n) * sizeof(uint32_t), pointer)) return false;
    out.resize(n);
    const uint8_t* p = span.bytes ? span.bytes->data() + span.offset : nullptr;
    for (size_t i = 0; i < n; ++i) {
        const double x = p ? element(p + i * kElements[span.type].bytes, span.type) : written[i];
        if (!(x >= 0 && x < double(limit)) || x != std::trunc(x)) {
            add_error(d_, pointer + "/" + std::to_string(i / size_t(channels)), "out-of-range", json(x).dump(),
                      limit == 0 ? "nothing: there is nothing to point at" : "a whole number from 0 to " + std::to_string(limit - 1));
            return false;
        }
        out[i] = uint32_t(x);
    }
    return true;
}

}  // namespace alder
