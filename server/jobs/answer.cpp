// Answers with what a render has made.
#include "server/jobs/answer.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>

#include <fmt/format.h>

#include "render/image/exr.h"
#include "render/image/view.h"
#include "server/digest.h"
#include "server/jobs/files.h"
#include "server/negotiate.h"
#include "server/picture.h"

namespace alder::jobs {
namespace {

std::string samples_of(const Job& job) { return std::to_string(job.progress.value("samples", int64_t{0})); }

http::Response shown(Service& s, http::Request& request, const std::string& path, const std::string& type) {
    http::Response r;
    s.run(s.compile_lane, request, 0, [&](const std::atomic<bool>&) {
        std::string error;
        const auto image = read_exr(path, error);
        if (!image) throw Problem{"expired", "the file of the render is not there any more"};
        const std::vector<uint8_t> bytes = type == "image/png" ? encode_png(*image, View{}, error) : encode_jpeg(*image, View{}, error);
        if (bytes.empty()) throw Problem{"settings-invalid", error};
        r = http::Response::text(200, std::string(bytes.begin(), bytes.end()), type);
    });
    r.set("Vary", "Accept");
    return r;
}

}  // namespace

http::Response output_response(Service& s, http::Request& request, const Job& job, const Output& o) {
    const std::string path = RenderFolder(s.options.data, job.id).output(o.file), etag = "\"" + o.digest + "\"";
    http::Response r;
    r.set("ETag", etag);
    r.set("Cache-Control", "private, no-cache");
    if (request.method != "POST" && none_match_names(request, etag)) {
        r.status = 304;
        return r;
    }
    r.set("Content-Type", "image/x-exr");
    r.set("Accept-Ranges", "bytes");
    r.set("Content-Disposition", fmt::format("attachment; filename=\"{}\"", o.file));
    r.set("Alder-Samples", samples_of(job));
    r.set("Alder-Warnings", std::to_string(job.warnings.size()));
    const auto range = request.method == "POST" ? std::nullopt : byte_range(request, o.bytes, etag);
    if (range) {
        r.status = 206;
        r.set("Content-Range", fmt::format("bytes {}-{}/{}", range->first, range->first + range->length - 1, o.bytes));
    } else {
        r.set("Content-Digest", digest_header(digest_hex(o.digest)));
    }
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw Problem{"expired", "the file of the render is not there any more"};
    r.file = range ? http::FileBody{fd, range->first, range->length} : http::FileBody{fd, 0, o.bytes};
    return r;
}

http::Response file_response(Service& s, http::Request& request, const Job& job, const Output& o, const std::string& type) {
    if (type == "image/x-exr") return output_response(s, request, job, o);
    http::Response r = shown(s, request, RenderFolder(s.options.data, job.id).output(o.file), type);
    r.set("Alder-Samples", samples_of(job));
    r.set("Alder-Warnings", std::to_string(job.warnings.size()));
    return r;
}

http::Response snapshot_response(Service& s, http::Request& request, const std::string& path, uint64_t samples, const std::string& type) {
    http::Response r;
    if (type == "image/x-exr") {
        const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
        struct stat info {};
        if (fd < 0 || ::fstat(fd, &info) != 0) throw Problem{"not-found", "there is no picture yet"};
        r.set("Content-Type", type);
        r.file = http::FileBody{fd, 0, static_cast<uint64_t>(info.st_size)};
    } else {
        r = shown(s, request, path, type);
    }
    r.set("Cache-Control", "no-store");
    r.set("Alder-Samples", std::to_string(samples));
    return r;
}

http::Response result_response(Service& s, http::Request& request, const Job& job, const std::string& type) {
    if (job.state == State::Failed || job.state == State::Cancelled) {
        Problem p{"cancelled", "the render was cancelled"};
        if (job.state == State::Failed) {
            const std::string kind = job.problem.value("type", "/problems/internal");
            p = Problem{kind.substr(kind.rfind('/') + 1), job.problem.value("detail", "")};
            if (job.problem.contains("errors")) p.extra["errors"] = job.problem["errors"];
        }
        p.extra["render"] = job.id;
        throw p;
    }
    if (type != "application/json" && job.outputs.size() == 1) {
        http::Response r = file_response(s, request, job, job.outputs[0], type);
        std::string timing;
        for (const auto& [name, seconds] : job.timings.items())
            if (seconds.is_number()) timing += fmt::format("{}{};dur={:.3f}", timing.empty() ? "" : ", ", name, seconds.get<double>() * 1e3);
        if (!timing.empty()) r.set("Server-Timing", timing);
        return r;
    }
    nlohmann::json j = job.document();
    j["stats"] = job.stats;
    http::Response r = json_response(200, j);
    r.set("ETag", job.etag());
    r.set("Alder-Samples", samples_of(job));
    return r;
}

}  // namespace alder::jobs
