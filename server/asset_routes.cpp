// /v1/assets: content by digest.
#include <fcntl.h>

#include <fmt/format.h>

#include "server/digest.h"
#include "server/members.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

constexpr size_t kMissingMost = 10000;

std::string hex_of(http::Request& request) {
    const std::string hex = digest_hex(request.parameters["digest"]);
    if (hex.empty()) throw Problem{"not-found", "an asset is named sha256: and 64 lower-case hexadecimal digits"};
    return hex;
}

}  // namespace

http::Response get_asset(Service& s, http::Request& request) {
    const std::string hex = hex_of(request);
    const auto size = s.assets.size(hex);
    if (!size) throw Problem{"not-found", "the asset is not in the store"};
    const std::string etag = "\"sha256:" + hex + "\"";
    http::Response r;
    r.set("ETag", etag);
    r.set("Cache-Control", "public, max-age=31536000, immutable");
    if (none_match_names(request, etag)) {
        r.status = 304;
        return r;
    }
    r.set("Content-Type", "application/octet-stream");
    r.set("Accept-Ranges", "bytes");
    r.set("Content-Disposition", "attachment");   // never shown as a page of this origin
    const auto range = byte_range(request, *size, etag);
    if (range) {
        r.status = 206;
        r.set("Content-Range", fmt::format("bytes {}-{}/{}", range->first, range->first + range->length - 1, *size));
    } else {
        r.set("Content-Digest", digest_header(hex));
    }
    const int fd = ::open(s.assets.path(hex).c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw Problem{"not-found", "the asset is not in the store"};
    r.file = range ? http::FileBody{fd, range->first, range->length} : http::FileBody{fd, 0, *size};
    return r;
}

http::Response put_asset(Service& s, http::Request& request) {
    const std::string hex = hex_of(request);
    const auto known = [&](int status) {
        http::Response r = json_response(status, {{"digest", "sha256:" + hex}, {"size", s.assets.size(hex).value_or(0)}});
        r.set("ETag", "\"sha256:" + hex + "\"");
        if (status == 201) r.set("Location", "/v1/assets/sha256:" + hex);
        return r;
    };
    if (const std::string* coding = request.header("content-encoding"); coding && *coding != "identity")
        throw Problem{"media-type", fmt::format("Content-Encoding '{}' is not accepted", *coding)};
    if (request.header("content-range")) throw Problem{"malformed-request", "PUT takes the whole asset, not a part"};
    if (s.assets.has(hex)) s.assets.touch(hex);
    if (s.assets.has(hex)) s.metrics.count("alder_asset_dedup_bytes", {}, static_cast<double>(s.assets.size(hex).value_or(0)));
    if (s.assets.has(hex)) return known(200);   // before the body: a client that said Expect need not send it

    const uint64_t limit = static_cast<uint64_t>(s.options.asset_gib) << 30;
    if (!s.assets.has_room(request.content_length.value_or(0))) throw Problem{"storage", "there is no room for the asset"};
    auto upload = s.assets.begin();
    if (!upload) throw Problem{"storage", "the store cannot be written"};
    uint64_t received = 0;
    bool disk_full = false;
    const auto result = request.read_body(limit, [&](std::string_view piece) {
        received += piece.size();
        disk_full = !upload->write(piece) || ((received >> 26) != ((received - piece.size()) >> 26) && !s.assets.has_room(0));
        return !disk_full;
    });
    if (disk_full) throw Problem{"storage", "there is no room for the asset"};
    switch (result) {
        case http::BodyResult::Complete: break;
        case http::BodyResult::TooLarge: {
            Problem p{"body-too-large", fmt::format("an asset has at most {} bytes", limit)};
            p.extra["limit"] = limit;
            p.extra["limit_option"] = "--max-asset-gib";
            throw p;
        }
        case http::BodyResult::TooSlow: throw Problem{"request-timeout", "the body did not arrive in time"};
        case http::BodyResult::Malformed: throw Problem{"malformed-request", "the chunks of the body are malformed"};
        default: throw Problem{"cancelled", "the client hung up"};
    }
    const std::string found = upload->hex();
    if (found != hex) {
        Problem p{"digest-mismatch", fmt::format("{} bytes with another digest", received)};
        p.extra["found"] = "sha256:" + found;
        throw p;
    }
    if (!upload->commit(hex)) throw Problem{"storage", "the asset could not be written"};
    s.metrics.count("alder_asset_bytes_received", {}, static_cast<double>(received));
    return known(201);
}

http::Response delete_asset(Service& s, http::Request& request) {
    const std::string hex = hex_of(request);
    if (!s.assets.has(hex)) throw Problem{"not-found", "the asset is not in the store"};
    if (const std::string scene = s.scenes.user_of("sha256:" + hex); !scene.empty()) {
        Problem p{"in-use", fmt::format("the scene {} refers to it", scene)};
        p.extra["scene"] = scene;
        throw p;
    }
    if (const std::string render = s.renders.store().user_of("sha256:" + hex); !render.empty()) {
        Problem p{"in-use", fmt::format("the render {} refers to it", render)};
        p.extra["render"] = render;
        throw p;
    }
    s.assets.remove(hex);
    http::Response r;
    r.status = 204;
    return r;
}

namespace {
void read_missing(Members& m, std::vector<std::string>& digests) {
    const auto* value = m.require("digests", "an array of digests", {{"type", "array"}, {"items", {{"type", "string"}, {"pattern", "^sha256:[0-9a-f]{64}$"}}}, {"maxItems", kMissingMost}});
    if (value) m.texts("digests", digests, kMissingMost);
    m.finish(false);
}
}  // namespace
void describe_missing(Members& m) {
    std::vector<std::string> digests;
    read_missing(m, digests);
}

http::Response post_assets_missing(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const nlohmann::json body = s.read_json(request);
    Diagnostics d;
    Members m(body, "", d);
    std::vector<std::string> digests;
    read_missing(m, digests);
    nlohmann::json missing = nlohmann::json::array();
    for (size_t i = 0; i < digests.size() && d.errors.size() < kMaxDiagnostics; ++i) {
        const std::string hex = digest_hex(digests[i]);
        if (hex.empty())
            d.errors.push_back({fmt::format("/digests/{}", i), "wrong-type", brief(digests[i]), "sha256: and 64 lower-case hexadecimal digits", {}});
        else if (!s.assets.has(hex))
            missing.push_back(digests[i]);
        else
            s.assets.touch(hex);   // who is told that it is there relies on it
    }
    if (!d.ok()) throw problem_from("request-invalid", d);
    return json_response(200, {{"missing", std::move(missing)}});
}

}  // namespace alder
