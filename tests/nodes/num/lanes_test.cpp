// The lane types: each operation on every lane of every instruction set gives the bits that the same operation gives on a
// scalar; and the scalar's special cases are what the header promises.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/nodes/num/lanes_test.cpp"
#include "hwy/foreach_target.h"

#include "nodes/num/lanes-inl.h"

#ifndef ALDER_LANES_TEST_RESULTS
#define ALDER_LANES_TEST_RESULTS
namespace alder {
constexpr int kOutputs = 64;
constexpr float kTable[8] = {0.5f, -1, 2, 3.25f, -4, 5, 6, 7.5f};
constexpr int32_t kIntTable[8] = {10, -11, 12, 13, -14, 15, 16, 17};
}  // namespace alder
#endif

HWY_BEFORE_NAMESPACE();
namespace alder::HWY_NAMESPACE {

inline constexpr TableOfTwos<16> kTwos16({1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, 0, -1, 0});
inline constexpr TableOfTwos<32> kTwos32({1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0});

template <class F>
struct Sink {
    float* out;   ///< kOutputs rows of n
    size_t n, i;
    int row = 0;
    HWY_INLINE Sink(float* o, size_t count, size_t at) : out(o), n(count), i(at) {}
    HWY_INLINE void put(F x) {
        float* const p = out + static_cast<size_t>(row++) * n + i;
        if constexpr (std::is_same_v<F, VF>) hn::StoreU(x.v, TagF(), p);
        else *p = x;
    }
    HWY_INLINE void put_int(Int<F> x) { put(bits_to_float<F>(x)); }
    HWY_INLINE void put_mask(Mask<F> m) { put(select(m, F(1), F(0))); }
};
template <class F>
HWY_INLINE void all_operations(F a, F b, Int<F> p, Int<F> q, Sink<F>& s) {
    s.put(a + b), s.put(a - b), s.put(a * b), s.put(a / b), s.put(-a);
    s.put_mask(a < b), s.put_mask(a <= b), s.put_mask(a > b), s.put_mask(a >= b), s.put_mask(a == b), s.put_mask(a != b);
    s.put_int(p + q), s.put_int(p - q), s.put_int(p * q), s.put_int(p & q), s.put_int(p | q), s.put_int(p ^ q);
    s.put_mask(p == q), s.put_mask(p != q), s.put_mask(p < q), s.put_mask(p > q), s.put_mask(p <= q), s.put_mask(p >= q);
    s.put_int(shl<5>(p)), s.put_int(shr<5>(p)), s.put_int(sar<5>(p)), s.put_int(rotl<11>(p));
    s.put_int(min(p, q)), s.put_int(max(p, q)), s.put_int(select(p < q, p, q));
    s.put(min(a, b)), s.put(max(a, b)), s.put(select(a < b, a, b));
    s.put(abs(a)), s.put(floor(a)), s.put(ceil(a)), s.put(trunc(a)), s.put(sqrt(a)), s.put(copysign(a, b));
    s.put_mask(isnan(a)), s.put_mask(isfinite(a)), s.put_mask((a < b) & (p < q)), s.put_mask((a < b) | (p < q)), s.put_mask(!(a < b));
    s.put_int(to_int(a)), s.put(to_float<F>(p)), s.put(unsigned_to_float<F>(p)), s.put_int(float_bits(a));
    s.put(gather<F>(kTable, p & Int<F>(7))), s.put_int(gather_int<F>(kIntTable, q & Int<F>(7)));
    s.put(lookup<F>(kTwos16, p)), s.put(lookup<F>(kTwos32, p));
    const F small = clamp(select(isfinite(a), a, F(0)), F(-4e6), F(4e6));
    s.put_int(small_floor_to_int(floor(small)));
    s.put(lerp(a, b, F(0.25))), s.put(saturate(a)), s.put(safe_sqrt(a)), s.put(safe_divide(a, b)), s.put(sqr(a));
    s.put(map_lanes(a, [](auto x) { return x * 2 + 1; })), s.put(map_lanes(a, b, [](auto x, auto y) { return x - 3 * y; }));
}
void lanes_operations(const float* a, const float* b, const int32_t* p, const int32_t* q, float* out, size_t n) {
    for (size_t i = 0; i < n; i += hn::Lanes(TagF())) {
        Sink<VF> s(out, n, i);
        all_operations<VF>(VF(hn::LoadU(TagF(), a + i)), VF(hn::LoadU(TagF(), b + i)), VI(hn::LoadU(TagI(), p + i)), VI(hn::LoadU(TagI(), q + i)), s);
    }
}
#if HWY_ONCE
void scalar_operations(const float* a, const float* b, const int32_t* p, const int32_t* q, float* out, size_t n) {
    for (size_t i = 0; i < n; ++i) {
        Sink<float> s(out, n, i);
        all_operations<float>(a[i], b[i], p[i], q[i], s);
    }
}
#endif
int lanes_any_all() {
    const size_t w = hn::Lanes(TagF());
    HWY_ALIGN float x[HWY_MAX_BYTES / sizeof(float)] = {};
    int wrong = 0;
    for (size_t set = 0; set <= w; ++set) {   // the first `set` lanes are true
        for (size_t i = 0; i < w; ++i) x[i] = i < set ? 1.0f : 0.0f;
        const VM m = VF(hn::Load(TagF(), x)) != VF(0);
        wrong += any(m) != (set > 0);
        wrong += all(m) != (set == w);
    }
    wrong += !all(VM(true)) + any(VM(false));
    return wrong;
}

}  // namespace alder::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

