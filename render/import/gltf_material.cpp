// glTF: materials as graphs with one Principled BSDF, mapped as Blender's importer maps them.
#include <array>
#include <cmath>
#include <optional>

#include "render/import/gltf_parts.h"

namespace alder {

using nlohmann::json;

namespace {

json link(const std::string& node, const char* output) { return {{"node", node}, {"output", output}}; }

class MaterialBuilder {
  public:
    MaterialBuilder(GltfFile& file, bool vertex_color, std::map<std::string, GltfImage>& images, std::map<int, std::string>& image_names)
        : file_(file), vertex_color_(vertex_color), images_(images), image_names_(image_names) {}

    json build(const json& material, const std::string& pointer) {
        JsonReader m = file_.reader(material, pointer);
        extensions_ = m.member("extensions");
        extensions_pointer_ = m.pointer_to("extensions");
        json& p = bsdf_;
        base_color(m, p);
        if (const json* unlit = extension("KHR_materials_unlit"); unlit) return finish_unlit(p);
        metallic_roughness(m, p);
        if (const json* t = m.member("normalTexture")) normal(*t, m.pointer_to("normalTexture"), p, "Normal");
        emission(m, p);
        ior_and_specular(p);
        transmission(p);
        coat(p);
        sheen(p);
        anisotropy(p);
        const std::string bsdf = add("Principled BSDF", "ShaderNodeBsdfPrincipled", p);
        return document(link(bsdf, "BSDF"));
    }

  private:
    struct Texture {
        std::string node;   ///< image texture node
    };

    const json* extension(const char* name) const {
        if (!extensions_ || !extensions_->is_object()) return nullptr;
        const auto i = extensions_->find(name);
        return i != extensions_->end() && i->is_object() ? &*i : nullptr;
    }
    JsonReader extension_reader(const json& j, const char* name) { return file_.reader(j, extensions_pointer_ + "/" + name); }

    std::string add(const std::string& name, const char* type, json params) {
        const std::string key = names_.take(name, type);
        nodes_[key] = {{"type", type}, {"params", std::move(params)}};
        return key;
    }
    json document(json surface) const { return {{"version", 1}, {"nodes", nodes_}, {"outputs", {{"surface", std::move(surface)}}}}; }

    /// Name of the image in the document, which is also its key in `images_`.
    std::string image(int index, const std::string& referrer) {
        if (const auto known = image_names_.find(index); known != image_names_.end()) return known->second;
        const json* j = file_.element("images", index, referrer);
        if (!j) return {};
        const std::string pointer = "/images/" + std::to_string(index);
        JsonReader r = file_.reader(*j, pointer);
        std::string uri, type, name;
        int view = -1;
        r.text("uri", uri);
        r.text("mimeType", type);
        r.text("name", name);
        r.integer("bufferView", view, 0, INT32_MAX);
        GltfImage out;
        if (type.empty() && uri.starts_with("data:image/")) type = uri.substr(5, uri.find_first_of(";,") - 5);
        const size_t dot = uri.rfind('.');
        out.extension = type == "image/jpeg" ? ".jpg" : type == "image/png" ? ".png" : type == "image/webp" ? ".webp"
                        : !uri.starts_with("data:") && dot != std::string::npos ? uri.substr(dot) : std::string();
        if (view >= 0) {
            std::span<const uint8_t> bytes;
            size_t stride = 0;
            if (!file_.view(view, r.pointer_to("bufferView"), bytes, stride)) return {};
            out.bytes.assign(bytes.begin(), bytes.end());
        } else if (uri.starts_with("data:")) {
            if (!file_.uri(uri, r.pointer_to("uri"), out.bytes)) return {};
        } else if (!uri.empty()) {
            out.file = uri;
        } else {
            add_error(file_.d, pointer, "missing-member", "neither uri nor bufferView", "one of them");
            return {};
        }
        for (char& c : name) {
            if (c == '/' || c == '\\') c = '_';
        }
        std::string key = out.file;
        if (key.empty()) key = "images/" + std::to_string(index) + (name.empty() ? "" : "-" + name) + out.extension;
        images_.emplace(key, std::move(out));
        return image_names_[index] = key;
    }

