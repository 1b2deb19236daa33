#include "render/evaluate.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "graph/json_text.h"
#include "render/closure/bsdf.h"
#include "render/point_surfaces.h"

namespace alder {
namespace {

using nlohmann::json;

json number_json(double v) {
    if (std::isnan(v)) return "nan";
    if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
    return v;
}

/// Directions or samples of the closure request: one triple for all points, or one a point.
bool read_triples(const json& j, uint32_t count, const std::string& pointer, std::vector<std::array<double, 3>>& out, Diagnostics& d) {
    const auto fail = [&](const std::string& where) {
        d.errors.push_back({where, "wrong-type", "not that", fmt::format("[x, y, z], or a list of {} of them", count), ""});
        return false;
    };
    const auto triple = [](const json& v, std::array<double, 3>& t) {
        if (!v.is_array() || v.size() != 3) return false;
        for (int i = 0; i < 3; ++i) {
            if (!v[i].is_number()) return false;
            t[i] = static_cast<float>(v[i].get<double>());
            if (!std::isfinite(t[i])) return false;
        }
        return true;
    };
    std::array<double, 3> one;
    if (j.is_array() && j.size() == 3 && triple(j, one)) {
        out.assign(count, one);
        return true;
    }
    if (!j.is_array() || j.size() != count) return fail(pointer);
    out.resize(count);
    for (uint32_t i = 0; i < count; ++i)
        if (!triple(j[i], out[i])) return fail(fmt::format("{}/{}", pointer, i));
    return true;
}

struct ClosureRequest {
    bool wanted = false;
    std::vector<std::array<double, 3>> wi, wo, sample;
};

template <class R>
struct Results {
    std::vector<std::vector<R>> outputs;  ///< by result channel: count values
    std::vector<std::array<R, 3>> f_cos, emission, sampled_wi, sampled_weight;
    std::vector<R> pdf, sampled_pdf;
};

template <class R>
Channel<R> slice(const std::vector<R>& values, bool uniform, uint32_t first) {
    return uniform ? Channel<R>{values.data(), 0} : Channel<R>{values.data() + first, 1};
}

template <class R>
class Evaluation {
  public:
    Evaluation(std::shared_ptr<const Program> values, std::shared_ptr<const Program> surface, const PointSet& points, const ClosureRequest& closure,
               const EvaluateOptions& options)
        : values_(std::move(values)), surface_(std::move(surface)), points_(points), closure_(closure), options_(options) {
        load(values_.get(), value_inputs_);
        load(surface_.get(), surface_inputs_);
        around_ = PointSurfaces::make(values_.get(), points_);
        if (!around_) around_ = PointSurfaces::make(surface_.get(), points_);
        const uint32_t n = points_.count();
        if (values_)
            for (const auto& o : values_->outputs())
                for (int c = 0; c < channels(o.type); ++c) {
                    registers_.push_back(o.register_first + c);
                    results_.outputs.emplace_back(n);
                }
        if (closure_.wanted) {
            results_.f_cos.resize(n);
            results_.emission.resize(n);
            results_.pdf.resize(n);
        }
        if (!closure_.sample.empty()) {
            results_.sampled_wi.resize(n);
            results_.sampled_weight.resize(n);
            results_.sampled_pdf.resize(n);
        }
    }

    /// Median seconds of one evaluation of all points.
    double run() {
        const int threads = options_.threads > 0 ? options_.threads : tbb::task_arena::automatic;
        tbb::task_arena arena(threads);
        std::vector<double> times;
        for (int r = 0; r < std::max(1, options_.repeat); ++r) {
            const auto start = std::chrono::steady_clock::now();
            if (options_.threads == 1) {
                block(0, points_.count());
            } else {
                arena.execute([&] {
                    tbb::parallel_for(tbb::blocked_range<uint32_t>(0, points_.count(), 4096), [&](const auto& range) { block(range.begin(), range.end()); });
                });
            }
            times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        }
        std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
        return times[times.size() / 2];
    }

