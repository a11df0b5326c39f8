"""Recordings of taps with values that stand for lost samples, or with a unit that is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from impact_testing import impact_modes
from impact_testing.measuring_chain import check_measured
from modal_core.errors import RecordingError
from test.support.hammer_bench import bench, taps

SEED = 993700
NAMES, UNITS = ('hammer', 'm0', 'm1', 'm2'), ('N', 'm/s^2', 'm/s^2', 'm/s^2')


def columns(seed, step=0.0):
    """Return force and responses of five taps; of a converter with so many units a step."""
    rng = np.random.default_rng(seed)
    record = taps(bench(), 2, 0.5 + 3.0 * np.arange(5), rng, noise=0.005, force_noise_n=0.1)
    values = np.column_stack([record.force_n, record.responses.acceleration])
    return np.round(values / step) * step if step else values


@pytest.mark.parametrize('value', (9999.0, 1e6, 1.5e7, -999.25))
@pytest.mark.parametrize('column', range(4))
def test_placeholders_are_refused_and_named(column, value):
    for seed in range(SEED, SEED + 1):
        values = columns(seed)
        rows = np.random.default_rng(seed).choice(len(values), 12, replace=False)
        values[rows, column] = value
        with pytest.raises(RecordingError) as told:
            check_measured('taps.csv', values, NAMES, UNITS)
        assert NAMES[column] in str(told.value), f'seed {seed}'
        assert f'12 x {value:.5g} {UNITS[column]}' in str(told.value), f'seed {seed}: {told.value}'


@pytest.mark.parametrize('step', (0.0, 0.01, 0.5))
@pytest.mark.parametrize('every', (1, 2, 4, 8))
def test_taps_are_no_placeholders(step, every):
    """Pulses of many samples down to one, with and without the steps of a converter."""
    for seed in range(SEED + 10, SEED + 12):
        check_measured('taps.csv', columns(seed, step)[::every], NAMES, UNITS)


@pytest.mark.parametrize(('column', 'times'), ((2, 1e3), (1, 1e-3)))
def test_a_unit_that_is_wrong_by_a_thousand_is_told(column, times):
    rng = np.random.default_rng(SEED)
    record = taps(bench(), 2, 0.5 + 3.0 * np.arange(5), rng, noise=0.005, force_noise_n=0.1)
    assert not any('unit and gain' in each for each in impact_modes([record]).remarks)
    rows = record.responses.acceleration * np.where(np.arange(3) == column, times, 1.0)
    wrong = replace(record, responses=replace(record.responses, acceleration=rows))
    name = record.responses.channel_names[column]
    assert any(
        each.startswith(f'{name} reads') and 'unit and gain' in each
        for each in impact_modes([wrong]).remarks
    )
