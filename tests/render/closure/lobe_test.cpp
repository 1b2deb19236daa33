// Laws of every lobe: samples follow the density, the density integrates to 1, weight = f cos / pdf, reciprocity, no
// energy gained, nothing non-finite.
#include <gtest/gtest.h>

#include <limits>

#include "tests/render/closure/lobe_fixture.h"

namespace alder::testing {
namespace {

/// Cells of equal area about an axis, on a sphere stretched so that narrow lobes fill many of them: the polar coordinate is
/// s = (1-c)/2 warped to s^(1/warp).
struct Cells {
    static constexpr int kRows = 24, kColumns = 32;
    closure::Frame<double> frame;
    double warp;
    int at(Vec3d w) const {
        const Vec3d l = frame.to_local(w);
        const double s = std::clamp((l.x * l.x + l.y * l.y) / (2 * (1 + std::abs(l.z))), 0.0, 0.5);
        const double polar = l.z >= 0 ? s : 1 - s;
        const int row = std::min(static_cast<int>(std::pow(polar, 1 / warp) * kRows), kRows - 1);
        const double phi = std::atan2(l.y, l.x) / (2 * kPi<double>) + 0.5;
        return row * kColumns + std::min(static_cast<int>(phi * kColumns), kColumns - 1);
    }
    Vec3d direction(double row, double column, double& jacobian) const {
        const double u = row / kRows, s = std::pow(u, warp), z = 1 - 2 * s, r = 2 * std::sqrt(std::max(s * (1 - s), 0.0));
        const double phi = (column / kColumns - 0.5) * 2 * kPi<double>;
        jacobian = 2 * warp * std::pow(u, warp - 1) / kRows * 2 * kPi<double> / kColumns;
        return frame.to_world({r * std::cos(phi), r * std::sin(phi), z});
    }
};

/// Probability that a chi-squared variable of k degrees exceeds x: Wilson and Hilferty's normal approximation.
double chi2_tail(double x, double k) {
    const double t = (std::cbrt(x / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
    return 0.5 * std::erfc(t / std::sqrt(2.0));
}

struct Setting {
    Lobe<double> lobe;
    ShadingView<double> view;
    std::string text;
};
Setting random_setting(const LobeCase& c, Random& random, int i, double alpha_min = 0.05) {
    Setting s{random_lobe<double>(c.spec, random, alpha_min), {}, {}};
    static const double angles[] = {0.0, 0.3, 0.8, 1.2, 1.45, 1.53};
    s.view.ng = s.view.ns = Vec3d(0, 0, 1);
    s.view.wo = tilted(angles[i % 6], random(0, 6.28));
    s.lobe.t = normalize(Vec3d(random(-1, 1), random(-1, 1), 0.3));
    if (i % 3 == 2) {  // bumped, but still visible
        Vec3d n;
        do n = normalize(tilted(random(0, 0.5), random(0, 6.28)));
        while (dot(n, s.view.wo) < 0.05);
        s.lobe.n = n;
    }
    s.text = c.name + " #" + std::to_string(i);
    for (int k = 0; k < c.spec.params(); ++k) s.text += " " + std::to_string(s.lobe.p[k]);
    return s;
}

/// The direction about which a lobe is narrowest, so that the cells resolve it.
Vec3d peak(const Setting& s) {
    Vec3d best = s.lobe.n;
    double density = 0;
    Random random(7);
    for (int i = 0; i < 200; ++i) {
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        if (x.valid && x.pdf > density) density = x.pdf, best = x.wi;
    }
    return best;
}

/// Midpoint rule over a square of cell coordinates.
double midpoint(const Setting& s, const Cells& cells, double row, double column, double size) {
    const int n = 4;
    double sum = 0;
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            double jacobian;
            const Vec3d wi = cells.direction(row + size * (a + 0.5) / n, column + size * (b + 0.5) / n, jacobian);
            sum += eval_lobe(s.lobe, s.view, wi).pdf * jacobian;
        }
    return sum * size * size / (n * n);
}
/// The density integrated over the square, refined where halving it still changes the result.
double integrate(const Setting& s, const Cells& cells, double row, double column, double size, int depth) {
    const double h = size / 2, coarse = midpoint(s, cells, row, column, size);
    double fine = 0;
    for (int q = 0; q < 4; ++q) fine += midpoint(s, cells, row + h * (q & 1), column + h * (q >> 1), h);
    if (depth == 6 || std::abs(fine - coarse) < 4e-7 + 3e-4 * fine) return fine;
    fine = 0;
    for (int q = 0; q < 4; ++q) fine += integrate(s, cells, row + h * (q & 1), column + h * (q >> 1), h, depth + 1);
    return fine;
}

class LobeLaws : public ::testing::TestWithParam<LobeCase> {};

// The expectation of a cell is the density integrated over it; rejected samples are one more cell, and everything sums to 1.
// p < 0.01 / number of settings tested (Bonferroni over all kinds) fails.
TEST_P(LobeLaws, samples_follow_the_density) {
    const LobeCase& c = GetParam();
    Random random(12);
    const int settings = 12, samples = 60000;
    const double significance = 0.01 / (settings * scattering_cases().size());
    for (int i = 0; i < settings; ++i) {
        const Setting s = random_setting(c, random, i);
        const Cells cells{closure::frame_around(peak(s)), 2.5};
        const int count = Cells::kRows * Cells::kColumns;
        std::vector<double> expected(count + 1, 0.0), observed(count + 1, 0.0);
        for (int row = 0; row < Cells::kRows; ++row)
            for (int column = 0; column < Cells::kColumns; ++column)
                expected[row * Cells::kColumns + column] = integrate(s, cells, row, column, 1, 0);
        for (int k = 0; k < samples; ++k) {
            const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
            ASSERT_FALSE(x.valid && x.is_delta) << s.text;
            ++observed[x.valid ? cells.at(x.wi) : count];
        }
        double total = 0;
        for (int k = 0; k < count; ++k) total += expected[k];
        const double rejected = observed[count] / samples;
        // Rejected samples are a binomial estimate: 4.5 standard deviations, and the quadrature's own error.
        const double deviation = std::sqrt(rejected * (1 - rejected) / samples);
        EXPECT_NEAR(total + rejected, 1, 4.5 * deviation + 2e-3) << s.text;
        expected[count] = std::max(1 - total, 0.0);
        double chi2 = 0, pooled_expected = 0, pooled_observed = 0;
        int degrees = -1;
        for (int k = 0; k <= count; ++k) {
            const double e = expected[k] * samples;
            if (e < 12) {
                pooled_expected += e;
                pooled_observed += observed[k];
                continue;
            }
            chi2 += (observed[k] - e) * (observed[k] - e) / e;
            ++degrees;
        }
        if (pooled_expected > 12) {
            chi2 += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
            ++degrees;
        }
        if (rejected < 0.9) {
            EXPECT_GT(degrees, 3) << s.text;
        }
        if (degrees < 1) continue;
        EXPECT_GT(chi2_tail(chi2, degrees), significance) << s.text << " chi2 " << chi2 << " of " << degrees;
    }
}

TEST_P(LobeLaws, sample_agrees_with_eval) {
    const LobeCase& c = GetParam();
    Random random(5);
    int valid = 0;
    for (int i = 0; i < 400; ++i) {
        const Setting s = random_setting(c, random, i, 0.02);
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        if (!x.valid) continue;
        ++valid;
        const BsdfEval<double> e = eval_lobe(s.lobe, s.view, x.wi);
        EXPECT_NEAR(length(x.wi), 1, 1e-12) << s.text;
        EXPECT_NEAR(x.pdf / e.pdf, 1, 1e-7) << s.text;
        EXPECT_EQ(x.is_transmission, dot(x.wi, s.view.ng) < 0) << s.text;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(x.weight[k] * x.pdf, e.f_cos[k], 1e-7 * e.f_cos[k] + 1e-300) << s.text;
    }
    EXPECT_GT(valid, 100) << c.name;
}

TEST_P(LobeLaws, float_follows_double) {
    const LobeCase& c = GetParam();
    Random random(9);
    for (int i = 0; i < 2000; ++i) {
        const Setting s = random_setting(c, random, i, 0.05);
        Lobe<float> l;
        l.spec = s.lobe.spec;
        l.weight = cast<float>(s.lobe.weight), l.n = cast<float>(s.lobe.n), l.t = cast<float>(s.lobe.t);
        for (int k = 0; k < kMaxLobeParams; ++k) l.p[k] = static_cast<float>(s.lobe.p[k]);
        const ShadingView<float> view{cast<float>(s.view.wo), cast<float>(s.view.ng), cast<float>(s.view.ns)};
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        const Vec3d wi = x.valid && i % 2 ? x.wi : random.direction();
        // Double at the rounded operands: the conditioning of the formula at the rounded direction is not float's fault.
        Setting r = s;
        for (int k = 0; k < kMaxLobeParams; ++k) r.lobe.p[k] = l.p[k];
        r.lobe.n = cast<double>(Vec3d(l.n.x, l.n.y, l.n.z));
        r.lobe.t = Vec3d(l.t.x, l.t.y, l.t.z);
        r.view.wo = Vec3d(view.wo.x, view.wo.y, view.wo.z);
        const Vec3<float> wf = cast<float>(wi);
        if (std::abs(wf.z) < 1e-3f || std::abs(dot(l.n, wf)) < 1e-3f) continue;
        const BsdfEval<float> a = eval_lobe(l, view, wf);
        const BsdfEval<double> b = eval_lobe(r.lobe, r.view, Vec3d(wf.x, wf.y, wf.z));
        // Edges (toon, total reflection, reachable facets) may fall on either side.
        if ((a.pdf > 0) != (b.pdf > 0)) continue;
        EXPECT_NEAR(a.pdf, b.pdf, 2e-3 * b.pdf + 1e-6) << s.text;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(a.f_cos[k], b.f_cos[k], 2e-3 * b.f_cos[k] + 1e-5) << s.text << " " << i;
    }
}

// f(wo, wi) = f(wi, wo) for reflection; with refraction f/eta² is symmetric, each seen from its own side.
TEST_P(LobeLaws, reciprocity) {
    const LobeCase& c = GetParam();
    if (c.spec.kind == LobeKind::SheenMicrofiber || c.spec.kind == LobeKind::SheenAshikhmin ||
        c.spec.kind == LobeKind::ToonDiffuse || c.spec.kind == LobeKind::ToonGlossy || c.spec.thin_film)
        GTEST_SKIP() << "not reciprocal by definition, or not from the far side";
    Random random(3);
    for (int i = 0; i < 500; ++i) {
        Setting s = random_setting(c, random, 3 * (i % 4));
        s.lobe.n = Vec3d(0, 0, 1);
        const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
        if (!x.valid || std::abs(x.wi.z) < 1e-3) continue;
        const bool through = x.is_transmission;
        if (through && c.spec.fresnel == FresnelMode::Principled) continue;  // tints differ by side
        const BsdfEval<double> forward = eval_lobe(s.lobe, s.view, x.wi);
        Setting back = s;
        back.view.wo = x.wi;
        Vec3d to = s.view.wo;
        double eta2 = 1;
        if (through) {  // turn everything over: the far side becomes the near one
            const double flip = -1;
            back.view.wo.z *= flip;
            to.z *= flip;
            back.lobe.t.z *= flip;
            const MicrofacetLayout at(c.spec);
            if (c.spec.is_microfacet() && at.eta >= 0) {
                eta2 = back.lobe.p[at.eta] * back.lobe.p[at.eta];
                back.lobe.p[at.eta] = 1 / back.lobe.p[at.eta];
            }
        }
        const BsdfEval<double> backward = eval_lobe(back.lobe, back.view, to);
        for (int k = 0; k < 3; ++k) {
            const double a = forward.f_cos[k] / std::abs(x.wi.z) / eta2, b = backward.f_cos[k] / std::abs(to.z);
            EXPECT_NEAR(a, b, 1e-6 * std::max(a, b)) << s.text;
        }
    }
}

TEST_P(LobeLaws, no_energy_is_gained) {
    const LobeCase& c = GetParam();
    if (c.spec.kind == LobeKind::SheenAshikhmin) GTEST_SKIP() << "the velvet's normal density is not normalised";
    Random random(21);
    for (int i = 0; i < 24; ++i) {
        Setting s = random_setting(c, random, i, 1e-3);
        s.lobe.n = Vec3d(0, 0, 1);
        if (c.spec.fresnel == FresnelMode::F82) for (int k = 0; k < 3; ++k) s.lobe.p[k + 1] = 1, s.lobe.p[k + 4] = 0;
        Vec3d mean(0, 0, 0), square(0, 0, 0);
        const int n = 20000;
        for (int k = 0; k < n; ++k) {
            const BsdfSample<double> x = sample_lobe(s.lobe, s.view, random(), random(), random());
            mean += x.weight;
            square += x.weight * x.weight;
        }
        for (int k = 0; k < 3; ++k) {
            const double m = mean[k] / n, deviation = std::sqrt(std::max(square[k] / n - m * m, 0.0) / n);
            // The energy-compensated Oren–Nayar is a fit, and the qualitative form gains a little at grazing angles.
            const double gain = c.spec.kind == LobeKind::Diffuse ? 1e-3 : c.spec.kind == LobeKind::OrenNayar ? 0.02 : 1e-9;
            EXPECT_LE(m, 1 + 5 * deviation + gain) << s.text;
            EXPECT_GE(m, 0) << s.text;
        }
    }
}

template <class T>
void expect_finite(const LobeCase& c) {
    Random random(33);
    const double extremes[] = {0, 1e-30, 1e-7, 1e-4, 0.5, 1, 1 - 1e-7, 1.0001, 7, 1e9, 1e30, -1e-3, -1e30};
    const auto pick = [&] { return extremes[static_cast<int>(random() * std::size(extremes))]; };
    for (int i = 0; i < 20000; ++i) {
        Lobe<T> l = random_lobe<T>(c.spec, random, 1e-5);
        for (int k = 0; k < c.spec.params(); ++k)
            if (random() < 0.3) l.p[k] = static_cast<T>(pick());
        l.weight = Vec3<T>(static_cast<T>(std::abs(pick())));
        const double grazing = random() < 0.5 ? kPi<double> / 2 - std::pow(10.0, random(-12, 0)) : random(0, 1.57);
        ShadingView<T> view;
        view.ng = view.ns = Vec3<T>(0, 0, 1);
        view.wo = cast<T>(tilted(grazing, random(0, 6.28)));
        if (i % 4 == 0) l.n = cast<T>(random.direction());
        if (i % 8 == 0) view.wo = l.n;
        l.t = i % 5 == 0 ? l.n : cast<T>(random.direction());
        const auto u = [&] {
            const double x = random();
            return static_cast<T>(x < 0.1 ? 0 : x > 0.9 ? 1 - std::numeric_limits<T>::epsilon() / 2 : x);
        };
        view.unreachable_too = i % 2;
        const BsdfSample<T> s = sample_lobe(l, view, u(), u(), u());
        const auto finite = [](Vec3<T> v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
        std::string text = c.name;
        for (int k = 0; k < c.spec.params(); ++k) text += " " + std::to_string(l.p[k]);
        ASSERT_TRUE(finite(s.weight) && std::isfinite(s.pdf) && s.pdf >= 0) << text << " pdf " << s.pdf << " w " << s.weight.x;
        if (s.valid) {
            ASSERT_TRUE(finite(s.wi)) << text;
            ASSERT_NEAR(length(s.wi), 1, 1e-5) << text;
        }
        for (const Vec3<T> wi : {s.wi, cast<T>(random.direction()), view.wo, -view.wo, Vec3<T>(0, 0, 1), Vec3<T>(1, 0, 0)}) {
            const BsdfEval<T> e = eval_lobe(l, view, wi);
            ASSERT_TRUE(finite(e.f_cos) && std::isfinite(e.pdf) && e.pdf >= 0) << text << " f " << e.f_cos.x << " p " << e.pdf;
        }
        ASSERT_TRUE(std::isfinite(lobe_sampling_weight(l, view.wo))) << text;
    }
}
TEST_P(LobeLaws, finite_at_the_extremes) {
    expect_finite<float>(GetParam());
    expect_finite<double>(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Kinds, LobeLaws, ::testing::ValuesIn(scattering_cases()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace alder::testing
