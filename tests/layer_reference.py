"""The bonded layer computed two other ways than the program does, for tests.

1. `propagate`: the equations of elasticity as a first-order system in z, solved by a matrix
   exponential in multiple precision (no closed form, any Poisson's ratio).
2. `FourierSum`: responses to square cells by the trapezoidal rule over the plane of wave numbers,
   which converges geometrically as every multiplier is an analytic, even function of them. It
   needs no table and no quadrature over the cell; 1/k tails are split off as Gaussians (Ewald).

Lengths are in thicknesses and moduli in E.
"""

from functools import cache

import mpmath as mp
import numpy as np
from scipy.special import ellipe, ellipk, erf, hyp2f1, j1

WAVES = 46.0  # end of the sum over wave numbers
SPLIT = 0.25  # widest Gaussian of the split


def _system(nu, alpha):
    """M in y' = M y with y = (U, W, Sx, Sz): u_x = iU, u_z = W, t_x = i Sx, t_z = Sz; h = E = 1.

    From strain-stress relations and equilibrium; 1 - 2 nu stands in numerators only, so the
    incompressible layer is nothing special.
    """
    shear = 1 / (2 * (1 + nu))
    uniaxial = (1 - 2 * nu) / (2 * shear * (1 - nu))
    return [
        [0, -alpha, 1 / shear, 0],
        [nu / (1 - nu) * alpha, 0, 0, uniaxial],
        [alpha**2 / (1 - nu**2), 0, 0, -alpha * nu / (1 - nu)],
        [0, 0, alpha, 0],
    ]


@cache
def propagate(nu: float, alpha: float) -> dict[str, mp.mpf]:
    """Every response at one wave number, to 40 digits or so."""
    with mp.workdps(60):
        exact, wave = mp.mpf(nu), mp.mpf(alpha)
        through = mp.expm(mp.matrix(_system(exact, wave)))
        base = through[2:4, 2:4] ** -1  # traction on the base per traction on top
        top = through[0:2, 2:4] * base  # displacement of the top per traction on top
        antiplane = mp.expm(mp.matrix([[0, 2 * (1 + exact)], [wave**2 / (2 * (1 + exact)), 0]]))
        across = antiplane[0, 1] / antiplane[1, 1] * wave / (2 * (1 + exact))
        return _named(exact, wave, top, base, across, 1 / antiplane[1, 1])


def _named(nu, alpha, top, base, antiplane, base_antiplane):
    """Responses from U, W on top and Sx, Sz on the base (rows) per Sx, Sz on top (columns)."""
    normal, mixed = alpha / (2 * (1 - nu**2)), alpha / (1 + nu)
    held = -top[0, 1] / top[0, 0]  # the cover's traction that keeps U = 0
    return {
        "nu": nu,
        "covered_limit": 1 - ((1 - 2 * nu) / (2 * (1 - nu))) ** 2,
        "normal": normal * top[1, 1],
        "tangential": normal * top[0, 0],
        "coupling": mixed * top[0, 1],
        "antiplane": antiplane,
        "base_normal": base[1, 1],
        "base_shear": base[0, 0],
        "base_shear_from_normal": base[0, 1],
        "base_normal_from_shear": base[1, 0],
        "base_antiplane": base_antiplane,
        "covered_normal": normal * (top[1, 1] + held * top[1, 0]),
        "covered_base_normal": base[1, 1] + held * base[1, 0],
        "covered_base_shear_from_normal": base[0, 1] + held * base[0, 0],
    }


def ratios(nu, alpha, lib=np):
    """Closed forms written out plainly, for arrays; `propagate` is their witness."""
    sinh, cosh, two = lib.sinh(alpha), lib.cosh(alpha), lib.sinh(2 * alpha)
    below = (3 - 4 * nu) * lib.cosh(2 * alpha) + 2 * alpha**2 + 8 * nu**2 - 12 * nu + 5
    stress = 4 * (1 - nu) / below
    out = {
        "normal": ((3 - 4 * nu) * two - 2 * alpha) / below,
        "tangential": ((3 - 4 * nu) * two + 2 * alpha) / below,
        "coupling": (2 * alpha**2 - 2 * (3 - 4 * nu) * (1 - 2 * nu) * sinh**2) / below,
        "antiplane": lib.tanh(alpha),
        "base_normal": stress * (alpha * sinh + 2 * (1 - nu) * cosh),
        "base_shear": stress * (2 * (1 - nu) * cosh - alpha * sinh),
        "base_shear_from_normal": stress * (alpha * cosh - (1 - 2 * nu) * sinh),
        "base_normal_from_shear": -stress * (alpha * cosh + (1 - 2 * nu) * sinh),
        "base_antiplane": 1 / cosh,
    }
    held = -out["coupling"] / (2 * (1 - nu) * out["tangential"])
    out["covered_normal"] = out["normal"] + held * out["coupling"] / (2 * (1 - nu))
    out["covered_base_normal"] = out["base_normal"] + held * out["base_normal_from_shear"]
    out["covered_base_shear_from_normal"] = out["base_shear_from_normal"] + held * out["base_shear"]
    return out


