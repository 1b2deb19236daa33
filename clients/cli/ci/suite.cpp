// A suite of pictures to check, from JSON.
#include "clients/cli/ci/suite.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "nodes/schema.h"

namespace alder::cli {
namespace {

using nlohmann::json;

std::string brief(const json& value) {
    std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}

class Reader {
  public:
    Reader(const std::string& path, Diagnostics& d) : folder_(std::filesystem::path(path).parent_path()), d_(d) {}

    Suite suite(const json& document, const std::string& path) {
        Suite out;
        out.name = std::filesystem::path(path).stem().string();
        if (!document.is_object()) {
            fault("", "wrong-type", brief(document), "an object with cases");
            return out;
        }
        known(document, "", {"name", "defaults", "cases"});
        text(document, "name", "", out.name);
        if (const auto it = document.find("defaults"); it != document.end()) {
            if (it->is_object()) {
                known(*it, "/defaults", {"settings", "layers"});
                defaults_ = *it;
            } else {
                fault("/defaults", "wrong-type", brief(*it), "an object with settings and layers");
            }
        }
        const auto cases = document.find("cases");
        if (cases == document.end() || !cases->is_array() || cases->empty()) {
            fault("/cases", "wrong-type", cases == document.end() ? "nothing" : brief(*cases), "a list of cases");
            return out;
        }
        for (size_t i = 0; i < cases->size(); ++i) out.cases.push_back(one((*cases)[i], fmt::format("/cases/{}", i)));
        return out;
    }

  private:
    void fault(const std::string& pointer, const char* code, const std::string& found, const std::string& expected, const std::string& suggest = {}) {
        d_.errors.push_back({pointer, code, found, expected, suggest, {}});
    }
    void known(const json& object, const std::string& pointer, const std::vector<std::string>& names) {
        for (const auto& [name, value] : object.items())
            if (std::find(names.begin(), names.end(), name) == names.end())
                fault(pointer + "/" + pointer_token(name), "unknown-member", name, fmt::format("one of {}", fmt::join(names, ", ")), nearest_name(name, names));
    }
    bool text(const json& object, const char* name, const std::string& pointer, std::string& out) {
        const auto it = object.find(name);
        if (it == object.end()) return false;
        if (it->is_string() && !it->get<std::string>().empty()) {
            out = it->get<std::string>();
            return true;
        }
        fault(pointer + "/" + name, "wrong-type", brief(*it), "a text");
        return false;
    }
    std::string beside(const std::string& name) const { return (folder_ / name).string(); }

    SuiteCase one(const json& c, const std::string& pointer) {
        SuiteCase out;
        if (!c.is_object()) {
            fault(pointer, "wrong-type", brief(c), "an object with name, scene, reference and layers");
            return out;
        }
        known(c, pointer, {"name", "scene", "graph", "stage", "settings", "overrides", "reference", "layers"});
        if (!text(c, "name", pointer, out.name) && !c.contains("name")) fault(pointer + "/name", "missing", "nothing", "the name of the case");
        if (!out.name.empty() && (!names_.insert(out.name).second)) fault(pointer + "/name", "duplicate", out.name, "a name that no other case has");
        std::string file;
        out.is_graph = c.contains("graph");
        if (out.is_graph == c.contains("scene")) fault(pointer + "/scene", "missing", out.is_graph ? "scene and graph" : "nothing", "either scene or graph: a file beside the suite");
        if (text(c, out.is_graph ? "graph" : "scene", pointer, file)) out.scene = beside(file);
        file = out.name + ".ref.exr";
        text(c, "reference", pointer, file);
        out.reference = beside(file);
        std::string stage;
        if (text(c, "stage", pointer, stage)) {
            if (out.is_graph)
                out.arguments.insert(out.arguments.end(), {"--stage", stage});
            else
                fault(pointer + "/stage", "unknown-member", "stage", "a stage only together with graph");
        }
        json settings = defaults_.value("settings", json::object());
        if (const auto it = c.find("settings"); it != c.end()) {
            if (it->is_object())
                settings.update(*it);
            else
                fault(pointer + "/settings", "wrong-type", brief(*it), "an object");
        }
        set_settings(settings, pointer + "/settings", out);
        if (const auto it = c.find("overrides"); it != c.end()) set_overrides(*it, pointer + "/overrides", out);
        set_layers(c.contains("layers") ? c["layers"] : defaults_.value("layers", json()), pointer + "/layers", out);
        return out;
    }

