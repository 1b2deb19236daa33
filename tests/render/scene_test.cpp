// Transform: laws of affine maps.
#include "render/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alder {
namespace {

Transform sheared() { return {{2, 0.5f, 0, 3, 0, 1, 0.25f, -1, 0.1f, 0, -3, 7}}; }

TEST(Transform, inverse_undoes_points_and_vectors) {
    const Transform t = sheared(), i = t.inverse();
    const Vec3f p(0.3f, -2, 5), q = i.point(t.point(p)), v = i.vector(t.vector(p));
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(q[k], p[k], 1e-5f) << "component " << k;
        EXPECT_NEAR(v[k], p[k], 1e-5f) << "component " << k;
    }
}

TEST(Transform, product_applies_the_right_factor_first) {
    const Transform a = sheared(), b{{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3}};
    const Vec3f p(1, 2, 3), x = (a * b).point(p), y = a.point(b.point(p));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(x[k], y[k], 1e-5f);
}

TEST(Transform, normals_stay_perpendicular_to_the_surface) {
    const Transform t = sheared();
    const Vec3f a(1, 2, 0.5f), b(-0.3f, 1, 2), n = cross(a, b);
    const Vec3f m = t.normal(n);
    EXPECT_NEAR(dot(m, t.vector(a)), 0, 1e-5f);
    EXPECT_NEAR(dot(m, t.vector(b)), 0, 1e-5f);
}

TEST(Transform, determinant_has_the_sign_of_the_orientation) {
    EXPECT_NEAR(sheared().determinant(), 2 * (1 * -3) - 0.5f * (0 - 0.25f * 0.1f), 1e-5f);
    EXPECT_FLOAT_EQ(Transform{}.determinant(), 1);
}

TEST(Transform, singular_maps_invert_to_the_identity) {
    const Transform flat{{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 0, 7}};
    EXPECT_EQ(flat.inverse().m, Transform{}.m);
    const Vec3f n = flat.normal(Vec3f(0, 0, 1));
    EXPECT_EQ(n.x, 0);
    EXPECT_EQ(n.y, 0);
    EXPECT_GT(n.z, 0);
    const Transform nan{{NAN, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    EXPECT_EQ(nan.inverse().m, Transform{}.m);
}

}  // namespace
}  // namespace alder
