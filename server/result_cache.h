// Finished answers by their tag, least recently used first out, bounded in bytes. Thread safe.
#pragma once
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "server/http/message.h"

namespace alder {

class ResultCache {
  public:
    explicit ResultCache(size_t bytes) : limit_(bytes) {}
    std::optional<http::Response> find(const std::string& tag);
    void keep(const std::string& tag, const http::Response& response);
    size_t bytes() const;

  private:
    struct Entry {
        std::string tag;
        http::Response response;
        size_t bytes;
    };
    mutable std::mutex mutex_;
    size_t limit_, bytes_ = 0;
    std::list<Entry> entries_;   ///< most recent first
    std::unordered_map<std::string, std::list<Entry>::iterator> by_tag_;
};

}  // namespace alder
