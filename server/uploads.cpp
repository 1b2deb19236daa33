// /v1/uploads: large assets in pieces. What was received survives a lost connection and a restart of the daemon; the asset
// appears under its digest when it is whole and its digest right.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>

#include <fmt/format.h>

#include "server/digest.h"
#include "server/http/door.h"
#include "server/jobs/files.h"
#include "server/members.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

namespace fs = std::filesystem;

struct UploadFile {
    std::string id, hex, data, head;   ///< paths of the bytes and of what they are to become
    uint64_t size = 0, offset = 0;
};

std::string folder_of(const Service& s) { return s.options.data + "/assets/uploads"; }

UploadFile find_upload(Service& s, const std::string& id) {
    const bool fits = id.size() == 30 && id.rfind("upl_", 0) == 0 && id.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz", 4) == std::string::npos;
    UploadFile u{id, {}, folder_of(s) + "/" + id + ".part", folder_of(s) + "/" + id + ".json"};
    std::ifstream file;
    if (fits) file.open(u.head);
    const auto j = fits && file ? nlohmann::json::parse(file, nullptr, false) : nlohmann::json();
    struct stat info {};
    if (!j.is_object() || ::stat(u.data.c_str(), &info) != 0) throw Problem{"not-found", "there is no such upload; it may be complete, or too old"};
    u.hex = j.value("hex", "");
    u.size = j.value("size", uint64_t{0});
    u.offset = static_cast<uint64_t>(info.st_size);
    return u;
}

http::Response upload_response(int status, const UploadFile& u, bool complete) {
    http::Response r = json_response(status, {{"id", u.id}, {"digest", "sha256:" + u.hex}, {"size", u.size}, {"offset", u.offset}, {"complete", complete}});
    r.set("Upload-Offset", std::to_string(u.offset));
    r.set("Upload-Length", std::to_string(u.size));
    r.set("Cache-Control", "no-store");
    if (complete) r.set("Content-Location", "/v1/assets/sha256:" + u.hex);
    return r;
}

/// One request at a time for an upload.
class InHand {
  public:
    explicit InHand(std::string id) : id_(std::move(id)) {
        const std::lock_guard lock(mutex());
        if (!ids().insert(id_).second) throw Problem{"state-conflict", "another request is sending to this upload"};
    }
    ~InHand() {
        const std::lock_guard lock(mutex());
        ids().erase(id_);
    }
    InHand(const InHand&) = delete;
    InHand& operator=(const InHand&) = delete;

  private:
    static std::mutex& mutex() {
        static std::mutex m;
        return m;
    }
    static std::set<std::string>& ids() {
        static std::set<std::string> s;
        return s;
    }
    std::string id_;
};

void forget(const UploadFile& u) {
    ::unlink(u.head.c_str());
    ::unlink(u.data.c_str());
}

}  // namespace

namespace {
struct Announced {
    std::string digest;
    int64_t size = 0;
};
void read_announced(Members& m, Announced& a, int64_t bytes_most) {
    constexpr const char* kDigest = "sha256: and 64 lower-case hexadecimal digits";
    const auto* digest = m.require("digest", kDigest, {{"type", "string"}, {"pattern", "^sha256:[0-9a-f]{64}$"}});
    if (digest && digest->is_string()) a.digest = *digest;
    if (digest && digest_hex(a.digest).empty()) m.fault("digest", "wrong-type", brief(*digest), kDigest);
    const auto* size = m.require("size", "its bytes", {{"type", "integer"}, {"minimum", 0}, {"maximum", bytes_most}});
    if (size && !whole_number(*size, 0, bytes_most, a.size)) m.fault("size", "out-of-range", brief(*size), fmt::format("a whole number from 0 to {}", bytes_most));
    m.finish(false);
}
}  // namespace
void describe_upload(Members& m) {
    Announced a;
    read_announced(m, a, int64_t{4} << 30);
}

