// Finished answers by their tag.
#include "server/result_cache.h"

namespace alder {

std::optional<http::Response> ResultCache::find(const std::string& tag) {
    const std::lock_guard lock(mutex_);
    const auto it = by_tag_.find(tag);
    if (it == by_tag_.end()) return std::nullopt;
    entries_.splice(entries_.begin(), entries_, it->second);
    return it->second->response;
}

void ResultCache::keep(const std::string& tag, const http::Response& response) {
    const size_t bytes = response.body.size() + 512;   // headers and bookkeeping, roughly
    const std::lock_guard lock(mutex_);
    if (bytes > limit_ / 4 || by_tag_.count(tag)) return;
    entries_.push_front({tag, response, bytes});
    by_tag_[tag] = entries_.begin();
    for (bytes_ += bytes; bytes_ > limit_; entries_.pop_back()) {
        bytes_ -= entries_.back().bytes;
        by_tag_.erase(entries_.back().tag);
    }
}

size_t ResultCache::bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
}

}  // namespace alder
