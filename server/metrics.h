// Metrics: counters and histograms of the daemon in OpenMetrics text. Thread safe; labels are templates, never identifiers.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace alder {

class Metrics {
  public:
    /// Adds to a counter; `labels` is the inner text: route="/v1/preview",method="POST".
    void count(const std::string& name, const std::string& labels = {}, double by = 1);
    /// Adds an observation in seconds to a histogram.
    void observe(const std::string& name, const std::string& labels, double seconds);
    /// A value that is asked for when the page is made.
    void gauge(const std::string& name, std::function<double()> value, const std::string& labels = {});
    double value(const std::string& name, const std::string& labels = {}) const;
    std::string text() const;

  private:
    static constexpr std::array<double, 14> kBounds{0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 10, 60, 600};
    struct Histogram {
        std::array<uint64_t, kBounds.size() + 1> buckets{};
        double sum = 0;
        uint64_t count = 0;
    };
    mutable std::mutex mutex_;
    std::map<std::string, std::map<std::string, double>> counters_;
    std::map<std::string, std::map<std::string, Histogram>> histograms_;
    struct Gauge {
        std::string labels;
        std::function<double()> value;
    };
    std::map<std::string, std::vector<Gauge>> gauges_;
};

}  // namespace alder
