// Checkpoints: the film and the counters of a progressive render as bytes, and back.
//
// Little-endian, as it lies in memory: a header that tells which render it is of, the nodes of the tree, the open leaf, and a
// hash over all before it. A file that ends early or has a flipped bit is refused.
#include <array>
#include <bit>
#include <cstring>
#include <istream>
#include <ostream>

#include "render/progressive.h"
#include "render/render_plan.h"

namespace alder {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr uint64_t kMagic = 0x314d4c4652444c41ull;  // "ALDRFLM1"
constexpr uint64_t kMaxNodes = 128;                 // a canonical cover of 2^64 leaves has fewer

/// 64 bits at a time, so that a checkpoint of gigabytes is not slowed by it. Not against forgery.
class Hash {
  public:
    void add(const void* bytes, size_t n) {
        const char* p = static_cast<const char*>(bytes);
        for (; n >= 8; p += 8, n -= 8) word(p, 8);
        if (n > 0) word(p, n);
    }
    uint64_t value() const { return value_; }

  private:
    void word(const char* p, size_t n) {
        uint64_t w = 0;
        std::memcpy(&w, p, n);
        value_ = std::rotl(value_ ^ w, 29) * 0x9e3779b97f4a7c15ull + n;
    }
    uint64_t value_ = 0xcbf29ce484222325ull;
};

class Writer {
  public:
    explicit Writer(std::ostream& out) : out_(out) {}
    void bytes(const void* p, size_t n) {
        hash_.add(p, n);
        out_.write(static_cast<const char*>(p), static_cast<std::streamsize>(n));
    }
    template <class T>
    void value(const T& v) { bytes(&v, sizeof v); }
    template <class T>
    void array(const std::vector<T>& v) { bytes(v.data(), v.size() * sizeof(T)); }
    void finish() {
        const uint64_t h = hash_.value();
        out_.write(reinterpret_cast<const char*>(&h), sizeof h);
    }

  private:
    std::ostream& out_;
    Hash hash_;
};

class Reader {
  public:
    explicit Reader(std::istream& in) : in_(in) {}
    bool bytes(void* p, size_t n) {
        if (!in_.read(static_cast<char*>(p), static_cast<std::streamsize>(n))) return false;
        hash_.add(p, n);
        return true;
    }
    template <class T>
    bool value(T& v) { return bytes(&v, sizeof v); }
    /// In pieces, so that a file that ends early costs no memory.
    template <class T>
    bool array(std::vector<T>& v, size_t n) {
        constexpr size_t kPiece = (size_t{16} << 20) / sizeof(T);
        v.clear();
        while (v.size() < n) {
            const size_t begin = v.size(), count = std::min(kPiece, n - begin);
            v.resize(begin + count);
            if (!bytes(v.data() + begin, count * sizeof(T))) return false;
        }
        return true;
    }
    bool finished() {
        const uint64_t h = hash_.value();
        uint64_t stored = 0;
        return in_.read(reinterpret_cast<char*>(&stored), sizeof stored) && stored == h;
    }

  private:
    std::istream& in_;
    Hash hash_;
};

}  // namespace

/// What two films must share for one to go on from the other.
struct ProgressiveRender::Identity {
    uint64_t magic = kMagic;
    std::array<int64_t, 14> numbers{};
    uint64_t layers = 0;
    bool operator==(const Identity&) const = default;
};

ProgressiveRender::Identity ProgressiveRender::identity() const {
    const RenderPlan& p = *plan_;
    const AovPlan& a = *p.aovs;
    Identity id;
    id.numbers = {p.width, p.height, p.crop_x, p.crop_y, p.settings.width, p.settings.height, int64_t{p.seed}, static_cast<int64_t>(first_),
                  a.sums, a.minima, a.firsts, a.film_row(), a.film_half_b, int64_t{kLeafSamples}};
    Hash names;
    for (const std::string& name : a.names()) names.add(name.data(), name.size());
    id.layers = names.value();
    return id;
}

void Film::save(const std::function<void(const void*, size_t)>& write) const {
    const uint64_t head[] = {nodes_.size(), samples_, whole_, open_.size()};
    write(head, sizeof head);
    for (const Node& n : nodes_) {
        const uint64_t node[] = {n.first, n.leaves, n.whole};
        write(node, sizeof node);
        write(n.rows.data(), n.rows.size() * sizeof(float));
    }
    write(open_.data(), open_.size() * sizeof(double));
}

void ProgressiveRender::save(std::ostream& out) const {
    Writer w(out);
    w.value(identity());
    w.value(next_);
    w.value(open_samples_);
    const RenderStats& s = stats_;
    w.value(std::array<uint64_t, 8>{s.camera_rays, s.bounce_rays, s.shadow_rays, s.subsurface_rays, s.shading_points,
                                    s.node_evaluations, s.node_skipped, s.nonfinite_samples});
    w.value(s.render_seconds);
    film_.save([&](const void* p, size_t n) { w.bytes(p, n); });
    w.finish();
}

bool ProgressiveRender::load(std::istream& in, std::string& why) {
    Reader r(in);
    Identity id;
    const auto refuse = [&](const char* text) {
        why = text;
        return false;
    };
    if (!r.value(id) || id.magic != kMagic) return refuse("not a checkpoint of this version");
    if (!(id == identity())) return refuse("a checkpoint of another render: resolution, crop, seed, offset or AOVs differ");
    uint64_t next = 0, open_samples = 0;
    std::array<uint64_t, 8> counters{};
    double seconds = 0;
    std::array<uint64_t, 4> head{};
    if (!r.value(next) || !r.value(open_samples) || !r.value(counters) || !r.value(seconds) || !r.value(head))
        return refuse("the checkpoint ends early");
    const auto [node_count, samples, whole, open_size] = head;
    const size_t row = pixels_ * plan_->aovs->film_row(), open_wanted = open_samples > 0 ? pixels_ * LeafSum(*plan_->aovs).size() : 0;
    if (node_count > kMaxNodes || open_samples >= kLeafSamples || open_size != open_wanted || next - first_ != samples + open_samples)
        return refuse("the checkpoint's numbers contradict each other");
    Film film(*plan_->aovs, pixels_);
    film.samples_ = samples;
    film.whole_ = whole;
    for (uint64_t k = 0; k < node_count; ++k) {
        std::array<uint64_t, 3> n{};
        std::vector<float> rows;
        if (!r.value(n) || !r.array(rows, row)) return refuse("the checkpoint ends early");
        film.nodes_.push_back({n[0], n[1], n[2] != 0, std::move(rows)});
    }
    if (!r.array(film.open_, open_size)) return refuse("the checkpoint ends early");
    if (!r.finished()) return refuse("the checkpoint is damaged");
    film_ = std::move(film);
    next_ = next;
    open_samples_ = open_samples;
    open_next_ = {};
    RenderStats& s = stats_;
    uint64_t* const to[] = {&s.camera_rays, &s.bounce_rays, &s.shadow_rays, &s.subsurface_rays, &s.shading_points,
                            &s.node_evaluations, &s.node_skipped, &s.nonfinite_samples};
    for (size_t i = 0; i < counters.size(); ++i) *to[i] = counters[i];
    s.render_seconds = seconds;
    return true;
}

}  // namespace alder