    const Results<R>& results() const { return results_; }
    uint64_t evaluations() const { return evaluations_; }
    uint64_t skipped() const { return skipped_; }

  private:
    struct Input {
        std::vector<R> values;
        bool uniform;
    };
    void load(const Program* p, std::vector<Input>& to) {
        if (!p) return;
        for (const auto& in : p->inputs()) {
            std::vector<ChannelValues> channels;
            points_.append(in, channels);
            for (auto& c : channels) {
                Input x{std::vector<R>(c.values.begin(), c.values.end()), c.uniform};
                if (x.uniform) x.values.resize(kPadding, x.values.empty() ? R(0) : x.values[0]);
                else x.values.resize(points_.count() + 2 * kPadding, x.values.empty() ? R(0) : x.values.back());
                for (size_t i = 1; x.uniform && i < x.values.size(); ++i) x.values[i] = x.values[0];
                to.push_back(std::move(x));
            }
        }
    }

    void block(uint32_t first, uint32_t last) {
        static const EvalContext context;
        const SceneQueryScope scope(around_ ? &around_->query() : nullptr);
        Executor<R> executor(context, options_.scalar);
        std::vector<Channel<R>> inputs;
        const auto each_batch = [&](const Program& p, const std::vector<Input>& in, auto&& then) {
            for (uint32_t i = first; i < last; i += p.batch()) {
                const uint32_t n = std::min(p.batch(), last - i);
                inputs.clear();
                for (const auto& x : in) inputs.push_back(slice(x.values, x.uniform, i));
                executor.run(p, n, inputs);
                then(i, n);
            }
        };
        if (values_)
            each_batch(*values_, value_inputs_, [&](uint32_t i, uint32_t n) {
                for (size_t c = 0; c < registers_.size(); ++c) {
                    const Channel<R> r = executor.channel(registers_[c]);
                    for (uint32_t k = 0; k < n; ++k) results_.outputs[c][i + k] = r.p[k * r.stride];
                }
            });
        if (surface_) each_batch(*surface_, surface_inputs_, [&](uint32_t i, uint32_t n) { scatter(executor, i, n); });
        evaluations_ += executor.stats().evaluations;
        skipped_ += executor.stats().skipped;
    }

    void scatter(const Executor<R>& executor, uint32_t first, uint32_t n) {
        const auto& specs = surface_->lobes();
        std::vector<std::vector<Channel<R>>> channels_of(specs.size());
        for (size_t l = 0; l < specs.size(); ++l)
            for (int c = 0; c < specs[l].spec.channels(); ++c) channels_of[l].push_back(executor.channel(specs[l].register_first + c));
        // Normals of the view come last among the inputs of the surface request.
        std::vector<Lobe<R>> lobes;
        for (uint32_t k = 0; k < n; ++k) {
            const uint32_t p = first + k;
            lobes.clear();
            for (size_t l = 0; l < specs.size(); ++l) {
                Lobe<R> lobe = load_lobe(specs[l].spec, channels_of[l].data(), k);
                if (lobe.weight.x != R(0) || lobe.weight.y != R(0) || lobe.weight.z != R(0)) lobes.push_back(lobe);
            }
            const auto vec = [](const std::array<double, 3>& v) { return Vec3<R>(R(v[0]), R(v[1]), R(v[2])); };
            ShadingView<R> view{vec(closure_.wo[p]), vec(ng_[p]), vec(ns_[p])};
            const Bsdf<R> bsdf(lobes, view);
            const Vec3<R> emission = bsdf.emission();
            results_.emission[p] = {emission.x, emission.y, emission.z};
            if (!closure_.wi.empty()) {
                // What Cycles evaluates, sampled or not: requests compare with its tables.
                view.unreachable_too = view.converged = true;
                const BsdfEval<R> e = Bsdf<R>(lobes, view).eval(vec(closure_.wi[p]));
                results_.f_cos[p] = {e.f_cos.x, e.f_cos.y, e.f_cos.z};
                results_.pdf[p] = e.pdf;
            }
            if (!closure_.sample.empty()) {
                const auto& u = closure_.sample[p];
                const BsdfSample<R> s = bsdf.sample(R(u[0]), R(u[1]), R(u[2]));
                results_.sampled_wi[p] = s.valid ? std::array<R, 3>{s.wi.x, s.wi.y, s.wi.z} : std::array<R, 3>{0, 0, 0};
                results_.sampled_pdf[p] = s.valid ? s.pdf : R(0);
                results_.sampled_weight[p] = s.valid ? std::array<R, 3>{s.weight.x, s.weight.y, s.weight.z} : std::array<R, 3>{0, 0, 0};
            }
        }
    }

