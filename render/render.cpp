// Rendering: passes over the tiles of an image until the samples are taken, the time is up or the error is small enough.
#include "render/render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>

#include "render/film.h"
#include "render/render_plan.h"
#include "render/worker.h"

namespace alder {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Samples taken by all pixels in one go: an aligned run of whole leaves, or a part of one leaf.
struct Pass {
    uint64_t first = 0, count = 0;
    bool ends_leaf = true;  ///< the leaf is complete with it, or no more samples of it will come
    bool whole() const { return count % kLeafSamples == 0 && first % kLeafSamples == 0; }
};

class Renderer {
  public:
    Renderer(const PreparedScene& scene, const RenderRequest& request, RenderStats& stats, const std::function<void(double)>& progress)
        : scene_(scene), request_(request), stats_(stats), progress_(progress), plan_(scene, request),
          pixels_(size_t(plan_.width) * plan_.height), film_(*plan_.aovs, pixels_), first_(request.sample_offset),
          end_(request.sample_offset + static_cast<uint64_t>(plan_.settings.samples)), next_(first_) {
        const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
        threads_ = request.threads > 0 ? std::min(request.threads, 1024) : cores;
        if (threads_ > cores) more_threads_.emplace(tbb::global_control::max_allowed_parallelism, threads_);
    }

    Image run() {
        tbb::task_arena arena(threads_);
        while (next_ < end_ && !plan_.stopped()) {
            const Pass pass = next_pass();
            if (pass.count == 0) break;
            const double before = seconds_since(start_);
            const bool done = arena.execute([&] { return run_pass(pass); });
            if (!done && film_.samples() + open_samples_ > 0) break;  // an unfinished pass is dropped
            finish_pass(pass);
            seconds_per_sample_ = (seconds_since(start_) - before) / static_cast<double>(pass.count);
            if (request_.target_error > 0 && film_.samples() >= 2 * kLeafSamples && error() <= request_.target_error) {
                reached_error_ = true;
                break;
            }
        }
        close_open_leaf();
        return image();
    }

  private:
    /// The longest aligned run of leaves that starts here and fits the samples, the schedule and the time.
    Pass next_pass() {
        const uint64_t in_leaf = next_ % kLeafSamples, left = end_ - next_;
        if (in_leaf != 0 || left < kLeafSamples) {
            const uint64_t count = std::min(kLeafSamples - in_leaf, left);
            return timed(next_, count);
        }
        // The first image of a render with a deadline must come early: 1 sample, then the rest of its leaf.
        if (request_.seconds > 0 && next_ == first_) return {next_, 1, false};
        const uint64_t leaf = next_ / kLeafSamples, done = film_.samples() / kLeafSamples;
        uint64_t leaves = std::bit_floor(left / kLeafSamples);
        if (leaf != 0) leaves = std::min(leaves, leaf & (~leaf + 1));  // aligned: a node of the tree
        // What a stop may throw away is bounded by a part of what is done; a large film keeps fewer unmerged nodes instead.
        const bool large = pixels_ * plan_.aovs->film_row() * sizeof(float) > (size_t{256} << 20);
        leaves = std::min(leaves, std::bit_floor(std::max<uint64_t>(1, large ? done : done / 4)));
        if (request_.seconds > 0)
            while (leaves > 1 && static_cast<double>(leaves * kLeafSamples) * seconds_per_sample_ > 0.5 * time_left()) leaves /= 2;
        if (leaves == 1) return timed(next_, kLeafSamples);
        return {next_, leaves * kLeafSamples, true};
    }

    /// Cut to the time that is left; none where not even one sample fits.
    Pass timed(uint64_t first, uint64_t count) const {
        const bool reaches_end = (first + count) % kLeafSamples == 0 || first + count == end_;
        if (request_.seconds <= 0 || seconds_per_sample_ <= 0) return {first, count, reaches_end};
        const double fits = time_left() / seconds_per_sample_;
        if (fits >= static_cast<double>(count)) return {first, count, reaches_end};
        return {first, static_cast<uint64_t>(std::max(fits, 0.0)), false};
    }

    double time_left() const { return request_.seconds - seconds_since(start_); }

    std::vector<Tile> tiles(uint64_t samples_at_once) const {
        // Some thousand paths at once fill batches and still fit the second-level cache; small images are cut finer, so that
        // every thread has work.
        int edge = 64;
        while (edge > 4 && (uint64_t(edge) * edge * samples_at_once > 4096 ||
                            uint64_t(plan_.width) * plan_.height < uint64_t(edge) * edge * 4 * threads_))
            edge /= 2;
        std::vector<Tile> list;
        for (int y = 0; y < plan_.height; y += edge)
            for (int x = 0; x < plan_.width; x += edge)
                list.push_back({x, y, std::min(x + edge, plan_.width), std::min(y + edge, plan_.height)});
        return list;
    }

