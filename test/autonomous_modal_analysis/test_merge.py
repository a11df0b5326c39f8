"""`ama merge`: set-ups of roving sensors become one shape over all points."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.numbers.indicators import mac

RATE_HZ, SEED = 100.0, 31
TRUTH_HZ = (4.0, 9.0)
POINTS = ('ref', 'a', 'b', 'c', 'd', 'e')
SHAPES = np.array([[1.0, 0.7], [0.8, -0.4], [0.5, -1.0], [0.3, 0.2], [-0.2, 0.9], [0.6, 0.5]])
SETUPS = {'one': ('ref', 'a', 'b'), 'two': ('ref', 'c', 'd')}
QUIET = ('ref', 'e')
"""Of a third set-up, in which nothing excites the higher mode."""


@pytest.fixture(scope='module')
def setups(tmp_path_factory):
    """Write set-ups of one structure that share a reference; the second is shaken harder."""
    folder = tmp_path_factory.mktemp('setups')
    rng = np.random.default_rng(SEED)
    levels = ((1.0, 1.0), (3.0, 3.0), (1.0, 0.0))
    for forces, (name, points) in zip(levels, {**SETUPS, 'quiet': QUIET}.items(), strict=True):
        rows = [POINTS.index(point) for point in points]
        total = np.zeros((18_000, len(rows)))
        for level, frequency_hz, shape in zip(forces, TRUTH_HZ, SHAPES[rows].T, strict=True):
            root = np.exp(
                2 * np.pi * frequency_hz * (-0.015 + 1j * np.sqrt(1 - 0.015**2)) / RATE_HZ
            )
            force = level * rng.normal(size=len(total))
            total += np.outer(
                lfilter([1.0, -1.0], np.poly([root, root.conj()]).real, force), shape
            )
        total += 0.01 * total.std() * rng.normal(size=total.shape)
        np.save(folder / f'{name}.npy', total)
        (folder / f'{name}.npy.yaml').write_text(
            f'sample_rate_hz: {RATE_HZ}\nunit: m/s^2\nchannels: [{", ".join(points)}]\n'
        )
    return folder


def test_two_set_ups_give_shapes_over_all_points(ama, setups, tmp_path):
    out = tmp_path / 'merged'
    files = [setups / f'{name}.npy' for name in SETUPS]
    run = ama('merge', *files, '--out', out, '--json')
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert found['shape_channels'] == ['ref', 'a', 'b', 'c', 'd']
    assert len(found['modes']) == 2, f'seed {SEED}'
    for mode, frequency_hz, shape in zip(found['modes'], TRUTH_HZ, SHAPES[:5].T, strict=True):
        assert abs(mode['frequency_hz'] - frequency_hz) < 4.0 * mode['frequency_std_hz'], (
            f'seed {SEED}'
        )
        merged = np.array(mode['shape_real']) + 1j * np.array(mode['shape_imag'])
        assert mac(merged, shape).item() > 0.99, f'seed {SEED}'
    assert '2 of 2 modes are in all set-ups' in run.stderr
    assert json.loads((out / 'modes.json').read_text())['modes'] == found['modes']
    page = (out / 'report.html').read_text()
    assert '2 modes of vibration' in page and 'one.npy, two.npy' in page
    assert 'id="stabilisation"' not in page


def test_set_ups_without_a_shared_channel_are_refused(ama, setups, tmp_path):
    other = tmp_path / 'other.npy'
    other.write_bytes((setups / 'two.npy').read_bytes())
    (tmp_path / 'other.npy.yaml').write_text(
        'sample_rate_hz: 100\nunit: m/s^2\nchannels: [x, y, z]\n'
    )
    run = ama('merge', setups / 'one.npy', other)
    assert run.returncode == 2
    assert 'share no channel' in run.stderr and 'reference' in run.stderr


@pytest.mark.slow
def test_a_mode_that_one_set_up_missed_stays_without_its_points(ama, setups, tmp_path):
    kept = tmp_path / 'kept'
    assert ama('identify', setups / 'one.npy', '--out', kept).returncode == 0
    out = tmp_path / 'merged'
    files = kept, setups / 'two.npy', setups / 'quiet.npy'
    run = ama('merge', *files, '--out', out)
    assert run.returncode == 0, run.stderr
    assert '3 of 3 set-ups' in run.stdout and '2 of 3 set-ups' in run.stdout, f'seed {SEED}'
    assert '1 of 2 modes are in all set-ups; 1 lack points that were not seen' in run.stderr
    found = json.loads((out / 'modes.json').read_text())
    low, high = found['modes']
    assert found['shape_channels'] == [*POINTS]
    assert None not in low['shape_real'] and high['shape_real'].index(None) == POINTS.index('e')
    assert found['set_ups']['seen_in'][1] == ['kept', 'two.npy']
    assert '2 of 3 set-ups' in (out / 'report.html').read_text()
    # What was merged is taken back, missing points and all.
    again = ama('compare', out, out, '--json')
    assert len(json.loads(again.stdout)['changes']) == 2, again.stderr