#include "hwy/targets.h"

namespace alder {
HWY_EXPORT(lanes_operations);
HWY_EXPORT(lanes_any_all);

class LanesOnEveryTarget : public testing::TestWithParam<int64_t> {
  protected:
    void SetUp() override { choose(GetParam()); }
    void TearDown() override { choose(0); }
    static void choose(int64_t targets) {
        hwy::SetSupportedTargetsForTest(targets);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};
TEST_P(LanesOnEveryTarget, operations_give_the_bits_of_the_scalar) {
    const float inf = INFINITY, special[] = {0.f, -0.f, 1.f, -1.f, 0.5f, -0.5f, 1e-45f, -1e-40f, 1e30f, -3.4e38f, inf, -inf, NAN, 2147483520.f,
                                             2147483648.f, -2147483648.f, -2147483904.f, 8388607.5f, -8388608.f, 16777216.f};
    const int32_t ints[] = {0, 1, -1, 7, 255, INT32_MAX, INT32_MIN, INT32_MIN + 1, 0x55555555, -12345678};
    std::vector<float> a, b;
    std::vector<int32_t> p, q;
    for (float x : special)
        for (float y : special) a.push_back(x), b.push_back(y), p.push_back(ints[a.size() % 10]), q.push_back(ints[a.size() / 10 % 10]);
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> value(-1000, 1000);
    while (a.size() < 4096) a.push_back(value(rng)), b.push_back(value(rng)), p.push_back(static_cast<int32_t>(rng())), q.push_back(static_cast<int32_t>(rng()));
    const size_t n = a.size();
    std::vector<float> lanes(kOutputs * n, -7.f), scalar(kOutputs * n, -7.f);
    HWY_DYNAMIC_DISPATCH(lanes_operations)(a.data(), b.data(), p.data(), q.data(), lanes.data(), n);
    HWY_STATIC_DISPATCH(scalar_operations)(a.data(), b.data(), p.data(), q.data(), scalar.data(), n);
    int differ = 0;
    for (size_t i = 0; i < lanes.size(); ++i) {
        int32_t x, y;
        std::memcpy(&x, &lanes[i], 4), std::memcpy(&y, &scalar[i], 4);
        if (x == y || (std::isnan(lanes[i]) && std::isnan(scalar[i]))) continue;
        if (++differ < 5) {
            ADD_FAILURE() << "operation " << i / n << " of " << a[i % n] << ", " << b[i % n] << ", " << p[i % n] << ", " << q[i % n] << ": lanes "
                          << lanes[i] << ", scalar " << scalar[i];
        }
    }
    EXPECT_EQ(differ, 0);
}
TEST_P(LanesOnEveryTarget, any_and_all_see_every_lane) { EXPECT_EQ(HWY_DYNAMIC_DISPATCH(lanes_any_all)(), 0); }

static std::vector<int64_t> lane_targets() {
    std::vector<int64_t> v;
    for (int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest; rest &= rest - 1) v.push_back(rest & -rest);
    return v;
}
INSTANTIATE_TEST_SUITE_P(Lanes, LanesOnEveryTarget, testing::ValuesIn(lane_targets()),
                         [](const auto& info) { return std::string(hwy::TargetName(info.param)); });

TEST(Lanes, scalar_special_cases_are_what_the_header_promises) {
    using namespace HWY_NAMESPACE;
    const float nan = NAN;
    EXPECT_EQ(HWY_NAMESPACE::min(1.0f, nan), 1.0f);   // a NaN in the second place is dropped
    EXPECT_TRUE(std::isnan(HWY_NAMESPACE::min(nan, 1.0f)));
    EXPECT_EQ(HWY_NAMESPACE::max(1.0f, nan), 1.0f);
    EXPECT_TRUE(std::isnan(HWY_NAMESPACE::max(nan, 1.0f)));
    EXPECT_EQ(to_int(nan), INT32_MIN);
    EXPECT_EQ(to_int(2147483648.0f), INT32_MIN);
    EXPECT_EQ(to_int(-2147483648.0f), INT32_MIN);
    EXPECT_EQ(to_int(2147483520.0f), 2147483520);
    EXPECT_EQ(to_int(-1.9f), -1);
    EXPECT_EQ(unsigned_to_float<float>(-1), 4294967296.0f);
    EXPECT_EQ(safe_divide(3.0f, 0.0f), 0.0f);
    EXPECT_EQ(HWY_NAMESPACE::lerp(0.1f, 0.7f, 1.0f), 0.7f);
    EXPECT_EQ(shr<4>(-1), 0x0fffffff);
    EXPECT_EQ(sar<4>(-16), -1);
    EXPECT_EQ(rotl<8>(0x12345678), 0x34567812);
}
}  // namespace alder
#endif
