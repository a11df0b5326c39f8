"""Arrays in, modes out: against a structure known in closed form, and wrong arrays."""

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from modal_core.errors import ModalAnalysisError, RecordingError, SettingsError
from modal_core.numbers.indicators import mac_of_pairs
from modal_core.words.flag_words import flag_words
from test.support.frame import DAMPING_RATIO, FLOORS, shaken_frame

RATE_HZ = 100.0
NOISE = np.random.default_rng(7).normal(size=(3000, 3))
TIME_S = np.arange(3000) / RATE_HZ


def test_a_frame_has_the_modes_of_its_formula(frame, identified):
    assert len(identified) == len(identified.modes) == 3
    assert identified.channel_names == FLOORS
    assert identified.frequencies_hz == pytest.approx(frame.frequencies_hz, rel=0.01)
    assert identified.damping_ratios == pytest.approx(np.full(3, DAMPING_RATIO), abs=0.005)
    assert identified.shapes.shape == identified.shapes_std.shape == (3, 3)
    assert mac_of_pairs(identified.shapes, frame.shapes.astype(complex)).min() > 0.999


@pytest.mark.slow
def test_errors_are_as_large_as_the_standard_deviations_say():
    """Of ten seeds; the root mean square of 30 scores is within 0.6 to 1.5 but once in 10,000."""
    scores = []
    for seed in range(10):
        frame = shaken_frame(seed, duration_s=120.0)
        found = ama.identify(frame.acceleration, RATE_HZ)
        assert len(found) == 3, f'seed {seed}'
        scores.append((found.frequencies_hz - frame.frequencies_hz) / found.frequencies_std_hz)
        damping = (found.damping_ratios - DAMPING_RATIO) / found.damping_ratios_std
        assert np.abs(damping).max() < 4.5, f'seed {seed}: {damping}'
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.5, scores


def test_shapes_have_standard_deviations_where_they_are_known(frame, identified):
    known = np.isfinite(identified.shapes_std.real)
    for column, mode in enumerate(identified.modes):
        assert known[:, column].all() == (mode.shape_std is not None)
    truth = frame.shapes / frame.shapes[np.argmax(np.abs(identified.shapes), axis=0), range(3)]
    away = np.abs((identified.shapes - truth).real)
    assert (away[known] <= 5.0 * identified.shapes_std.real[known] + 1e-3).all()


def test_units_are_units(frame):
    in_g = frame.acceleration / 9.80665
    plain = ama.identify(frame.acceleration, RATE_HZ)
    for options in ({'unit': 'g'}, {'channel_names': ['a [g]', 'b [g]', 'c [g]']}):
        found = ama.identify(in_g, RATE_HZ, **options)
        assert found.frequencies_hz == pytest.approx(plain.frequencies_hz, rel=1e-9)
        rms = [channel.rms for channel in found.found.identification.quality.channels]
        expected = [channel.rms for channel in plain.found.identification.quality.channels]
        assert rms == pytest.approx(expected, rel=1e-6)


def test_values_that_are_no_numbers_are_samples_lost(frame, identified):
    """As the mean of a logger's dropouts, one value in 500; and a channel that never came."""
    lost = np.random.default_rng(3).random(frame.acceleration.shape) < 0.002
    found = ama.identify(np.where(lost, np.nan, frame.acceleration), RATE_HZ)
    off = np.abs(found.frequencies_hz - identified.frequencies_hz)
    assert (off < 0.5 * identified.frequencies_std_hz).all()
    assert any('no numbers, taken as lost: ' in remark for remark in found.remarks)

    without = ama.identify(np.where([False, True, False], np.inf, frame.acceleration), RATE_HZ)
    assert without.channel_names == ('ch1', 'ch3') and len(without) == 3
    assert 'left out: ch2 (values that are not numbers)' in without.remarks
    with pytest.raises(ModalAnalysisError, match='every channel is excluded: values that are not'):
        ama.identify(np.full_like(frame.acceleration, np.nan), RATE_HZ)


def test_rows_without_a_number_are_pauses_of_the_recorder(frame, identified):
    """Four pauses of half a second to seven seconds."""
    paused = frame.acceleration.copy()
    for share, pause_s in ((0.1, 0.5), (0.3, 7.0), (0.6, 2.5), (0.8, 4.0)):
        first = round(share * len(paused))
        paused[first : first + round(pause_s * RATE_HZ)] = np.nan
    found = ama.identify(paused, RATE_HZ)
    assert found.shapes.shape == (3, 3)
    off = np.abs(found.frequencies_hz - identified.frequencies_hz)
    assert (off < 3.0 * identified.frequencies_std_hz).all()


def test_a_copied_column_is_left_out_and_a_flat_one_is_flat(frame):
    flat = np.zeros(len(frame.acceleration))
    columns = (*frame.acceleration.T, frame.acceleration[:, 1], flat, flat)
    found = ama.identify(np.column_stack(columns), RATE_HZ)
    assert found.channel_names == ('ch1', 'ch2', 'ch3')
    (told,) = (remark for remark in found.remarks if remark.startswith('left out'))
    assert f'ch4 ({flag_words("copied")})' in told
    assert f'ch5 and ch6 ({flag_words("flatline")})' in told


