// The lookdev page at /ui: files that were compiled in (server/ui, docs/examples), nothing else.
#include <algorithm>

#include <fmt/format.h>

#include "render/stages.h"
#include "server/digest.h"
#include "server/routes.h"
#include "server/service.h"
#include "server/ui_files.h"

namespace alder {
namespace {

std::string type_of(std::string_view name) {
    const std::string_view end = name.substr(std::min(name.rfind('.'), name.size()));
    if (end == ".html") return "text/html; charset=utf-8";
    if (end == ".css") return "text/css; charset=utf-8";
    if (end == ".js") return "text/javascript; charset=utf-8";
    if (end == ".svg") return "image/svg+xml";
    return "application/json";
}

/// The page asks this daemon only, and runs no script but its own.
constexpr const char* kPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
                                "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

http::Response file_answer(http::Request& request, const UiFile& file) {
    const std::string etag = "\"" + sha256_hex(file.content).substr(0, 40) + "\"";
    http::Response r;
    if (const std::string* known = request.header("if-none-match"); known && *known == etag) {
        r.status = 304;
    } else {
        r = http::Response::text(200, std::string(file.content), type_of(file.name));
        // Styles that scripts set on elements (sizes of the canvas) count as the scripts' own under style-src 'self'.
        r.set("Content-Security-Policy", kPolicy);
        r.set("Referrer-Policy", "no-referrer");
    }
    r.set("ETag", etag);
    r.set("Cache-Control", "no-cache");
    return r;
}

const UiFile& find_file(const std::string& name) {
    for (const UiFile& f : ui_files())
        if (f.name == name) return f;
    throw Problem{"not-found", "the page has no such file"};
}

/// "weathered_paint.graph.json" -> "weathered paint".
std::string title_of(std::string_view file) {
    std::string title(file.substr(0, file.find('.')));
    std::replace(title.begin(), title.end(), '_', ' ');
    return title;
}

}  // namespace

http::Response get_ui(Service&, http::Request& request) { return file_answer(request, find_file("index.html")); }
http::Response get_ui_file(Service&, http::Request& request) { return file_answer(request, find_file(request.parameters["file"])); }
http::Response get_ui_example(Service&, http::Request& request) { return file_answer(request, find_file("examples/" + request.parameters["file"])); }

http::Response get_ui_examples(Service&, http::Request&) {
    nlohmann::json examples = nlohmann::json::array(), stages = nlohmann::json::array();
    for (const UiFile& f : ui_files())
        if (f.name.substr(0, 9) == "examples/") examples.push_back({{"file", f.name.substr(9)}, {"title", title_of(f.name.substr(9))}});
    for (const auto& stage : stage_names()) stages.push_back(stage);
    auto r = json_response(200, {{"examples", examples}, {"stages", stages}});
    r.set("Cache-Control", "no-cache");
    return r;
}

}  // namespace alder
