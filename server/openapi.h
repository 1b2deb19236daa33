// The description of the interface at /v1/openapi.json, and the routes it is made from.
#pragma once
#include <vector>

#include "server/http/message.h"

namespace alder {

class Service;

/// A route that is served: method, path with {names}, and the scope a token needs.
struct RouteInfo {
    const char* method;
    const char* path;
    unsigned scope;
};
std::vector<RouteInfo> route_list();

http::Response get_openapi(Service&, http::Request&);

}  // namespace alder