    /// UV coordinates of a texture: the active map, another one, or either transformed.
    json coordinates(const json& info, const std::string& pointer) {
        JsonReader r = file_.reader(info, pointer);
        int set = 0;
        r.integer("texCoord", set, 0, 7);
        const json* e = r.member("extensions");
        const json* transform = nullptr;
        if (e && e->is_object()) {
            if (const auto i = e->find("KHR_texture_transform"); i != e->end() && i->is_object()) transform = &*i;
        }
        std::array<float, 2> offset{0, 0}, scale{1, 1};
        float rotation = 0;
        if (transform) {
            JsonReader t = file_.reader(*transform, r.pointer_to("extensions") + "/KHR_texture_transform");
            t.numbers("offset", offset);
            t.numbers("scale", scale);
            t.number("rotation", rotation);
            t.integer("texCoord", set, 0, 7);
        }
        json uv = set == 0 ? link(shared("Texture Coordinate", "ShaderNodeTexCoord", json::object()), "UV")
                           : link(shared(gltf_uv_name(set), "ShaderNodeUVMap", {{"uv_map", gltf_uv_name(set)}}), "UV");
        if (!transform) return uv;
        // glTF turns and scales about the upper left corner with v downwards; ours starts at the lower left.
        const float s = std::sin(rotation), c = std::cos(rotation);
        return link(add("Mapping", "ShaderNodeMapping",
                        {{"vector_type", "POINT"}, {"Vector", uv}, {"Scale", {scale[0], scale[1], 1}}, {"Rotation", {0, 0, rotation}},
                         {"Location", {offset[0] + scale[1] * s, 1 - offset[1] - scale[1] * c, 0}}}), "Vector");
    }

    /// One node for all who need it.
    std::string shared(const std::string& name, const char* type, json params) {
        std::string& node = shared_[name];
        if (node.empty()) node = add(name, type, std::move(params));
        return node;
    }

    std::optional<Texture> texture(const json& info, const std::string& pointer, const char* label, const char* colorspace) {
        const size_t faults = file_.d.errors.size();
        JsonReader r = file_.reader(info, pointer);
        int index = -1, source = -1, sampler = -1;
        if (r.required("index", "the index of a texture")) r.integer("index", index, 0, INT32_MAX);
        if (file_.d.errors.size() > faults) return std::nullopt;
        const json* t = file_.element("textures", index, r.pointer_to("index"));
        if (!t) return std::nullopt;
        const std::string texture_pointer = "/textures/" + std::to_string(index);
        JsonReader tr = file_.reader(*t, texture_pointer);
        tr.integer("source", source, 0, INT32_MAX);
        tr.integer("sampler", sampler, 0, INT32_MAX);
        if (const json* e = tr.member("extensions"); e && e->is_object() && source < 0) {
            if (const auto w = e->find("EXT_texture_webp"); w != e->end()) {
                JsonReader wr = file_.reader(*w, tr.pointer_to("extensions") + "/EXT_texture_webp");
                wr.integer("source", source, 0, INT32_MAX);
            }
        }
        if (source < 0) {
            add_warning(file_.d, texture_pointer, "unsupported", "a texture without a PNG, JPEG or WebP source", "one: the texture is left out");
            return std::nullopt;
        }
        const std::string file = image(source, tr.pointer_to("source"));
        if (file.empty()) return std::nullopt;
        json params{{"image", {{"file", file}, {"colorspace", colorspace}}}, {"Vector", coordinates(info, pointer)}};
        if (sampler >= 0) {
            if (const json* s = file_.element("samplers", sampler, tr.pointer_to("sampler"))) {
                JsonReader sr = file_.reader(*s, "/samplers/" + std::to_string(sampler));
                int mag = 9729, wrap_s = 10497, wrap_t = 10497;
                sr.integer("magFilter", mag, 0, INT32_MAX);
                sr.integer("wrapS", wrap_s, 0, INT32_MAX);
                sr.integer("wrapT", wrap_t, 0, INT32_MAX);
                if (mag == 9728) params["interpolation"] = "Closest";
                params["extension"] = wrap_s == 33071 ? "EXTEND" : wrap_s == 33648 ? "MIRROR" : "REPEAT";
                if (wrap_s != wrap_t) add_warning(file_.d, sr.pointer(), "unsupported", "different wrapS and wrapT", "equal ones: wrapS is used for both");
            }
        }
        return Texture{add(label, "ShaderNodeTexImage", std::move(params))};
    }

