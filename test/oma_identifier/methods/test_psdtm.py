"""Poles from transmissibilities: exact ones, coloured forces, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from benchmarks.identifier.plant import Plant, simulate
from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.methods.catalogue import identify_by
from oma_identifier.methods.psdtm import poles_of_conditions

SEED = 31
RATE_HZ = 64.0


def test_poles_are_exact_whatever_the_colour_of_the_forces():
    rng = np.random.default_rng(SEED)
    poles = np.exp(np.array([-0.02 + 0.5j, -0.03 + 1.3j]))
    shapes = rng.standard_normal((3, 2)).astype(complex)
    angle = np.linspace(0.1, 2.5, 200)
    z = np.exp(1j * angle)[:, None]
    directions = []
    for force in rng.standard_normal((2, 2)):
        answer = np.zeros((200, 3), dtype=complex)
        for pole, shape, part in zip(poles, shapes.T, force, strict=True):
            answer += part * (shape / (z - pole) + shape.conj() / (z - pole.conj()))
        colour = rng.standard_normal((200, 1)) + 1j * rng.standard_normal((200, 1))
        directions.append(answer * colour)
    found = poles_of_conditions(angle, directions, range(6, 7))
    for pole, shape in zip(poles, shapes.T, strict=True):
        near = int(np.argmin(np.abs(found.eigenvalue - pole)))
        assert abs(found.eigenvalue[near] - pole) < 1e-6
        assert mac(found.shape[:, near], shape)[0, 0] > 0.9  # at the line beside it


def chain() -> Plant:
    """Three masses; forces act on each of them."""
    mass = np.diag([10.0, 8.0, 6.0])
    stiffness = np.array([[60.0, -30.0, 0.0], [-30.0, 50.0, -20.0], [0.0, -20.0, 20.0]]) * 1e3
    square, shapes = eigh(stiffness, mass)
    hz = np.sqrt(square) / (2.0 * np.pi)
    return Plant(hz, np.array([0.02, 0.015, 0.03]), shapes, shapes.T)


def shaken(masses: tuple[int, ...], seed: int, duration_s: float = 120.0) -> Samples:
    """One mass after the other is shaken by a coloured force."""
    plant, rng = chain(), np.random.default_rng(seed)
    rows = [
        simulate(
            Plant(
                plant.frequency_hz,
                plant.damping_ratio,
                plant.shapes,
                plant.participation[:, [one]],
            ),
            rng,
            duration_s,
            RATE_HZ,
            noise=0.01,
            colour=0.98,
        ).acceleration
        for one in masses
    ]
    return Samples(np.concatenate(rows), RATE_HZ, tuple(Channel(name) for name in 'abc'))


@pytest.mark.parametrize('masses', [(0, 2), (0, 1, 2)])
def test_modes_of_a_structure_shaken_at_one_place_after_the_other(masses):
    samples, truth = shaken(masses, SEED), chain()
    found = identify_by('psdtm', samples).modes
    assert len(found) == 3, found.frequency_hz
    np.testing.assert_allclose(found.frequency_hz, truth.frequency_hz, rtol=0.03)
    np.testing.assert_allclose(found.damping_ratio, truth.damping_ratio, rtol=0.6)
    assert all(np.isnan(mode.frequency_std_hz) for mode in found)


@pytest.mark.parametrize('mass', [0, 1])
def test_one_loading_condition_is_refused_in_a_line(mass):
    with pytest.raises(IdentificationError, match=r'one, the forces act alike.*two or more') as e:
        identify_by('psdtm', shaken((mass,), SEED, 240.0))
    assert '\n' not in str(e.value)
    with pytest.raises(IdentificationError, match='one channel'):
        identify_by('psdtm', shaken((0, 2), SEED).select(['a']))


@pytest.mark.parametrize('duration_s', [4.0, 8.0])
def test_a_record_of_few_segments_is_refused_in_a_line(duration_s):
    """As the last window of a recording, which may be short."""
    samples = shaken((0, 2), SEED)
    n_samples = round(duration_s * samples.sample_rate_hz)
    with pytest.raises(IdentificationError, match='found one'):
        identify_by('psdtm', replace(samples, acceleration=samples.acceleration[:n_samples]))
