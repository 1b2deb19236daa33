// The elementary functions on lanes against libm in double, on every instruction set this machine has: random arguments,
// and arguments chosen to hurt (special values, domain edges, neighbours of zeros and multiples of π/2, denormals).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/nodes/num/math_test.cpp"
#include "hwy/foreach_target.h"

#include "nodes/num/math-inl.h"

#ifndef ALDER_MATH_TEST_LISTS
#define ALDER_MATH_TEST_LISTS
#define ALDER_MATH_TEST_UNARY(X) \
    X(exp) X(exp2) X(log) X(log2) X(log10) X(sin) X(cos) X(tan) X(asin) X(acos) X(atan) X(sinh) X(cosh) X(tanh) X(cbrt)
#define ALDER_MATH_TEST_BINARY(X) X(pow) X(atan2) X(fmod)
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {
#define X(name)                                                                     \
    void test_##name(const float* x, const float*, float* out, size_t n) {          \
        for (size_t i = 0; i < n; i += hn::Lanes(TagF()))                           \
            hn::StoreU(name(VF(hn::LoadU(TagF(), x + i))).v, TagF(), out + i);      \
    }
ALDER_MATH_TEST_UNARY(X)
#undef X
#define X(name)                                                                                                      \
    void test_##name(const float* x, const float* y, float* out, size_t n) {                                         \
        for (size_t i = 0; i < n; i += hn::Lanes(TagF()))                                                            \
            hn::StoreU(name(VF(hn::LoadU(TagF(), x + i)), VF(hn::LoadU(TagF(), y + i))).v, TagF(), out + i);         \
    }
ALDER_MATH_TEST_BINARY(X)
#undef X
}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "hwy/targets.h"