    json times(const char* label, json a, const json& b) {   // colours
        return link(add(label, "ShaderNodeMix", {{"data_type", "RGBA"}, {"blend_type", "MULTIPLY"}, {"Factor_Float", 1}, {"A_Color", std::move(a)}, {"B_Color", b}}), "Result_Color");
    }
    json math(const char* label, const char* operation, json a, json b) {
        return link(add(label, "ShaderNodeMath", {{"operation", operation}, {"Value", std::move(a)}, {"Value_001", std::move(b)}}), "Value");
    }

    /// factor x texture, as a colour socket.
    void color(JsonReader& r, const char* factor_key, const char* texture_key, Vec3f factor, json& p, const char* socket) {
        r.vector(factor_key, factor);
        const json value{factor.x, factor.y, factor.z};
        const json* t = r.member(texture_key);
        const std::optional<Texture> tex = t ? texture(*t, r.pointer_to(texture_key), (std::string(socket) + " Texture").c_str(), "sRGB") : std::nullopt;
        if (!tex) p[socket] = value;
        else p[socket] = factor.x == 1 && factor.y == 1 && factor.z == 1 ? link(tex->node, "Color") : times(socket, link(tex->node, "Color"), value);
    }
    /// factor x one channel of a texture ("Red" ... or "Alpha"), as a float socket.
    void scalar(JsonReader& r, const char* factor_key, const char* texture_key, float factor, const char* channel, json& p, const char* socket, float scale = 1) {
        r.number(factor_key, factor);
        factor *= scale;
        const json* t = r.member(texture_key);
        const std::optional<Texture> tex = t ? texture(*t, r.pointer_to(texture_key), (std::string(socket) + " Texture").c_str(), "Non-Color") : std::nullopt;
        if (!tex) {
            p[socket] = factor;
            return;
        }
        const json value = channel_of(*tex, channel);
        p[socket] = factor == 1 ? value : math(socket, "MULTIPLY", value, factor);
    }
    json channel_of(const Texture& t, const std::string& channel) {
        if (channel == "Alpha") return link(t.node, "Alpha");
        return link(shared("Separate " + t.node, "ShaderNodeSeparateColor", {{"Color", link(t.node, "Color")}}), channel.c_str());
    }

    void base_color(JsonReader& m, json& p) {
        const json empty = json::object();
        const json* pbr = m.member("pbrMetallicRoughness");
        JsonReader r = file_.reader(pbr ? *pbr : empty, m.pointer_to("pbrMetallicRoughness"));
        std::array<float, 4> factor{1, 1, 1, 1};
        r.numbers("baseColorFactor", factor);
        std::string mode = "OPAQUE";
        m.text("alphaMode", mode);
        float cutoff = 0.5f;
        m.number("alphaCutoff", cutoff);

        json rgb{factor[0], factor[1], factor[2]}, alpha = factor[3];
        if (const json* t = r.member("baseColorTexture")) {
            if (const auto tex = texture(*t, r.pointer_to("baseColorTexture"), "Base Color Texture", "sRGB")) {
                const bool white = factor[0] == 1 && factor[1] == 1 && factor[2] == 1;
                rgb = white ? link(tex->node, "Color") : times("Base Color Factor", link(tex->node, "Color"), rgb);
                alpha = factor[3] == 1 ? link(tex->node, "Alpha") : math("Alpha Factor", "MULTIPLY", link(tex->node, "Alpha"), factor[3]);
            }
        }
        if (vertex_color_) {
            const std::string node = add("Vertex Color", "ShaderNodeVertexColor", {{"layer_name", kGltfColorAttribute}});
            rgb = times("Vertex Color Tint", link(node, "Color"), rgb);
            alpha = math("Vertex Alpha", "MULTIPLY", link(node, "Alpha"), alpha);
        }
        p["Base Color"] = rgb;
        if (mode == "OPAQUE") return;
        if (mode == "MASK") {   // 1 - (alpha < cutoff)
            if (alpha.is_number()) alpha = alpha.get<float>() < cutoff ? 0 : 1;
            else alpha = math("Alpha Mask", "SUBTRACT", 1, math("Alpha Cutoff", "LESS_THAN", alpha, cutoff));
        } else if (mode != "BLEND") {
            add_error(file_.d, m.pointer_to("alphaMode"), "unknown-value", mode, "OPAQUE, MASK or BLEND");
        }
        p["Alpha"] = alpha;
    }

