// /v1/renders: renders as jobs.
#include <fcntl.h>
#include <sys/stat.h>

#include <charconv>

#include <fmt/format.h>

#include "render/image/exr.h"
#include "server/digest.h"
#include "server/jobs/accept.h"
#include "server/jobs/answer.h"
#include "server/jobs/files.h"
#include "server/jobs/visible.h"
#include "server/negotiate.h"
#include "server/openapi.h"
#include "server/query.h"
#include "server/picture.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {

jobs::Job jobs::visible(Service& s, const http::Request& request) {
    const std::string& id = request.parameters.at("id");
    Job job = s.renders.get(id);
    if (!request.sees_all && job.user != request.user) throw Problem{"not-found", fmt::format("there is no render '{}'", id.substr(0, 64))};
    return job;
}

namespace {

using namespace jobs;

constexpr size_t kKeyMost = 255;
constexpr double kPollMost = 3600;

double wait_of(const http::Request& request) {
    const auto wait = preferred_wait(request);
    if (wait && *wait > kWaitMost) throw Problem{"malformed-request", "Prefer: wait is at most 3600 seconds"};
    return wait.value_or(0);
}

/// Holds an Idempotency-Key while its request is answered.
class KeyInUse {
  public:
    KeyInUse(Service& s, const http::Request& request) : s_(s) {
        const std::string* key = request.header("idempotency-key");
        if (!key) return;
        const bool printable = std::all_of(key->begin(), key->end(), [](char c) { return c >= 0x20 && c < 0x7F; });
        if (key->empty() || key->size() > kKeyMost || !printable) throw Problem{"malformed-request", "Idempotency-Key has 1 to 255 printable characters"};
        if (!s.renders.begin_key(request.user, *key)) {
            Problem p{"idempotency-in-progress", ""};
            p.headers.emplace_back("Retry-After", "1");
            throw p;
        }
        user_ = request.user;
        key_ = *key;
    }
    ~KeyInUse() { release(); }
    /// The answer is on disk: who comes with the key gets it, also while this request waits for the render.
    void release() {
        if (!key_.empty()) s_.renders.end_key(user_, key_);
        key_.clear();
    }
    KeyInUse(const KeyInUse&) = delete;
    KeyInUse& operator=(const KeyInUse&) = delete;
    const std::string& key() const { return key_; }

