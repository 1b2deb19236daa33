// Live renders by identifier, and what routes need to edit them.
#include "server/live/live_store.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "render/prepared_scene.h"
#include "server/errors.h"
#include "server/http/door.h"
#include "server/json_patch.h"
#include "server/members.h"

namespace alder::live {
namespace {

constexpr size_t kLiveMost = 64;
constexpr int kStreamsMost = 256;
constexpr int64_t kUnwatchedSeconds = 60;      // asleep, and first to go where there are too many
constexpr int64_t kForgottenSeconds = 3600;   // a live render that nobody names so long is gone
constexpr size_t kPatchedBytesMost = 8 << 20;

int64_t now_seconds() { return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Problem busy(std::string detail) {
    Problem p{"queue-full", std::move(detail)};
    p.headers.emplace_back("Retry-After", "1");
    return p;
}

}  // namespace

LiveStore::LiveStore(Metrics& metrics, jobs::Gate* gate) : metrics_(metrics), turns_(gate), epoch_(http::time_sorted_id()) {}

std::shared_ptr<LiveEntry> LiveStore::add(std::shared_ptr<LiveEntry> entry, LiveSource source, const LiveSettings& settings) {
    std::vector<std::shared_ptr<LiveEntry>> forgotten;   // joined without the lock
    {
        const std::lock_guard lock(mutex_);
        const int64_t now = now_seconds();
        for (auto it = entries_.begin(); it != entries_.end();)
            if (now - it->second->used_at > kForgottenSeconds && !it->second->render->has_readers()) {
                forgotten.push_back(std::move(it->second));
                it = entries_.erase(it);
            } else {
                ++it;
            }
        if (stopping_) throw Problem{"draining", ""};
        if (entries_.size() >= kLiveMost) {   // the one that nobody has looked at or named for longest gives way
            auto oldest = entries_.end();
            for (auto it = entries_.begin(); it != entries_.end(); ++it)
                if (!it->second->render->has_readers() && now - it->second->used_at > kUnwatchedSeconds && (oldest == entries_.end() || it->second->used_at < oldest->second->used_at)) oldest = it;
            if (oldest != entries_.end()) {
                forgotten.push_back(std::move(oldest->second));
                entries_.erase(oldest);
            }
        }
        if (entries_.size() >= kLiveMost) throw busy(fmt::format("there are {} live renders already", entries_.size()));
        const std::string id = "rnd_" + http::time_sorted_id();
        entry->used_at = now;
        entry->render = std::make_shared<LiveRender>(id, std::move(source), settings, turns_, metrics_);
        entries_[id] = entry;
    }
    for (const auto& e : forgotten) e->render->close("cancelled");
    return entry;
}

std::shared_ptr<LiveEntry> LiveStore::find(const std::string& id) {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(id);
    if (it == entries_.end()) return nullptr;
    it->second->used_at = now_seconds();
    return it->second;
}

void LiveStore::remove(const std::string& id) {
    std::shared_ptr<LiveEntry> entry;
    {
        const std::lock_guard lock(mutex_);
        const auto it = entries_.find(id);
        if (it == entries_.end()) return;
        entry = std::move(it->second);
        entries_.erase(it);
    }
    entry->render->close("cancelled");
}

void LiveStore::scene_changed(const std::string& scene, const LiveSource& source, const std::string& token) {
    std::vector<std::shared_ptr<LiveEntry>> followers;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [id, entry] : entries_)
            if (entry->scene == scene) followers.push_back(entry);
    }
    for (const auto& entry : followers) entry->render->edit(source, token);
}

void LiveStore::stop() {
    stopping_ = true;
    std::vector<std::shared_ptr<LiveEntry>> all;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [id, entry] : entries_) all.push_back(entry);
    }
    for (const auto& entry : all) entry->render->close("cancelled");
}

size_t LiveStore::size() const {
    const std::lock_guard lock(mutex_);
    return entries_.size();
}

LiveStore::Stream::Stream(LiveStore& store) : store_(store) {
    if (++store_.streams_ > kStreamsMost) {
        --store_.streams_;
        throw busy(fmt::format("there are {} streams already", kStreamsMost));
    }
}
LiveStore::Stream::~Stream() { --store_.streams_; }

std::string edit_token(const http::Request& request) {
    const std::string* token = request.header("alder-edit-id");
    if (!token) return {};
    const bool fits = !token->empty() && token->size() <= 64 && std::all_of(token->begin(), token->end(), [](char c) { return c > 0x20 && c < 0x7F; });
    if (!fits) throw Problem{"malformed-request", "Alder-Edit-Id has 1 to 64 printable characters"};
    return *token;
}

nlohmann::json patched(const http::Request& request, nlohmann::json current, const nlohmann::json& body) {
    const std::string* type = request.header("content-type");
    if (!type || type->rfind("application/json-patch+json", 0) != 0) {
        current.merge_patch(body);
        return current;
    }
    if (!body.is_array() || body.size() > 1000) throw Problem{"request-invalid", "a JSON Patch is an array of at most 1000 operations"};
    for (size_t i = 0; i < body.size(); ++i) {
        if (!apply_operation(current, body[i])) {
            Problem p{"request-invalid", fmt::format("operation {} of the patch cannot be applied", i)};
            p.faults.errors.push_back({fmt::format("/{}", i), "patch-failed", brief(body[i]),
                                       "an operation of RFC 6902 whose path exists", {}});
            throw p;
        }
        // Copies may double the document each time.
        if (body[i].value("op", "") == "copy" && current.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).size() > kPatchedBytesMost)
            throw Problem{"limit-exceeded", fmt::format("operation {} makes the document larger than {} bytes", i, kPatchedBytesMost)};
    }
    return current;
}

nlohmann::json reused(const PreparedScene& before, const PreparedScene& after) {
    size_t same = 0;
    const size_t n = std::min(before.materials.size(), after.materials.size());
    for (size_t i = 0; i < n; ++i) same += before.materials[i] == after.materials[i];
    const bool geometry = before.surfaces == after.surfaces;
    const size_t meshes = after.surfaces->meshes().size(), built = geometry ? 0 : after.surfaces->accel().meshes_built();
    return {{"geometry", geometry},
            {"meshes", meshes - std::min(built, meshes)},
            {"meshes_built", built},
            {"lights", before.lights == after.lights},
            {"world", before.world == after.world},
            {"materials", same},
            {"materials_compiled", after.materials.size() - same}};
}

}  // namespace alder::live
