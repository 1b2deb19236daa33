// Access: bearer tokens, Host and Origin checks, scopes.
#include "server/access.h"

#include <fstream>

#include <fmt/format.h>
#include <openssl/crypto.h>

#include "server/digest.h"
#include "server/errors.h"
#include "server/http/door.h"

namespace alder {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text)
        if (c == separator)
            parts.emplace_back();
        else
            parts.back().push_back(c);
    return parts;
}

unsigned scope_bit(const std::string& name) {
    if (name == "read") return kScopeRead;
    if (name == "render") return kScopeRender;
    if (name == "edit") return kScopeEdit;
    if (name == "admin") return kScopeRead | kScopeRender | kScopeEdit | kScopeAdmin;
    return 0;
}

const char* scope_name(unsigned scope) {
    return scope == kScopeRead ? "read" : scope == kScopeRender ? "render" : scope == kScopeEdit ? "edit" : "admin";
}

}  // namespace

bool is_loopback_host(const std::string& host) {
    std::string name = host;
    if (!name.empty() && name[0] == '[') {
        const size_t end = name.find(']');
        name = end == std::string::npos ? name : name.substr(0, end + 1);
    } else if (const size_t colon = name.rfind(':'); colon != std::string::npos) {
        name.resize(colon);
    }
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (name == "localhost" || (name.size() > 10 && name.ends_with(".localhost"))) return true;
    return http::Door::is_loopback(name + ":1");
}

std::string Access::parse(const std::string& path, std::vector<Token>& tokens) {
    std::ifstream file(path);
    if (!file) return fmt::format("the token file '{}' cannot be read", path);
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty() || line[0] == '#') continue;
        const auto fields = split(line, ':');
        const auto bad = [&](const char* why) { return fmt::format("{}:{}: {}", path, number, why); };
        if (fields.size() < 3) return bad("expected name:scopes:sha256-of-token");
        Token token{fields[0], fields[2], 0};
        if (token.name.empty()) return bad("the name is empty");
        for (const auto& scope : split(fields[1], ',')) {
            const unsigned bit = scope_bit(scope);
            if (!bit) return bad("a scope is none of read, render, edit, admin");
            token.scopes |= bit;
        }
        if (!is_sha256_hex(token.digest_hex)) return bad("the digest is not 64 lower-case hexadecimal digits");
        tokens.push_back(std::move(token));
    }
    return tokens.empty() ? fmt::format("the token file '{}' has no tokens", path) : std::string();
}

std::string Access::load_tokens(const std::string& path) {
    path_ = path;
    return reload();
}

std::string Access::reload() {
    if (path_.empty()) return {};
    std::vector<Token> fresh;
    std::string error = parse(path_, fresh);
    if (!error.empty()) return error;
    const std::lock_guard lock(mutex_);
    tokens_ = std::move(fresh);
    return {};
}

bool Access::uses_tokens() const { return !path_.empty(); }

std::string Access::cors_origin(const http::Request& request) const {
    const std::string* origin = request.header("origin");
    if (!origin) return {};
    for (const auto& allowed : allowed_origins)
        if (*origin == allowed) return *origin;
    return {};
}

void Access::check(http::Request& request, unsigned scope) const {
    if (check_host && !uses_tokens() && !request.host.empty() && !is_loopback_host(request.host))
        throw Problem{"host-refused", fmt::format("Host is '{}'", request.host)};
    if (const std::string* origin = request.header("origin");
        origin && *origin != "http://" + request.host && *origin != "https://" + request.host && cors_origin(request).empty())
        throw Problem{"origin-refused", fmt::format("Origin is '{}'", *origin)};
    if (!uses_tokens() || scope == kScopeNone) return;

    const std::string* authorization = request.header("authorization");
    const auto challenge = [](const char* type, const char* detail) {
        Problem p{type, detail};
        p.headers.emplace_back("WWW-Authenticate", "Bearer");
        return p;
    };
    if (!authorization) throw challenge("token-missing", "there is no Authorization header");
    constexpr std::string_view kBearer = "bearer ";
    std::string kind = authorization->substr(0, kBearer.size());
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (kind != kBearer) throw challenge("token-missing", "Authorization is not 'Bearer TOKEN'");
    const std::string digest = sha256_hex(std::string_view(*authorization).substr(kBearer.size()));
    const Token* match = nullptr;
    const std::lock_guard lock(mutex_);
    for (const Token& token : tokens_)   // all of them, in constant time each: how long it takes tells nothing
        if (CRYPTO_memcmp(token.digest_hex.data(), digest.data(), digest.size()) == 0) match = &token;
    if (!match) throw challenge("token-invalid", "");
    request.user = match->name;
    request.sees_all = (match->scopes & kScopeAdmin) != 0;
    if ((match->scopes & scope) != scope)
        throw Problem{"scope-missing", fmt::format("the scope '{}' is needed", scope_name(scope))};
}

}  // namespace alder