namespace alder {
#define X(name) HWY_EXPORT(test_##name);
ALDER_MATH_TEST_UNARY(X)
ALDER_MATH_TEST_BINARY(X)
#undef X

using LanesFn = void (*)(const float*, const float*, float*, size_t);
struct Fn {
    const char* name;
    bool binary;
    LanesFn lanes;
    double (*exact)(double, double);
    double ulp_limit;
};
static std::vector<Fn> functions() {
    std::vector<Fn> v;
#define X(name)                                                                                                        \
    v.push_back({#name, false, [](const float* x, const float* y, float* o, size_t n) { HWY_DYNAMIC_DISPATCH(test_##name)(x, y, o, n); }, \
                 [](double a, double) { return std::name(a); }, 2.0});
    ALDER_MATH_TEST_UNARY(X)
#undef X
#define X(name)                                                                                                        \
    v.push_back({#name, true, [](const float* x, const float* y, float* o, size_t n) { HWY_DYNAMIC_DISPATCH(test_##name)(x, y, o, n); }, \
                 [](double a, double b) { return std::name(a, b); }, 2.0});
    ALDER_MATH_TEST_BINARY(X)
#undef X
    // The logarithms, pow and cbrt round a double once; tan divides two rounded series, asin subtracts from π/2.
    for (Fn& f : v) {
        const std::string n = f.name;
        if (n == "fmod") f.ulp_limit = 0;
        else if (n == "log" || n == "log2" || n == "log10" || n == "pow" || n == "cbrt") f.ulp_limit = 0.51;
        else if (n == "tan" || n == "asin") f.ulp_limit = 3;
    }
    return v;
}

/// Distance in units of the last place of the exact value as a float.
static double ulps(float got, double exact) {
    if (std::isnan(exact)) return std::isnan(got) ? 0 : 1e30;
    const float nearest = static_cast<float>(exact);
    if (std::isnan(got)) return 1e30;
    if (exact == 0) return got == 0 && std::signbit(got) == std::signbit(exact) ? 0 : 1e30;
    if (std::isinf(got) && std::isinf(nearest)) return got == nearest ? 0 : 1e30;
    if (std::isinf(exact)) return 1e30;
    // At the overflow threshold either side is right: infinity counts as 2^128.
    const double value = std::isinf(got) ? std::copysign(std::ldexp(1.0, 128), got) : got;
    const int exponent = std::clamp(std::ilogb(exact), -126, 127);
    return std::fabs(value - exact) / std::ldexp(1.0, exponent - 23);
}

static std::vector<float> adversarial() {
    const float inf = std::numeric_limits<float>::infinity();
    std::vector<float> v = {0.f, 1e-45f, 1e-40f, 1.17549435e-38f, 1e-30f, 1e-10f, 1e-5f, 0.25f, 1.f / 3, 0.41421357f, 0.5f, 0.625f, 0.70710677f,
                            1.f, 1.4142135f, 2.f, 2.4142137f, 3.f, 4.f, 5.f, 7.f, 10.f, 42.f, 87.33655f, 88.72283f, 88.8f, 89.41599f, 89.5f,
                            103.97f, 104.5f, 127.f, 127.99999f, 128.f, 149.f, 149.5f, 150.5f, 1e3f, 65536.f, 1.6e6f, 1.7e6f, 16777215.f,
                            16777216.f, 16777217.f, 2147483648.f, 1e10f, 1e20f, 1e38f, 2e38f, 3.4028235e38f, inf, std::nanf("")};
    for (int k = 1; k <= 64; ++k)
        v.push_back(static_cast<float>(k * 1.57079632679489661923)), v.push_back(static_cast<float>(k * 15707.9632679489661923));
    const size_t n = v.size();
    for (size_t i = 0; i < n; ++i) {
        v.push_back(std::nextafter(v[i], -inf));
        v.push_back(std::nextafter(v[i], inf));
    }
    const size_t m = v.size();
    for (size_t i = 0; i < m; ++i) v.push_back(-v[i]);
    return v;
}

static std::vector<std::pair<float, float>> arguments(bool binary) {
    std::vector<std::pair<float, float>> a;
    const std::vector<float> hard = adversarial();
    if (binary) {
        for (size_t i = 0; i < hard.size(); ++i)
            for (size_t j = 0; j < hard.size(); j += 1 + (i + j) % 5) a.emplace_back(hard[i], hard[j]);
    } else {
        for (float x : hard) a.emplace_back(x, 0.f);
    }
    std::mt19937 rng(7);
    std::uniform_real_distribution<float> unit(-1, 1), wide(-110, 110), log10s(-38, 38), small(-4, 4);
    std::uniform_int_distribution<int> integer(-20, 20);
    for (int i = 0; i < 60000; ++i) {
        const float any_x = std::bit_cast<float>(static_cast<uint32_t>(rng())), any_y = std::bit_cast<float>(static_cast<uint32_t>(rng()));
        switch (i % 6) {
            case 0: a.emplace_back(unit(rng), unit(rng)); break;
            case 1: a.emplace_back(wide(rng), wide(rng)); break;
            case 2: a.emplace_back(any_x, any_y); break;
            case 3: a.emplace_back(std::pow(10.f, log10s(rng)), small(rng)); break;
            case 4: a.emplace_back(wide(rng), static_cast<float>(integer(rng))); break;
            default: a.emplace_back(std::fabs(1 + 1e-3f * unit(rng)), 1e4f * wide(rng)); break;
        }
    }
    while (a.size() % 16) a.emplace_back(1.f, 1.f);
    return a;
}

class MathOnEveryTarget : public testing::TestWithParam<int64_t> {
  protected:
    void SetUp() override {
        hwy::SetSupportedTargetsForTest(GetParam());
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    void TearDown() override {
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

TEST_P(MathOnEveryTarget, is_within_its_ulp_bound_of_libm_in_double) {
    for (const Fn& f : functions()) {
        const auto args = arguments(f.binary);
        std::vector<float> x, y, out(args.size());
        for (auto [p, q] : args) x.push_back(p), y.push_back(q);
        f.lanes(x.data(), y.data(), out.data(), out.size());
        double worst = 0;
        size_t at = 0;
        for (size_t i = 0; i < out.size(); ++i) {
            const double u = ulps(out[i], f.exact(x[i], y[i]));
            if (u > worst) worst = u, at = i;
        }
        EXPECT_LE(worst, f.ulp_limit) << f.name << "(" << x[at] << ", " << y[at] << ") = " << out[at] << ", exact "
                                      << f.exact(x[at], y[at]) << " on " << hwy::TargetName(GetParam());
        RecordProperty(std::string("ulp_") + f.name, std::to_string(worst));
    }
}

/// Each compiled instruction set that this CPU has.
static std::vector<int64_t> targets() {
    std::vector<int64_t> v;
    for (int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest; rest &= rest - 1) v.push_back(rest & -rest);
    return v;
}
INSTANTIATE_TEST_SUITE_P(Math, MathOnEveryTarget, testing::ValuesIn(targets()),
                         [](const auto& info) { return std::string(hwy::TargetName(info.param)); });

}  // namespace alder
#endif
