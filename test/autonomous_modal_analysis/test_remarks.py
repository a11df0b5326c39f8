"""What should be known of an identification is said in a plain line, and nothing of sound data."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from autonomous_modal_analysis import identify
from autonomous_modal_analysis.identified.remarks import remarks
from oma_identifier.settings import IdentificationSettings

SEED = 77


def response(rate_hz, duration_s, modes, noise=1e-3, rng_seed=SEED):
    """Return accelerations of three sensors under white forces, (n_samples, 3)."""
    rng = np.random.default_rng(rng_seed)
    total = np.zeros((round(rate_hz * duration_s), 3))
    for frequency_hz, damping in modes:
        pole = np.exp(
            2 * np.pi * frequency_hz * (-damping + 1j * np.sqrt(1 - damping**2)) / rate_hz
        )
        motion = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], rng.normal(size=len(total)))
        total += np.outer(motion / motion.std(), rng.normal(size=3))
    return total + noise * rng.normal(size=total.shape)


def test_sound_data_need_no_remark():
    for rate_hz, modes in (
        (100.0, [(3.0, 0.02), (17.0, 0.01)]),
        (12.0, [(1.1, 0.03), (4.0, 0.02)]),
    ):
        found = identify(response(rate_hz, 300.0, modes), rate_hz)
        assert len(found) == 2 and found.remarks == (), f'seed {SEED}'


@pytest.mark.slow
def test_windows_too_short_for_the_slowest_mode_are_named_with_those_that_would_do(ama, tmp_path):
    np.save(tmp_path / 'slow.npy', response(20.0, 1800.0, [(0.32, 0.03), (4.0, 0.02)]))
    options = tmp_path / 'slow.npy', '--sample-rate-hz', '20', '--unit', 'm/s^2'
    shown = ama('identify', *options)
    note = next(line for line in shown.stdout.splitlines() if line.startswith('note: '))
    assert '1 mode at 0.3' in note and 'windows of 60 s are too short' in note, f'seed {SEED}'
    longer = note.split('--window-s ')[1].split()[0]
    again = ama('identify', *options, '--window-s', longer)
    assert 'note: ' not in again.stdout, f'seed {SEED}'


def test_a_sensor_on_a_part_that_swings_by_itself_says_what_to_do():
    found = identify(response(20.0, 130.0, [(1.5, 0.02), (4.0, 0.02)]), 20.0).found
    windows = found.identification.windows
    assert len(windows) > 2 and 'swings by itself' not in ' '.join(found.identification.remarks)

    def left_out(window):
        channels = window.quality.channels
        odd = replace(channels[0], excluded=True, flags=('incoherent',))
        return replace(window, quality=replace(window.quality, channels=(odd, *channels[1:])))

    for n_out, told in ((len(windows), True), (1, False)):
        marked = [left_out(w) if k < n_out else w for k, w in enumerate(windows)]
        said = remarks(found.whole, marked, 20.0, IdentificationSettings())
        name = windows[0].quality.channels[0].name
        assert any(line.startswith(f'{name}: the clock') for line in said) == told, said


def test_no_window_longer_than_the_record_is_asked_for():
    found = identify(response(20.0, 300.0, [(0.6, 0.05), (4.0, 0.02)]), 20.0).found
    flags = ('windows_too_short',)
    whole = replace(found.whole, quality=replace(found.whole.quality, flags=flags))
    slow = whole.modes.modes[0]
    blind = [
        replace(window, modes=tuple(mode for mode in window.modes if mode.id != slow.id))
        for window in found.identification.windows
    ]
    # Windows for 2 / (0.05 0.6 Hz) and 2 / (0.005 0.6 Hz).
    for damping, words in ((0.05, '--window-s'), (0.005, 'record several times')):
        modes = (replace(slow, damping_ratio=damping), *whole.modes.modes[1:])
        one = replace(whole, modes=replace(whole.modes, modes=modes))
        said = [
            line
            for line in remarks(one, blind, 20.0, IdentificationSettings())
            if 'too short, most' in line
        ]
        assert len(said) == 1 and words in said[0], f'seed {SEED}: {said}'
        assert ('--window-s' in said[0]) == (damping == 0.05), said


def test_a_record_too_short_for_light_damping_says_how_long_it_should_be():
    records = [
        identify(response(100.0, 60.0, [(3.0, 0.02)], rng_seed=SEED + n), 100.0).found
        for n in range(6)
    ]
    sound = [found for found in records if not found.identification.remarks]
    # 3 of 240 such records are taken for unsteady ones.
    assert len(sound) >= 5, f'seeds {SEED} to {SEED + 5}'
    found = sound[0]
    light = replace(found.whole.modes.modes[0], damping_ratio=0.004)
    whole = replace(found.whole, modes=replace(found.whole.modes, modes=(light,)))
    said = remarks(whole, found.identification.windows, 100.0, IdentificationSettings())
    # 1 / sqrt(2 pi 0.004 3 Hz T) is 20 % at 332 s.
    assert len(said) == 1 and '60 s are short for the damping' in said[0]
    assert said[0].endswith('record 340 s for 20 %') and 'without σ' not in said[0]


def test_damping_without_a_deviation_is_said_to_be():
    found = identify(response(100.0, 60.0, [(3.0, 0.02)]), 100.0).found
    mode = found.whole.modes.modes[0]
    for ratio, words in ((0.004, 'short for the damping (without σ)'), (0.02, 'moves too far')):
        withheld = replace(mode, damping_ratio=ratio, damping_ratio_std=np.nan)
        whole = replace(found.whole, modes=replace(found.whole.modes, modes=(withheld,)))
        said = remarks(whole, found.identification.windows, 100.0, IdentificationSettings())
        assert len(said) == 1 and words in said[0], said


def test_a_mode_that_a_line_moved_across_says_why_it_has_no_deviation():
    found = identify(response(100.0, 120.0, [(3.0, 0.02), (17.0, 0.02)]), 100.0).found
    first, second = found.whole.modes.modes
    bare = replace(second, frequency_std_hz=np.nan, damping_ratio_std=np.nan)
    for line_hz, words in ((17.2, ['without σ, for 1 line at 17.2 Hz']), (30.0, [])):
        line = replace(second, frequency_hz=line_hz, harmonic=True)
        whole = replace(
            found.whole,
            modes=replace(found.whole.modes, modes=(first, bare)),
            harmonics=replace(found.whole.harmonics, modes=(line,)),
        )
        said = remarks(whole, found.identification.windows, 100.0, IdentificationSettings())
        assert len(said) == bool(words) and all(word in said[0] for word in words), said


@pytest.mark.parametrize(
    ('rate_hz', 'frequency_hz', 'words'),
    [(1000.0, 6.0, 'far below half the sample rate'), (100.0, 46.0, 'may be folded')],
)
def test_a_rate_that_does_not_fit_the_response_is_asked_about(rate_hz, frequency_hz, words):
    found = identify(response(rate_hz, 120.0, [(frequency_hz, 0.01)], noise=0.1), rate_hz)
    assert [line for line in found.remarks if words in line and 'rate right?' in line]
    assert found.found.identification.remarks == tuple(found.to_dict()['remarks'])


def test_windows_without_modes_are_counted_with_the_remedy():
    data = response(50.0, 600.0, [(4.0, 0.01)], noise=0.05)
    data[6000:] = 0.05 * np.random.default_rng(SEED).normal(size=data[6000:].shape)
    found = identify(data, 50.0)
    assert any('windows gave no modes' in line and 'excitation' in line for line in found.remarks)


def test_the_table_is_in_order_of_frequency_lines_among_the_modes(ama, tmp_path):
    data = response(100.0, 120.0, [(4.0, 0.01), (21.0, 0.01)])
    line = np.sin(2 * np.pi * 11.0 * np.arange(len(data)) / 100.0)
    np.save(tmp_path / 'line.npy', data + 0.5 * np.outer(line, [1.0, 0.5, -0.7]))
    shown = ama(
        'identify', tmp_path / 'line.npy', '--sample-rate-hz', '100', '--unit', 'm/s^2'
    ).stdout
    rows = [row for row in shown.splitlines() if ' ± ' in row or 'harmonic' in row]
    cells = [[cell.strip() for cell in row.split('│')] for row in rows]
    frequencies = [float(row[2].split()[0]) for row in cells]
    assert len(frequencies) == 3 and frequencies == sorted(frequencies), shown
    assert 'harmonic' in rows[1], shown
