// ProgressiveRender: a render that goes on: take some samples, look at the picture, take more, put it away and resume later.
//
//   ProgressiveRender r(prepared, request);
//   r.advance(1);  show(r.picture()->image());  r.advance(15);  r.save(file);
//
// Whatever the advances, and wherever it was saved and loaded between them, the same total gives the same bits as render(),
// because all sums lie on the film's tree (film.h). One thread owns it; pictures may be read by others while it goes on.
#pragma once
#include <chrono>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/film.h"
#include "render/render.h"

namespace alder {

struct RenderPlan;
struct Tile;
class Worker;

/// Sums of a film at one number of samples, from which layers are made when someone asks. Immutable.
class FilmPicture {
  public:
    /// The layers asked for (names or groups) that were recorded, beauty first; none named: all.
    Image image(const std::vector<std::string>& aovs = {}) const;
    uint64_t samples() const { return totals_.samples; }
    double estimated_error() const;
    int width() const { return width_; }
    int height() const { return height_; }
    const AovPlan& aovs() const { return *aovs_; }
    /// Rows of AovPlan::film_row() sums, one a pixel.
    const std::vector<float>& rows() const { return rows_; }

  private:
    friend class ProgressiveRender;
    std::shared_ptr<const AovPlan> aovs_;
    std::vector<std::string> graph_aovs_;
    std::vector<float> rows_;
    AovPlan::FilmTotals totals_;
    int width_ = 0, height_ = 0, full_width_ = 0, full_height_ = 0, crop_x_ = 0, crop_y_ = 0;
    uint64_t sample_offset_ = 0, nonfinite_samples_ = 0, seed_ = 0;
    bool complete_ = false;
};

class ProgressiveRender {
  public:
    using Clock = std::chrono::steady_clock;

    /// request.seconds and target_error are not looked at: the caller decides when to stop. request.cancel is, between the
    /// stages of every tile.
    ProgressiveRender(std::shared_ptr<const PreparedScene> scene, const RenderRequest& request);
    ~ProgressiveRender();
    ProgressiveRender(const ProgressiveRender&) = delete;
    ProgressiveRender& operator=(const ProgressiveRender&) = delete;

    /// Takes this many more samples of every pixel, in passes of next_pass(). False if cancelled or past the deadline: the
    /// pass under way is then dropped whole, earlier ones stay. progress: fraction of this advance, never falling.
    bool advance(uint64_t samples, const std::function<void(double)>& progress = {});
    /// How many of `samples` more are taken in one go, as one node of the tree or a part of a leaf.
    uint64_t next_pass(uint64_t samples) const;
    /// advance() gives up then, unless nothing has been rendered yet.
    void set_deadline(std::optional<Clock::time_point> deadline) { deadline_ = deadline; }

    uint64_t samples() const { return film_.samples() + open_samples_; }
    /// Those of the request, or of the scene.
    uint64_t planned_samples() const;
    double estimated_error() const;
    /// Counters, and seconds spent in advance(), since the beginning (over save and load, too).
    RenderStats stats() const;
    std::shared_ptr<const FilmPicture> picture() const;
    Image image(const std::vector<std::string>& aovs = {}) const { return picture()->image(aovs); }

    /// The film with its counters. What it is a render of is not in it: the caller keeps scene and request beside it.
    void save(std::ostream& out) const;
    /// Goes on from what save() wrote. False, and unchanged, if it is damaged, or of a render with another resolution, crop,
    /// seed, offset or AOVs; `why` tells.
    bool load(std::istream& in, std::string& why);

  private:
    struct Pass;
    struct Identity;
    std::vector<Tile> tiles(uint64_t samples_at_once) const;
    bool run_pass(const Pass& pass, const std::function<void(double)>& report);
    bool run_tile(Worker& w, const Tile& tile, const Pass& pass);
    bool run_part(Worker& w, const Tile& tile, const Pass& pass, std::span<LeafSum> sums);
    void store(const Tile& tile, const std::vector<float>& rows);
    size_t pixel(const Tile& tile, size_t i) const;
    void finish_pass(const Pass& pass);
    void collect(std::unique_ptr<Worker> worker);
    void check_time();
    Identity identity() const;

    std::shared_ptr<const PreparedScene> scene_;
    std::unique_ptr<RenderPlan> plan_;
    size_t pixels_;
    Film film_;
    uint64_t first_, next_;
    uint64_t open_samples_ = 0;        ///< in the leaf that is not full
    std::vector<double> open_next_;    ///< what the pass under way makes of it
    int threads_ = 1, cores_ = 1;
    std::optional<Clock::time_point> deadline_;
    RenderStats stats_;
};

}  // namespace alder