    void set_settings(const json& settings, const std::string& pointer, SuiteCase& out) {
        static const std::vector<std::string> kScene{"samples", "seconds", "target_error", "seed", "threads", "resolution", "crop", "aovs", "lenient", "strict", "texture_filter", "noise_filter"};
        static const std::vector<std::string> kGraph{"samples", "seconds", "seed", "threads", "size", "aovs", "lenient", "strict"};
        known(settings, pointer, out.is_graph ? kGraph : kScene);
        for (const auto& [name, value] : settings.items()) {
            const std::string here = pointer + "/" + pointer_token(name);
            std::string option = "--" + name;
            std::replace(option.begin(), option.end(), '_', '-');
            if (name == "aovs") {
                if (!value.is_array()) fault(here, "wrong-type", brief(value), "a list of layers and groups");
                for (const json& aov : value)
                    if (aov.is_string()) out.arguments.insert(out.arguments.end(), {"--aov", aov.get<std::string>()});
            } else if (name == "resolution" || name == "crop") {
                const size_t n = name == "crop" ? 4 : 2;
                if (!value.is_array() || value.size() != n || !std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number_integer(); })) {
                    fault(here, "wrong-type", brief(value), fmt::format("a list of {} whole numbers", n));
                    continue;
                }
                std::string joined;
                for (const json& v : value) joined += (joined.empty() ? "" : n == 4 ? "," : "x") + v.dump();
                out.arguments.insert(out.arguments.end(), {option, joined});
            } else if (name == "lenient" || name == "strict") {
                if (!value.is_boolean()) fault(here, "wrong-type", brief(value), "true or false");
                if (value == json(true)) out.arguments.push_back(option);
            } else if (name == "texture_filter" || name == "noise_filter") {
                if (value != "on" && value != "off") fault(here, "wrong-type", brief(value), "\"on\" or \"off\"");
                out.arguments.insert(out.arguments.end(), {option, value.is_string() ? value.get<std::string>() : ""});
            } else if (value.is_number()) {
                out.arguments.insert(out.arguments.end(), {option, value.dump()});
            } else {
                fault(here, "wrong-type", brief(value), "a number");
            }
        }
    }

    /// {"MATERIAL/NODE.PARAM": value}, or a JSON Patch as POST /v1/renders takes it.
    void set_overrides(const json& overrides, const std::string& pointer, SuiteCase& out) {
        const auto add = [&](const std::string& target, const json& value) { out.arguments.insert(out.arguments.end(), {"--set", target + "=" + value.dump()}); };
        if (overrides.is_object()) {
            for (const auto& [target, value] : overrides.items()) add(target, value);
            return;
        }
        if (!overrides.is_array()) {
            fault(pointer, "wrong-type", brief(overrides), "an object of MATERIAL/NODE.PARAM and values, or a JSON Patch");
            return;
        }
        for (size_t i = 0; i < overrides.size(); ++i) {
            const std::string here = fmt::format("{}/{}", pointer, i);
            const json& o = overrides[i];
            if (!o.is_object() || (o.value("op", json()) != "replace" && o.value("op", json()) != "add") || !o.value("path", json()).is_string() || !o.contains("value")) {
                fault(here, "wrong-type", brief(o), R"({"op": "replace", "path": "/materials/M/nodes/N/params/P", "value": ...})");
                continue;
            }
            std::vector<std::string> parts;
            try {
                for (json::json_pointer at(o["path"].get<std::string>()); !at.empty(); at.pop_back()) parts.insert(parts.begin(), at.back());
            } catch (const json::exception&) {
                parts.clear();
            }
            const bool of_scene = parts.size() == 6 && parts[0] == "materials" && parts[2] == "nodes" && parts[4] == "params";
            const bool of_graph = parts.size() == 4 && parts[0] == "nodes" && parts[2] == "params";
            if (out.is_graph ? of_graph : of_scene)
                add(out.is_graph ? parts[1] + "." + parts[3] : parts[1] + "/" + parts[3] + "." + parts[5], o["value"]);
            else
                fault(here + "/path", "unsupported", brief(o["path"]), out.is_graph ? "/nodes/N/params/P" : "/materials/M/nodes/N/params/P");
        }
    }

    void set_layers(const json& layers, const std::string& pointer, SuiteCase& out) {
        if (!layers.is_object() || layers.empty()) {
            fault(pointer, "wrong-type", layers.is_null() ? "nothing" : brief(layers), R"(an object such as {"beauty": {"relmse_trimmed": 1e-4}})");
            return;
        }
        std::vector<std::string> aovs;
        for (const auto& [layer, limits] : layers.items()) {
            const std::string here = pointer + "/" + pointer_token(layer);
            if (!limits.is_object() || limits.empty()) {
                fault(here, "wrong-type", brief(limits), "an object of figures and their limits");
                continue;
            }
            auto& entry = out.layers.emplace_back(layer, std::vector<Limit>{});
            for (const auto& [figure, value] : limits.items()) {
                std::string error;
                const auto limit = limit_from_json(figure, value, error);
                if (!limit) {
                    fault(here + "/" + pointer_token(figure), "wrong-limit", brief(value), error);
                    continue;
                }
                entry.second.push_back(*limit);
                if (figure == "sigma") aovs.push_back("variance");
            }
            const std::string base = layer.substr(0, layer.find('.'));
            if (base != "beauty") aovs.push_back(base);
        }
        for (const std::string& aov : aovs) out.arguments.insert(out.arguments.end(), {"--aov", aov});
    }

    std::filesystem::path folder_;
    Diagnostics& d_;
    json defaults_ = json::object();
    std::set<std::string> names_;
};

}  // namespace

Suite read_suite(const json& document, const std::string& path, Diagnostics& d) { return Reader(path, d).suite(document, path); }

bool matches(const std::string& pattern, const std::string& name) { return fnmatch(pattern.c_str(), name.c_str(), 0) == 0; }

}  // namespace alder::cli
