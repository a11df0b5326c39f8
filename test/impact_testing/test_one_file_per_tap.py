"""Taps of which each has a recording of its own, as analysers with a trigger save them."""

from dataclasses import replace

import numpy as np
import pytest

from impact_testing import impact_modes
from modal_core.errors import IdentificationError
from test.support.hammer_bench import bench, taps

SEED = 983
RINGS = (2.5, 5.0)
"""Seconds from the tap to the end of its recording: modes ring on there, or have died."""


def single_taps(seed, n=5, last_s=4.0, before_s=0.5, hit='m2'):
    """Return a recording for each tap, from rest, offsets and noise of their own."""
    rng, structure = np.random.default_rng(seed), bench()
    found = []
    for number in range(n):
        each = taps(structure, 2, [before_s], rng, noise=0.005, last_s=last_s, force_noise_n=0.02)
        rows = each.responses.acceleration + rng.normal(0.0, 3.0, structure.n)
        found.append(
            replace(
                each,
                force_n=each.force_n + rng.normal(),
                responses=replace(each.responses, acceleration=rows),
                hit=hit,
                name=f'tap_{number}',
            )
        )
    return found


@pytest.mark.parametrize('last_s', RINGS)
@pytest.mark.parametrize('before_s', (0.05, 1.0))
def test_recordings_of_one_point_are_joined(last_s, before_s):
    """Of 16 tests the errors are those their standard deviations promise."""
    poles, shapes = bench().modes()
    errors = []
    for seed in range(SEED, SEED + 4):
        found = impact_modes(single_taps(seed, 5, last_s, before_s))
        assert len(found.points) == 1
        assert found.points[0].n_good == 5, seed
        assert found.modes.frequency_hz == pytest.approx(np.abs(poles) / 2 / np.pi, rel=1e-3)
        for each, pole, shape in zip(found.scaled_modes, poles, shapes.T, strict=True):
            mass = 1.0 / (2.0 * pole.imag * np.abs(shape).max() ** 2)
            mode = each.mode
            errors += [
                (mode.frequency_hz - abs(pole) / 2 / np.pi) / mode.frequency_std_hz,
                (mode.damping_ratio + pole.real / abs(pole)) / mode.damping_ratio_std,
                (each.modal_mass_kg - mass) / each.modal_mass_std_kg,
            ]
    known = np.array(errors)[np.isfinite(errors)]
    assert len(known) >= 24
    # Of 36 standard normal numbers the rms is below 1.4 but for one time in ten thousand.
    assert np.sqrt(np.mean(known**2)) < 1.4, (SEED, known.round(1))


def test_each_tap_is_told_by_its_recording():
    records = single_taps(SEED, 5)
    low = replace(records[3], force_n=0.02 * records[3].force_n)
    (point,) = impact_modes([*records[:3], low, records[4]]).points
    told = [(name, number, tap.good) for name, number, _, tap in point.told_taps()]
    assert told == [(f'tap_{n}', 1, n != 3) for n in range(5)]
    assert [time_s for _, _, time_s, _ in point.told_taps()] == pytest.approx([0.5] * 5, abs=0.05)


def test_where_nobody_says_the_point_it_is_asked_for():
    with pytest.raises(IdentificationError, match='say which point they hit') as raised:
        impact_modes(single_taps(SEED, 3, hit=''))
    assert 'tap_0' in str(raised.value)


def test_responses_that_an_analyser_windowed_are_refused():
    """Their damping is the window's, and the noise that falls made modes that are none."""
    whole = single_taps(SEED, 4, before_s=0.3)
    time_s = np.arange(len(whole[0].force_n)) / whole[0].rate_hz
    window = np.exp(-np.maximum(time_s - 0.25, 0.0))
    windowed = [
        replace(
            each,
            responses=replace(
                each.responses,
                acceleration=(each.responses.acceleration - 1.0) * window[:, None],
            ),
        )
        for each in whole
    ]
    with pytest.raises(IdentificationError, match='an exponential window was applied'):
        impact_modes(windowed)


def test_what_still_rings_before_the_tap_is_no_window():
    """Runs of a trigger, cut from taps 3 s apart: before each tap the one before rings."""
    rng, structure = np.random.default_rng(SEED), bench()
    record = taps(structure, 2, 3.0 + 3.0 * np.arange(6), rng, noise=0.005, last_s=3.0)
    first = [round((2.7 + 3.0 * number) * record.rate_hz) for number in range(1, 6)]
    length = round(2.9 * record.rate_hz)
    cut = [
        replace(
            record,
            force_n=record.force_n[row : row + length],
            responses=record.responses.part(slice(row, row + length)),
            hit='m2',
            name=f'tap_{number}',
        )
        for number, row in enumerate(first)
    ]
    found = impact_modes(cut)
    assert any('still moves when recordings begin' in each for each in found.remarks)
    assert np.isnan([each.frequency_std_hz for each in found.modes]).all()
