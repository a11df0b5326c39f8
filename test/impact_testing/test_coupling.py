"""Force and responses that passed high-passes, as couplings by alternating current are."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

from impact_testing import impact_modes
from impact_testing.measuring_chain import force_corner
from test.support.hammer_bench import bench, random_structure, Structure, taps

SEED, RATE_HZ = 984_000, 512.0


def passed(values, corner_hz):
    """Return what a high-pass of first order leaves."""
    high = bilinear([1.0, 0.0], [1.0, 2.0 * np.pi * corner_hz], RATE_HZ)
    return lfilter(*high, values, axis=0)


def coupled(structure, rng, of_force=(), of_responses=(), hit=2):
    """Return a record of five taps, noise of the converters behind the high-passes."""
    record = taps(structure, hit, 0.5 + 4.0 * np.arange(5), rng)
    force, motion = record.force_n, record.responses.acceleration
    for corner_hz in of_force:
        force = passed(force, corner_hz)
    for corner_hz in of_responses:
        motion = passed(motion, corner_hz)
    force = force + 0.05 * rng.standard_normal(force.shape) + rng.normal()
    motion = motion + 0.01 * rng.standard_normal(motion.shape) + rng.normal(size=structure.n)
    responses = replace(record.responses, acceleration=motion)
    return replace(record, force_n=force, responses=responses)


@pytest.mark.parametrize(
    ('of_force', 'of_responses'),
    [((0.16,), (0.16,)), ((0.5,), (0.5,)), ((0.5,), (0.5, 0.16)), ((), (0.5,)), ((3.4,), (3.4,))],
)
def test_a_high_pass_is_undone_and_told(of_force, of_responses):
    """Without that there were three to nine false modes, and masses off by 2 to 9 %."""
    rng = np.random.default_rng(SEED)
    found = impact_modes([coupled(bench(), rng, of_force, of_responses)])
    poles, shapes = bench().modes()
    assert len(found.modes) == 3, (SEED, found.modes.frequency_hz)
    for each, pole, shape in zip(found.scaled_modes, poles, shapes.T, strict=True):
        mode, size = each.mode, abs(pole)
        mass = 1.0 / (2.0 * pole.imag * np.abs(shape).max() ** 2)
        assert abs(mode.frequency_hz - size / 2 / np.pi) < 4.0 * mode.frequency_std_hz
        assert abs(mode.damping_ratio + pole.real / size) < 4.0 * mode.damping_ratio_std
        assert abs(each.modal_mass_kg - mass) < 4.0 * each.modal_mass_std_kg < 0.02 * mass
    (told,) = (each for each in found.remarks if 'high-pass' in each)
    assert ('the force one of' in told) == bool(of_force)
    assert 'the responses one of' in told


def test_what_passed_none_has_none():
    """Ten structures whose dampers make their modes complex."""
    for seed in range(SEED, SEED + 10):
        rng = np.random.default_rng(seed)
        plain = random_structure(rng, 4)
        damping = plain.C.copy()
        damping[1, 1] += 2.0 * damping.diagonal().mean()
        found = impact_modes([coupled(Structure(plain.M, damping, plain.K), rng)])
        assert not any('high-pass' in each for each in found.remarks), seed


@pytest.mark.parametrize('corner_hz', [0.05, 0.5, 3.4])
def test_the_corner_of_a_force_is_told_by_what_it_reads_behind_the_taps(corner_hz):
    errors = []
    for seed in range(SEED, SEED + 6):
        rng = np.random.default_rng(seed)
        found = force_corner([coupled(bench(), rng, (corner_hz,))])
        assert found.sure, seed
        errors.append((found.hz - corner_hz) / found.std_hz)
    assert np.abs(errors).max() < 4.0, (SEED, errors)


def test_a_force_that_drifts_gives_what_one_at_rest_gives():
    """Modes that are none had explained it, and masses were lost."""
    rng = np.random.default_rng(SEED)
    record = coupled(bench(), rng)
    time = np.linspace(0.0, 1.0, len(record.force_n))
    still = impact_modes([record])
    for drift in (40.0 * time, 5.0 * np.sin(5.0 * time) + 3.0 * time**2):
        found = impact_modes([replace(record, force_n=record.force_n + drift)])
        assert any('the force drifts by' in each for each in found.remarks)
        assert len(found.modes) == 3
        for moved, each in zip(found.scaled_modes, still.scaled_modes, strict=True):
            assert abs(moved.modal_mass_kg - each.modal_mass_kg) < 2.0 * each.modal_mass_std_kg
            off_hz = abs(moved.mode.frequency_hz - each.mode.frequency_hz)
            assert off_hz < each.mode.frequency_std_hz
    assert not any('drift' in each for each in still.remarks)
