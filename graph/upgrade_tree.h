// The node tree of a document while it is upgraded: parameters, links and new nodes. Private to upgrade*.cpp.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace alder::upgrade {

using nlohmann::json;

/// True for a link or an attribute: anything whose value is not known now.
inline bool is_link(const json& v) { return v.is_object() && (v.contains("node") || v.contains("attribute")); }

class Tree {
  public:
    explicit Tree(json& nodes) : nodes_(nodes) {}
    json& nodes() { return nodes_; }
    /// The node's parameters, made where it has none.
    json& params(const std::string& name) {
        json& p = nodes_[name]["params"];
        if (!p.is_object()) p = json::object();
        return p;
    }
    bool has(const std::string& name, const char* param) { return params(name).contains(param); }
    /// Moves a parameter to another name; what is there already wins.
    void rename(const std::string& name, const char* from, const char* to) {
        json& p = params(name);
        if (!p.contains(from)) return;
        json value = std::move(p[from]);
        p.erase(from);
        if (!p.contains(to)) p[to] = std::move(value);
    }
    /// A number that is written out, else `absent`.
    double number(const std::string& name, const char* param, double absent) {
        const json& p = params(name);
        const auto it = p.find(param);
        return it != p.end() && it->is_number() ? it->get<double>() : absent;
    }
    /// A new node beside `beside`; gives its name.
    std::string add(const std::string& beside, const char* what, const char* type, json params) {
        std::string name = beside + " (" + what + ")";
        while (nodes_.contains(name)) name += "'";
        nodes_[name] = {{"type", type}, {"params", std::move(params)}};
        return name;
    }
    /// Math node with operation; values may be links.
    std::string math(const std::string& beside, const char* what, const char* operation, json a, json b) {
        return add(beside, what, "ShaderNodeMath", {{"operation", operation}, {"Value", std::move(a)}, {"Value_001", std::move(b)}});
    }
    static json link(const std::string& node, const char* output) { return {{"node", node}, {"output", output}}; }

  private:
    json& nodes_;
};

}  // namespace alder::upgrade