http::Response post_uploads(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    Diagnostics d;
    Members m(body, "", d);
    Announced a;
    read_announced(m, a, s.options.asset_gib << 30);
    if (!d.ok()) throw problem_from("request-invalid", d);
    UploadFile u{"upl_" + http::time_sorted_id(), digest_hex(a.digest), {}, {}, static_cast<uint64_t>(a.size), 0};
    if (s.assets.has(u.hex)) {
        s.assets.touch(u.hex);
        u.offset = u.size = s.assets.size(u.hex).value_or(0);
        return upload_response(200, u, true);
    }
    if (!s.assets.has_room(u.size)) throw Problem{"storage", "there is no room for the asset"};
    u.data = folder_of(s) + "/" + u.id + ".part";
    u.head = folder_of(s) + "/" + u.id + ".json";
    std::error_code code;
    fs::create_directories(folder_of(s), code);
    const int fd = ::open(u.data.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd >= 0) ::close(fd);
    if (fd < 0 || jobs::write_whole(u.head, nlohmann::json{{"hex", u.hex}, {"size", u.size}, {"user", request.user}}.dump()) != 0) {
        forget(u);
        throw Problem{"storage", "the store cannot be written"};
    }
    http::Response r = upload_response(201, u, false);
    r.set("Location", "/v1/uploads/" + u.id);
    return r;
}

http::Response get_upload(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    return upload_response(200, find_upload(s, request.parameters["id"]), false);
}

http::Response delete_upload(Service& s, http::Request& request) {
    const InHand in_hand(request.parameters["id"]);
    forget(find_upload(s, request.parameters["id"]));
    http::Response r;
    r.status = 204;
    return r;
}

http::Response patch_upload(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const InHand in_hand(request.parameters["id"]);
    UploadFile u = find_upload(s, request.parameters["id"]);
    if (const std::string* coding = request.header("content-encoding"); coding && *coding != "identity")
        throw Problem{"media-type", fmt::format("Content-Encoding '{}' is not accepted", *coding)};
    const std::string* text = request.header("upload-offset");
    uint64_t offset = 0;
    const bool number = text && !text->empty() && std::from_chars(text->data(), text->data() + text->size(), offset).ptr == text->data() + text->size();
    if (!number) throw Problem{"malformed-request", "Upload-Offset says where the body begins: a whole number"};
    if (offset != u.offset) {
        Problem p{"upload-offset", fmt::format("{} bytes are there", u.offset)};
        p.extra["offset"] = u.offset;
        p.headers.emplace_back("Upload-Offset", std::to_string(u.offset));
        throw p;
    }
    if (!s.assets.has_room(u.size - u.offset)) throw Problem{"storage", "there is no room for the asset"};
    const int fd = ::open(u.data.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (fd < 0) throw Problem{"storage", "the store cannot be written"};
    int error = 0;
    const auto result = request.read_body(u.size - u.offset, [&](std::string_view piece) {
        if ((error = jobs::write_all(fd, piece)) != 0) return false;
        u.offset += piece.size();
        return true;
    });
    const bool synced = fsync(fd) == 0;
    ::close(fd);
    if (error || !synced) throw Problem{"storage", "there is no room for the asset"};
    switch (result) {
        case http::BodyResult::Complete: break;
        case http::BodyResult::TooLarge: throw Problem{"body-too-large", fmt::format("the upload was announced with {} bytes", u.size)};
        case http::BodyResult::TooSlow: throw Problem{"request-timeout", "the body did not arrive in time; what came is kept"};
        case http::BodyResult::Malformed: throw Problem{"malformed-request", "the chunks of the body are malformed"};
        default: throw Problem{"cancelled", "the client hung up; what came is kept"};
    }
    if (u.offset < u.size) return upload_response(200, u, false);
    const std::string found = jobs::file_digest(u.data);
    if (found != u.hex) {
        forget(u);
        Problem p{"digest-mismatch", fmt::format("{} bytes with another digest; the upload is gone", u.size)};
        p.extra["found"] = "sha256:" + found;
        throw p;
    }
    if (!s.assets.adopt(u.data, u.hex)) throw Problem{"storage", "the asset could not be written"};
    forget(u);
    s.metrics.count("alder_asset_bytes_received", {}, static_cast<double>(u.size));
    return upload_response(200, u, true);
}

}  // namespace alder
