// alder nodes: the catalogue of node types.
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"
#include "nodes/registry_json.h"

namespace alder::cli {
namespace {

std::string default_text(const nlohmann::json& param) {
    if (param.contains("default_global")) return "(" + param["default_global"].get<std::string>() + ")";
    const auto& value = param["default"];
    return value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
}

void describe(const NodeType& type) {
    const nlohmann::json j = node_json(type);
    fmt::print("{}  ({}, {})\n  {}\n", type.name, j["system"].get<std::string>(), type.category, type.summary);
    if (!type.help.empty()) fmt::print("  {}\n", type.help);
    fmt::print("parameters:\n");
    for (const auto& p : j["params"]) {
        fmt::print("  {:32} {:8} {}", p["name"].get<std::string>(), p["type"].get<std::string>(), default_text(p));
        if (p.contains("enum")) {
            std::vector<std::string> names;
            for (const auto& item : p["enum"]) names.push_back(item["name"]);
            fmt::print("  {{{}}}", fmt::join(names, ", "));
        }
        if (p.contains("help")) fmt::print("  {}", p["help"].get<std::string>());
        fmt::print("\n");
    }
    fmt::print("outputs:\n");
    for (const auto& out : j["outputs"]) fmt::print("  {:32} {}\n", out["name"].get<std::string>(), out["type"].get<std::string>());
}

int run(const std::string& name, bool json) {
    if (name.empty()) {
        if (json)
            fmt::print("{}\n", nodes_json().dump(1));
        else
            for (const NodeType* type : all_nodes()) fmt::print("{:34} {:10} {}\n", type->name, type->category, type->summary);
        return kDone;
    }
    const NodeType* type = find_node(name);
    if (!type) {
        std::vector<std::string> names;
        for (const NodeType* n : all_nodes()) names.push_back(n->name);
        const std::string near = nearest_name(name, names);
        fail(kWrong, fmt::format("there is no node type '{}'{}", name, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
    }
    if (json)
        fmt::print("{}\n", node_json(*type).dump(1));
    else
        describe(*type);
    return kDone;
}

}  // namespace

Run add_nodes(CLI::App& app) {
    struct Options {
        std::string name;
        bool json = false;
    };
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("nodes", "the catalogue of node types");
    c->add_option("TYPE", o->name, "one type in full");
    c->add_flag("--json", o->json, "as /v1/nodes answers");
    return [o] { return run(o->name, o->json); };
}

}  // namespace alder::cli