    bool run_pass(const Pass& pass) {
        const std::vector<Tile> list = tiles(std::min<uint64_t>(pass.count, kLeafSamples));
        const size_t doubles = LeafSum(*plan_.aovs).size();
        opens_leaf_ = !pass.whole() && pass.first % kLeafSamples != 0 && film_.has_open_leaf();
        if (!pass.whole() && !pass.ends_leaf) open_next_.resize(pixels_ * doubles);
        film_.pass_rows();
        std::atomic<size_t> finished{0};
        tbb::parallel_for(tbb::blocked_range<size_t>(0, list.size(), 1), [&](const tbb::blocked_range<size_t>& r) {
            for (size_t i = r.begin(); i < r.end(); ++i) {
                check_time();
                if (plan_.stopped()) return;
                if (!run_tile(worker(), list[i], pass)) return;
                report(pass, static_cast<double>(++finished) / static_cast<double>(list.size()));
            }
        }, tbb::simple_partitioner());
        return finished == list.size();
    }

    bool run_tile(Worker& w, const Tile& tile, const Pass& pass) {
        const size_t stride = plan_.aovs->film_row(), n = tile.pixels();
        while (w.leaf_sums.size() < n) w.leaf_sums.emplace_back(*plan_.aovs);
        const std::span<LeafSum> sums(w.leaf_sums.data(), n);
        if (!pass.whole()) return run_part(w, tile, pass, sums);
        const uint64_t first_leaf = pass.first / kLeafSamples, leaves = pass.count / kLeafSamples;
        auto& levels = w.tree_rows;
        std::vector<float>* top = nullptr;
        for (uint64_t k = 0; k < leaves; ++k) {
            for (LeafSum& s : sums) s.clear();
            if (!w.trace(tile, (first_leaf + k) * kLeafSamples, kLeafSamples, sums)) return false;
            // A binary counter of nodes: leaf k closes as many levels as k has trailing ones.
            const size_t height = std::countr_one(k);
            while (levels.size() <= height) levels.emplace_back();
            levels[height].resize(std::max(levels[height].size(), n * stride));
            std::vector<float>& to = levels[height];
            for (size_t i = 0; i < n; ++i) {
                float* const row = to.data() + i * stride;
                scratch(w).resize(stride);
                float* const sum = scratch(w).data();
                sums[i].finish((first_leaf + k) & 1, kLeafSamples, sum);
                for (size_t level = 0; level < height; ++level) combine_rows(*plan_.aovs, levels[level].data() + i * stride, sum, sum);
                std::copy(sum, sum + stride, row);
            }
            top = &to;
        }
        store(tile, *top);
        return true;
    }

    /// Part of a leaf: its double sums wait in the film until the leaf is full.
    bool run_part(Worker& w, const Tile& tile, const Pass& pass, std::span<LeafSum> sums) {
        const size_t stride = plan_.aovs->film_row(), n = tile.pixels(), doubles = sums[0].size();
        std::vector<double>* const open = opens_leaf_ ? &film_.open_leaf(doubles) : nullptr;
        for (size_t i = 0; i < n; ++i) {
            if (open) sums[i].load(open->data() + pixel(tile, i) * doubles);
            else sums[i].clear();
        }
        if (!w.trace(tile, pass.first, static_cast<uint32_t>(pass.count), sums)) return false;
        if (!pass.ends_leaf) {
            for (size_t i = 0; i < n; ++i) sums[i].store(open_next_.data() + pixel(tile, i) * doubles);
            return true;
        }
        std::vector<float>& rows = scratch(w);
        rows.resize(n * stride);
        const uint32_t samples = static_cast<uint32_t>(open_samples_ + pass.count);
        for (size_t i = 0; i < n; ++i) sums[i].finish((pass.first / kLeafSamples) & 1, samples, rows.data() + i * stride);
        store(tile, rows);
        return true;
    }

    static std::vector<float>& scratch(Worker& w) { return w.scratch_row; }
    size_t pixel(const Tile& tile, size_t i) const {
        const size_t width = tile.x1 - tile.x0;
        return (tile.y0 + i / width) * plan_.width + tile.x0 + i % width;
    }
    void store(const Tile& tile, const std::vector<float>& rows) {
        const size_t stride = plan_.aovs->film_row();
        float* const to = film_.pass_rows().data();
        for (int i = 0; i < tile.pixels(); ++i)
            std::copy(rows.data() + i * stride, rows.data() + (i + 1) * stride, to + pixel(tile, i) * stride);
    }

    void finish_pass(const Pass& pass) {
        next_ = pass.first + pass.count;
        if (!pass.whole() && !pass.ends_leaf) {
            film_.open_leaf(LeafSum(*plan_.aovs).size()).swap(open_next_);
            open_samples_ += pass.count;
            return;
        }
        if (pass.whole()) {
            film_.commit(pass.first / kLeafSamples, pass.count / kLeafSamples, pass.count);
        } else {
            film_.commit(pass.first / kLeafSamples, 1, open_samples_ + pass.count);
            film_.close_leaf();
            open_samples_ = 0;
        }
    }

