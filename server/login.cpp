// POST /v1/login: a token in, a cookie out, for pages: their images and event sources cannot send an Authorization header.
#include "server/members.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

constexpr int kCookieSeconds = 12 * 3600;

std::string cookie(const Service& s, const std::string& value, int seconds) {
    // Strict: no other site's links or forms bring it along. HttpOnly: no script reads it.
    return std::string(kSessionCookie) + "=" + value + "; Path=/; Max-Age=" + std::to_string(seconds) + "; HttpOnly; SameSite=Strict" + (s.options.tls_cert.empty() ? "" : "; Secure");
}

}  // namespace

http::Response post_login(Service& s, http::Request& request) {
    const nlohmann::json body = s.read_json(request);
    Diagnostics d;
    Members m(body, "", d);
    std::string token;
    if (m.require("token", "a token")) m.text("token", token);
    m.finish(false);
    if (!d.ok()) throw problem_from("request-invalid", d);
    if (!s.access.uses_tokens()) return json_response(200, {{"user", nullptr}});
    const auto session = s.access.login(token, kCookieSeconds);
    http::Response r = json_response(200, {{"user", session.user}});
    r.set("Set-Cookie", cookie(s, session.id, kCookieSeconds));
    r.set("Cache-Control", "no-store");
    return r;
}

http::Response delete_login(Service& s, http::Request& request) {
    s.access.logout(request);
    http::Response r;
    r.status = 204;
    if (s.access.uses_tokens()) r.set("Set-Cookie", cookie(s, "", 0));
    return r;
}

}  // namespace alder
