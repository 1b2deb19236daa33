// Settings of a render: the body of POST /v1/renders, read and checked the same way by the daemon before it accepts the job
// and by the worker that renders it.
#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "render/image/exr.h"
#include "render/render.h"
#include "server/members.h"

namespace alder::jobs {

struct JobSettings {
    std::string scene, camera;
    RenderRequest render;
    ExrOptions exr;
    std::string name;                ///< of output files; may have %04d
    bool has_frames = false;
    std::vector<int> frames{0};      ///< in order; one where none was asked for
    int min_samples = 0;
    nlohmann::json overrides;        ///< RFC 6902 operations on the scene; null: none
    int64_t priority = 50;
    double retain = -1;              ///< seconds; < 0: the daemon's
    nlohmann::json labels = nlohmann::json::object();
    bool lenient = false, strict = false, cancel_on_disconnect = false;

    std::string file_name(int frame) const;
    /// Seed of a frame: each has noise of its own; a render without frames has the request's.
    uint32_t frame_seed(int frame, uint32_t scene_seed) const;
    /// Whether equal requests have equal results: nothing stops it by the clock.
    bool is_deterministic() const { return render.seconds <= 0; }
};

inline constexpr double kWaitMost = 3600;

JobSettings read_settings(const nlohmann::json& body, Diagnostics& d);
void read_settings(Members& m, JobSettings& settings);
/// "1-48", "1-9x2,20": ascending, without repetition. Empty where it is not one or has more than `most`.
std::vector<int> parse_frames(const std::string& text, size_t most);
/// The member "labels" of a body or PATCH.
void read_labels(Members& m, nlohmann::json& out);
/// Bytes that rendering needs for pixels: film, checkpoint and image, from above.
uint64_t film_bytes(const JobSettings& settings, int width, int height, const std::vector<std::string>& graph_aovs);

}  // namespace alder::jobs
