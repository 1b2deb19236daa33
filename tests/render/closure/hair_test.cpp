// Laws of fibre lobes and of measured tables: samples follow the density, weight = f cos / density, white furnaces, reciprocity
// where it holds, nothing non-finite.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>

#include "nodes/surface/merl.h"
#include "tests/render/closure/chi2.h"
#include "tests/render/closure/lobe_fixture.h"

namespace alder::testing {
namespace {

/// A made-up measured surface: a coloured highlight over a diffuse base, with a grazing rise.
std::shared_ptr<const MerlTable> made_up_table() {
    static const std::shared_ptr<const MerlTable> table = [] {
        std::vector<double> numbers(size_t{3} * MerlTable::kCells);
        for (int h = 0; h < 90; ++h)
            for (int d = 0; d < 90; ++d)
                for (int p = 0; p < 180; ++p) {
                    const double theta = MerlTable::band_edge(h);
                    for (int c = 0; c < 3; ++c)
                        numbers[size_t(c) * MerlTable::kCells + p + 180 * (d + 90 * h)] =
                            1500 * (0.05 * (c + 1) + 2 * std::exp(-60 * theta * theta) + 0.2 * std::pow(d / 90.0, 5)) * (1 + 0.1 * std::cos(2 * kPi<double> * p / 180));
                }
        auto t = std::make_shared<MerlTable>();
        t->set(numbers.data());
        return t;
    }();
    return table;
}

struct HairCase {
    std::string name;
    LobeSpec spec;
    std::function<void(Lobe<double>&, Random&)> fill;
    bool slow = false;  ///< an integral stands behind each value
};

void no_absorption(Lobe<double>& l) { l.p[0] = l.p[1] = l.p[2] = 0; }
double variance(double r) { return std::pow(0.726 * r + 0.812 * r * r + 3.7 * std::pow(r, 20), 2); }

std::vector<HairCase> hair_cases() {
    std::vector<HairCase> cases;
    const auto add = [&](std::string name, LobeKind kind, std::function<void(Lobe<double>&, Random&)> fill, int order = 0, bool slow = false) {
        LobeSpec spec{.kind = kind};
        spec.order = static_cast<int8_t>(order);
        cases.push_back({std::move(name), spec, std::move(fill), slow});
    };
    const auto absorb = [](Lobe<double>& l, Random& r) {
        for (int c = 0; c < 3; ++c) l.p[c] = r(0, 1);
    };
    const auto cycles = [](Lobe<double>& l, Random& r) { l.p[0] = r(-0.4, 0.4), l.p[1] = r(0.05, 1), l.p[2] = r(0.05, 1); };
    add("reflection", LobeKind::HairReflection, cycles);
    add("transmission", LobeKind::HairTransmission, cycles);
    add("chiang", LobeKind::HairChiang, [=](Lobe<double>& l, Random& r) {
        absorb(l, r);
        l.p[3] = variance(r(0.1, 1)), l.p[4] = variance(r(0.1, 1)), l.p[5] = r(0.05, 2), l.p[6] = r(-0.2, 0.2), l.p[7] = r(1.1, 2), l.p[8] = r(-1, 1);
    });
    for (int order = 0; order < 4; ++order)
        add("order_" + std::to_string(order), LobeKind::HairOrder, [=](Lobe<double>& l, Random& r) {
            absorb(l, r);
            l.p[3] = variance(r(0.1, 1)), l.p[4] = r(0.05, 2), l.p[5] = r(-0.4, 0.4), l.p[6] = r(1.1, 2), l.p[7] = r(-1, 1);
        }, order);
    const auto huang = [=](Lobe<double>& l, Random& r, double aspect, double coverage) {
        absorb(l, r);
        l.p[3] = r(0.25, 1), l.p[4] = r(-0.1, 0.1), l.p[5] = r(1.2, 1.9), l.p[6] = aspect, l.p[7] = r(-0.5, 0.5), l.p[8] = coverage;
        l.p[9] = r(), l.p[10] = r(), l.p[11] = r();
        l.n = aspect < 1 ? normalize(cross(l.t, r.direction())) : Vec3d(0, 0, 0);
    };
    add("huang_near", LobeKind::HairHuang, [=](Lobe<double>& l, Random& r) { huang(l, r, 1, 0.3); }, 0, true);
    add("huang_far", LobeKind::HairHuang, [=](Lobe<double>& l, Random& r) { huang(l, r, 1, 1); }, 0, true);
    add("huang_ellipse", LobeKind::HairHuang, [=](Lobe<double>& l, Random& r) { huang(l, r, 0.7, 1); }, 0, true);
    add("huang_first", LobeKind::HairHuang, [=](Lobe<double>& l, Random& r) { huang(l, r, 1, 1), l.p[10] = l.p[11] = 0; });
    add("kajiya", LobeKind::HairKajiya, [](Lobe<double>&, Random&) {});
    add("al_glossy", LobeKind::HairGlossy, [](Lobe<double>& l, Random& r) { l.p[0] = r(-0.3, 0.3), l.p[1] = r(0.03, 0.5); });
    add("al_forward", LobeKind::HairForward, [](Lobe<double>& l, Random& r) { l.p[0] = r(-0.3, 0.3), l.p[1] = r(0.03, 0.5), l.p[2] = r(0.02, 0.5); });
    add("al_glint", LobeKind::HairGlint,
        [](Lobe<double>& l, Random& r) { l.p[0] = r(-0.3, 0.3), l.p[1] = r(0.03, 0.5), l.p[2] = r(0.02, 0.5), l.p[3] = r(0, 2 * kPi<double>); });
    add("al_dual", LobeKind::HairDual, [](Lobe<double>& l, Random& r) {
        for (int c = 0; c < 5; ++c) l.p[c] = r(0.05, 0.95);
        l.p[5] = -0.07, l.p[6] = 0.06, l.p[7] = 0.17, l.p[8] = 0.09;
    });
    add("measured", LobeKind::Measured, [](Lobe<double>&, Random&) {});
    cases.back().spec.prepared = made_up_table();
    return cases;
}

struct Setting {
    Lobe<double> lobe;
    ShadingView<double> view;
    std::string text;
};
Setting random_setting(const HairCase& c, Random& random, int i) {
    static const double angles[] = {0.0, 0.4, 0.9, 1.3, 1.5, 0.2};
    Setting s;
    s.view.ng = s.view.ns = Vec3d(0, 0, 1);
    s.view.wo = tilted(angles[i % 6], random(0, 6.28));
    s.lobe.spec = &c.spec;
    s.lobe.weight = Vec3d(1.0);
    s.lobe.t = c.spec.is_hair() ? normalize(tilted(kPi<double> / 2 - random(0, 0.3), random(0, 6.28))) : Vec3d(1, 0, 0);
    c.fill(s.lobe, random);
    s.text = c.name + " #" + std::to_string(i);
    for (int k = 0; k < c.spec.params(); ++k) s.text += " " + std::to_string(s.lobe.p[k]);
    return s;
}

class HairLaws : public ::testing::TestWithParam<HairCase> {};

TEST_P(HairLaws, samples_follow_the_density) {
    const HairCase& c = GetParam();
    Random random(12);
    const int settings = c.slow ? 3 : 8;
    for (int i = 0; i < settings; ++i) {
        const Setting s = random_setting(c, random, i);
        expect_samples_follow_density([&](Vec3d wi) { return eval_lobe(s.lobe, s.view, wi).pdf; },
                                      [&] { return sample_lobe(s.lobe, s.view, random(), random(), random()); }, c.slow ? 30000 : 50000,
                                      0.01 / (settings * hair_cases().size()), s.text);
    }
}

TEST_P(HairLaws, sample_agrees_with_eval) {
    const HairCase& c = GetParam();
    Random random(5);
    int valid = 0;
    for (int i = 0; i < 300; ++i) {
        const Setting s = random_setting(c, random, i);
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        if (!x.valid) continue;
        ++valid;
        const BsdfEval<double> e = eval_lobe(s.lobe, s.view, x.wi);
        EXPECT_NEAR(length(x.wi), 1, 1e-12) << s.text;
        EXPECT_NEAR(x.pdf / e.pdf, 1, 1e-9) << s.text;
        EXPECT_EQ(x.is_transmission, dot(x.wi, s.view.ng) < 0) << s.text;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(x.weight[k] * x.pdf, e.f_cos[k], 1e-9 * e.f_cos[k] + 1e-300) << s.text;
    }
    EXPECT_GT(valid, 80) << c.name;
}

TEST_P(HairLaws, float_follows_double) {
    const HairCase& c = GetParam();
    if (c.slow) GTEST_SKIP() << "estimated with numbers that follow from the directions' bits: other bits, other estimate";
    Random random(9);
    int outside = 0, count = 0;
    for (int i = 0; i < 1500; ++i) {
        Setting s = random_setting(c, random, i);
        Lobe<float> l;
        l.spec = s.lobe.spec;
        l.weight = cast<float>(s.lobe.weight), l.n = cast<float>(s.lobe.n), l.t = cast<float>(s.lobe.t);
        for (int k = 0; k < kMaxLobeParams; ++k) s.lobe.p[k] = l.p[k] = static_cast<float>(s.lobe.p[k]);
        const ShadingView<float> view{cast<float>(s.view.wo), cast<float>(s.view.ng), cast<float>(s.view.ns)};
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        const Vec3f wi = cast<float>(x.valid && i % 2 ? x.wi : random.direction());
        s.lobe.n = cast<double>(Vec3d(l.n.x, l.n.y, l.n.z));
        s.lobe.t = Vec3d(l.t.x, l.t.y, l.t.z);
        s.view.wo = Vec3d(view.wo.x, view.wo.y, view.wo.z);
        const BsdfEval<float> a = eval_lobe(l, view, wi);
        const BsdfEval<double> b = eval_lobe(s.lobe, s.view, Vec3d(wi.x, wi.y, wi.z));
        ++count;
        // Edges (a side, a table's cell, a visible facet) may fall on either side.
        bool close = std::abs(a.pdf - b.pdf) <= 2e-3 * b.pdf + 1e-6;
        for (int k = 0; k < 3; ++k) close = close && std::abs(a.f_cos[k] - b.f_cos[k]) <= 3e-3 * b.f_cos[k] + 1e-5;
        outside += !close;
    }
    EXPECT_LE(outside, count / 100) << c.name;
}

template <class T>
void expect_finite(const HairCase& c) {
    Random random(33);
    const double extremes[] = {0, 1e-30, 1e-7, 1e-4, 0.5, 1, 1 - 1e-7, 1.0001, 7, 1e9, 1e30, -1e-3, -1e30};
    const auto pick = [&] { return extremes[static_cast<int>(random() * std::size(extremes))]; };
    for (int i = 0; i < (c.slow ? 1500 : 8000); ++i) {
        const Setting s = random_setting(c, random, i);
        Lobe<T> l;
        l.spec = &c.spec;
        for (int k = 0; k < c.spec.params(); ++k) l.p[k] = static_cast<T>(random() < 0.3 && !(c.spec.kind == LobeKind::HairHuang && k == 3) ? pick() : s.lobe.p[k]);
        l.weight = Vec3<T>(static_cast<T>(std::abs(pick())));
        l.n = cast<T>(i % 3 ? s.lobe.n : random.direction());
        l.t = cast<T>(i % 4 ? s.lobe.t : random.direction());
        ShadingView<T> view;
        view.ng = view.ns = Vec3<T>(0, 0, 1);
        view.wo = i % 5 == 0 ? l.t : i % 7 == 0 ? -l.t : cast<T>(s.view.wo);
        view.unreachable_too = i % 2;
        view.fibres = static_cast<T>(i % 6 == 0 ? pick() : 0);
        view.fibre_variance = static_cast<T>(i % 6 == 0 ? pick() : 0);
        const auto u = [&] {
            const double x = random();
            return static_cast<T>(x < 0.1 ? 0 : x > 0.9 ? 1 - std::numeric_limits<T>::epsilon() / 2 : x);
        };
        const BsdfSample<T> x = sample_lobe(l, view, u(), u(), u());
        const auto finite = [](Vec3<T> v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
        std::string text = c.name + " " + std::to_string(i);
        for (int k = 0; k < c.spec.params(); ++k) text += " " + std::to_string(l.p[k]);
        ASSERT_TRUE(finite(x.weight) && std::isfinite(x.pdf) && x.pdf >= 0) << text << " pdf " << x.pdf << " w " << x.weight.x;
        if (x.valid) {
            ASSERT_TRUE(finite(x.wi)) << text;
            ASSERT_NEAR(length(x.wi), 1, 1e-5) << text;
        }
        for (const Vec3<T> wi : {x.wi, cast<T>(random.direction()), view.wo, -view.wo, l.t, -l.t}) {
            const BsdfEval<T> e = eval_lobe(l, view, wi);
            ASSERT_TRUE(finite(e.f_cos) && std::isfinite(e.pdf) && e.pdf >= 0) << text << " f " << e.f_cos.x << " p " << e.pdf;
        }
        ASSERT_TRUE(std::isfinite(lobe_sampling_weight(l, view.wo))) << text;
    }
}
TEST_P(HairLaws, finite_at_the_extremes) {
    expect_finite<float>(GetParam());
    expect_finite<double>(GetParam());
}

// Reciprocal: Kajiya and Kay's lobe, alHair's (symmetric in both thetas and in phi) and a measured table. Not: Cycles' Hair BSDF
// (its Cauchy is normalised for the viewer), Chiang's orders (path and Fresnel term are the viewer's), Huang's (the offset is
// integrated over the viewer's width, the facets are those that the viewer sees), dual scattering (its tables are the light's).
TEST_P(HairLaws, reciprocity) {
    const HairCase& c = GetParam();
    const LobeKind k = c.spec.kind;
    if (k != LobeKind::HairKajiya && k != LobeKind::HairGlossy && k != LobeKind::HairForward && k != LobeKind::HairGlint && k != LobeKind::Measured)
        GTEST_SKIP() << "not reciprocal: see the comment above";
    Random random(3);
    int outside = 0, count = 0;
    for (int i = 0; i < 500; ++i) {
        Setting s = random_setting(c, random, i % 4);
        const Vec3d wi = sample_lobe(s.lobe, s.view, random(), random(), random()).wi, wo = s.view.wo;
        const auto cosine = [&](Vec3d w) { return c.spec.is_hair() ? length(cross(s.lobe.t, w)) : w.z; };
        if (!(cosine(wi) > 0.05 && cosine(wo) > 0.05)) continue;
        const double forward = eval_lobe(s.lobe, s.view, wi).f_cos.y / cosine(wi);
        s.view.wo = wi;
        const double backward = eval_lobe(s.lobe, s.view, wo).f_cos.y / cosine(wo);
        ++count;
        outside += !(std::abs(forward - backward) <= (k == LobeKind::Measured ? 0.02 : 1e-9) * forward + 1e-300);
    }
    EXPECT_LE(outside, k == LobeKind::Measured ? count / 20 : 0) << "of " << count << "; a table's cells have edges";
    EXPECT_GT(count, 200);
}

Vec3d furnace(const std::function<BsdfSample<double>()>& sample, int n, double& deviation) {
    Vec3d mean(0, 0, 0);
    double square = 0;
    for (int i = 0; i < n; ++i) {
        const Vec3d w = sample().weight;
        mean += w / double(n);
        square += w.x * w.x / n;
    }
    deviation = std::sqrt(std::max(square - mean.x * mean.x, 0.0) / n);
    return mean;
}

TEST_P(HairLaws, no_energy_is_gained) {
    const HairCase& c = GetParam();
    const LobeKind kind = c.spec.kind;
    if (kind == LobeKind::HairGlossy || kind == LobeKind::HairForward || kind == LobeKind::HairGlint || kind == LobeKind::HairDual)
        GTEST_SKIP() << "alHair's lobes are not normalised: what a fibre keeps is in constants of their weights";
    if (kind == LobeKind::Measured) GTEST_SKIP() << "a table has the energy it has";
    Random random(21);
    for (int i = 0; i < (c.slow ? 4 : 12); ++i) {
        Setting s = random_setting(c, random, i % 4);
        if (kind == LobeKind::HairHuang) s.lobe.p[9] = s.lobe.p[10] = s.lobe.p[11] = 1;
        double deviation;
        const Vec3d mean = furnace([&] { return sample_lobe(s.lobe, s.view, random(), random(), random()); }, 20000, deviation);
        // Cycles' Bessel function is up to 2 % off; Huang's tables compensate for more than an inclined view loses.
        const double gain = kind == LobeKind::HairChiang ? 0.02 : kind == LobeKind::HairHuang ? 0.2 : 1e-9;
        for (int k = 0; k < 3; ++k) EXPECT_LE(mean[k], 1 + 5 * deviation + gain) << s.text;
        EXPECT_GE(mean.x, 0) << s.text;
    }
}

// A fibre that absorbs nothing sends on all light: the orders add up to 1, at any width, offset and index.
TEST(Hair, orders_of_a_clear_fibre_sum_to_one) {
    Random random(17);
    for (int i = 0; i < 10; ++i) {
        double sum = 0, error = 0;
        const Vec3d wo = tilted(random(0, 1.5), random(0, 6)), t = random.direction();
        const double h = random(-1, 1), eta = random(1.1, 2), v = variance(random(0.05, 1)), s = random(0.05, 2);
        for (int order = 0; order < 4; ++order) {
            LobeSpec spec{.kind = LobeKind::HairOrder};
            spec.order = static_cast<int8_t>(order);
            Lobe<double> l;
            l.spec = &spec;
            l.weight = Vec3d(1.0);
            l.t = t;
            l.p[3] = v, l.p[4] = s, l.p[5] = 0.1 * order, l.p[6] = eta, l.p[7] = h;
            const ShadingView<double> view{wo, wo, wo};
            double deviation;
            sum += furnace([&] { return sample_lobe(l, view, random(), random(), random()); }, 2000, deviation).x;
            error += deviation;
        }
        EXPECT_NEAR(sum, 1, 1e-9 + 5 * error) << "h " << h << " eta " << eta << " v " << v;
    }
}

TEST(Hair, chiang_white_furnace) {
    Random random(18);
    LobeSpec spec{.kind = LobeKind::HairChiang};
    for (const double r : {0.1, 0.2, 0.3, 0.5, 0.9})
        for (const double h : {-0.9, 0.0, 0.6}) {
            Lobe<double> l;
            l.spec = &spec;
            l.weight = Vec3d(1.0);
            l.t = Vec3d(1, 0, 0);
            no_absorption(l);
            l.p[3] = l.p[4] = variance(r), l.p[5] = 0.3, l.p[6] = 0.03, l.p[7] = 1.55, l.p[8] = h;
            const Vec3d wo = tilted(0.7, 0.5);
            const ShadingView<double> view{wo, wo, wo};
            double deviation;
            const double mean = furnace([&] { return sample_lobe(l, view, random(), random(), random()); }, 10000, deviation).x;
            // 2 %: the Bessel function that Cycles' values have.
            EXPECT_NEAR(mean, 1, 0.02 + 5 * deviation) << "roughness " << r << " h " << h;
        }
}

// Scales are not tilted, fibres clear, seen near the middle: Huang's model loses and gains little. Over the whole width it gains
// (up to 2.4 where nothing is absorbed): the ends of Simpson's rule weigh 22 times, and what goes on inside does not vanish there.
// Cycles' values have it, so ours do.
TEST(Hair, huang_white_furnace) {
    Random random(19);
    LobeSpec spec{.kind = LobeKind::HairHuang};
    for (const double r : {0.2, 0.4})
        for (const double coverage : {0.1, 0.3}) {
            Lobe<double> l;
            l.spec = &spec;
            l.weight = Vec3d(1.0);
            l.t = Vec3d(1, 0, 0);
            l.n = Vec3d(0, 0, 0);
            no_absorption(l);
            l.p[3] = r, l.p[4] = 0, l.p[5] = 1.55, l.p[6] = 1, l.p[7] = 0.1, l.p[8] = coverage, l.p[9] = l.p[10] = l.p[11] = 1;
            const Vec3d wo = tilted(0.4, 0.5);
            const ShadingView<double> view{wo, wo, wo};
            double deviation;
            const double mean = furnace([&] { return sample_lobe(l, view, random(), random(), random()); }, 20000, deviation).x;
            EXPECT_NEAR(mean, 1, 0.1 + 5 * deviation) << "roughness " << r << " coverage " << coverage;
        }
}

INSTANTIATE_TEST_SUITE_P(Kinds, HairLaws, ::testing::ValuesIn(hair_cases()), [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace alder::testing
