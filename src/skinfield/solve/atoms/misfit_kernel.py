"""Model error of a reading, compiled: the evidence of its atoms for each size of the error.

A taxel reads s σ of noise and m A of model error: σ is its stated noise, A the amplitude that the
atoms have around it, and m what the model is wrong by. Residuals alone say little of m, as atoms
fit part of it away; their marginal likelihood (MacKay 2003, chapters 27 and 28) knows how much.
"""

import numpy as np

from skinfield.compiled import njit
from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import prior_evidence
from skinfield.solve.atoms.fit_kernel import (
    NEAR,
    NOW,
    READINGS,
    WHITE,
    FitMemory,
    FitModel,
    evaluate,
    factor,
    gather,
    is_long,
)


@njit
def evidence_of_errors(
    model: FitModel,
    memory: FitMemory,
    noise: Floats,
    amplitude: Floats,
    common: float,
    errors: Floats,
    beside: Floats,
    out: Floats,
) -> None:
    """Write the logarithm of the marginal likelihood of the atoms of NOW for each model error.

    The atoms stay where they are; what is known of their set for the weights before, does not hold
    any more.

    Parameters
    ----------
    noise : (L,) array
        Infinite of taxels that are not heard.
    amplitude : (2, L) array
        Squares of what a taxel reads around the atoms, and of what its neighbours do.
    common : float
        Standard deviation of an offset that all taxels share.
    errors : (N,) array
    beside : (N,) array
        How much neighbours count.
    out : (N,) array
    """
    count = memory.counts[NOW]
    size, readings, white = 6 * count, memory.taxels[READINGS], memory.taxels[WHITE]
    atoms, predicted, jacobian = memory.atoms[NOW], memory.predicted[NOW], memory.jacobian
    system, sums = memory.system, memory.steps[2]
    for taxel in range(len(white)):  # without weights the Hessian is that of the priors
        white[taxel] = 0.0
        if not count:
            predicted[taxel] = 0.0
    prior, known = 0.0, 0.0
    memory.marks[NEAR] = 0
    if count:
        gather(model, memory, NOW, READINGS)
        prior = evaluate(model, memory, NOW, READINGS)
        known = prior_evidence(model, memory, NOW)
    hessian, near = memory.hessian[NOW], memory.near[: memory.marks[NEAR]]
    for k in range(len(errors)):
        for i in range(size * size):
            system[i] = hessian[i]
        for i in range(size):
            sums[i] = 0.0
        weights, total, squares, volume = 0.0, 0.0, 0.0, 0.0
        for taxel in range(len(white)):
            if not noise[taxel] < np.inf:
                continue
            share = amplitude[0, taxel] + beside[k] * beside[k] * amplitude[1, taxel]
            share *= (errors[k] / noise[taxel]) ** 2
            white[taxel] = 1.0 / (noise[taxel] * np.sqrt(1.0 + share))
            weight, residual = white[taxel] * white[taxel], readings[taxel] - predicted[taxel]
            weights += weight
            total += weight * residual
            squares += weight * residual * residual
            volume += np.log1p(share)
        for at in range(len(near)):
            first, weight = size * at, white[near[at]] * white[near[at]]
            for n in range(0, size, 6):
                if jacobian[first + n + 2] == 0.0:
                    continue
                for i in range(n, n + 6):
                    slope = jacobian[first + i] * weight
                    sums[i] += slope
                    for j in range(i + 1):
                        system[i * size + j] += slope * jacobian[first + j]
        shared = common * common / (1.0 + common * common * weights)
        determinant = 0.0
        for i in range(size):
            for j in range(i + 1):
                system[i * size + j] -= shared * sums[i] * sums[j]
            system[i * size + i] += 1e-9
        for i in range(size):
            if i % 6 >= 4 and not is_long(atoms[i // 6]):
                for j in range(size):
                    system[i * size + j] = 0.0
                    system[j * size + i] = 0.0
                system[i * size + i] = 1.0
        out[k] = -np.inf
        if factor(system, size):
            for i in range(size):
                determinant += np.log(system[i * size + i])
            cost = prior + 0.5 * (squares - shared * total * total)
            volume += np.log1p(common * common * weights)
            out[k] = known - cost - 0.5 * volume - determinant