    void metallic_roughness(JsonReader& m, json& p) {
        const json empty = json::object();
        const json* pbr = m.member("pbrMetallicRoughness");
        JsonReader r = file_.reader(pbr ? *pbr : empty, m.pointer_to("pbrMetallicRoughness"));
        float metallic = 1, roughness = 1;
        r.number("metallicFactor", metallic, 0, 1);
        r.number("roughnessFactor", roughness, 0, 1);
        p["Metallic"] = metallic;
        p["Roughness"] = roughness;
        const json* t = r.member("metallicRoughnessTexture");
        const auto tex = t ? texture(*t, r.pointer_to("metallicRoughnessTexture"), "Metallic Roughness Texture", "Non-Color") : std::nullopt;
        if (!tex) return;
        const json blue = channel_of(*tex, "Blue"), green = channel_of(*tex, "Green");
        p["Metallic"] = metallic == 1 ? blue : math("Metallic Factor", "MULTIPLY", blue, metallic);
        p["Roughness"] = roughness == 1 ? green : math("Roughness Factor", "MULTIPLY", green, roughness);
    }

    void normal(const json& info, const std::string& pointer, json& p, const char* socket) {
        JsonReader r = file_.reader(info, pointer);
        float scale = 1;
        int set = 0;
        r.number("scale", scale);
        r.integer("texCoord", set, 0, 7);
        const auto tex = texture(info, pointer, (std::string(socket) + " Texture").c_str(), "Non-Color");
        if (!tex) return;
        json params{{"Strength", scale}, {"Color", link(tex->node, "Color")}};
        if (set != 0) params["uv_map"] = gltf_uv_name(set);
        p[socket] = link(add(std::string(socket) + " Map", "ShaderNodeNormalMap", params), "Normal");
    }

    void emission(JsonReader& m, json& p) {
        float strength = 1;
        if (const json* e = extension("KHR_materials_emissive_strength")) {
            JsonReader r = extension_reader(*e, "KHR_materials_emissive_strength");
            r.number("emissiveStrength", strength, 0);
        }
        Vec3f factor(0);
        m.vector("emissiveFactor", factor);
        if (!(factor.x > 0 || factor.y > 0 || factor.z > 0)) return;
        color(m, "emissiveFactor", "emissiveTexture", Vec3f(0), p, "Emission Color");
        p["Emission Strength"] = strength;
    }

    void ior_and_specular(json& p) {
        if (const json* e = extension("KHR_materials_ior")) {
            float ior = 1.5f;
            extension_reader(*e, "KHR_materials_ior").number("ior", ior, 0, 1000);
            p["IOR"] = ior;
        }
        if (const json* e = extension("KHR_materials_specular")) {
            JsonReader r = extension_reader(*e, "KHR_materials_specular");
            scalar(r, "specularFactor", "specularTexture", 1, "Alpha", p, "Specular IOR Level", 0.5f);
            color(r, "specularColorFactor", "specularColorTexture", Vec3f(1), p, "Specular Tint");
        }
    }

