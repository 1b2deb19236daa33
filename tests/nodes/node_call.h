// NodeCall: runs one node's kernel on given operands outside any graph, for tests of kernels. Every path (lanes, scalar, double)
// sees the same operands; the padding lanes hold NaN, so that a kernel that trips over them shows.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "nodes/schema.h"

namespace alder::test {

enum class Path { Lanes, Scalar, Double };

class NodeCall {
  public:
    explicit NodeCall(const std::string& name, size_t points = 1) : type_(*find_node(name)), n_(points) {
        const size_t count = type_.params.size();
        statics_.type = &type_;
        statics_.enums.assign(count, 0);
        statics_.text.assign(count, "");
        statics_.linked.assign(count, false);
        for (size_t p = 0; p < count; ++p) {
            const Param& param = type_.params[p];
            for (int c = 0; c < channels(param.type); ++c) channel_.push_back({param.number[c]});
            statics_.text[p] = param.text;
            if (param.type == Type::Enum) set(param.name, param.text.c_str());
            if (param.type == Type::Bool || (param.type == Type::Int && !param.takes_links)) statics_.enums[p] = static_cast<int>(param.number[0]);
        }
        for (Global g : type_.globals)
            for (int c = 0; c < channels(g); ++c) channel_.push_back({0.0});
    }
    NodeCall& set(const std::string& param, double x) { return set(param, {x}); }
    NodeCall& set(const std::string& param, int x) { return set(param, {static_cast<double>(x)}); }
    /// One constant: as many numbers as the parameter has channels.
    NodeCall& set(const std::string& param, std::initializer_list<double> x) {
        const int p = index(param);
        int c = type_.channel_of(p);
        for (double v : x) channel_[c++] = {v};
        if (type_.params[p].type == Type::Bool || type_.params[p].type == Type::Int) statics_.enums[p] = static_cast<int>(*x.begin());
        return *this;
    }
    NodeCall& set(const std::string& param, const char* text) {
        const int p = index(param);
        statics_.text[p] = text;
        const auto& items = type_.params[p].items;
        for (size_t i = 0; i < items.size(); ++i)
            if (items[i].name == text) return statics_.enums[p] = static_cast<int>(i), *this;
        EXPECT_TRUE(items.empty()) << type_.name << "." << param << " has no item " << text;
        return *this;
    }
    /// One value a point in channel `component` of the parameter, as a link would give.
    NodeCall& vary(const std::string& param, std::vector<double> x, int component = 0) {
        const int p = index(param);
        statics_.linked[p] = true;
        channel_[type_.channel_of(p) + component] = std::move(x);
        return *this;
    }
    NodeCall& global(Global g, std::initializer_list<double> x) {
        int c = 0;
        for (double v : x) vary_global(g, {v}, c++);
        return *this;
    }
    NodeCall& vary_global(Global g, std::vector<double> x, int component = 0) {
        for (size_t i = 0; i < type_.globals.size(); ++i)
            if (type_.globals[i] == g) channel_[type_.channel_of_global(static_cast<int>(i)) + component] = std::move(x);
        return *this;
    }
    Statics& statics() { return statics_; }
    /// Leaves an output unasked for: its channels read as NaN.
    NodeCall& without(const std::string& output) {
        int first = 0;
        for (const auto& o : type_.outputs) {
            for (int c = 0; c < channels(o.type); ++c, ++first)
                if (o.name == output) unasked_.push_back(first);
        }
        return *this;
    }

    /// All channels of all outputs, each with one value a point.
    std::vector<std::vector<double>> run(Path path = Path::Lanes) {
        if (type_.prepare && !statics_.prepared) {
            std::vector<std::string> errors;
            statics_.prepared = type_.prepare(statics_, errors);
            EXPECT_TRUE(errors.empty()) << type_.name << ": " << errors[0];
        }
        if (path == Path::Double) return run_as<double>(type_.kernel.f64);
        return run_as<float>(path == Path::Lanes ? type_.kernel.lanes : type_.kernel.scalar);
    }
    /// First channel at the first point.
    double value(Path path = Path::Lanes) { return run(path)[0][0]; }

  private:
    int index(const std::string& param) const {
        const int p = type_.param_index(param);
        if (p < 0) ADD_FAILURE() << type_.name << " has no parameter " << param;
        return std::max(p, 0);
    }
    template <class R>
    std::vector<std::vector<double>> run_as(void (*kernel)(const OpCall<R>&)) {
        const size_t padded = (n_ + kPadding - 1) / kPadding * kPadding;
        const R nan = std::numeric_limits<R>::quiet_NaN();
        std::vector<std::vector<R>> in, out;
        std::vector<Channel<R>> channel;
        for (const auto& c : channel_) {
            const bool uniform = c.size() == 1;
            std::vector<R> v(padded, uniform ? static_cast<R>(c[0]) : nan);
            for (size_t i = 0; !uniform && i < std::min(c.size(), n_); ++i) v[i] = static_cast<R>(static_cast<float>(c[i]));
            if (uniform) std::fill(v.begin(), v.end(), static_cast<R>(static_cast<float>(c[0])));
            in.push_back(std::move(v));
            channel.push_back({in.back().data(), uniform ? 0u : 1u});
        }
        int outputs = 0;
        for (const auto& o : type_.outputs) outputs += channels(o.type);
        out.assign(outputs, std::vector<R>(padded, nan));
        std::vector<R*> p;
        for (auto& o : out) p.push_back(o.data());
        for (int c : unasked_) p[c] = nullptr;
        const EvalContext context;
        kernel({channel.data(), p.data(), &statics_, &context, static_cast<uint32_t>(n_)});
        std::vector<std::vector<double>> result;
        for (auto& o : out) result.emplace_back(o.begin(), o.begin() + n_);
        return result;
    }

    const NodeType& type_;
    size_t n_;
    Statics statics_;
    std::vector<std::vector<double>> channel_;   ///< one number, or one a point
    std::vector<int> unasked_;                   ///< output channels
};

}  // namespace alder::test
