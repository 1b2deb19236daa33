// Rendering one job: its frames one after the other, with checkpoints.
//
// A checkpoint is one line of JSON (what it is of) and the film's tree of sums. Because sums are added in one order whatever
// the cuts, a render that goes on from a checkpoint gives the same bits as one that was never disturbed; so the samples at
// which the error is looked at are a function of their number alone, never of the clock.
#include "server/jobs/render_job.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <streambuf>

#include <fmt/format.h>

#include "render/prepared_scene.h"
#include "render/progressive.h"
#include "render/programs.h"
#include "server/build_id.h"
#include "server/digest.h"
#include "server/errors.h"
#include "server/picture.h"

namespace alder::jobs {
namespace {

constexpr double kChunkSeconds = 0.5;       // of rendering between looks at stops, snapshots and checkpoints
constexpr double kProgressSeconds = 0.25;

double since(std::chrono::steady_clock::time_point t) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count(); }

/// The next number of samples at which the error decides: 32, then an eighth more each time, whole leaves.
uint64_t next_error_check(uint64_t samples) {
    uint64_t at = 2 * kLeafSamples;
    while (at <= samples) at += std::max<uint64_t>(kLeafSamples, at / 8 / kLeafSamples * kLeafSamples);
    return at;
}

/// std::ostream over a file descriptor that remembers the first error.
class FdBuffer : public std::streambuf {
  public:
    explicit FdBuffer(int fd) : fd_(fd), buffer_(256 << 10) { setp(buffer_.data(), buffer_.data() + buffer_.size()); }
    int error() const { return error_; }
    int flush_all() {
        sync();
        return error_;
    }

  protected:
    int overflow(int c) override {
        if (sync() != 0) return traits_type::eof();
        if (c != traits_type::eof()) sputc(static_cast<char>(c));
        return traits_type::not_eof(c);
    }
    int sync() override {
        if (!error_) error_ = write_all(fd_, {pbase(), static_cast<size_t>(pptr() - pbase())});
        setp(buffer_.data(), buffer_.data() + buffer_.size());
        return error_ ? -1 : 0;
    }

  private:
    int fd_;
    std::vector<char> buffer_;
    int error_ = 0;
};

/// The prepared scene seen through another of its cameras.
std::shared_ptr<const PreparedScene> through_camera(const std::shared_ptr<const PreparedScene>& prepared, const std::string& name) {
    const Scene& scene = *prepared->scene;
    if (name.empty() || scene.camera.name == name) return prepared;
    const auto it = std::find_if(scene.other_cameras.begin(), scene.other_cameras.end(), [&](const Camera& c) { return c.name == name; });
    if (it == scene.other_cameras.end()) return nullptr;
    auto seen = std::make_shared<Scene>(scene);
    seen->camera = *it;
    auto other = std::make_shared<PreparedScene>(*prepared);
    other->scene = std::move(seen);
    return other;
}

}  // namespace

RenderJob::RenderJob(WorkerContext& context, const nlohmann::json& order)
    : context_(context), id_(order.at("id").get<std::string>()), snapshot_(order.at("snapshot").get<std::string>()), request_(order.at("request")),
      done_(order.at("done")), folder_(context.data, id_), last_checkpoint_(begun_), last_progress_(begun_) {
    Diagnostics d;
    settings_ = read_settings(request_, d);
    settings_.render.threads = context.engine.threads();
}

void RenderJob::stop(const std::string& how) {
    const std::lock_guard lock(mutex_);
    if (how_.empty() || how == "cancel") how_ = how;
    cancel_ = true;
}

void RenderJob::want_snapshot(int64_t ticket) {
    const std::lock_guard lock(mutex_);
    tickets_.push_back(ticket);
}

void RenderJob::log(const char* level, const std::string& text) const { append_log(folder_.log(), level, text); }

void RenderJob::tell(const char* is, nlohmann::json more) {
    more["is"] = is;
    more["id"] = id_;
    context_.send(more);
}

