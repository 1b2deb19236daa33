#!/usr/bin/env python3
"""Writes al_albedo_table.cpp: three-point Gauss rules for the directional albedo of rough specular reflection.

    python3 nodes/surface/al_albedo_table.py > nodes/surface/al_albedo_table.cpp

The albedo towards wo of an isotropic microfacet lobe is the integral of F(c) over a measure on c = H.wi in [0, 1] that depends
on mu = N.wo and alpha alone: W(dc) = D(m) G2(wo, wi) (wo.m) / mu dm (Walter et al. 2007, equations 20 and 38). For every cell the
measure is sampled at fixed points, and the Stieltjes procedure with Golub and Welsch 1969 gives the three nodes c_i and weights
w_i for which sum w_i p(c_i) is exact for every polynomial p up to degree 5. Any Fresnel curve can then be put in: dielectric or
metal, per channel.
Axes: sqrt(alpha) from sqrt(0.001) to 1 by row; nu = mu (1 + 6 alpha)/(mu + 6 alpha) = column/15, in which small widths look alike.
A cell holds (c_i - mu)/alpha, then w_i. Needs numpy.
"""
import numpy as np

SIZE, STRETCH, ALPHA_MIN = 16, 6.0, 1e-3


def smith_lambda(ggx, alpha, cos):
    tan2 = np.maximum(1 - cos * cos, 0) / (cos * cos)
    if ggx:
        return (np.sqrt(1 + alpha * alpha * tan2) - 1) / 2
    a = 1 / np.sqrt(np.maximum(alpha * alpha * tan2, 1e-30))
    b = np.minimum(a, 1.6)
    return np.where(a < 1.6, (1 - 1.259 * b + 0.396 * b * b) / (3.535 * b + 2.181 * b * b), 0)


def measure(ggx, mu, alpha, radial=512, azimuthal=128):
    """Sample points of c and their weights: microfacets drawn from D cos by stratified midpoints."""
    u = (np.arange(radial) + 0.5) / radial
    phi = (np.arange(azimuthal) + 0.5) / azimuthal * np.pi
    tan2 = alpha * alpha * u / (1 - u) if ggx else -alpha * alpha * np.log1p(-u)
    mz = (1 / np.sqrt(1 + tan2))[:, None] * np.ones_like(phi)
    mx = np.sqrt(tan2)[:, None] * mz * np.cos(phi)
    c = mx * np.sqrt(1 - mu * mu) + mz * mu
    iz = 2 * c * mz - mu
    seen = (c > 0) & (iz > 0)
    cos_i = np.where(seen, np.minimum(iz, 1), 1)
    shadowing = 1 / (1 + smith_lambda(ggx, alpha, mu) + smith_lambda(ggx, alpha, cos_i))
    w = np.where(seen, c / (mu * mz) * shadowing, 0) / (radial * azimuthal)
    return c[seen], w[seen]


def gauss_rule(c, w, n=3):
    total = w.sum()
    a, b = [], []
    before, p, norm = np.zeros_like(c), np.ones_like(c), total
    for k in range(n):
        a.append((w * c * p * p).sum() / norm)
        before, p = p, (c - a[k]) * p - (b[k - 1] if k else 0) * before
        b.append((w * p * p).sum() / norm)
        norm *= b[k]
    off = np.sqrt(b[: n - 1])
    nodes, vectors = np.linalg.eigh(np.diag(a) + np.diag(off, 1) + np.diag(off, -1))
    return nodes, total * vectors[0] ** 2


def cells(ggx):
    for row in range(SIZE):
        alpha = (ALPHA_MIN ** 0.5 + (1 - ALPHA_MIN ** 0.5) * row / (SIZE - 1)) ** 2
        for column in range(SIZE):
            nu = column / (SIZE - 1) / (1 + STRETCH * alpha)
            mu = min(max(STRETCH * alpha * nu / (1 - nu), 1e-4 * alpha), 1)
            c, w = gauss_rule(*measure(ggx, mu, alpha))
            yield list((c - mu) / alpha) + list(w)


def main():
    print("// Gauss rules for the directional albedo of rough specular reflection. Written by al_albedo_table.py, which says how.")
    print('#include "nodes/surface/al_albedo_table.h"\n\nnamespace alder {\n')
    for name, ggx in (("kAlbedoRulesGgx", True), ("kAlbedoRulesBeckmann", False)):
        print("const float %s[kAlbedoRuleFloats] = {" % name)
        for cell in cells(ggx):
            print("    " + ", ".join("%.6gf" % x if "." in "%.6g" % x or "e" in "%.6g" % x else "%.6g.0f" % x for x in cell) + ",")
        print("};\n")
    print("}  // namespace alder")


main()