@cache
def _mesh(nu, step):
    """Wave numbers along one axis, their length (n, n) and the responses there."""
    wave = (np.arange(int(WAVES / step)) + 0.5) * step
    k = np.hypot(*np.meshgrid(wave, wave, indexing="ij"))
    wide = ratios(np.longdouble(nu), k.astype(np.longdouble))
    return wave, k, {name: value.astype(float) for name, value in wide.items()}


class FourierSum:
    """Responses of a layer (h = E = 1) at offsets (N, 2) to a unit traction on a square cell.

    Parameters
    ----------
    nu, cell, pad : float
        Poisson's ratio, side of the cell and radius of the pad.
    span : float
        Largest offset plus half the cell plus the pad's radius; the sum repeats with a period
        that keeps its copies 46 thicknesses away, where every response is below 1e-15.
    """

    def __init__(self, nu: float, cell: float, pad: float = 0.0, span: float = 14.0):
        self.nu, self.cell, self.pad = nu, cell, pad
        step = 2 * np.pi / (46.0 + span)
        self.wave, self.k, self.ratio = _mesh(nu, step)
        side = np.sinc(self.wave * cell / (2 * np.pi)) * cell
        mean = 2 * j1(self.k * pad) / (self.k * pad) if pad else 1.0
        self.load = np.outer(side, side) * mean * (step / np.pi) ** 2
        node, weight = np.polynomial.legendre.leggauss(12)
        edge = SPLIT * 2.0 ** -np.arange(46.0)
        self.width = np.ravel(
            (edge[1:] + edge[:-1]) / 2 + (edge[:-1] - edge[1:]) / 2 * node[:, None]
        )
        self.share = np.ravel((edge[:-1] - edge[1:]) / 2 * weight[:, None])

    def _sum(self, offset, multiplier, odd_x=False, odd_y=False):
        x = (np.sin if odd_x else np.cos)(np.outer(offset[:, 0], self.wave))
        y = (np.sin if odd_y else np.cos)(np.outer(offset[:, 1], self.wave))
        sign = -1.0 if odd_x or odd_y else 1.0
        return sign * np.einsum("ni,ni->n", x @ (multiplier * self.load), y)

    def base_stress(self, offset, covered=False):
        return self._sum(offset, self.ratio["covered_base_normal" if covered else "base_normal"])

    def base_traction(self, offset):
        """(N, 3, 3): component i on the base (facing up) per component j on top."""
        r, kx, ky = self.ratio, self.wave[:, None] / self.k, self.wave / self.k
        out = np.empty((len(offset), 3, 3))
        turn = r["base_shear"] - r["base_antiplane"]
        out[:, 0, 0] = self._sum(offset, r["base_antiplane"] + turn * kx**2)
        out[:, 1, 1] = self._sum(offset, r["base_antiplane"] + turn * ky**2)
        out[:, 0, 1] = out[:, 1, 0] = self._sum(offset, turn * kx * ky, True, True)
        out[:, 2, 2] = self._sum(offset, r["base_normal"])
        for axis, (along, odd) in enumerate(((kx, (True, False)), (ky, (False, True)))):
            out[:, axis, 2] = self._sum(offset, r["base_shear_from_normal"] * along, *odd)
            out[:, 2, axis] = -self._sum(offset, r["base_normal_from_shear"] * along, *odd)
        return out

    def covered_shear(self, offset):
        """(N, 2): tangential traction on the base per unit normal traction, under a cover."""
        per = self.ratio["covered_base_shear_from_normal"] / self.k
        x = self._sum(offset, per * self.wave[:, None], True, False)
        return np.stack([x, self._sum(offset, per * self.wave, False, True)], axis=1)

    def electrostatic(self, offset, covered=False):
        """Indentation smoothed by k / sinh k, averaged over the pad."""
        ratio = self.ratio["covered_normal" if covered else "normal"]
        return self._sum(offset, 2 * (1 - self.nu**2) * ratio / np.sinh(self.k))

    def lift(self, offset, smoothed=True):
        """(N, 2): height of the surface over the pad per traction along x and y."""
        assert smoothed or self.nu == 0.5  # else the sum does not converge
        per = self.ratio["coupling"] / (np.sinh(self.k) if smoothed else self.k) / self.k
        x = self._sum(offset, per * self.wave[:, None], True, False)
        y = self._sum(offset, per * self.wave, False, True)
        return -(1 + self.nu) * np.stack([x, y], axis=1)

    def normal(self, offset, covered=False):
        """Normal displacement at points per unit normal traction."""
        assert not self.pad
        limit = _limit(self.nu) if covered else 1.0
        ratio = self.ratio["covered_normal" if covered else "normal"] / self.k
        near = self._gaussians(offset, 0, 0) @ (self.share * limit)
        far = self._sum(offset, ratio - limit * self._tail(0) * 2 / np.sqrt(np.pi))
        return 2 * (1 - self.nu**2) * (far + near * 2 / np.sqrt(np.pi))

    def over_pad(self, offset, covered=False):
        """Indentation averaged over the pad.

        1/k is cut into erf(k)/k, whose Gaussians are narrower than 1, and the rest. The former is
        the mean of 1/r, by `mean_inverse_distance` here, less Gaussians wider than 1.
        """
        ratio = self.ratio["covered_normal" if covered else "normal"] / self.k
        limit = _limit(self.nu) if covered else 1.0
        far = self._sum(offset, ratio - limit * erf(self.k) / self.k)
        one = np.array([mean_inverse_distance(place, self.cell, self.pad) for place in offset])
        near = one / (2 * np.pi) - self._wide_gaussians(offset)
        return 2 * (1 - self.nu**2) * (far + limit * near)

    def _wide_gaussians(self, offset):
        """2/sqrt(pi) times the integral over t > 1 of exp(-k² t²), over the cell and the pad."""
        inverse, weight = np.polynomial.legendre.leggauss(int(32 + 4 * self.pad))
        inverse, weight = (inverse + 1) / 2, weight / 2  # of the width t
        count = 16 + int(3 * self.pad)
        radial, share = np.polynomial.legendre.leggauss(count)
        r, angle = self.pad * np.sqrt((radial + 1) / 2), np.arange(2 * count) * np.pi / count
        x = offset[:, :1, None] + np.outer(r, np.cos(angle)).ravel()[:, None]
        y = offset[:, 1:, None] + np.outer(r, np.sin(angle)).ravel()[:, None]
        mean = np.repeat(share / 2, 2 * count) / (2 * count)
        half = self.cell / 2
        box = lambda v: (erf((v + half) * inverse / 2) - erf((v - half) * inverse / 2)) / 2
        blurred = np.einsum("nqt,q->nt", box(x) * box(y), mean)
        return 2 / np.sqrt(np.pi) * blurred @ (weight / inverse**2)

    def displacement(self, offset):
        """(N, 3, 3): component i of the surface per component j of the traction."""
        nu, r = self.nu, self.ratio
        half, root = 2 * (1 + nu), 2 / np.sqrt(np.pi)
        wave = [self.wave[:, None], self.wave]
        across = half * r["antiplane"] / self.k
        turn = (2 * (1 - nu**2) * r["tangential"] - half * r["antiplane"]) / self.k**3
        one, cube = root * self._tail(0), 2 * root * self._tail(2)
        out = np.empty((len(offset), 3, 3))
        out[:, 2, 2] = self.normal(offset)
        flat = self._sum(offset, across - half * one)
        flat += half * root * self._gaussians(offset, 0, 0) @ self.share
        for i, j in ((0, 0), (0, 1), (1, 1)):
            odd, order = i != j, (np.eye(2, dtype=int)[i] + np.eye(2, dtype=int)[j])
            rest = self._sum(offset, (turn + nu * half * cube) * wave[i] * wave[j], odd, odd)
            sharp = -self._gaussians(offset, *order) @ (2 * root * self.width**2 * self.share)
            out[:, i, j] = out[:, j, i] = rest - nu * half * sharp + (i == j) * flat
        square = 2 * self._tail(1)
        for i in (0, 1):
            rest = (r["coupling"] / self.k**2 + (1 - 2 * nu) * square) * wave[i]
            smooth = self._sum(offset, rest, i == 0, i == 1)
            sharp = self._gaussians(offset, 1 - i, i) @ (2 * self.width * self.share)
            out[:, i, 2] = (1 + nu) * (smooth - (1 - 2 * nu) * sharp)
            out[:, 2, i] = -out[:, i, 2]
        return out

    def _tail(self, power):
        """Sum over widths t of t^power exp(-k² t²): the 1/k^(power + 1) of large k, made entire."""
        bell = np.exp(-(np.outer(self.wave, self.width) ** 2))
        return (bell * self.share * self.width**power) @ bell.T

    def _gaussians(self, offset, order_x, order_y):
        """Derivatives of the cell blurred by exp(-k² t²), (N, widths)."""
        return self._edge(offset[:, :1], order_x) * self._edge(offset[:, 1:], order_y)

    def _edge(self, x, order):
        t = self.width
        high, low = (x + self.cell / 2) / (2 * t), (x - self.cell / 2) / (2 * t)
        if order == 0:
            return (erf(high) - erf(low)) / 2
        bell = [np.exp(-np.minimum(v**2, 700.0)) / (2 * t * np.sqrt(np.pi)) for v in (high, low)]
        if order == 1:
            return bell[0] - bell[1]
        return -(high * bell[0] - low * bell[1]) / t


