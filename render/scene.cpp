// Transform: affine maps of points, vectors and normals, as the scene holds them.
#include "render/scene.h"

#include <cmath>

namespace alder {
namespace {

/// Cofactors of the linear part in double: the inverse transpose is cofactors / determinant.
std::array<double, 9> cofactors(const std::array<float, 12>& m) {
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6], g = m[8], h = m[9], i = m[10];
    return {e * i - f * h, f * g - d * i, d * h - e * g, c * h - b * i, a * i - c * g,
            b * g - a * h, b * f - c * e, c * d - a * f, a * e - b * d};
}

double determinant_of(const std::array<float, 12>& m, const std::array<double, 9>& c) {
    return double(m[0]) * c[0] + double(m[1]) * c[1] + double(m[2]) * c[2];
}

}  // namespace

Vec3f Transform::point(Vec3f p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

Vec3f Transform::vector(Vec3f v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

Vec3f Transform::normal(Vec3f n) const {
    const std::array<double, 9> c = cofactors(m);
    const double det = determinant_of(m, c);
    // A singular map flattens space: its cofactors still give the direction of the flattened normal.
    const double s = std::isnormal(det) ? 1 / det : 1;
    return {float(s * (c[0] * n.x + c[1] * n.y + c[2] * n.z)), float(s * (c[3] * n.x + c[4] * n.y + c[5] * n.z)),
            float(s * (c[6] * n.x + c[7] * n.y + c[8] * n.z))};
}

Transform Transform::inverse() const {
    const std::array<double, 9> c = cofactors(m);
    const double det = determinant_of(m, c);
    if (!std::isnormal(det)) return Transform{};
    const double s = 1 / det;
    Transform r;
    for (int row = 0; row < 3; ++row) {
        double t = 0;
        for (int col = 0; col < 3; ++col) {
            const double x = c[col * 3 + row] * s;
            r.m[row * 4 + col] = float(x);
            t -= x * m[col * 4 + 3];
        }
        r.m[row * 4 + 3] = float(t);
    }
    return r;
}

Transform Transform::operator*(const Transform& b) const {
    Transform r;
    for (int row = 0; row < 3; ++row) {
        for (int col = 0; col < 4; ++col) {
            double x = col == 3 ? m[row * 4 + 3] : 0;
            for (int k = 0; k < 3; ++k) x += double(m[row * 4 + k]) * b.m[k * 4 + col];
            r.m[row * 4 + col] = float(x);
        }
    }
    return r;
}

size_t Mesh::primitive_count() const {
    switch (shape) {
        case Shape::Triangles: return triangles.size();
        case Shape::Spheres: return positions.size();
        case Shape::Curves: return curve_first.empty() ? 0 : positions.size() - (curve_first.size() - 1);  // one less a curve
    }
    return 0;
}

float Transform::determinant() const { return float(determinant_of(m, cofactors(m))); }

}  // namespace alder
