// POST /v1/renders: which kind of render is asked for.
#include "server/routes.h"
#include "server/service.h"

namespace alder {

http::Response post_renders(Service& s, http::Request& request) {
    const nlohmann::json body = s.read_json(request);
    if (body.is_object() && body.value("mode", nlohmann::json()) == "live") return post_live_render(s, request, body);
    return post_final_render(s, request, body);
}

}  // namespace alder
