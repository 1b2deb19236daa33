// The placement built into texture nodes: Blender's TexMapping structure to the matrix that Cycles applies.
#include "nodes/texture/texture_mapping.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

namespace alder {
namespace {

using Matrix = std::array<std::array<double, 4>, 4>;

Matrix identity() {
    Matrix m{};
    for (int i = 0; i < 4; ++i) m[i][i] = 1;
    return m;
}
Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix m{};
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            for (int k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
        }
    }
    return m;
}
Matrix scaling(const std::array<double, 3>& s) {
    Matrix m = identity();
    for (int i = 0; i < 3; ++i) m[i][i] = s[i];
    return m;
}
Matrix translation(const std::array<double, 3>& t) {
    Matrix m = identity();
    for (int i = 0; i < 3; ++i) m[i][3] = t[i];
    return m;
}
/// About x, then y, then z.
Matrix rotation_xyz(const std::array<double, 3>& e) {
    const double cx = std::cos(e[0]), cy = std::cos(e[1]), cz = std::cos(e[2]);
    const double sx = std::sin(e[0]), sy = std::sin(e[1]), sz = std::sin(e[2]);
    return {{{cy * cz, sy * sx * cz - cx * sz, sy * cx * cz + sx * sz, 0},
             {cy * sz, sy * sx * sz + cx * cz, sy * cx * sz - sx * cz, 0},
             {-sy, cy * sx, cy * cx, 0},
             {0, 0, 0, 1}}};
}
Matrix transposed(const Matrix& m) {
    Matrix t;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) t[i][j] = m[j][i];
    }
    return t;
}

/// Reads `key` as three numbers into `out`.
void read_vector(const nlohmann::json& j, const char* key, std::array<double, 3>& out, std::vector<std::string>& errors) {
    const auto it = j.find(key);
    if (it == j.end()) return;
    bool good = it->is_array() && it->size() == 3;
    for (int i = 0; good && i < 3; ++i) good = (*it)[i].is_number();
    if (!good) {
        errors.push_back(std::string("texture_mapping.") + key + ": three numbers expected");
        return;
    }
    for (int i = 0; i < 3; ++i) out[i] = static_cast<float>((*it)[i].get<double>());
}
int read_choice(const nlohmann::json& j, const char* key, std::initializer_list<std::string_view> names, int absent,
                std::vector<std::string>& errors) {
    const auto it = j.find(key);
    if (it == j.end()) return absent;
    int index = 0;
    std::string all;
    for (const std::string_view name : names) {
        if (it->is_string() && it->get_ref<const std::string&>() == name) return index;
        all += (index++ ? ", " : "") + std::string(name);
    }
    errors.push_back(std::string("texture_mapping.") + key + ": one of " + all + " expected");
    return absent;
}

}  // namespace

TextureMapping parse_texture_mapping(const std::string& json, std::vector<std::string>& errors) {
    TextureMapping result;
    const nlohmann::json j = nlohmann::json::parse(json, nullptr, false);
    if (j.is_null()) return result;
    if (!j.is_object()) {
        errors.push_back("texture_mapping: an object with translation, rotation, scale, vector_type, mapping_x, mapping_y, "
                         "mapping_z expected");
        return result;
    }
    std::array<double, 3> move{}, turn{}, scale{1, 1, 1};
    read_vector(j, "translation", move, errors);
    read_vector(j, "rotation", turn, errors);
    read_vector(j, "scale", scale, errors);
    enum { kPoint, kTexture, kVector, kNormal };
    const int kind = read_choice(j, "vector_type", {"POINT", "TEXTURE", "VECTOR", "NORMAL"}, kPoint, errors);
    int axis[3];  // 0 NONE, 1 to 3: x, y, z
    const char* const axis_keys[3] = {"mapping_x", "mapping_y", "mapping_z"};
    for (int i = 0; i < 3; ++i) axis[i] = read_choice(j, axis_keys[i], {"NONE", "X", "Y", "Z"}, i + 1, errors);

    // The vector type alone changes nothing, as in Cycles: NORMAL with no transformation does not normalise either.
    const bool swapped = axis[0] != 1 || axis[1] != 2 || axis[2] != 3;
    result.active = swapped || move != std::array<double, 3>{} || turn != std::array<double, 3>{} ||
                    scale != std::array<double, 3>{1, 1, 1};
    if (!result.active) return result;
    result.normalize = kind == kNormal;

    if (kind == kTexture || kind == kNormal) {
        for (double& s : scale) {
            if (std::fabs(s) < 1e-5) s = s < 0 ? -1e-5 : 1e-5;  // keeps the matrix invertible
        }
    }
    // The inverses are written out rather than computed: rotation's is its transpose, scale's its reciprocal.
    const Matrix rotation = rotation_xyz(turn);
    const std::array<double, 3> inverse_scale = {1 / scale[0], 1 / scale[1], 1 / scale[2]};
    Matrix m;
    switch (kind) {
        case kTexture: m = scaling(inverse_scale) * transposed(rotation) * translation({-move[0], -move[1], -move[2]}); break;
        case kVector: m = rotation * scaling(scale); break;
        case kNormal: m = rotation * scaling(inverse_scale); break;  // inverse transpose of rotation times scale
        default: m = translation(move) * rotation * scaling(scale); break;
    }
    Matrix axes{};
    axes[3][3] = 1;
    for (int i = 0; i < 3; ++i) {
        if (axis[i] > 0) axes[i][axis[i] - 1] = 1;
    }
    m = m * axes;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 4; ++k) result.matrix[i][k] = static_cast<float>(m[i][k]);
    }
    return result;
}

Param texture_mapping_param() {
    return param::json("texture_mapping")
        .alias("tex_mapping")
        .in("Mapping")
        .doc("placement applied to Vector: {\"translation\", \"rotation\", \"scale\": three numbers (radians), \"vector_type\": POINT, "
             "TEXTURE, VECTOR or NORMAL, \"mapping_x\", \"mapping_y\", \"mapping_z\": NONE, X, Y or Z}; null is none");
}

Param color_mapping_param() { return param::json("color_mapping").doc("Blender's colour mapping: has no effect, as in Cycles"); }

std::shared_ptr<const Prepared> prepare_texture_mapping(const Statics& statics, std::vector<std::string>& errors) {
    const int index = statics.type->param_index("texture_mapping");
    auto prepared = std::make_shared<PreparedTexture>();
    prepared->mapping = parse_texture_mapping(statics.text[index], errors);
    if (!prepared->mapping.active) return nullptr;
    return prepared;
}

}  // namespace alder