def test_columns_of_other_kinds_give_the_same_modes(frame):
    """The acceleration of the second floor integrated once, [mm/s], that of the third twice, [um].

    Drift is no motion of the frame: integrated in the frequency domain, from 0.2 Hz on.
    """
    turn = 2j * np.pi * np.fft.rfftfreq(len(frame.acceleration), 1.0 / RATE_HZ)[:, None]
    kept = np.abs(turn) > 0.4 * np.pi
    spectrum = np.fft.rfft(frame.acceleration, axis=0) * kept / np.where(kept, turn, 1.0) ** (
        0, 1, 2
    )  # fmt: skip
    sent = np.fft.irfft(spectrum, len(frame.acceleration), axis=0) * (1.0, 1e3, 1e6)
    names = ['first [m/s^2]', 'second [mm/s]', 'third [um]']
    found = ama.identify(sent, RATE_HZ, channel_names=names)
    assert found.channel_names == ('first', 'second', 'third')
    assert found.frequencies_hz == pytest.approx(frame.frequencies_hz, rel=0.01)
    assert mac_of_pairs(found.shapes, frame.shapes.astype(complex)).min() > 0.999
    channels = found.to_dict()['channels']
    assert [channel['unit'] for channel in channels] == ['m/s^2', 'm/s', 'm']


def test_a_data_frame_names_its_channels_and_its_time(frame):
    pandas = pytest.importorskip('pandas')
    time_s = np.arange(len(frame.acceleration)) / RATE_HZ
    table = pandas.DataFrame(frame.acceleration, columns=list(FLOORS))
    plain = ama.identify(frame.acceleration, RATE_HZ, channel_names=FLOORS)
    by_rate = ama.identify(table, RATE_HZ)
    assert by_rate.channel_names == FLOORS
    assert (by_rate.frequencies_hz == plain.frequencies_hz).all()
    table.insert(0, 'time [s]', time_s)
    by_time = ama.identify(table)
    assert by_time.frequencies_hz == pytest.approx(plain.frequencies_hz, rel=1e-6)


def test_settings_are_those_of_the_identifier(frame):
    low = ama.identify(frame.acceleration, RATE_HZ, max_frequency_hz=8.0, window_s=30.0)
    inside = frame.frequencies_hz[frame.frequencies_hz < 8.0]
    assert low.frequencies_hz == pytest.approx(inside, rel=0.01)
    assert {window.modes.method for window in low.windows} == {'ssi_cov'}
    by_fdd = ama.identify(frame.acceleration, RATE_HZ, method='efdd')
    assert by_fdd.modes.method == 'efdd'


@pytest.mark.parametrize(
    ('array', 'options', 'words'),
    [
        (NOISE, {}, 'no sample rate'),
        (NOISE.T, {'sample_rate_hz': RATE_HZ}, 'transpose it'),
        (NOISE[:, 0][None, :], {'sample_rate_hz': RATE_HZ}, 'transpose it'),
        (np.column_stack([TIME_S, NOISE]), {'sample_rate_hz': RATE_HZ}, 'column 1: counts up'),
        (np.column_stack([NOISE, np.arange(3000)]), {'sample_rate_hz': 1.0}, 'column 4: counts'),
        (np.column_stack([TIME_S, NOISE]), {}, 'column 1: counts up'),
        (NOISE, {'sample_rate_hz': -1}, 'bad rate'),
        (NOISE, {'sample_rate_hz': 'fast'}, 'bad rate'),
        (NOISE, {'sample_rate_hz': RATE_HZ, 'channel_names': ['a', 'b']}, 'number of channel'),
        (NOISE, {'sample_rate_hz': RATE_HZ, 'channel_names': 'abc'}, 'not a list'),
        (NOISE, {'sample_rate_hz': RATE_HZ, 'unit': 'parsec'}, 'unknown unit'),
        (NOISE + 0j, {'sample_rate_hz': RATE_HZ}, 'not real numbers'),
        (NOISE > 0.0, {'sample_rate_hz': RATE_HZ}, 'not real numbers'),
        (NOISE[None], {'sample_rate_hz': RATE_HZ}, 'not a table'),
        ([[1.0, 2.0], [3.0]], {'sample_rate_hz': RATE_HZ}, 'not an array'),
        (None, {'sample_rate_hz': RATE_HZ}, 'not real numbers'),
        ('bridge.mcap', {'sample_rate_hz': RATE_HZ}, 'ama.open'),
        (np.ma.masked_greater(NOISE, 3.0), {'sample_rate_hz': RATE_HZ}, 'masked'),
    ],
)
def test_a_wrong_array_is_refused_in_one_line(array, options, words):
    with pytest.raises(RecordingError, match=words) as caught:
        ama.identify(array, **options)
    text = str(caught.value)
    assert '\n' not in text and text.startswith('array') and '--' not in text


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        ({'windows_s': 30.0}, 'unknown setting .found windows_s, expected window_s'),
        ({'window_s': 'long'}, 'window_s: wrong kind of value'),
        ({'window_s': -1.0}, 'window_s: out of range'),
        ({'method': 'magic'}, 'unknown method'),
    ],
)
def test_a_wrong_setting_is_named(settings, words):
    with pytest.raises(SettingsError, match=words):
        ama.identify(NOISE, RATE_HZ, **settings)


def test_an_array_too_short_says_what_would_do():
    with pytest.raises(ama.ModalAnalysisError, match='window_s'):
        ama.identify(NOISE[:200], RATE_HZ)


def test_the_array_is_left_as_it_is(frame):
    before = frame.acceleration.copy()
    frame.acceleration.flags.writeable = False
    try:
        ama.identify(frame.acceleration, RATE_HZ)
    finally:
        frame.acceleration.flags.writeable = True
    assert (frame.acceleration == before).all()