  private:
    Service& s_;
    std::string user_, key_;
};

void refuse_if_busy(Service& s, const http::Request& request) {
    if (s.draining) {
        Problem p{"draining", ""};
        p.headers.emplace_back("Retry-After", "10");
        throw p;
    }
    const int64_t waiting = s.renders.store().count(std::nullopt);
    if (waiting >= s.options.renders_queued) {
        Problem p{"queue-full", fmt::format("{} renders are waiting already", waiting)};
        p.extra["limit_option"] = "--renders-queued";
        p.headers.emplace_back("Retry-After", "10");
        throw p;
    }
    // One client's renders leave room for others'.
    if (s.access.uses_tokens()) {
        const int64_t own = s.renders.store().count(std::nullopt, &request.user);
        if (own >= std::max<int64_t>(1, s.options.renders_queued / 2)) {
            Problem p{"rate", fmt::format("{} renders of this token are waiting already", own)};
            p.headers.emplace_back("Retry-After", "10");
            throw p;
        }
    }
}

http::Response accepted_response(const Job& job, int status) {
    http::Response r = json_response(status, job.document());
    r.set("Location", "/v1/renders/" + job.id);
    r.set("ETag", job.etag());
    if (status == 202) r.set("Retry-After", "1");
    return r;
}

/// Waits as the request asks and answers with what there is then.
http::Response answer_when_done(Service& s, http::Request& request, const std::string& id, double seconds, const std::string& type, bool cancel_on_disconnect) {
    const Job job = s.renders.wait(id, seconds, [](const Job& j) { return is_terminal(j.state); }, request.client_gone);
    if (!is_terminal(job.state)) {
        if (cancel_on_disconnect && request.client_gone && request.client_gone()) s.renders.cancel(id);
        http::Response r = accepted_response(job, 202);
        r.set("Preference-Applied", fmt::format("wait={:g}", seconds));
        return r;
    }
    http::Response r = result_response(s, request, job, type);
    r.set("Location", "/v1/renders/" + job.id);
    r.set("Preference-Applied", fmt::format("wait={:g}", seconds));
    return r;
}


ListFilter read_filter(Query& q) {
    ListFilter f;
    f.limit = static_cast<int>(q.integer("limit", f.limit, 1, 1000));
    if (const std::string* cursor = q.find("cursor", {{"type", "string"}, {"pattern", "^rnd_[0-9a-z]{26}$"}})) {
        if (cursor->size() != 30 || cursor->rfind("rnd_", 0) != 0 || cursor->find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz", 4) != std::string::npos)
            throw Problem{"malformed-request", "the query member 'cursor' is the member next of an earlier answer"};
        f.before = *cursor;
    }
    State state;
    if (state_from_name(q.choice("state", "", {"queued", "preparing", "rendering", "writing", "paused", "succeeded", "failed", "cancelled"}), state)) f.state = state;
    if (const std::string* scene = q.find("scene")) f.scene = *scene;
    f.labels = q.prefixed("label.");
    return f;
}

}  // namespace

http::Response post_final_render(Service& s, http::Request& request, const nlohmann::json& body) {
    Diagnostics d;
    const JobSettings settings = read_settings(body, d);
    if (!d.ok()) throw problem_from("settings-invalid", d);
    const double wait = wait_of(request);
    const std::string type = wait > 0 ? best_type(request, {"image/x-exr", "image/png", "image/jpeg", "application/json"}) : "application/json";
    KeyInUse in_use(s, request);
    std::string digest;
    if (!in_use.key().empty()) {
        digest = content_digest({{"method", request.method}, {"path", request.segments}, {"body", body}});
        if (const auto known = s.renders.store().remembered(request.user, in_use.key(), wall_seconds() - 86400)) {
            if (known->request_digest != digest) throw Problem{"idempotency-key-reused", ""};
            in_use.release();
            http::Response r;
            if (wait > 0 && s.renders.store().exists(known->render)) {
                r = answer_when_done(s, request, known->render, wait, type, settings.cancel_on_disconnect);
            } else {
                r = http::Response::text(known->status, known->body, "application/json");
                r.set("Location", "/v1/renders/" + known->render);
            }
            r.set("Idempotency-Replayed", "true");
            return r;
        }
    }
    refuse_if_busy(s, request);
    const Accepted a = accept(s, request, body, settings, d);
    http::Response first = accepted_response(a.job, 202);
    const Remembered answer{request.user, in_use.key(), digest, 202, first.body, a.job.id};
    try {
        s.renders.submit(a.job, a.assets, in_use.key().empty() ? nullptr : &answer);
    } catch (const DatabaseError& e) {
        if (a.from_cache) RenderFolder(s.options.data, a.job.id).remove();
        throw Problem{"storage", "the render could not be written"};
    }
    in_use.release();
    if (wait > 0) first = answer_when_done(s, request, a.job.id, wait, type, settings.cancel_on_disconnect);
    if (a.from_cache) first.set("Alder-Cache", "hit");
    return first;
}

http::Response get_renders(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    Query q(request);
    ListFilter filter = read_filter(q);
    q.finish();
    if (!request.sees_all) filter.user = request.user;
    const int limit = filter.limit++;
    auto found = s.renders.list(filter);
    const bool more = static_cast<int>(found.size()) > limit;
    if (more) found.pop_back();
    nlohmann::json items = nlohmann::json::array();
    for (const Job& job : found) items.push_back(job.document());
    return json_response(200, {{"items", std::move(items)}, {"next", more ? nlohmann::json(found.back().id) : nlohmann::json()}});
}

http::Response get_render(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    Job job = visible(s, request);
    const double wait = std::min(wait_of(request), kPollMost);
    if (wait > 0 && none_match_names(request, job.etag()))
        job = s.renders.wait(job.id, wait, [&](const Job& j) { return !none_match_names(request, j.etag()); }, request.client_gone);
    http::Response r;
    if (none_match_names(request, job.etag())) r.status = 304;
    else r = json_response(200, job.document());
    r.set("ETag", job.etag());
    r.set("Cache-Control", "no-cache");
    if (wait > 0) r.set("Preference-Applied", fmt::format("wait={:g}", wait));
    return r;
}

namespace {

/// Changes what may be changed. True where there is more to render.
bool read_change(Members& m, Job& job) {
    m.integer("priority", job.priority, 0, 100);
    m.number("retain", job.retain, 0, 3650.0 * 86400);
    read_labels(m, job.labels);
    bool more = false;
    JobSettings settings;
    if (!m.describes()) {
        Diagnostics unused;
        settings = read_settings(job.request, unused);
    }
    int64_t samples = 0;
    if (m.integer("samples", samples, 1, 1 << 20)) {
        const int64_t had = settings.render.samples > 0 ? settings.render.samples : job.progress.value("samples", int64_t{0});
        if (samples < had) m.fault("samples", "out-of-range", std::to_string(samples), fmt::format("at least {}: samples are only raised", had));
        else if (samples != had) {
            job.request["samples"] = samples;
            more = true;
        }
    }
    m.object("stop", [&](Members& limits) {
        double error = 0, seconds = 0;
        if (limits.number("error", error, 1e-6, 10)) {
            if (settings.render.target_error <= 0 || error > settings.render.target_error) limits.fault("error", "out-of-range", fmt::format("{:g}", error), "a smaller error than the render has now");
            else job.request["stop"]["error"] = error, more = error != settings.render.target_error || more;
        }
        if (limits.number("seconds", seconds, 0.001, 1e7)) {
            if (settings.render.seconds <= 0 || seconds < settings.render.seconds) limits.fault("seconds", "out-of-range", fmt::format("{:g}", seconds), "more seconds than the render has now");
            else job.request["stop"]["seconds"] = seconds, more = seconds != settings.render.seconds || more;
        }
        limits.finish(false);
    });
    m.finish(false);
    return more;
}

}  // namespace

void describe_render_change(Members& m) {
    Job job;
    read_change(m, job);
}
void describe_render(Members& m) {
    JobSettings settings;
    read_settings(m, settings);
}
void describe_renders_query(Query& q) { read_filter(q); }

http::Response patch_render(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const Job before = visible(s, request);
    const nlohmann::json body = s.read_json(request);
    const Job after = s.renders.edit(before.id, [&](Job& job) {
        if (request.header("if-match")) require_match(request, job.etag());
        Diagnostics d;
        Members m(body, "", d);
        const bool more = read_change(m, job);
        if (!d.ok()) throw problem_from("settings-invalid", d);
        if (!more) return false;
        if (job.state == State::Failed || job.state == State::Cancelled) {
            Problem p{"state-conflict", fmt::format("the render is {}: it does not go on", state_name(job.state))};
            p.extra["state"] = state_name(job.state);
            throw p;
        }
        const JobSettings settings = read_settings(job.request, d);
        struct stat info {};
        if (job.state == State::Succeeded && (job.expired || settings.frames.size() > 1 || ::stat(RenderFolder(s.options.data, job.id).checkpoint().c_str(), &info) != 0))
            throw Problem{"not-resumable", "its checkpoint is gone"};
        job.cache_key = result_key(job.snapshot, job.request, settings);
        return true;
    });
    http::Response r = json_response(200, after.document());
    r.set("ETag", after.etag());
    return r;
}

http::Response delete_render(Service& s, http::Request& request) {
    s.renders.remove(visible(s, request).id);
    http::Response r;
    r.status = 204;
    return r;
}

http::Response post_render_cancel(Service& s, http::Request& request) { return json_response(200, s.renders.cancel(visible(s, request).id).document()); }
http::Response post_render_pause(Service& s, http::Request& request) { return json_response(200, s.renders.pause(visible(s, request).id).document()); }
http::Response post_render_resume(Service& s, http::Request& request) { return json_response(200, s.renders.resume(visible(s, request).id).document()); }

http::Response get_render_outputs(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const Job job = visible(s, request);
    return json_response(200, {{"items", job.document()["outputs"]}, {"next", nullptr}});
}

http::Response get_render_output(Service& s, http::Request& request) {
    const Job job = visible(s, request);
    if (job.expired) throw Problem{"expired", "the files of the render have been removed"};
    for (const jobs::Output& o : job.outputs)
        if (o.file == request.parameters["file"]) return output_response(s, request, job, o);
    throw Problem{"not-found", "the render has no such file (yet)"};
}

http::Response get_render_log(Service& s, http::Request& request) {
    best_type(request, {"text/plain"});
    const Job job = visible(s, request);
    http::Response r;
    r.set("Content-Type", "text/plain; charset=utf-8");
    r.set("Cache-Control", "no-cache");
    const int fd = ::open(RenderFolder(s.options.data, job.id).log().c_str(), O_RDONLY | O_CLOEXEC);
    struct stat info {};
    if (fd >= 0 && ::fstat(fd, &info) == 0) r.file = http::FileBody{fd, 0, static_cast<uint64_t>(info.st_size)};
    return r;
}

http::Response get_render_stats(Service& s, http::Request& request) {
    best_type(request, {"application/json"});
    const Job job = visible(s, request);
    return json_response(200, {{"id", job.id}, {"state", state_name(job.state)}, {"attempt", job.attempt}, {"timings", job.timings}, {"stats", job.stats}});
}

namespace {

http::Response snapshot(Service& s, http::Request& request, const std::string& type) {
    const Job job = visible(s, request);
    if (job.expired) throw Problem{"expired", "the files of the render have been removed"};
    if (is_active(job.state))
        if (const auto now = s.renders.snapshot(job.id, 30)) return snapshot_response(s, request, now->file, now->samples, type);
    const Job then = s.renders.get(job.id);   // it may have ended meanwhile
    if (then.outputs.size() == 1) return file_response(s, request, then, then.outputs[0], type);
    throw Problem{"not-found", "there is no picture yet"};
}

}  // namespace

http::Response get_render_snapshot_exr(Service& s, http::Request& request) { return snapshot(s, request, "image/x-exr"); }
http::Response get_render_snapshot_png(Service& s, http::Request& request) { return snapshot(s, request, "image/png"); }
http::Response get_render_snapshot_jpg(Service& s, http::Request& request) { return snapshot(s, request, "image/jpeg"); }

}  // namespace alder