void RenderJob::state(const char* name) { tell("state", {{"state", name}, {"timings", timings_}}); }

void RenderJob::tell_progress(double samples, double total, double error, bool now) {
    if (!now && since(last_progress_) < kProgressSeconds) return;
    last_progress_ = Clock::now();
    const double frames = static_cast<double>(settings_.frames.size());
    const double part = total > 0 ? std::min(samples / total, 1.0) : 0;
    const double fraction = std::min((static_cast<double>(frames_done_) + part) / frames, 1.0);
    const double spent = elapsed_ + since(begun_);
    nlohmann::json j = {{"fraction", fraction}, {"samples", static_cast<int64_t>(samples)}, {"frames_done", frames_done_}, {"frames", settings_.frames.size()},
                        {"eta", part > 0 ? nlohmann::json(spent * (1 - part) / part + spent / part * (frames - 1 - static_cast<double>(frames_done_))) : nlohmann::json()}};
    j["estimated_error"] = error > 0 ? nlohmann::json(error) : nlohmann::json();
    tell("progress", {{"progress", std::move(j)}});
}

void RenderJob::run() {
    try {
        if (const int error = folder_.prepare()) {
            if (is_no_space(error)) throw NoSpace{1 << 20};
            throw Failed{"storage", "the folder of the render cannot be made"};
        }
        log("info", fmt::format("begun by alderd {} ({})", ALDER_VERSION, build_id()));
        prepare();
        for (const int frame : settings_.frames) {
            const bool written = std::any_of(done_.begin(), done_.end(), [&](const auto& f) { return f == frame; });
            if (!written) render_frame(frame);
            ++frames_done_;
        }
        if (stats_.is_null()) stats_ = nlohmann::json::object();
        log("info", "succeeded");
        tell("done", {{"stats", stats_}, {"timings", timings_}});
    } catch (const Stopped&) {
        std::string how;
        {
            const std::lock_guard lock(mutex_);
            how = how_;
        }
        log("info", "stopped: " + how);
        tell("stopped", {{"how", how}});
    } catch (const NoSpace& missing) {
        log("error", fmt::format("the disk is full: there is no room for {} bytes", missing.bytes));
        tell("paused", {{"reason", "disk-full"}, {"bytes", missing.bytes}});
    } catch (const Failed& f) {
        log("error", f.type + ": " + f.detail);
        tell("failed", {{"type", f.type}, {"detail", f.detail}, {"errors", f.errors}});
    } catch (const Problem& p) {
        log("error", p.type + ": " + p.detail);
        nlohmann::json errors = to_json(p.faults.errors);
        tell("failed", {{"type", p.type}, {"detail", p.detail}, {"errors", std::move(errors)}});
    }
    answer_snapshot(nullptr);
}

void RenderJob::prepare() {
    state("preparing");
    const auto loading = Clock::now();
    std::vector<uint8_t> text;
    std::ifstream file(context_.assets.path(digest_hex(snapshot_)), std::ios::binary);
    const auto document = nlohmann::json::parse(file, nullptr, false);
    if (!document.is_object()) throw Failed{"asset-unreadable", "the revision of the scene is not in the store any more"};
    const auto revision = revision_from_json(snapshot_, document);
    Diagnostics d;
    const auto loaded = context_.scenes.load(context_.engine, context_.assets, *revision, d);
    if (settings_.strict) require_files(*loaded->scene, d);
    if (!d.ok()) throw problem_from("scene-invalid", d);
    prepared_ = through_camera(loaded->prepared, settings_.camera);
    if (!prepared_) throw Failed{"settings-invalid", "the scene has no camera '" + settings_.camera + "'"};
    scene_seed_ = loaded->scene->settings.seed;
    nlohmann::json warnings = nlohmann::json::array();
    for (const auto& w : loaded->scene->warnings) warnings.push_back(w);
    for (const auto& w : d.warnings) {
        log("warn", w.line());
        warnings.push_back(w.line());
    }
    timings_["load"] = since(loading);
    timings_["build"] = prepared_->build_seconds;
    timings_["compile"] = prepared_->compile_seconds;
    tell("state", {{"state", "preparing"}, {"timings", timings_}, {"warnings", warnings}});
    if (cancel_) throw Stopped{};
}

