// GET /v1/renders/{id}/events of renders that are jobs: what happens, as server-sent events.
#include <memory>

#include <fmt/format.h>

#include "server/jobs/visible.h"
#include "server/negotiate.h"
#include "server/routes.h"
#include "server/service.h"

namespace alder {
namespace {

constexpr double kCommentSeconds = 10;   // so that both sides know that the other is there

std::string event(const std::string& id, const char* name, const nlohmann::json& data) {
    return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", id, name, data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

http::Response get_render_events(Service& s, http::Request& request) {
    best_type(request, {"text/event-stream"});
    const std::string id = jobs::visible(s, request).id;
    http::Response r;
    r.stream_type = "text/event-stream";
    r.set("Cache-Control", "no-store");
    r.set("X-Accel-Buffering", "no");
    // A stream begins with the whole document, also after a reconnect: there is nothing that could have been missed.
    r.stream = [&s, id, counted = std::make_shared<live::LiveStore::Stream>(s.live), gone = request.client_gone](const http::StreamWriter& write) {
        if (!write("retry: 1000\n\n")) return;
        std::string state, reason, seen;
        uint64_t sequence = 0;
        const auto next_id = [&] { return fmt::format("{}.{}", s.live.epoch(), ++sequence); };
        jobs::Job job;
        try {
            for (bool first = true;; first = false) {
                job = first ? s.renders.get(id) : s.renders.wait(id, kCommentSeconds, [&](const jobs::Job& j) { return j.etag() != seen; }, gone);
                const bool same = job.etag() == seen;
                seen = job.etag();
                bool open = true;
                if (same) {
                    open = write(": still here\n\n");
                } else if (state != jobs::state_name(job.state) || reason != job.reason) {
                    state = jobs::state_name(job.state);
                    reason = job.reason;
                    open = write(event(next_id(), "state", job.document()));
                } else {
                    nlohmann::json progress = job.progress;
                    progress["outputs"] = job.outputs.size();
                    open = write(event(next_id(), "progress", progress));
                }
                if (!open) return;
                if (jobs::is_terminal(job.state) || s.draining) break;
            }
            write(event(next_id(), "end", {{"state", jobs::state_name(job.state)}}));
        } catch (const Problem&) {   // it has been removed
            write(event(next_id(), "end", {{"state", "removed"}}));
        } catch (const std::exception&) {   // the store cannot be read: the client will ask again
        }
    };
    return r;
}

}  // namespace alder
