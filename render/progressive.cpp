// ProgressiveRender: passes over the tiles of an image, each one node of the film's tree or part of a leaf.
#include "render/progressive.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <istream>
#include <mutex>
#include <ostream>
#include <thread>

#include "render/render_plan.h"
#include "render/tile_gate.h"
#include "render/worker.h"

namespace alder {
namespace {

double seconds_since(ProgressiveRender::Clock::time_point t) {
    return std::chrono::duration<double>(ProgressiveRender::Clock::now() - t).count();
}

}  // namespace

/// Samples taken by all pixels in one go: an aligned run of whole leaves, or a part of one leaf.
struct ProgressiveRender::Pass {
    uint64_t first = 0, count = 0;
    bool whole() const { return count % kLeafSamples == 0 && first % kLeafSamples == 0; }
    bool fills_leaf() const { return (first + count) % kLeafSamples == 0; }
};

ProgressiveRender::ProgressiveRender(std::shared_ptr<const PreparedScene> scene, const RenderRequest& request)
    : scene_(std::move(scene)),
      plan_(std::make_unique<RenderPlan>(*scene_, request)),
      pixels_(size_t(plan_->width) * plan_->height),
      film_(*plan_->aovs, pixels_),
      first_(request.sample_offset),
      next_(first_) {
    cores_ = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    threads_ = request.threads > 0 ? std::min(request.threads, 1024) : cores_;
    stats_.build_seconds = scene_->build_seconds;
    stats_.compile_seconds = scene_->compile_seconds;
    for (const auto& m : scene_->materials)
        if (m->surface)
            for (const std::string& s : m->surface->program->stats().skipped) stats_.skipped.push_back(m->material.name + "/" + s);
}

ProgressiveRender::~ProgressiveRender() = default;

uint64_t ProgressiveRender::planned_samples() const { return static_cast<uint64_t>(plan_->settings.samples); }

uint64_t ProgressiveRender::next_pass(uint64_t samples) const {
    const uint64_t in_leaf = next_ % kLeafSamples;
    if (in_leaf != 0 || samples < kLeafSamples) return std::min(kLeafSamples - in_leaf, samples);
    const uint64_t leaf = next_ / kLeafSamples, done = film_.samples() / kLeafSamples;
    uint64_t leaves = std::bit_floor(samples / kLeafSamples);
    if (leaf != 0) leaves = std::min(leaves, leaf & (~leaf + 1));  // aligned: a node of the tree
    // What a stop may throw away is bounded by a part of what is done; a large film keeps fewer unmerged nodes instead.
    const bool large = pixels_ * plan_->aovs->film_row() * sizeof(float) > (size_t{256} << 20);
    leaves = std::min(leaves, std::bit_floor(std::max<uint64_t>(1, large ? done : done / 4)));
    return leaves * kLeafSamples;
}

bool ProgressiveRender::advance(uint64_t samples, const std::function<void(double)>& progress) {
    const auto start = Clock::now();
    std::optional<tbb::global_control> more_threads;
    if (threads_ > cores_) more_threads.emplace(tbb::global_control::max_allowed_parallelism, threads_);
    tbb::task_arena arena(threads_);
    plan_->out_of_time = false;
    uint64_t taken = 0;
    double last = 0;
    bool done = true;
    while (done && taken < samples) {
        const Pass pass{next_, next_pass(samples - taken)};
        const auto report = [&](double part) {
            const double fraction = (static_cast<double>(taken) + part * static_cast<double>(pass.count)) / static_cast<double>(samples);
            if (fraction > last) progress(last = fraction);
        };
        done = arena.execute([&] { return run_pass(pass, progress ? report : std::function<void(double)>{}); });
        if (!done) break;
        finish_pass(pass);
        taken += pass.count;
    }
    stats_.render_seconds += seconds_since(start);
    return done;
}

std::vector<Tile> ProgressiveRender::tiles(uint64_t samples_at_once) const {
    // Some thousand paths at once fill batches and still fit the second-level cache; small images are cut finer, so that
    // every thread has work.
    int edge = 64;
    while (edge > 4 && (uint64_t(edge) * edge * samples_at_once > 4096 ||
                        uint64_t(plan_->width) * plan_->height < uint64_t(edge) * edge * 4 * threads_))
        edge /= 2;
    std::vector<Tile> list;
    for (int y = 0; y < plan_->height; y += edge)
        for (int x = 0; x < plan_->width; x += edge)
            list.push_back({x, y, std::min(x + edge, plan_->width), std::min(y + edge, plan_->height)});
    return list;
}

bool ProgressiveRender::run_pass(const Pass& pass, const std::function<void(double)>& report) {
    if (plan_->stopped()) return false;
    const std::vector<Tile> list = tiles(std::min<uint64_t>(pass.count, kLeafSamples));
    if (!pass.whole() && !pass.fills_leaf()) open_next_.resize(pixels_ * LeafSum(*plan_->aovs).size());
    film_.pass_rows();
    const uint64_t nonfinite_before = stats_.nonfinite_samples;
    std::atomic<size_t> finished{0};
    std::mutex report_mutex;
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, list.size(), 1), [&](const tbb::blocked_range<size_t>& r) {
        for (size_t i = r.begin(); i < r.end(); ++i) {
            pass_tile_gate();
            check_time();
            if (plan_->stopped()) return;
            std::unique_ptr<Worker>& w = workers.local();
            if (!w) {
                w = scene_->workers->take();
                w->begin(*plan_);
            }
            if (!run_tile(*w, list[i], pass)) return;
            const size_t n = ++finished;
            if (!report) continue;
            const std::unique_lock lock(report_mutex, std::try_to_lock);
            if (lock) report(static_cast<double>(n) / static_cast<double>(list.size()));
        }
    }, tbb::simple_partitioner());
    for (std::unique_ptr<Worker>& w : workers)
        if (w) collect(std::move(w));
    const bool done = finished == list.size();
    if (!done) stats_.nonfinite_samples = nonfinite_before;  // files tell this number: a dropped pass may not show
    return done;
}