void RenderJob::render_frame(int frame) {
    RenderRequest request = settings_.render;
    request.seed = settings_.frame_seed(frame, scene_seed_);
    request.cancel = &cancel_;
    request.seconds = 0;
    request.target_error = 0;
    ProgressiveRender r(prepared_, request);
    elapsed_ = 0;
    begun_ = last_checkpoint_ = Clock::now();
    resume(r, frame);
    const uint64_t planned = r.planned_samples();
    const double target = settings_.render.target_error, most_seconds = settings_.render.seconds;
    const uint64_t at_least = std::max<uint64_t>({2 * kLeafSamples, static_cast<uint64_t>(settings_.min_samples)});
    uint64_t checkpoint_at = r.samples() + std::max<uint64_t>(1, static_cast<uint64_t>(static_cast<double>(planned) * context_.checkpoint_fraction));
    double error = 0, seconds_per_sample = 0;
    bool reached = false, out_of_time = false;
    state("rendering");
    while (r.samples() < planned && !reached && !out_of_time) {
        const uint64_t before = r.samples();
        uint64_t count = planned - before;
        if (target > 0) count = std::min(count, next_error_check(before) - before);
        // Short of a node of the tree where that would take long: sums of an unfinished leaf or node are kept as well.
        count = std::min(count, r.next_pass(count));
        if (seconds_per_sample > 0) count = std::clamp<uint64_t>(static_cast<uint64_t>(kChunkSeconds / seconds_per_sample), 1, count);
        else count = std::min<uint64_t>(count, kLeafSamples);
        const auto start = Clock::now();
        const bool whole = r.advance(count, [&](double part) { tell_progress(static_cast<double>(before) + part * static_cast<double>(count), static_cast<double>(planned), error, false); });
        if (r.samples() > before) {
            seconds_per_sample = since(start) / static_cast<double>(r.samples() - before);
            if (first_image_ == 0) timings_["first_image"] = first_image_ = std::max(since(begun_), 1e-6);
        }
        answer_snapshot(&r);
        if (cancel_ || !whole) {
            bool keep = true;
            {
                const std::lock_guard lock(mutex_);
                keep = how_ != "cancel";
            }
            if (keep) put_away(r, frame, true);
            throw Stopped{};
        }
        if (target > 0 && r.samples() == next_error_check(r.samples() - 1)) {
            error = r.estimated_error();
            reached = r.samples() >= at_least && error <= target;
        }
        out_of_time = most_seconds > 0 && elapsed_ + since(begun_) >= most_seconds && r.samples() >= static_cast<uint64_t>(settings_.min_samples);
        if (r.samples() >= checkpoint_at && since(last_checkpoint_) >= context_.checkpoint_seconds && r.samples() < planned) {
            const auto begun = Clock::now();
            put_away(r, frame, true);
            const double spent = since(begun);
            checkpoint_at = r.samples() + std::max<uint64_t>(1, static_cast<uint64_t>(static_cast<double>(planned) * context_.checkpoint_fraction));
            tell("checkpoint", {{"samples", r.samples()}, {"seconds", spent}});
        }
    }
    render_seconds_ += since(begun_);
    timings_["render"] = render_seconds_;
    write_output(r, frame, r.samples() >= planned || reached);
    if (settings_.frames.size() == 1) put_away(r, frame, false);   // what more samples could go on from
    else ::unlink(folder_.checkpoint().c_str());
}

