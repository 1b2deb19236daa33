// Query: members of a request's query, each known and used once; what is left over is a malformed-request. As Members does, it
// describes itself: the parameters of /v1/openapi.json are written down by the code that reads them.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/http/message.h"

namespace alder {

/// Schema of text in an address: control characters are refused wherever they come.
nlohmann::json plain_text(size_t least = 0);

class Query {
  public:
    explicit Query(const http::Request& request) : request_(&request), used_(request.query.size()) {}
    /// Parameter objects of OpenAPI for what `read` reads.
    static nlohmann::json describing(const std::function<void(Query&)>& read);

    const std::string* find(const std::string& name, const nlohmann::json& schema = plain_text(), bool required = false);
    double number(const std::string& name, double otherwise, double low, double high);
    int64_t integer(const std::string& name, int64_t otherwise, int64_t low, int64_t high, bool required = false);
    std::string choice(const std::string& name, std::string otherwise, const std::vector<std::string>& choices);
    /// Separated by commas.
    std::vector<std::string> list(const std::string& name);
    /// Members whose name begins so: what follows it, and the value.
    std::vector<std::pair<std::string, std::string>> prefixed(const std::string& prefix);
    void finish() const;

  private:
    explicit Query(nlohmann::json& parameters) : parameters_(&parameters) {}
    const http::Request* request_ = nullptr;
    nlohmann::json* parameters_ = nullptr;
    std::vector<bool> used_;
};

}  // namespace alder
