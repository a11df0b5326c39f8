"""`ama identify A B --method psdtm`: one recording per loading condition."""

import json

import numpy as np
import pytest

import autonomous_modal_analysis as ama_api
from autonomous_modal_analysis.identified.loading_conditions import joined
from modal_core.errors import RecordingError, SettingsError
from test.oma_identifier.methods.test_psdtm import chain, RATE_HZ, SEED, shaken


def write(path, rows, rate_hz=RATE_HZ):
    np.save(path, rows)
    path.with_name(f'{path.name}.yaml').write_text(f'sample_rate_hz: {rate_hz}\nunit: m/s^2\n')
    return path


@pytest.fixture(scope='module')
def conditions(tmp_path_factory):
    """Write the chain shaken at its first mass, and at its last, on another gravity."""
    folder = tmp_path_factory.mktemp('conditions')
    return [
        write(folder / f'mass_{mass}.npy', shaken((mass,), SEED + mass).acceleration + 9.81 * mass)
        for mass in (0, 2)
    ]


@pytest.mark.slow
def test_two_recordings_give_the_modes_and_the_number_of_conditions(ama, conditions):
    run = ama('identify', *conditions, '--method', 'psdtm', '--json')
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    hz = [mode['frequency_hz'] for mode in found['modes']]
    np.testing.assert_allclose(hz, chain().frequency_hz, rtol=0.03, err_msg=f'seed {SEED}')
    assert any('2 loading conditions were told apart' in line for line in found['remarks'])


def test_one_condition_recorded_twice_is_refused_in_a_line(ama, conditions):
    run = ama('identify', conditions[0], conditions[0], '--method', 'psdtm')
    assert run.returncode == 2
    assert len(run.stderr.strip().splitlines()) == 1
    assert 'error: mass_0.npy + mass_0.npy: ' in run.stderr, run.stderr
    assert 'found one' in run.stderr and 'expected two or more' in run.stderr


def test_other_methods_take_one_recording(ama, conditions):
    run = ama('identify', *conditions)
    assert run.returncode == 2
    assert 'ama merge' in run.stderr and 'ama compare' in run.stderr


def test_what_does_not_fit_together_is_named(conditions, tmp_path):
    first = ama_api.open(conditions[0])
    rows = np.load(conditions[0])
    with pytest.raises(RecordingError, match=r'fewer.npy: other channels than mass_0'):
        joined([first, ama_api.open(write(tmp_path / 'fewer.npy', rows[:, :2]))])
    with pytest.raises(RecordingError, match=r'fast.npy: another rate than mass_0'):
        joined([first, ama_api.open(write(tmp_path / 'fast.npy', rows, 2 * RATE_HZ))])
    with pytest.raises(RecordingError, match=r'short.npy: much shorter'):
        joined([first, ama_api.open(write(tmp_path / 'short.npy', rows[:2000]))])
    with pytest.raises(SettingsError, match='2 to 5'):
        joined([first] * 6)
    assert joined([first]) is first
