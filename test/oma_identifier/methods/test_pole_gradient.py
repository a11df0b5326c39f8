"""How poles of the poly-reference method answer to what a stretch adds to the spectra."""

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from oma_identifier.methods.half_spectra import half_spectra, LagSums
from oma_identifier.methods.jackknife import stretches
from oma_identifier.methods.pole_gradient import pole_gradient
from oma_identifier.methods.polyreference import NormalEquations, poles_of

SEED, ORDER, HIGHEST = 993900, 9, 12


@pytest.fixture(scope='module')
def sums() -> LagSums:
    generator = np.random.default_rng(SEED)
    plant = Plant(
        frequency_hz=np.array([4.0, 9.0, 11.0, 21.0]),
        damping_ratio=np.array([0.02, 0.01, 0.02, 0.015]),
        shapes=generator.standard_normal((5, 4)),
        participation=generator.standard_normal((4, 4)),
    )
    rows = simulate(plant, generator, 120.0, 64.0).acceleration
    return LagSums(rows - rows.mean(axis=0), np.array([0, 2, 3]), 256)


def modes_of(equations: NormalEquations, decay: float) -> np.ndarray:
    """Return the damped poles of one order."""
    pole = np.log(poles_of(equations, [ORDER], decay).eigenvalue)
    return pole[(pole.real < 0.0) & (-pole.real < 0.05 * np.abs(pole))]


def nearest(poles: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    return poles[np.abs(poles - wanted[:, None]).argmin(axis=1)]


def test_gradient_is_the_limit_of_differences(sums):
    spectra = half_spectra(sums.covariance(), 0.0, 0.49)
    equations = NormalEquations(spectra, HIGHEST)
    pole = modes_of(equations, spectra.decay)
    assert len(pole) >= 4
    gradient = pole_gradient(equations, ORDER, np.exp(pole - spectra.decay))
    generator = np.random.default_rng(SEED + 1)
    step = generator.standard_normal((*spectra.value.shape, 2)) @ np.array([1.0, 1.0j])
    step *= 1e-6 * np.abs(spectra.value).mean()
    predicted = gradient @ equations.change(spectra.value + step)
    both = [
        nearest(
            np.log(
                poles_of(
                    NormalEquations(
                        type(spectra)(spectra.angle, spectra.value + sign * step, spectra.decay),
                        HIGHEST,
                    ),
                    [ORDER],
                    spectra.decay,
                ).eigenvalue
            ),
            pole,
        )
        for sign in (1.0, -1.0)
    ]
    exact = (both[0] - both[1]) / 2.0
    assert np.abs(predicted - exact).max() < 1e-3 * np.abs(exact).max()


def test_scatter_is_that_of_solutions_anew(sums):
    """Each stretch left out: the poles by their gradient, and from equations without it."""
    spectra = half_spectra(sums.covariance(), 0.0, 0.49)
    equations = NormalEquations(spectra, HIGHEST)
    pole = modes_of(equations, spectra.decay)
    gradient = pole_gradient(equations, ORDER, np.exp(pole - spectra.decay))
    first, anew = [], []
    for stretch in stretches(120 * 64):
        left = half_spectra(sums.covariance(stretch), 0.0, 0.49)
        first.append(gradient @ equations.change(left.value))
        eigenvalue = poles_of(NormalEquations(left, HIGHEST), [ORDER], left.decay).eigenvalue
        anew.append(nearest(np.log(eigenvalue), pole) - pole)
    # On 41 modes of a large record the two were 0.98 to 1.02 times each other, 0.92 to 1.1 where
    # the record hardly tells the pole.
    ratio = np.std(first, axis=0) / np.std(anew, axis=0)
    assert np.all(np.abs(np.log(ratio)) < 0.1), f'seed {SEED}: {ratio}'
