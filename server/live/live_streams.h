// Streams of a live render: events, pictures for an <img>, whole EXRs, tiles. Each runs on its client's own thread and takes the
// newest there is whenever the client has taken the last: a slow reader sees fewer pictures.
#pragma once
#include <memory>

#include "render/image/view.h"
#include "server/live/live_store.h"
#include "server/query.h"

namespace alder {
class Service;
}

namespace alder::live {

http::Response events_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry);
http::Response preview_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry);
http::Response exr_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry);
http::Response tile_stream(Service& s, http::Request& request, const std::shared_ptr<LiveEntry>& entry);

/// aov, exposure, transform, quality: how pictures for screens are asked for.
View query_view(Query& q);
/// The frame's picture as a file of this type, at full resolution; throws settings-invalid where it has no such layer.
std::string encode_frame(const Frame& frame, const std::string& type, const View& view, int side);

}  // namespace alder::live
