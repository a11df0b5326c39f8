"""Lines of the drives: found where they are, at any speed, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

from oma_identifier.identify import identify_samples
from oma_identifier.motion.drive_orders import ORDERS, remove_drive_orders
from oma_identifier.settings import IdentificationSettings

RATE_HZ = 128.0
FREQUENCIES = [9.0, 17.0, 30.0]
SETTINGS = IdentificationSettings(window_s=120.0)


def shaken(structure, seed):
    made = structure(FREQUENCIES, [0.02, 0.02, 0.02], 5, seed)
    return made.simulate(np.random.default_rng(seed), 120.0, RATE_HZ)


def turning(n_samples, low_hz, high_hz):
    """Return shaft angles that go from one speed to another and back, [rad]."""
    time = np.arange(n_samples) / RATE_HZ
    middle, half = (low_hz + high_hz) / 2.0, (high_hz - low_hz) / 2.0
    speed_hz = middle - half * np.cos(2.0 * np.pi * time / time[-1])
    return 2.0 * np.pi * np.cumsum(speed_hz) / RATE_HZ


def with_order(samples, phase, amplitude, seed):
    shape = np.random.default_rng(seed).standard_normal(samples.acceleration.shape[1])
    return replace(
        samples, acceleration=samples.acceleration + amplitude * np.outer(np.cos(phase), shape)
    )


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize(('low_hz', 'high_hz'), [(11.0, 14.0), (12.0, 12.0), (6.0, 25.0)])
def test_an_order_is_found_at_its_place_and_leaves_no_mode(structure, seed, low_hz, high_hz):
    clean = shaken(structure, seed)
    angle = turning(len(clean.acceleration), low_hz, high_hz)
    samples = with_order(clean, angle, 0.5, seed)
    found = remove_drive_orders(samples, np.column_stack([angle, 0.0 * angle]))
    assert [(order.drive, order.order) for order in found.orders] == [(0, 1.0)], f'seed {seed}'
    order = found.orders[0]
    assert order.lowest_hz == pytest.approx(low_hz, rel=0.02)
    assert order.highest_hz == pytest.approx(high_hz, rel=0.02)
    assert all(line.harmonic for line in found.lines)
    added = np.mean((samples.acceleration - clean.acceleration) ** 2)
    left = np.mean((found.samples.acceleration - clean.acceleration) ** 2)
    # A fifth of a hertz along the track goes with the line, the structure's share included.
    structure_power = np.mean(clean.acceleration**2)
    assert left < 0.05 * added + 0.02 * structure_power, f'seed {seed}'
    result = identify_samples(found.samples, SETTINGS)
    assert result.modes.frequency_hz == pytest.approx(FREQUENCIES, rel=0.01), f'seed {seed}'
    assert not len(result.harmonics)


def test_several_orders_of_several_drives(structure):
    seed = 4
    clean = shaken(structure, seed)
    n = len(clean.acceleration)
    angles = np.column_stack([turning(n, 5.0, 8.0), turning(n, 13.0, 16.0)])
    samples = with_order(clean, 2.0 * angles[:, 0], 0.4, 1)
    samples = with_order(samples, 3.0 * angles[:, 1], 0.4, 2)
    found = remove_drive_orders(samples, angles)
    assert [(o.drive, o.order) for o in found.orders] == [(0, 2.0), (1, 3.0)], f'seed {seed}'


def test_nothing_is_found_where_there_is_nothing(structure):
    n_found = 0
    for seed in range(12):
        clean = shaken(structure, seed)
        angle = turning(len(clean.acceleration), 3.0 + seed, 5.0 + 1.5 * seed)
        found = remove_drive_orders(clean, angle[:, None])
        n_found += len(found.orders)
    assert n_found == 0, f'{n_found} of {12 * len(ORDERS)}, seeds 0 to 11'


def test_a_drive_that_hardly_turns_makes_no_line(structure):
    clean = shaken(structure, 0)
    wiggle = 3.0 * np.sin(2.0 * np.pi * 5.0 * np.arange(len(clean.acceleration)) / RATE_HZ)
    assert not remove_drive_orders(clean, wiggle[:, None]).orders