bool ProgressiveRender::run_tile(Worker& w, const Tile& tile, const Pass& pass) {
    const size_t stride = plan_->aovs->film_row(), n = tile.pixels();
    while (w.leaf_sums.size() < n) w.leaf_sums.emplace_back(*plan_->aovs);
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
        w.scratch_row.resize(std::max(w.scratch_row.size(), stride));
        float* const sum = w.scratch_row.data();
        for (size_t i = 0; i < n; ++i) {
            sums[i].finish((first_leaf + k) & 1, kLeafSamples, sum);
            for (size_t level = 0; level < height; ++level) combine_rows(*plan_->aovs, levels[level].data() + i * stride, sum, sum);
            std::copy(sum, sum + stride, to.data() + i * stride);
        }
        top = &to;
    }
    store(tile, *top);
    return true;
}

/// Part of a leaf: its double sums wait in the film until the leaf is full.
bool ProgressiveRender::run_part(Worker& w, const Tile& tile, const Pass& pass, std::span<LeafSum> sums) {
    const size_t stride = plan_->aovs->film_row(), n = tile.pixels(), doubles = sums[0].size();
    const std::vector<double>* const open = open_samples_ > 0 ? &film_.open_leaf(doubles) : nullptr;
    for (size_t i = 0; i < n; ++i) {
        if (open) sums[i].load(open->data() + pixel(tile, i) * doubles);
        else sums[i].clear();
    }
    if (!w.trace(tile, pass.first, static_cast<uint32_t>(pass.count), sums)) return false;
    if (!pass.fills_leaf()) {
        for (size_t i = 0; i < n; ++i) sums[i].store(open_next_.data() + pixel(tile, i) * doubles);
        return true;
    }
    std::vector<float>& rows = w.scratch_row;
    rows.resize(std::max(rows.size(), n * stride));
    const uint32_t samples = static_cast<uint32_t>(open_samples_ + pass.count);
    for (size_t i = 0; i < n; ++i) sums[i].finish((pass.first / kLeafSamples) & 1, samples, rows.data() + i * stride);
    store(tile, rows);
    return true;
}

size_t ProgressiveRender::pixel(const Tile& tile, size_t i) const {
    const size_t width = tile.x1 - tile.x0;
    return (tile.y0 + i / width) * plan_->width + tile.x0 + i % width;
}

void ProgressiveRender::store(const Tile& tile, const std::vector<float>& rows) {
    const size_t stride = plan_->aovs->film_row();
    float* const to = film_.pass_rows().data();
    for (int i = 0; i < tile.pixels(); ++i)
        std::copy(rows.data() + i * stride, rows.data() + (i + 1) * stride, to + pixel(tile, i) * stride);
}

