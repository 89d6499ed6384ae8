"""Closed forms of a layer on a rigid sphere or cylinder: harmonic functions, one load at a time.

With div u = -(1 - 2ν) q/μ and q harmonic, μ∇²u = ∇q (Papkovich and Neuber); unknown factors follow
from u = 0 on the base and the load on the surface. Lengths are in thicknesses, μ = 1.
"""

import numpy as np
from scipy.special import iv, ivp, kv, kvp


def _solved(base, surface, load, stress, radial):
    """-σ_rr on the base and -u_r of the surface; columns are the solutions, rows what they do."""
    matrix = np.vstack([base, surface])
    scale = np.abs(matrix).max(axis=0)
    factors = np.linalg.solve(matrix / scale, np.concatenate([np.zeros(len(base)), load])) / scale
    return -stress @ factors, -radial @ factors


def sphere(n, radius, nu):
    """Of the pressure P_n on r = radius + 1."""
    outer = radius + 1.0

    def states(r):
        columns = []
        for m, unit in ((n, outer), (-n - 1, radius)):
            x = r / unit
            columns.append((m * x ** (m - 1) / unit, x ** (m - 1) / unit,
                            2 * m * (m - 1) * x ** (m - 2) / unit**2,
                            2 * (m - 1) * x ** (m - 2) / unit**2))  # fmt: skip
            a, b = np.linalg.solve([[4 * m + 2, 2], [2 * m, m + 3]], [1, 2 * nu - 1])
            up, along = (a * m + b) * x ** (m + 1) * unit, a * x ** (m + 1) * unit
            shear = up / r + m * along / r
            columns.append((up, along, 2 * (m + 1) * up / r - 2 * nu * x**m, shear))
        return np.array(columns).T

    base, surface = states(radius), states(outer)
    return _solved(base[:2], surface[2:], [-1.0, 0.0], base[2], surface[0])


def cylinder(m, k, radius, nu):
    """Of the pressure cos mφ cos kz on r = radius + 1; m, k > 0."""
    outer = radius + 1.0

    def derivatives(kind, r):  # of f(kr), up to the third
        first = (lambda j: ivp(m, k * r, j)) if kind == "I" else (lambda j: kvp(m, k * r, j))
        value = iv(m, k * r) if kind == "I" else kv(m, k * r)
        return [value, *(k**j * first(j) for j in (1, 2, 3))]

    def states(r):
        """u_r, u_φ, u_z, σ_rr, σ_rφ, σ_rz of six solutions, times the cosines and sines."""
        columns = []
        for kind in "IK":
            f, f1, f2, f3 = derivatives(kind, r)
            # u = grad(f cos cos)
            columns.append(
                (f1, -m * f / r, -k * f, 2 * f2, 2 * m * (f / r**2 - f1 / r), -2 * k * f1)
            )
            # u = curl of (f sin mφ cos kz) along z
            columns.append((m * f / r, -f1, 0.0, 2 * m * (f1 / r - f / r**2),
                            f1 / r - f2 - m**2 * f / r**2, -k * m * f / r))  # fmt: skip
            # q = f: u = grad(r f')/(2 k²) + v along z with div v = -2 (1 - ν) q
            g, g1, g2 = r * f1, f1 + r * f2, 2 * f2 + r * f3
            half = 0.5 / k**2
            along = -2 * (1 - nu) * f / k  # of sin kz: its divergence is k along
            rr = 2 * half * g2 - 2 * nu * f
            shear = half * 2 * m * (g / r**2 - g1 / r)
            up = -2 * half * k * g1 - 2 * (1 - nu) * f1 / k
            columns.append((half * g1, -half * m * g / r, -half * k * g + along, rr, shear, up))
        return np.array(columns).T

    base, surface = states(radius), states(outer)
    return _solved(base[:3], surface[3:], [-1.0, 0.0, 0.0], base[3], surface[0])


def of_cap(response, radius, pad, places, cap, profile):
    """Readings at angles `places` (L,) of a pressure by the angle from the pole, 0 beyond `cap`.

    `response` (N,) is that of P_0 .. P_(N - 1); `pad` is the angle to the pad's rim.
    """
    n = np.arange(len(response))
    node, weight = np.polynomial.legendre.leggauss(200)
    low = np.cos(cap)
    cosine, weight = low + (node + 1) / 2 * (1 - low), weight * (1 - low) / 2
    legendre = np.polynomial.legendre.legvander
    load = (2 * n + 1) / 2 * (weight * profile(np.arccos(cosine)) @ legendre(cosine, n[-1]))
    edge = legendre(np.cos([pad]), n[-1] + 1)[0]
    mean = np.concatenate([[1.0], (edge[:-2] - edge[2:]) / ((2 * n[1:] + 1) * (1 - np.cos(pad)))])
    return legendre(np.cos(places), n[-1]) @ (load * response * mean)


def of_bump(response, outer, around, along, places, width):
    """Readings at places around and along (2, L) of a pressure exp(-distance²/2 width²).

    `response` (M, K) is that of cos mφ cos kz, all m from 0 and even steps of k from 0.
    """
    m, k = np.arange(len(around)), along
    bump = 2 * np.pi * width**2 * np.exp(-(around[:, None] ** 2 + k**2) * width**2 / 2)
    twice = np.where(m[:, None] > 0, 2.0, 1.0) * np.where(k > 0, 2.0, 1.0)
    weights = response * bump * twice * (k[1] - k[0]) / (4 * np.pi**2 * outer)
    angle, height = places
    return np.einsum(
        "mk,lm,lk->l", weights, np.cos(np.outer(angle, m)), np.cos(np.outer(height, k))
    )
