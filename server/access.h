// Access: who may ask. Bearer tokens, the Host and Origin checks that keep web pages away from a loopback daemon, and scopes.
#pragma once
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace alder {

enum Scope : unsigned { kScopeNone = 0, kScopeRead = 1, kScopeRender = 2, kScopeEdit = 4, kScopeAdmin = 8 };

class Access {
  public:
    std::vector<std::string> allowed_origins;
    bool check_host = true;   ///< on loopback TCP without tokens

    /// Reads "name:scopes:sha256-of-token[:quota=N]" lines. Empty, or a sentence that names file and line.
    std::string load_tokens(const std::string& path);
    std::string reload();   ///< the same file again; keeps the old tokens where it is wrong
    bool uses_tokens() const;

    /// A session for who has this token; throws token-invalid. Sessions live in memory: a restart ends them.
    struct Session {
        std::string id, user;
    };
    Session login(const std::string& token, int seconds);
    /// Ends the session that the request's cookie names.
    void logout(const http::Request& request);

    /// Throws a Problem where the request may not go on; sets request.user.
    void check(http::Request& request, unsigned scope) const;
    /// The request's Origin where it is one that may read answers, else empty.
    std::string cors_origin(const http::Request& request) const;

  private:
    struct Token {
        std::string name, digest_hex;
        unsigned scopes = 0;
    };
    struct Open {
        std::string token_digest;
        std::chrono::steady_clock::time_point ends;
    };
    const Token* find(const std::string& digest) const;
    static std::string parse(const std::string& path, std::vector<Token>& tokens);

    mutable std::mutex mutex_;
    std::string path_;
    std::vector<Token> tokens_;
    std::map<std::string, Open> sessions_;   ///< by the digest of their id: what is in memory opens nothing
};

/// Name of the cookie that POST /v1/login gives.
inline constexpr const char* kSessionCookie = "alder_session";

/// Whether a Host header's name is this machine's loopback: localhost, *.localhost, 127.0.0.0/8, [::1].
bool is_loopback_host(const std::string& host);

}  // namespace alder
