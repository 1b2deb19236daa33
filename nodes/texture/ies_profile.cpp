// IES profiles: IESNA LM-63 text to a table of intensities. ANSI/IES LM-63-02 for the format; photometric types A, B and C and the
// shorthand for symmetric lights are brought to type C over a full turn, with Blender 4.5's tolerance for files that bend the rules.
#include "nodes/texture/ies_profile.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace alder {
namespace {

using Rows = std::vector<std::vector<float>>;

constexpr long kMostAngles = 65536;
constexpr size_t kMostIntensities = size_t{1} << 24, kMostBytes = size_t{64} << 20;

/// Candela to the watts of a renderer's lamp: 4 pi over D65's luminous efficacy of 177.83 lm/W.
constexpr double kWattsPerCandela = 0.0706650768394;

/// Numbers after the TILT line, in order; commas count as blanks.
class Numbers {
  public:
    explicit Numbers(std::string text) : text_(std::move(text)) {
        std::replace(text_.begin(), text_.end(), ',', ' ');
        at_ = std::strstr(text_.c_str(), "\nTILT=");
    }
    bool at_end() const { return !at_ || *at_ == '\0'; }
    bool failed() const { return failed_; }
    double real() {
        char* end = nullptr;
        const double v = at_end() ? 0 : std::strtod(at_, &end);
        return advance(end) ? v : 0;
    }
    long whole() {
        char* end = nullptr;
        const long v = at_end() ? 0 : std::strtol(at_, &end, 10);
        return advance(end) ? v : 0;
    }
    /// Past the TILT line, and the block of lamp tilt that may follow it.
    void skip_tilt() {
        constexpr char kInclude[] = "\nTILT=INCLUDE";
        if (std::strncmp(at_, kInclude, sizeof kInclude - 1) == 0) {
            at_ += sizeof kInclude - 1;
            real();
            const long pairs = whole();
            for (long i = 0; i < 2 * std::min(pairs, kMostAngles) && !failed_; ++i) real();
        } else {
            at_ = std::strstr(at_ + 1, "\n");
        }
        if (!at_end()) ++at_;
    }

  private:
    bool advance(char* end) {
        if (at_end() || end == at_) {
            failed_ = true;
            at_ = nullptr;
            return false;
        }
        at_ = end;
        return true;
    }
    std::string text_;
    const char* at_ = nullptr;
    bool failed_ = false;
};

bool close(float a, float b) { return std::fabs(a - b) < 1e-4f; }

/// Angles 0 ... 90 become -90 ... 90 by mirroring; both are shifted to 0 ... 180. `mirror(i)` prepends entry i.
std::vector<float> shifted_by_90(const std::vector<float>& angles, bool mirrored) {
    std::vector<float> r;
    if (mirrored)
        for (size_t i = angles.size() - 1; i > 0; --i) r.push_back(90.0f - angles[i]);
    for (float a : angles) r.push_back(90.0f + a);
    return r;
}
template <class T>
std::vector<T> mirrored_list(const std::vector<T>& list) {
    std::vector<T> r(list.rbegin(), list.rend() - 1);
    r.insert(r.end(), list.begin(), list.end());
    return r;
}

/// Type A: vertical angles about the horizon, horizontal ones -90 ... 90, which are 270 ... 90 of type C.
void convert_type_a(std::vector<float>& h, std::vector<float>& v, Rows& rows) {
    for (float& a : v) a += 90.0f;
    std::vector<float> angles;
    Rows turned;
    for (size_t i = h.size(); i-- > 0;) {
        angles.push_back(180.0f - h[i]);
        turned.push_back(rows[i]);
    }
    if (close(h[0], 0.0f)) {
        for (size_t i = 1; i < h.size(); ++i) {
            angles.push_back(180.0f + h[i]);
            turned.push_back(rows[i]);
        }
    }
    h.swap(angles);
    rows.swap(turned);
}

/// Type B: its polar axis lies level. The axes are exchanged and the light is otherwise taken as it stands.
void convert_type_b(std::vector<float>& h, std::vector<float>& v, Rows& rows) {
    Rows turned(v.size());
    for (size_t i = 0; i < v.size(); ++i)
        for (size_t j = 0; j < h.size(); ++j) turned[i].push_back(rows[j][i]);
    rows.swap(turned);
    h.swap(v);
    const bool mirror_h = close(h[0], 0.0f), mirror_v = close(v[0], 0.0f);
    h = shifted_by_90(h, mirror_h);
    if (mirror_h) rows = mirrored_list(rows);
    v = shifted_by_90(v, mirror_v);
    if (mirror_v)
        for (auto& row : rows) row = mirrored_list(row);
}

/// Appends the entries before the last again, mirrored about `end` degrees.
void mirror_about(float end, std::vector<float>& h, Rows& rows) {
    for (size_t i = h.size() - 1; i-- > 0;) {
        h.push_back(2 * end - h[i]);
        rows.push_back(rows[i]);
    }
}
void convert_type_c(std::vector<float>& h, Rows& rows) {
    if (close(h[0], 90.0f))
        for (float& a : h) a -= 90.0f;
    if (h.size() == 1) {  // symmetric about the axis
        h = {0.0f, 360.0f};
        rows.push_back(rows[0]);
    }
    if (close(h.back(), 90.0f)) mirror_about(90.0f, h, rows);
    if (close(h.back(), 180.0f)) mirror_about(180.0f, h, rows);
    // Some files leave out the last entry, which is the first again; the spacing shows it.
    if (close(h[0], 0.0f) && !close(h.back(), 360.0f)) {
        const float gap = 360.0f - h.back();
        if (close(h.back() - h[h.size() - 2], gap) || close(h[1] - h[0], gap)) {
            h.push_back(360.0f);
            rows.push_back(rows[0]);
        }
    }
}

std::vector<float> running_maximum(const std::vector<float>& angles) {
    std::vector<float> r = angles;
    for (size_t i = 2; i < r.size(); ++i) r[i] = std::max(r[i], r[i - 1]);
    return r;
}

}  // namespace