void ProgressiveRender::finish_pass(const Pass& pass) {
    next_ = pass.first + pass.count;
    if (pass.whole()) return film_.commit(pass.first / kLeafSamples, pass.count / kLeafSamples, pass.count);
    if (!pass.fills_leaf()) {
        film_.open_leaf(LeafSum(*plan_->aovs).size()).swap(open_next_);
        open_samples_ += pass.count;
        return;
    }
    film_.commit(pass.first / kLeafSamples, 1, open_samples_ + pass.count);
    film_.close_leaf();
    open_next_ = {};
    open_samples_ = 0;
}

void ProgressiveRender::check_time() {
    if (deadline_ && samples() > 0 && Clock::now() >= *deadline_) plan_->out_of_time = true;
}

void ProgressiveRender::collect(std::unique_ptr<Worker> w) {
    const WorkerCounters& c = w->counters();
    stats_.camera_rays += c.camera_rays;
    stats_.bounce_rays += c.bounce_rays;
    stats_.shadow_rays += c.shadow_rays;
    stats_.subsurface_rays += c.subsurface_rays;
    stats_.timed_paths += c.timed_paths;
    stats_.shading_points += c.shading_points;
    stats_.medium_segments += c.medium_segments;
    stats_.medium_points += c.medium_points;
    stats_.media_ignored += c.media_ignored;
    stats_.nonfinite_samples += c.nonfinite_samples;
    const ExecStats e = w->executed();
    stats_.node_evaluations += e.evaluations;
    stats_.node_skipped += e.skipped;
    scene_->workers->give_back(std::move(w));
}

double ProgressiveRender::estimated_error() const { return picture()->estimated_error(); }

RenderStats ProgressiveRender::stats() const {
    RenderStats s = stats_;
    s.samples = static_cast<int>(samples());
    s.complete = samples() >= planned_samples();
    return s;
}

std::shared_ptr<const FilmPicture> ProgressiveRender::picture() const {
    auto p = std::make_shared<FilmPicture>();
    p->aovs_ = plan_->aovs;
    p->graph_aovs_ = plan_->graph_aovs;
    p->width_ = plan_->width;
    p->height_ = plan_->height;
    p->full_width_ = plan_->settings.width;
    p->full_height_ = plan_->settings.height;
    p->crop_x_ = plan_->crop_x;
    p->crop_y_ = plan_->crop_y;
    p->sample_offset_ = first_;
    p->seed_ = plan_->seed;
    p->nonfinite_samples_ = stats_.nonfinite_samples;
    p->complete_ = samples() >= planned_samples();
    const AovPlan& aovs = *plan_->aovs;
    p->rows_ = film_.total();
    const size_t stride = aovs.film_row();
    if (open_samples_ > 0) {  // as if it ended here: what the open leaf has is a leaf of its own
        LeafSum sum(aovs);
        std::vector<float> row(stride);
        const std::vector<double>& open = film_.open_leaf();
        const bool alone = p->rows_.empty();
        p->rows_.resize(pixels_ * stride);
        for (size_t i = 0; i < pixels_; ++i) {
            sum.load(open.data() + i * sum.size());
            sum.finish(((next_ - 1) / kLeafSamples) & 1, static_cast<uint32_t>(open_samples_), row.data());
            float* const to = p->rows_.data() + i * stride;
            if (alone) std::copy(row.begin(), row.end(), to);
            else combine_rows(aovs, to, row.data(), to);
        }
    }
    if (p->rows_.empty()) p->rows_.assign(pixels_ * stride, 0.f);
    p->totals_ = {p->rows_, samples(), open_samples_ > 0 ? 0 : film_.whole_leaves()};
    return p;
}

double FilmPicture::estimated_error() const { return aovs_->estimated_error(totals_, size_t(width_) * height_); }

Image FilmPicture::image(const std::vector<std::string>& wanted) const {
    Image im;
    im.width = width_;
    im.height = height_;
    im.full_width = full_width_;
    im.full_height = full_height_;
    im.crop_x = crop_x_;
    im.crop_y = crop_y_;
    const std::vector<std::string> only = expand_aovs(wanted, graph_aovs_);
    im.layers = aovs_->layers(totals_, size_t(width_) * height_, wanted.empty() ? nullptr : &only);
    im.attributes = {{"alder/samples", std::to_string(samples())},
                     {"alder/sample_offset", std::to_string(sample_offset_)},
                     {"alder/seed", std::to_string(seed_)},
                     {"alder/estimated_error", std::to_string(estimated_error())},
                     {"alder/nonfinite_samples", std::to_string(nonfinite_samples_)},
                     {"alder/complete", complete_ ? "1" : "0"}};
    return im;
}

}  // namespace alder