void RenderJob::resume(ProgressiveRender& r, int frame) {
    std::ifstream file(folder_.checkpoint(), std::ios::binary);
    if (!file) return;
    std::string line, why = "its head is damaged";
    if (std::getline(file, line) && line.size() < (1 << 20)) {
        const auto head = nlohmann::json::parse(line, nullptr, false);
        if (head.is_object() && head.value("frame", -1) == frame && head.value("snapshot", "") == snapshot_ && head.value("build", "") == build_id()) {
            if (r.load(file, why)) {
                elapsed_ = head.value("elapsed", 0.0);
                log("info", fmt::format("frame {} goes on after {} samples", frame, r.samples()));
                return;
            }
        } else if (head.is_object()) {
            why = "it is of another frame, scene or version";
        }
    }
    log("warn", "the checkpoint is not used: " + why);
}

void RenderJob::put_away(const ProgressiveRender& r, int frame, bool durable) {
    const auto start = Clock::now();
    const nlohmann::json head = {{"frame", frame}, {"snapshot", snapshot_}, {"build", build_id()}, {"elapsed", elapsed_ + since(begun_)}, {"samples", r.samples()}};
    const auto write = [&](int fd) {
        FdBuffer buffer(fd);
        std::ostream out(&buffer);
        out << head.dump() << '\n';
        r.save(out);
        out.flush();
        return buffer.flush_all();
    };
    const int error = write_whole(folder_.checkpoint(), write);
    last_checkpoint_ = Clock::now();
    // Without a checkpoint the result is the same, only later: the render goes on.
    if (error && durable) log("warn", fmt::format("no checkpoint: {}", std::generic_category().message(error)));
    else if (!error) log("debug", fmt::format("checkpoint after {} samples, {:.3f} s", r.samples(), since(start)));
}

void RenderJob::write_output(ProgressiveRender& r, int frame, bool complete) {
    state("writing");
    const RenderStats stats = r.stats();
    if (settings_.strict && stats.nonfinite_samples > 0)
        throw Failed{"nonfinite", fmt::format("{} samples were not finite numbers", stats.nonfinite_samples)};
    if (settings_.strict) {   // a file may turn out broken in the middle, once its tiles are read
        Diagnostics d;
        require_files(*prepared_->scene, d);
        if (!d.ok()) throw problem_from("scene-invalid", d);
    }
    Image image = r.image();
    for (auto& [name, value] : image.attributes)
        if (name == "alder/complete") value = complete ? "1" : "0";
    std::string error;
    const std::vector<uint8_t> bytes = encode_exr(image, settings_.exr, error);
    if (bytes.empty()) throw Failed{"internal", error};
    const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string name = settings_.file_name(frame);
    if (const int code = write_whole(folder_.output(name), view)) {
        if (is_no_space(code)) {
            put_away(r, frame, true);
            throw NoSpace{bytes.size()};
        }
        throw Failed{"storage", fmt::format("the result cannot be written: {}", std::generic_category().message(code))};
    }
    stats_ = stats_json(stats);
    stats_["complete"] = complete;
    nlohmann::json layers = nlohmann::json::array();
    for (const Layer& layer : image.layers) layers.push_back(layer.name.empty() ? "rgba" : layer.name);
    tell("output", {{"file", name}, {"frame", frame}, {"bytes", bytes.size()}, {"digest", "sha256:" + sha256_hex(view)}, {"layers", std::move(layers)}, {"complete", complete},
                    {"samples", stats.samples}, {"estimated_error", stats.estimated_error}, {"width", image.width}, {"height", image.height}});
    log("info", fmt::format("{}: {} samples, estimated error {:.4g}", name, stats.samples, stats.estimated_error));
}

void RenderJob::answer_snapshot(const ProgressiveRender* r) {
    std::vector<int64_t> tickets;
    {
        const std::lock_guard lock(mutex_);
        tickets.swap(tickets_);
    }
    if (tickets.empty()) return;
    std::string file, error;
    uint64_t samples = 0;
    if (r && r->samples() > 0) {
        const Image image = r->image();
        samples = r->samples();
        file = folder_.root + "/snapshot.exr";
        if (!write_exr(file, image, settings_.exr, error)) file.clear();
    }
    for (const int64_t ticket : tickets) tell("snapshot", {{"ticket", ticket}, {"file", file}, {"samples", samples}});
}

}  // namespace alder::jobs
