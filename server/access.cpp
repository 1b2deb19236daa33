// Access: bearer tokens, Host and Origin checks, scopes.
#include "server/access.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

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

namespace {

constexpr size_t kSessionsMost = 10000;

/// The session's id in the Cookie header; empty where there is none.
std::string session_id(const http::Request& request) {
    const std::string* header = request.header("cookie");
    if (!header) return {};
    const std::string name = std::string(kSessionCookie) + "=";
    for (const std::string& part : split(*header, ';')) {
        const size_t begin = part.find_first_not_of(' ');
        if (begin != std::string::npos && part.compare(begin, name.size(), name) == 0) return part.substr(begin + name.size());
    }
    return {};
}

Problem challenge(const char* type, const char* detail) {
    Problem p{type, detail};
    p.headers.emplace_back("WWW-Authenticate", "Bearer");
    return p;
}

}  // namespace

/// With the lock held.
const Access::Token* Access::find(const std::string& digest) const {
    const Token* match = nullptr;
    for (const Token& token : tokens_)   // all of them, in constant time each: how long it takes tells nothing
        if (CRYPTO_memcmp(token.digest_hex.data(), digest.data(), digest.size()) == 0) match = &token;
    return match;
}

Access::Session Access::login(const std::string& token, int seconds) {
    const std::string digest = sha256_hex(token);
    const std::lock_guard lock(mutex_);
    const Token* match = find(digest);
    if (!match) throw challenge("token-invalid", "");
    const auto now = std::chrono::steady_clock::now();
    std::erase_if(sessions_, [&](const auto& s) { return s.second.ends < now; });
    if (sessions_.size() >= kSessionsMost) sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), [](const auto& a, const auto& b) { return a.second.ends < b.second.ends; }));
    unsigned char random[32];
    if (RAND_bytes(random, sizeof random) != 1) throw Problem{"internal", "no random numbers"};
    const std::string id = sha256_hex(std::string_view(reinterpret_cast<const char*>(random), sizeof random));
    sessions_[sha256_hex(id)] = {digest, now + std::chrono::seconds(seconds)};
    return {id, match->name};
}

void Access::logout(const http::Request& request) {
    const std::string id = session_id(request);
    const std::lock_guard lock(mutex_);
    if (!id.empty()) sessions_.erase(sha256_hex(id));
}

void Access::check(http::Request& request, unsigned scope) const {
    if (check_host && !uses_tokens() && !request.host.empty() && !is_loopback_host(request.host))
        throw Problem{"host-refused", fmt::format("Host is '{}'", request.host)};
    if (const std::string* origin = request.header("origin");
        origin && *origin != "http://" + request.host && *origin != "https://" + request.host && cors_origin(request).empty())
        throw Problem{"origin-refused", fmt::format("Origin is '{}'", *origin)};
    if (!uses_tokens() || scope == kScopeNone) return;

    const std::string* authorization = request.header("authorization");
    const std::string session = authorization ? std::string() : session_id(request);
    std::string digest;
    if (authorization) {
        constexpr std::string_view kBearer = "bearer ";
        std::string kind = authorization->substr(0, kBearer.size());
        for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (kind != kBearer) throw challenge("token-missing", "Authorization is not 'Bearer TOKEN'");
        digest = sha256_hex(std::string_view(*authorization).substr(kBearer.size()));
    } else if (session.empty()) {
        throw challenge("token-missing", "there is no Authorization header");
    }
    const std::lock_guard lock(mutex_);
    if (!session.empty()) {
        const auto open = sessions_.find(sha256_hex(session));
        if (open == sessions_.end() || open->second.ends < std::chrono::steady_clock::now()) throw challenge("token-missing", "the session has ended");
        digest = open->second.token_digest;   // a token that was taken back ends its sessions too
    }
    const Token* match = find(digest);
    if (!match) throw challenge("token-invalid", "");
    request.user = match->name;
    request.sees_all = (match->scopes & kScopeAdmin) != 0;
    if ((match->scopes & scope) != scope)
        throw Problem{"scope-missing", fmt::format("the scope '{}' is needed", scope_name(scope))};
}

}  // namespace alder