    void transmission(json& p) {
        if (const json* e = extension("KHR_materials_transmission")) {
            JsonReader r = extension_reader(*e, "KHR_materials_transmission");
            scalar(r, "transmissionFactor", "transmissionTexture", 0, "Red", p, "Transmission Weight");
        }
        if (const json* e = extension("KHR_materials_volume"); e && e->contains("attenuationColor")) {
            add_warning(file_.d, extensions_pointer_ + "/KHR_materials_volume", "unsupported", "absorption inside", "clear glass: the attenuation is left out");
        }
    }

    void coat(json& p) {
        const json* e = extension("KHR_materials_clearcoat");
        if (!e) return;
        JsonReader r = extension_reader(*e, "KHR_materials_clearcoat");
        scalar(r, "clearcoatFactor", "clearcoatTexture", 0, "Red", p, "Coat Weight");
        scalar(r, "clearcoatRoughnessFactor", "clearcoatRoughnessTexture", 0, "Green", p, "Coat Roughness");
        if (const json* t = r.member("clearcoatNormalTexture")) normal(*t, r.pointer_to("clearcoatNormalTexture"), p, "Coat Normal");
    }

    void sheen(json& p) {
        const json* e = extension("KHR_materials_sheen");
        if (!e) return;
        JsonReader r = extension_reader(*e, "KHR_materials_sheen");
        p["Sheen Weight"] = 1;
        color(r, "sheenColorFactor", "sheenColorTexture", Vec3f(0), p, "Sheen Tint");
        scalar(r, "sheenRoughnessFactor", "sheenRoughnessTexture", 0, "Alpha", p, "Sheen Roughness");
    }

    void anisotropy(json& p) {
        const json* e = extension("KHR_materials_anisotropy");
        if (!e) return;
        JsonReader r = extension_reader(*e, "KHR_materials_anisotropy");
        float strength = 0, rotation = 0;
        r.number("anisotropyStrength", strength, 0, 1);
        r.number("anisotropyRotation", rotation);
        p["Anisotropic"] = strength;
        // Radians there, turns here.
        float turns = rotation / 6.28318531f;
        p["Anisotropic Rotation"] = turns - std::floor(turns);
        if (r.member("anisotropyTexture")) {
            add_warning(file_.d, r.pointer_to("anisotropyTexture"), "unsupported", "a texture", "a constant anisotropy: the texture is left out");
        }
    }

    /// Shown as it is: emission for camera rays, nothing for others, as Blender's importer does.
    json finish_unlit(json& p) {
        const std::string light = add("Emission", "ShaderNodeEmission", {{"Color", p["Base Color"]}, {"Strength", 1}});
        const std::string clear = add("Transparent", "ShaderNodeBsdfTransparent", json::object());
        json surface = link(light, "Emission");
        if (p.contains("Alpha")) {
            surface = link(add("Alpha Mix", "ShaderNodeMixShader", {{"Fac", p["Alpha"]}, {"Shader", link(clear, "BSDF")}, {"Shader_001", surface}}), "Shader");
        }
        const std::string path = add("Light Path", "ShaderNodeLightPath", json::object());
        surface = link(add("Camera Only", "ShaderNodeMixShader", {{"Fac", link(path, "Is Camera Ray")}, {"Shader", link(clear, "BSDF")}, {"Shader_001", surface}}), "Shader");
        return document(surface);
    }

    GltfFile& file_;
    bool vertex_color_;
    std::map<std::string, GltfImage>& images_;
    std::map<int, std::string>& image_names_;
    json nodes_ = json::object(), bsdf_ = json::object();
    GltfNames names_;
    std::map<std::string, std::string> shared_;
    const json* extensions_ = nullptr;
    std::string extensions_pointer_;
};

}  // namespace

json gltf_material(GltfFile& file, int index, bool vertex_color, std::map<std::string, GltfImage>& images, std::map<int, std::string>& image_names) {
    const std::string pointer = "/materials/" + std::to_string(index);
    const json* j = file.element("materials", index, pointer);
    return j ? MaterialBuilder(file, vertex_color, images, image_names).build(*j, pointer) : json();
}

}  // namespace alder
