// Service: one request from access check to log line.
#include "server/service.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <new>
#include <thread>

#include <fmt/format.h>

#include "graph/json_text.h"
#include "nodes/texture/image_store.h"
#include "server/digest.h"
#include "server/http/head.h"
#include "server/log.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/routes.h"

namespace alder {
namespace {

constexpr size_t kBufferedBytesMost = size_t{1} << 30;   // of all bodies together, whatever each may have
constexpr double kWatchSeconds = 0.02;                   // how often a waiting request looks whether its client is still there

size_t engine_workers(int threads) {
    const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
    return threads > 0 ? static_cast<size_t>(threads) : processors;
}

Problem json_problem(const Diagnostic& d) {
    Problem p{d.code == "limit-exceeded" ? "limit-exceeded" : d.code, d.found};
    unsigned line = 0, column = 0;
    if (std::sscanf(d.found.c_str(), "line %u, column %u", &line, &column) == 2) {
        p.extra["line"] = line;
        p.extra["column"] = column;
    }
    p.faults.errors.push_back(d);
    return p;
}

}  // namespace

http::Response json_response(int status, const nlohmann::json& value) {
    return http::Response::text(status, value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n", "application/json");
}

http::Response constant_json(http::Request& request, const nlohmann::json& value) {
    http::Response r = json_response(200, value);
    const std::string etag = "\"" + sha256_hex(r.body).substr(0, 32) + "\"";
    if (none_match_names(request, etag)) {
        r = {};
        r.status = 304;
    }
    r.set("ETag", etag);
    r.set("Cache-Control", "no-cache");
    return r;
}

Service::Service(const ServiceOptions& o)
    : options(o),
      assets(o.data + "/assets"),
      engine(assets, o.asset_roots, o.threads),
      scenes(o.data + "/scenes"),
      results(static_cast<size_t>(o.cache_mib) << 20),
      renders(options, assets, metrics),
      compile_lane("compile", engine_workers(o.threads), static_cast<size_t>(o.queue)),
      preview_lane("preview", 1, static_cast<size_t>(o.queue)),
      live(metrics, &renders.gate()) {
    access.allowed_origins = o.allowed_origins;
    assets.set_quota(static_cast<uint64_t>(o.store_gib) << 30);
    metrics.gauge("alder_store_bytes", [this] { return static_cast<double>(assets.bytes()); }, "what=\"assets\"");
    metrics.gauge("alder_memory_bytes", [this] { return static_cast<double>(results.bytes()); }, "pool=\"results\"");
    metrics.gauge("alder_memory_bytes", [] { return static_cast<double>(ImageStore::shared().usage().whole_bytes + ImageStore::shared().usage().tile_bytes); }, "pool=\"textures\"");
    for (const Lane* lane : {&compile_lane, &preview_lane}) {
        metrics.gauge("alder_" + lane->name() + "_queued", [lane] { return static_cast<double>(lane->queued()); });
        metrics.gauge("alder_" + lane->name() + "_running", [lane] { return static_cast<double>(lane->running()); });
    }
    metrics.gauge("alder_live_renders", [this] { return static_cast<double>(live.size()); });
    metrics.gauge("alder_streams", [this] { return static_cast<double>(live.streams()); });
    metrics.gauge("alder_result_cache_bytes", [this] { return static_cast<double>(results.bytes()); });
    metrics.gauge("alder_material_cache_hits", [this] { return static_cast<double>(engine.materials().counters().hits); });
    metrics.gauge("alder_material_cache_misses", [this] { return static_cast<double>(engine.materials().counters().misses); });
    watch_textures();
}

/// Textures are the process's, shared by all that is rendered.
void Service::watch_textures() {
    ImageStore& store = ImageStore::shared();
    store.set_budget(static_cast<size_t>(options.texture_mib) << 20);
    set_color_configuration(options.color_configuration);
    set_image_fault_listener([](const std::string& fault) { log_event("warn", "texture broken", {{"file", fault}}); });
    const auto gauge = [&](const std::string& name, auto member) {
        metrics.gauge("alder_texture_" + name, [member] { return static_cast<double>(ImageStore::shared().usage().*member); });
    };
    gauge("budget_bytes", &ImageStore::Usage::budget_bytes);
    gauge("whole_bytes", &ImageStore::Usage::whole_bytes);
    gauge("tile_bytes", &ImageStore::Usage::tile_bytes);
    gauge("read_ahead_bytes", &ImageStore::Usage::read_bytes);
    gauge("images_whole", &ImageStore::Usage::whole_images);
    gauge("images_tiled", &ImageStore::Usage::tiled_images);
    gauge("tile_requests", &ImageStore::Usage::tile_requests);
    gauge("tile_misses", &ImageStore::Usage::tile_misses);
    gauge("tiles_read", &ImageStore::Usage::tiles_read);
    gauge("tiles_dropped", &ImageStore::Usage::tiles_dropped);
    gauge("faults", &ImageStore::Usage::faults);
}

Service::~Service() {
    live.stop();
    for (Lane* lane : {&compile_lane, &preview_lane}) lane->stop();
}

nlohmann::json Service::read_json(http::Request& request, bool is_scene) {
    if (const std::string* coding = request.header("content-encoding"); coding && *coding != "identity")
        throw Problem{"media-type", fmt::format("Content-Encoding '{}' is not accepted", *coding)};
    if (const std::string* type = request.header("content-type")) {
        std::string base = type->substr(0, type->find(';'));
        while (!base.empty() && base.back() == ' ') base.pop_back();
        for (char& c : base) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (base != "application/json" && !base.ends_with("+json"))
            throw Problem{"media-type", fmt::format("Content-Type is '{}'; application/json is needed", *type)};
    }
    const uint64_t limit = is_scene ? std::max(options.limits.scene_bytes, options.limits.body_bytes) : options.limits.body_bytes;
    const auto too_large = [&] {
        Problem p{"body-too-large", fmt::format("the body is larger than {} bytes", limit)};
        p.extra["limit"] = limit;
        p.extra["limit_option"] = is_scene ? "--max-scene" : "--max-body";
        return p;
    };
    // What all bodies being read hold together stays bounded too, however many connections there are.
    struct Reserved {
        std::atomic<size_t>& total;
        size_t bytes = 0;
        ~Reserved() { total -= bytes; }
    } reserved{buffered_bytes_};
    std::string body;
    const auto result = request.read_body(limit, [&](std::string_view piece) {
        reserved.bytes += piece.size();
        if ((buffered_bytes_ += piece.size()) > kBufferedBytesMost) return false;
        body.append(piece);
        return true;
    });
    switch (result) {
        case http::BodyResult::Complete: break;
        case http::BodyResult::Stopped: {
            Problem p{"queue-full", "too many bodies are being received"};
            p.headers.emplace_back("Retry-After", "1");
            throw p;
        }
        case http::BodyResult::TooLarge: throw too_large();
        case http::BodyResult::TooSlow: throw Problem{"request-timeout", "the body did not arrive in time"};
        case http::BodyResult::Malformed: throw Problem{"malformed-request", "the chunks of the body are malformed"};
        case http::BodyResult::Disconnected: throw Problem{"cancelled", "the client hung up"};
    }
    if (body.empty()) throw Problem{"malformed-json", "the body is empty"};
    Diagnostics d;
    JsonLimits limits;
    if (is_scene) limits.string_bytes = limit;   // arrays as base64
    auto json = parse_json(body, limits, d);
    if (!json) throw json_problem(d.errors.front());
    return std::move(*json);
}

void Service::run(Lane& lane, http::Request& request, double seconds,
                  const std::function<void(const std::atomic<bool>& cancel)>& work) {
    if (draining) {
        Problem p{"draining", ""};
        p.headers.emplace_back("Retry-After", "10");
        throw p;
    }
    std::exception_ptr thrown;
    const auto task = lane.submit([&](const std::atomic<bool>& cancel) {
        try {
            work(cancel);
        } catch (...) {
            thrown = std::current_exception();
        }
    });
    if (!task) {
        Problem p{"queue-full", fmt::format("{} requests are waiting already", lane.queued())};
        p.headers.emplace_back("Retry-After", "1");
        throw p;
    }
    const auto start = std::chrono::steady_clock::now();
    bool gone = false;
    while (!task->wait(kWatchSeconds)) {
        if (!gone && request.client_gone && request.client_gone()) {
            gone = true;
            task->cancel = true;
            metrics.count("alder_requests_abandoned");
        }
        if (seconds > 0 && std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) task->cancel = true;
    }
    if (thrown) std::rethrow_exception(thrown);
    if (gone) throw Problem{"cancelled", "the client hung up"};
    if (draining && task->cancel) throw Problem{"draining", "the work was cancelled because the daemon is stopping"};
}

void Service::count_render(const RenderStats& stats) {
    metrics.count("alder_rays", "kind=\"camera\"", static_cast<double>(stats.camera_rays));
    metrics.count("alder_rays", "kind=\"bounce\"", static_cast<double>(stats.bounce_rays));
    metrics.count("alder_rays", "kind=\"shadow\"", static_cast<double>(stats.shadow_rays));
    metrics.count("alder_rays", "kind=\"subsurface\"", static_cast<double>(stats.subsurface_rays));
    metrics.count("alder_samples", {}, static_cast<double>(stats.samples));
    metrics.count("alder_shading_points", {}, static_cast<double>(stats.shading_points));
    metrics.count("alder_node_evaluations", "outcome=\"run\"", static_cast<double>(stats.node_evaluations));
    metrics.count("alder_node_evaluations", "outcome=\"skipped\"", static_cast<double>(stats.node_skipped));
    metrics.count("alder_nonfinite_samples", {}, static_cast<double>(stats.nonfinite_samples));
    metrics.observe("alder_render_seconds", {}, stats.render_seconds);
}

http::Response Service::route(http::Request& request) {
    if (request.fault) throw Problem{request.fault->type, request.fault->detail};
    const RouteMatch match = match_route(request);
    // Access comes before 404 and 405: without a token nobody learns what is there.
    access.check(request, match.scope);
    if (!match.path_known) throw Problem{"not-found", fmt::format("nothing has the path of '{}'", request.target.substr(0, 200))};
    if (request.method == "OPTIONS") {
        http::Response r;
        r.status = 204;
        r.set("Allow", match.allow);
        if (!access.cors_origin(request).empty() && request.header("access-control-request-method")) {
            r.set("Access-Control-Allow-Methods", match.allow);
            r.set("Access-Control-Allow-Headers", "Authorization, Content-Type, If-Match, If-None-Match, Prefer, Range");
            r.set("Access-Control-Max-Age", "600");
        }
        return r;
    }
    if (!match.handler) {
        Problem p{"method", fmt::format("{} is not available here", request.method)};
        p.headers.emplace_back("Allow", match.allow);
        throw p;
    }
    // Like unknown members of bodies: what would be ignored is refused. (/ui has addresses with a query of their own.)
    if (!request.query.empty() && request.route.rfind("/v1/", 0) == 0 && !has_query(request.method == "HEAD" ? "GET" : request.method, request.route))
        throw Problem{"malformed-request", fmt::format("the query member '{}' is not known here", request.query.front().first.substr(0, 64))};
    if (auto answer = live_route(*this, request)) return std::move(*answer);
    return match.handler(*this, request);
}

http::Response Service::handle(http::Request& request) {
    const auto start = std::chrono::steady_clock::now();
    http::Response response;
    std::string error_type;
    try {
        response = route(request);
    } catch (const Problem& p) {
        error_type = p.type;
        try {
            response = p.response(request.id);
        } catch (...) {
            response = {};
            response.status = 500;
        }
    } catch (const std::bad_alloc&) {
        error_type = "internal";
        log_event("error", "out of memory", {{"request_id", request.id}, {"route", request.route}});
        response = Problem{"internal", "out of memory"}.response(request.id);
    } catch (const std::exception& e) {
        error_type = "internal";
        log_event("error", "exception", {{"request_id", request.id}, {"route", request.route}, {"what", e.what()}});
        response = Problem{"internal", ""}.response(request.id);
    } catch (...) {
        error_type = "internal";
        log_event("error", "exception", {{"request_id", request.id}, {"route", request.route}});
        response = Problem{"internal", ""}.response(request.id);
    }
    response.set("Alder-Request-Id", request.id);
    response.set("X-Content-Type-Options", "nosniff");
    if (const std::string origin = request.fault ? std::string() : access.cors_origin(request); !origin.empty()) {
        response.set("Access-Control-Allow-Origin", origin);
        response.set("Access-Control-Expose-Headers", "ETag, Location, Alder-Request-Id, Alder-Warnings, Alder-Samples, Server-Timing");
        response.set("Vary", "Origin, Accept");
    }
    if (draining) response.close = true;

    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::string method = known_method(request.method) ? request.method : "other";
    const std::string labels = fmt::format("route=\"{}\",method=\"{}\"", request.route, method);
    metrics.count("alder_http_requests", fmt::format("{},code=\"{}\"", labels, response.status));
    metrics.observe("alder_http_request_seconds", labels, seconds);
    nlohmann::json fields = {{"request_id", request.id}, {"remote", request.remote}, {"method", method}, {"route", request.route},
                             {"status", response.status}, {"seconds", seconds}};
    if (!error_type.empty()) fields["error"] = error_type;
    if (!request.user.empty()) fields["user"] = request.user;
    log_event(response.status >= 500 ? "warn" : "info", "request", fields);
    return response;
}

}  // namespace alder