  public:
    void set_normals(std::vector<std::array<double, 3>> ng, std::vector<std::array<double, 3>> ns) {
        ng_ = std::move(ng);
        ns_ = std::move(ns);
    }

  private:
    std::shared_ptr<const Program> values_, surface_;
    std::unique_ptr<PointSurfaces> around_;  ///< for nodes that cast rays
    const PointSet& points_;
    const ClosureRequest& closure_;
    const EvaluateOptions& options_;
    std::vector<Input> value_inputs_, surface_inputs_;
    std::vector<int> registers_;
    std::vector<std::array<double, 3>> ng_, ns_;
    Results<R> results_;
    std::atomic<uint64_t> evaluations_{0}, skipped_{0};
};

std::vector<std::array<double, 3>> global_values(const PointSet& points, Global g) {
    ProgramInput in;
    in.global = g;
    in.channels = 3;
    std::vector<ChannelValues> c;
    points.append(in, c);
    std::vector<std::array<double, 3>> v(points.count());
    for (uint32_t i = 0; i < points.count(); ++i)
        for (int k = 0; k < 3; ++k) v[i][k] = c[k].uniform ? c[k].values[0] : c[k].values[i];
    return v;
}

template <class T>
json triples_json(const std::vector<std::array<T, 3>>& v) {
    json list = json::array();
    list.get_ref<json::array_t&>().reserve(v.size());
    for (const auto& x : v) list.push_back({number_json(x[0]), number_json(x[1]), number_json(x[2])});
    return list;
}

template <class R>
json evaluate(std::shared_ptr<const Program> values, std::shared_ptr<const Program> surface, const PointSet& points, const ClosureRequest& closure,
              const EvaluateOptions& options) {
    Evaluation<R> evaluation(values, surface, points, closure, options);
    if (surface) evaluation.set_normals(global_values(points, Global::Ng), global_values(points, Global::N));
    const double seconds = evaluation.run();
    const auto& r = evaluation.results();
    json answer = {{"outputs", json::object()}};
    size_t c = 0;
    if (values)
        for (const auto& o : values->outputs()) {
            json list = json::array();
            list.get_ref<json::array_t&>().reserve(points.count());
            const int width = channels(o.type);
            for (uint32_t i = 0; i < points.count(); ++i) {
                if (width == 1) list.push_back(number_json(r.outputs[c][i]));
                else list.push_back({number_json(r.outputs[c][i]), number_json(r.outputs[c + 1][i]), number_json(r.outputs[c + 2][i])});
            }
            c += width;
            answer["outputs"][o.name] = std::move(list);
        }
    if (closure.wanted) {
        json& out = answer["closure"] = json::object();
        out["emission"] = triples_json(r.emission);  // apart: f_cos is scattering alone
        if (!closure.wi.empty()) {
            out["f_cos"] = triples_json(r.f_cos);
            json pdf = json::array();
            for (R v : r.pdf) pdf.push_back(number_json(v));
            out["pdf"] = std::move(pdf);
        }
        if (!closure.sample.empty()) {
            out["sampled_wi"] = triples_json(r.sampled_wi);
            out["sampled_weight"] = triples_json(r.sampled_weight);
            json pdf = json::array();
            for (R v : r.sampled_pdf) pdf.push_back(number_json(v));
            out["sampled_pdf"] = std::move(pdf);
        }
    }
    if (options.stats) {
        json& s = answer["stats"];
        s["points"] = points.count();
        s["seconds"] = seconds;
        const int repeat = std::max(1, options.repeat);
        s["evaluations"] = evaluation.evaluations() / repeat;
        s["evaluations_skipped"] = evaluation.skipped() / repeat;
        s["isa"] = options.precision == EvaluateOptions::Precision::Double ? "double" : options.scalar ? "scalar" : current_isa();
        double compile = 0;
        for (const auto* p : {values.get(), surface.get()}) {
            if (!p) continue;
            const auto& ps = p->stats();
            compile += ps.compile_seconds;
            s["nodes"] = ps.nodes;
            s["live_nodes"] = ps.live_nodes;
            s["ops"] = s.value("ops", 0) + ps.ops;
            s["constant_folded"] = s.value("constant_folded", 0) + ps.folded;
            s["regions"] = s.value("regions", 0) + ps.regions;
            s["skipped"] = ps.skipped;
        }
        s["compile_seconds"] = compile;
    }
    return answer;
}

}  // namespace

json evaluate_request(const json& request, const EvaluateOptions& options, Diagnostics& d) {
    const auto at = [&](const std::string& p) { return options.pointer_prefix + p; };
    const auto error = [&](const std::string& p, std::string code, std::string found, std::string expected, std::string suggest = {}) {
        d.errors.push_back({at(p), std::move(code), std::move(found), std::move(expected), std::move(suggest)});
    };
    if (!request.is_object()) {
        error("", "wrong-type", "not an object", "{\"graph\", \"points\", \"outputs\", \"closure\"}");
        return nullptr;
    }
    const std::vector<std::string> known{"graph", "points", "outputs", "closure", "domain", "lenient", "strict", "texture_filter", "noise_filter", "precision", "stats", "repeat"};
    const bool lenient = request.contains("lenient") && request["lenient"] == true;
    for (const auto& [key, value] : request.items())
        if (std::find(known.begin(), known.end(), key) == known.end()) {
            auto& list = lenient ? d.warnings : d.errors;
            list.push_back({at("/" + pointer_token(key)), "unknown-member", key, fmt::format("one of {}", fmt::join(known, ", ")), nearest_name(key, known)});
        }
    if (!request.contains("graph")) error("/graph", "missing", "nothing", "a graph document");
    EvaluateOptions o = options;
    o.material.lenient = lenient;
    o.material.pointer_prefix = at("/graph");
    const auto flag = [&](const char* name) {
        if (!request.contains(name)) return false;
        if (!request[name].is_boolean()) error(std::string("/") + name, "wrong-type", request[name].dump(), "true or false");
        return request[name] == true;
    };
    o.material.strict = flag("strict");
    if (request.contains("precision")) {
        if (request["precision"] == "double") o.precision = EvaluateOptions::Precision::Double;
        else if (request["precision"] != "float") error("/precision", "wrong-type", request["precision"].dump(), "\"float\" or \"double\"");
    }
    if (request.contains("stats")) {
        if (request["stats"].is_boolean()) o.stats |= request["stats"].get<bool>();
        else error("/stats", "wrong-type", request["stats"].dump(), "true or false");
    }
    if (request.contains("repeat")) {
        if (request["repeat"].is_number_integer() && request["repeat"] >= 1 && request["repeat"] <= 10000) o.repeat = request["repeat"];
        else error("/repeat", "wrong-type", request["repeat"].dump(), "1 ... 10000");
    }
    std::string domain = "surface";
    if (request.contains("domain")) {
        if (request["domain"] == "world" || request["domain"] == "surface") domain = request["domain"];
        else error("/domain", "wrong-type", request["domain"].dump(), "\"surface\" or \"world\"");
    }
    json points_json = request.contains("points") ? request["points"] : json{{"count", 1}};
    ClosureRequest closure;
    const bool has_closure = request.contains("closure") && !request["closure"].is_null();
    if (has_closure && !request["closure"].is_object()) {
        error("/closure", "wrong-type", "not an object", "{\"output\": \"surface\", \"wi\", \"wo\"}");
    } else if (has_closure && points_json.is_object() && !points_json.contains("I") && request["closure"].contains("wo")) {
        points_json["I"] = request["closure"]["wo"];  // the viewer is where wo points
    }
    auto points = PointSet::parse(points_json, domain, at("/points"), o.points, d);

    if (has_closure && request["closure"].is_object() && points) {
        const json& c = request["closure"];
        const std::vector<std::string> members{"output", "wi", "wo", "sample"};
        for (const auto& [key, value] : c.items())
            if (std::find(members.begin(), members.end(), key) == members.end())
                error("/closure/" + pointer_token(key), "unknown-member", key, fmt::format("one of {}", fmt::join(members, ", ")), nearest_name(key, members));
        if (c.contains("output") && c["output"] != "surface") error("/closure/output", "wrong-type", c["output"].dump(), "\"surface\"");
        closure.wanted = true;
        if (!c.contains("wo")) error("/closure/wo", "missing", "nothing", "directions towards the viewer");
        else read_triples(c["wo"], points->count(), at("/closure/wo"), closure.wo, d);
        if (c.contains("wi")) read_triples(c["wi"], points->count(), at("/closure/wi"), closure.wi, d);
        if (c.contains("sample")) read_triples(c["sample"], points->count(), at("/closure/sample"), closure.sample, d);
        if (!c.contains("wi") && !c.contains("sample")) error("/closure", "missing", "neither wi nor sample", "wi, sample or both");
    }
    ProgramRequest values, surface{.surface = LobeFilter::Scatter | LobeFilter::Emission};
    values.filter_textures = surface.filter_textures = flag("texture_filter");
    values.fade_noise = surface.fade_noise = flag("noise_filter");
    if (request.contains("outputs")) {
        const json& list = request["outputs"];
        if (!list.is_array()) error("/outputs", "wrong-type", "not a list", "a list of NODE.OUTPUT");
        else
            for (size_t i = 0; i < list.size(); ++i) {
                if (list[i].is_string()) values.outputs.push_back(list[i]);
                else error(fmt::format("/outputs/{}", i), "wrong-type", list[i].dump(), "NODE.OUTPUT");
            }
    }
    std::shared_ptr<const Material> material;
    if (request.contains("graph")) material = o.cache ? o.cache->get(request["graph"], o.material, d) : build_material(request["graph"], o.material, d);
    if (!material || !points || !d.ok()) return nullptr;

    std::shared_ptr<const Program> value_program, surface_program;
    if (!values.outputs.empty()) {
        Diagnostics local;
        value_program = material->program(values, local);
        for (auto& e : local.errors) {
            e.pointer = e.pointer == "/outputs" ? at("/outputs") : e.pointer;
            if (d.errors.size() < kMaxDiagnostics) d.errors.push_back(e);
        }
        d.warnings.insert(d.warnings.end(), local.warnings.begin(), local.warnings.end());
    }
    if (closure.wanted) {
        if (!material->has_surface()) error("/closure/output", "unknown-output", "surface", "a graph with a surface output");
        else surface_program = material->program(surface, d);
    }
    if (!d.ok()) return nullptr;
    json answer = o.precision == EvaluateOptions::Precision::Double ? evaluate<double>(value_program, surface_program, *points, closure, o)
                                                                    : evaluate<float>(value_program, surface_program, *points, closure, o);
    if (o.material.strict)   // a file may break off in the middle
        for (const Diagnostic& fault : material->file_faults())
            if (d.errors.size() < kMaxDiagnostics) d.errors.push_back(fault);
    if (!d.ok()) return nullptr;
    if (!d.warnings.empty()) {
        json list = json::array();
        for (const auto& w : d.warnings) list.push_back({{"pointer", w.pointer}, {"code", w.code}, {"found", w.found}, {"expected", w.expected}, {"suggest", w.suggest}});
        answer["warnings"] = std::move(list);
    }
    return answer;
}

}  // namespace alder