def _limit(nu):
    """The covered half-space's normal displacement over that of the free one."""
    return 1 - ((1 - 2 * nu) / (2 * (1 - nu))) ** 2


def mean_inverse_distance(offset, cell, radius):
    """Integral of 1/distance over a square cell, averaged over a disc, ring by ring about the disc.

    The disc's potential (Maxwell's elliptic integrals) times the part of each ring that lies in
    the square, by a double-exponential rule between the radii where that part has a kink. Far
    away, where that part is a thin slice, by Gauss's rule over the square.
    """
    if np.hypot(*offset) > radius + 2 * cell:
        node, weight = np.polynomial.legendre.leggauss(24)
        r = np.hypot(*np.meshgrid(*(v + node * cell / 2 for v in offset)))
        mean = hyp2f1(0.5, 0.5, 2.0, (radius / r) ** 2) / r
        return weight @ mean @ weight * cell**2 / 4
    x, y = (np.abs(v) + cell / 2 * np.array([-1, 1]) for v in offset)
    corners = np.hypot(*np.meshgrid(x, y)).ravel()
    kinks = np.unique(np.hstack([0.0, radius, np.abs(x), np.abs(y), corners]))
    kinks = kinks[kinks <= corners.max()]
    t = np.arange(-4.0, 4.0, 0.05) + 0.025
    share = 1 / (1 + np.exp(-np.pi * np.sinh(t)))
    slope = 0.05 * np.pi * np.cosh(t) * share * (1 - share)
    low, wide = kinks[:-1, None], np.diff(kinks)[:, None]
    r, weight = (low + wide * share).ravel(), (wide * slope).ravel()
    keep = r > 0
    r, weight = r[keep], weight[keep]
    return weight @ (disc_potential(r, radius) * r * _angle_inside(r, x, y)) / (np.pi * radius**2)


