// Metrics: counters and histograms of the daemon in OpenMetrics text.
#include "server/metrics.h"

#include <algorithm>

#include <fmt/format.h>

namespace alder {

void Metrics::count(const std::string& name, const std::string& labels, double by) {
    const std::lock_guard lock(mutex_);
    counters_[name][labels] += by;
}

void Metrics::observe(const std::string& name, const std::string& labels, double seconds) {
    const std::lock_guard lock(mutex_);
    Histogram& h = histograms_[name][labels];
    const size_t bucket = std::lower_bound(kBounds.begin(), kBounds.end(), seconds) - kBounds.begin();
    ++h.buckets[bucket];
    ++h.count;
    h.sum += seconds;
}

void Metrics::gauge(const std::string& name, std::function<double()> value, const std::string& labels) {
    const std::lock_guard lock(mutex_);
    gauges_[name].push_back({labels, std::move(value)});
}

double Metrics::value(const std::string& name, const std::string& labels) const {
    const std::lock_guard lock(mutex_);
    const auto it = counters_.find(name);
    if (it == counters_.end()) return 0;
    const auto row = it->second.find(labels);
    return row == it->second.end() ? 0 : row->second;
}

std::string Metrics::text() const {
    std::map<std::string, std::vector<Gauge>> gauges;
    std::string out;
    const auto braces = [](const std::string& labels) { return labels.empty() ? std::string() : "{" + labels + "}"; };
    {
        const std::lock_guard lock(mutex_);
        gauges = gauges_;
        for (const auto& [name, rows] : counters_) {
            out += fmt::format("# TYPE {} counter\n", name);
            for (const auto& [labels, value] : rows) out += fmt::format("{}_total{} {}\n", name, braces(labels), value);
        }
        for (const auto& [name, rows] : histograms_) {
            out += fmt::format("# TYPE {} histogram\n", name);
            for (const auto& [labels, h] : rows) {
                uint64_t below = 0;
                const std::string comma = labels.empty() ? "" : labels + ",";
                for (size_t i = 0; i < kBounds.size(); ++i)
                    out += fmt::format("{}_bucket{{{}le=\"{}\"}} {}\n", name, comma, kBounds[i], below += h.buckets[i]);
                out += fmt::format("{}_bucket{{{}le=\"+Inf\"}} {}\n", name, comma, h.count);
                out += fmt::format("{0}_sum{1} {2}\n{0}_count{1} {3}\n", name, braces(labels), h.sum, h.count);
            }
        }
    }
    for (const auto& [name, rows] : gauges) {
        out += fmt::format("# TYPE {} gauge\n", name);
        for (const Gauge& g : rows) out += fmt::format("{}{} {}\n", name, braces(g.labels), g.value());   // may lock elsewhere
    }
    return out + "# EOF\n";
}

}  // namespace alder