std::shared_ptr<const IesProfile> parse_ies(const std::string& text, std::string& fault) {
    Numbers n(text);
    if (n.at_end()) {
        fault = "no IES profile: it has no line that begins with TILT=";
        return nullptr;
    }
    n.skip_tilt();
    if (n.at_end()) {
        fault = "no IES profile: nothing follows the TILT= line";
        return nullptr;
    }
    n.whole();                // lamps
    n.real();                 // lumens per lamp
    double factor = n.real(); // candela multiplier
    const long v_count = n.whole(), h_count = n.whole(), type = n.whole();
    n.whole();                // unit of the three sizes
    for (int i = 0; i < 3; ++i) n.real();
    factor *= n.real();       // ballast factor
    factor *= n.real();       // ballast-lamp photometric factor
    n.real();                 // watts
    if (n.failed()) {
        fault = "no IES profile: the numbers after the TILT= line are not complete";
        return nullptr;
    }
    if (type < 1 || type > 3) {
        fault = "IES profile: photometric type " + std::to_string(type) + ", there are 1 (C), 2 (B) and 3 (A)";
        return nullptr;
    }
    if (v_count < 1 || h_count < 1 || v_count > kMostAngles || h_count > kMostAngles ||
        static_cast<size_t>(v_count) * static_cast<size_t>(h_count) > kMostIntensities) {
        fault = "IES profile: " + std::to_string(v_count) + " vertical and " + std::to_string(h_count) + " horizontal angles";
        return nullptr;
    }
    factor *= kWattsPerCandela;
    std::vector<float> v, h;
    Rows rows;
    for (long i = 0; i < v_count && !n.failed(); ++i) v.push_back(static_cast<float>(n.real()));
    for (long i = 0; i < h_count && !n.failed(); ++i) h.push_back(static_cast<float>(n.real()));
    for (long i = 0; i < h_count && !n.failed(); ++i) {
        rows.emplace_back();
        for (long k = 0; k < v_count && !n.failed(); ++k) rows.back().push_back(static_cast<float>(factor * n.real()));
    }
    if (n.failed()) {
        fault = "IES profile: it ends before all angles and intensities";
        return nullptr;
    }
    if (type == 3) convert_type_a(h, v, rows);
    else if (type == 2) convert_type_b(h, v, rows);
    else convert_type_c(h, rows);

    auto profile = std::make_shared<IesProfile>();
    constexpr float kRadians = 3.141592653589793f / 180.0f;
    for (float& a : h) a *= kRadians;
    for (float& a : v) a *= kRadians;
    for (const auto& row : rows) profile->intensity.insert(profile->intensity.end(), row.begin(), row.end());
    profile->horizontal_bound = running_maximum(h);
    profile->vertical_bound = running_maximum(v);
    profile->horizontal = std::move(h);
    profile->vertical = std::move(v);
    return profile;
}

std::shared_ptr<const IesProfile> load_ies(const std::string& json, std::string& fault) {
    const nlohmann::json j = nlohmann::json::parse(json, nullptr, false);
    if (!j.is_object()) return nullptr;
    if (j.contains("text") && j["text"].is_string()) return parse_ies(j["text"].get<std::string>(), fault);
    if (!j.contains("file") || !j["file"].is_string()) return nullptr;
    if (j.contains("missing")) {  // not found beside the document: the name is not a path
        fault = "there is no such file";
        return nullptr;
    }
    const std::string name = j["file"].get<std::string>();
    std::ifstream file(name, std::ios::binary);
    std::string text;
    char block[65536];
    while (file && text.size() <= kMostBytes) {
        file.read(block, sizeof block);
        text.append(block, static_cast<size_t>(file.gcount()));
    }
    if (text.empty() || text.size() > kMostBytes) {
        fault = "the IES profile cannot be read";
        return nullptr;
    }
    return parse_ies(text, fault);
}

}  // namespace alder