    /// Stopped inside a leaf: what it has is a leaf of its own.
    void close_open_leaf() {
        if (open_samples_ == 0) return;
        LeafSum sum(*plan_.aovs);
        const std::vector<double>& open = film_.open_leaf(sum.size());
        std::vector<float>& rows = film_.pass_rows();
        const uint64_t leaf = (next_ - 1) / kLeafSamples;
        for (size_t i = 0; i < pixels_; ++i) {
            sum.load(open.data() + i * sum.size());
            sum.finish(leaf & 1, static_cast<uint32_t>(open_samples_), rows.data() + i * plan_.aovs->film_row());
        }
        film_.commit(leaf, 1, open_samples_);
        film_.close_leaf();
        open_samples_ = 0;
    }

    void check_time() {
        if (request_.seconds > 0 && film_.samples() + open_samples_ > 0 && time_left() <= 0) plan_.out_of_time = true;
    }

    void report(const Pass& pass, double part) {
        if (!progress_) return;
        std::unique_lock lock(progress_mutex_, std::try_to_lock);
        if (!lock) return;
        double fraction = (static_cast<double>(pass.first - first_) + part * static_cast<double>(pass.count)) / static_cast<double>(end_ - first_);
        if (request_.seconds > 0) fraction = std::max(fraction, seconds_since(start_) / request_.seconds);
        fraction = std::min(fraction, 1.0);
        if (fraction <= last_fraction_) return;  // never falls
        last_fraction_ = fraction;
        progress_(fraction);
    }

    Worker& worker() {
        bool exists = false;
        std::unique_ptr<Worker>& w = workers_.local(exists);
        if (!w) {
            w = scene_.workers->take();
            w->begin(plan_);
        }
        return *w;
    }

    double error() const {
        const std::vector<float> rows = film_.total();
        return plan_.aovs->estimated_error({rows, film_.samples(), film_.whole_leaves()}, pixels_);
    }

    Image image();

    const PreparedScene& scene_;
    const RenderRequest& request_;
    RenderStats& stats_;
    const std::function<void(double)>& progress_;
    RenderPlan plan_;
    size_t pixels_;
    Film film_;
    uint64_t first_, end_, next_;
    int threads_ = 1;
    std::optional<tbb::global_control> more_threads_;
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers_;
    std::vector<double> open_next_;
    uint64_t open_samples_ = 0;
    bool opens_leaf_ = false, reached_error_ = false;
    double seconds_per_sample_ = 0, last_fraction_ = 0;
    std::mutex progress_mutex_;
    Clock::time_point start_ = Clock::now();
};

Image Renderer::image() {
    for (std::unique_ptr<Worker>& w : workers_) {
        if (!w) continue;
        const WorkerCounters& c = w->counters();
        stats_.camera_rays += c.camera_rays;
        stats_.bounce_rays += c.bounce_rays;
        stats_.shadow_rays += c.shadow_rays;
        stats_.subsurface_rays += c.subsurface_rays;
        stats_.shading_points += c.shading_points;
        stats_.medium_segments += c.medium_segments;
        stats_.medium_points += c.medium_points;
        stats_.media_ignored += c.media_ignored;
        stats_.nonfinite_samples += c.nonfinite_samples;
        const ExecStats e = w->executed();
        stats_.node_evaluations += e.evaluations;
        stats_.node_skipped += e.skipped;
        scene_.workers->give_back(std::move(w));
    }
    for (const auto& m : scene_.materials)
        if (m->surface)
            for (const std::string& s : m->surface->program->stats().skipped) stats_.skipped.push_back(m->material.name + "/" + s);

    const std::vector<float> rows = film_.total();
    const AovPlan::FilmTotals totals{rows, film_.samples(), film_.whole_leaves()};
    stats_.build_seconds = scene_.build_seconds;
    stats_.compile_seconds = scene_.compile_seconds;
    stats_.samples = static_cast<int>(film_.samples());
    stats_.estimated_error = rows.empty() ? 0 : plan_.aovs->estimated_error(totals, pixels_);
    stats_.complete = next_ >= end_ || reached_error_;

    Image im;
    im.width = plan_.width;
    im.height = plan_.height;
    im.full_width = plan_.settings.width;
    im.full_height = plan_.settings.height;
    im.crop_x = plan_.crop_x;
    im.crop_y = plan_.crop_y;
    if (rows.empty()) {  // stopped before anything was there
        const std::vector<float> nothing(pixels_ * plan_.aovs->film_row(), 0.f);
        im.layers = plan_.aovs->layers({nothing, 0, 0}, pixels_);
    } else {
        im.layers = plan_.aovs->layers(totals, pixels_);
    }
    im.attributes = {{"alder/samples", std::to_string(film_.samples())},
                     {"alder/sample_offset", std::to_string(first_)},
                     {"alder/seed", std::to_string(plan_.seed)},
                     {"alder/estimated_error", std::to_string(stats_.estimated_error)},
                     {"alder/nonfinite_samples", std::to_string(stats_.nonfinite_samples)},
                     {"alder/complete", stats_.complete ? "1" : "0"}};
    stats_.render_seconds = seconds_since(start_);
    return im;
}

}  // namespace

Image render(const PreparedScene& scene, const RenderRequest& request, RenderStats& stats, const std::function<void(double)>& progress) {
    stats = {};
    Renderer renderer(scene, request, stats, progress);
    Image im = renderer.run();
    if (progress && stats.complete) progress(1);
    return im;
}

}  // namespace alder