def disc_potential(r, radius):
    """Integral of 1/distance over a disc from a point in its plane (Maxwell)."""
    m = (np.minimum(r, radius) / np.maximum(r, radius)) ** 2
    beyond = 4 * r * (ellipe(m) - (1 - m) * ellipk(np.minimum(m, 1 - 1e-16)))
    return np.where(r <= radius, 4 * radius * ellipe(m), beyond)


def _angle_inside(r, x, y):
    """Angle of circles of radii r (N,) about the origin inside a rectangle."""
    cosine = np.arccos(np.clip(x / r[:, None], -1, 1))
    sine = np.arcsin(np.clip(y / r[:, None], -1, 1))
    cuts = [cosine, -cosine, sine, np.pi - sine, np.full((len(r), 1), -np.pi)]
    cuts = np.sort((np.hstack(cuts) + np.pi) % (2 * np.pi) - np.pi, axis=1)
    cuts = np.hstack([cuts, np.full((len(r), 1), np.pi)])
    middle = (cuts[:, 1:] + cuts[:, :-1]) / 2
    px, py = r[:, None] * np.cos(middle), r[:, None] * np.sin(middle)
    inside = (x[0] < px) & (px < x[1]) & (y[0] < py) & (py < y[1])
    return np.sum(np.diff(cuts, axis=1) * inside, axis=1)
