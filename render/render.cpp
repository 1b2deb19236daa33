// Rendering: a progressive render until the samples are taken, the time is up or the error is small enough.
#include "render/render.h"

#include <algorithm>
#include <chrono>

#include "render/progressive.h"

namespace alder {
namespace {

using Clock = ProgressiveRender::Clock;
double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// How much of the next pass is begun in a limited time.
class Schedule {
  public:
    Schedule(double seconds, Clock::time_point start) : seconds_(seconds), start_(start) {}

    /// Samples of a pass of `count`; none where not even one fits.
    uint64_t cut(uint64_t count, bool is_first) const {
        if (seconds_ <= 0) return count;
        if (is_first) return 1;  // the first image of a render with a deadline must come early: 1 sample, then the rest of its leaf
        const double left = seconds_ - seconds_since(start_);
        if (count > kLeafSamples) {
            while (count > kLeafSamples && static_cast<double>(count) * seconds_per_sample_ > 0.5 * left) count /= 2;
            if (count > kLeafSamples) return count;
        }
        const double fits = seconds_per_sample_ > 0 ? left / seconds_per_sample_ : 1e9;
        return fits >= static_cast<double>(count) ? count : static_cast<uint64_t>(std::max(fits, 0.0));
    }
    void took(double seconds, uint64_t samples) { seconds_per_sample_ = seconds / static_cast<double>(samples); }

  private:
    double seconds_, seconds_per_sample_ = 0;
    Clock::time_point start_;
};

}  // namespace

Image render(const PreparedScene& scene, const RenderRequest& request, RenderStats& stats, const std::function<void(double)>& progress) {
    const auto start = Clock::now();
    // The caller's scene outlives the call.
    ProgressiveRender film(std::shared_ptr<const PreparedScene>(std::shared_ptr<const PreparedScene>(), &scene), request);
    Schedule schedule(request.seconds, start);
    if (request.seconds > 0)
        film.set_deadline(start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(request.seconds, 1e8))));
    const uint64_t end = film.planned_samples();
    bool reached_error = false;
    double last = 0;
    while (film.samples() < end && !reached_error) {
        const uint64_t before = film.samples(), count = schedule.cut(film.next_pass(end - before), before == 0);
        if (count == 0) break;
        const auto report = [&](double part) {
            double fraction = (static_cast<double>(before) + part * static_cast<double>(count)) / static_cast<double>(end);
            if (request.seconds > 0) fraction = std::max(fraction, seconds_since(start) / request.seconds);
            fraction = std::min(fraction, 1.0);
            if (fraction > last) progress(last = fraction);
        };
        const auto pass_start = Clock::now();
        if (!film.advance(count, progress ? report : std::function<void(double)>{})) break;
        schedule.took(seconds_since(pass_start), count);
        reached_error = request.target_error > 0 && film.samples() >= 2 * kLeafSamples && film.samples() % kLeafSamples == 0 &&
                        film.estimated_error() <= request.target_error;
    }
    const auto picture = film.picture();
    Image im = picture->image();
    stats = film.stats();
    stats.estimated_error = picture->estimated_error();
    stats.complete = stats.complete || reached_error;
    for (auto& [name, value] : im.attributes)
        if (name == "alder/complete") value = stats.complete ? "1" : "0";
    stats.render_seconds = seconds_since(start);
    if (progress && stats.complete) progress(1);
    return im;
}

}  // namespace alder
