// JSON Patch (RFC 6902), one operation at a time.
#include "server/json_patch.h"

#include <string>

namespace alder {
namespace {

using nlohmann::json;

/// The library asserts that what something is added to can hold it; a client may ask for anything.
bool can_hold(const json& document, const json& operation) {
    const json::json_pointer path(operation.at("path").get<std::string>());
    if (path.empty()) return true;
    const json& parent = document.at(path.parent_pointer());
    return parent.is_structured() || parent.is_null();
}

bool apply(json& document, const json& operation) {
    const std::string name = operation.at("op").get<std::string>();
    if (name == "move") {   // in two steps: what is left after the first decides whether the second is possible
        const std::string from = operation.at("from").get<std::string>(), path = operation.at("path").get<std::string>();
        if (path.rfind(from + "/", 0) == 0) return false;   // into itself
        const json value = document.at(json::json_pointer(from));
        json rest = from.empty() ? document : document.patch(json::array({{{"op", "remove"}, {"path", from}}}));
        if (!apply(rest, {{"op", "add"}, {"path", path}, {"value", value}})) return false;
        document = std::move(rest);
        return true;
    }
    if ((name == "add" || name == "copy") && !can_hold(document, operation)) return false;
    document = document.patch(json::array({operation}));
    return true;
}

}  // namespace

bool apply_operation(json& document, const json& operation) {
    try {
        return operation.is_object() && apply(document, operation);
    } catch (const json::exception&) {
        return false;
    }
}

}  // namespace alder
