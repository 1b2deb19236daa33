// Requests and responses as the routes see them: parsed, bounded and free of any HTTP library's types.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace alder::http {

struct Limits {
    size_t request_line_bytes = 8 << 10;
    size_t header_bytes = 16 << 10;
    size_t header_fields = 100;
    size_t body_bytes = 8 << 20;          ///< of JSON; routes that store files set their own
    size_t scene_bytes = 256 << 20;       ///< of a scene document
    double head_seconds = 5;              ///< from the first byte of a request to the end of its headers
    double idle_seconds = 15;             ///< between the requests of a connection
    double body_grace_seconds = 10;       ///< after which a body must have come at `body_bytes_per_second`
    double body_bytes_per_second = 4 << 10;
    double write_stall_seconds = 30;      ///< a client that takes nothing for so long is given up
    size_t connections = 512;
};

/// Why a request's head is refused: a row of the error table and a sentence.
struct Fault {
    std::string type;    ///< "uri-too-long", "headers-too-large", "malformed-request"
    std::string detail;
};

struct Head {
    std::string method;
    std::string target;                                       ///< as sent
    std::vector<std::string> segments;                        ///< path, split and percent-decoded: "/v1/nodes" = {"v1","nodes"}
    std::vector<std::pair<std::string, std::string>> query;   ///< decoded
    std::vector<std::pair<std::string, std::string>> headers; ///< names in lower case
    std::string host;                                         ///< from Host or an absolute target; empty where there is none
    bool http_1_0 = false;
    bool keep_alive = true;
    bool chunked = false;
    bool expects_continue = false;
    std::optional<uint64_t> content_length;

    /// The first header of that (lower case) name, or null.
    const std::string* header(std::string_view name) const;
    bool has_body() const { return chunked || content_length.value_or(0) > 0; }
};

enum class BodyResult { Complete, Stopped, TooLarge, Malformed, TooSlow, Disconnected };

struct Request : Head {
    std::string id;                                 ///< Alder-Request-Id
    std::string remote;                             ///< address of the client
    std::string route;                              ///< template of the matched route, for metrics
    std::map<std::string, std::string> parameters;  ///< what the route's {names} matched
    std::string user;                               ///< name of the token; empty where none is needed
    bool sees_all = true;                           ///< no tokens are in use, or this one's scopes have admin
    std::optional<Fault> fault;                     ///< the head was refused; nothing else is valid

    /// Reads the body piece by piece; the receiver returns false to stop. At most once a request.
    std::function<BodyResult(uint64_t limit, const std::function<bool(std::string_view)>& receiver)> read_body;
    /// Whether the client has closed its side.
    std::function<bool()> client_gone;
};

/// A part of an open file to be sent as the body. Closed by whoever sends it.
struct FileBody {
    int fd = -1;
    uint64_t offset = 0, length = 0;
};

/// Sends a piece of a stream; false when the client is gone or takes nothing any more.
using StreamWriter = std::function<bool(std::string_view)>;

struct Response {
    int status = 200;
    std::vector<std::pair<std::string, std::string>> headers;
    std::string body;
    std::optional<FileBody> file;
    std::string stream_type;                           ///< Content-Type of `stream`
    std::function<void(const StreamWriter&)> stream;   ///< writes the body until it returns; on the connection's own thread
    bool close = false;   ///< end the connection after this answer

    void set(std::string name, std::string value);   ///< replaces a header of that name
    static Response text(int status, std::string body, std::string type);
};

}  // namespace alder::http
