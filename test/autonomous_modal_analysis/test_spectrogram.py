"""Spectra over time and joint speed: against signals whose spectra are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from autonomous_modal_analysis.spectrogram import SpectrogramWatch
from autonomous_modal_analysis.spectrogram.columns import Columns
from autonomous_modal_analysis.spectrogram.joint_speed import mean_speeds, motor_turns
from modal_core.channel import Channel
from modal_core.measurements import JointSamples
from modal_core.samples import Samples
from modal_core.window import Window
from modal_reports import spectrogram_data
from structural_model.robot_files import load_robot

RATE_HZ = 128.0
SECOND = 1_000_000_000
FIRST_NS = 1_760_000_000 * SECOND
NAMES = ('resting', 'turning')


def windows(signal, length_s=20.0, hop_s=10.0, angle=None):
    """Yield overlapping windows of one channel, with the angle of the joint that turns."""
    length, hop = round(length_s * RATE_HZ), round(hop_s * RATE_HZ)
    for index, row in enumerate(range(0, len(signal) - length + 1, hop)):
        start_ns = FIRST_NS + round(row / RATE_HZ * SECOND)
        samples = Samples(signal[row : row + length, None], RATE_HZ, (Channel('a'),), start_ns)
        joints = None
        if angle is not None:
            stamps = start_ns + np.round(np.arange(length) / RATE_HZ * SECOND).astype(np.int64)
            position = np.column_stack([np.full(length, 0.3), angle[row : row + length]])
            joints = JointSamples(stamps, NAMES, position, np.full(position.shape, np.nan))
        yield Window(index, samples, joints=joints)


def watched(*arguments, robot=None, **options):
    watch = SpectrogramWatch(robot)
    for window in windows(*arguments, **options):
        watch.add(window)
    return watch.found()


def test_white_noise_has_its_density_at_all_times_and_each_sample_counts_once():
    seed = 41
    signal = 3.0 * np.random.default_rng(seed).standard_normal(round(400 * RATE_HZ))
    found = watched(signal)
    # Variance spread over half the rate; 200 independent segments of 2 s, none twice.
    assert len(found.time_s) == 200, seed
    density = 9.0 / (RATE_HZ / 2.0)
    inner = found.psd[:, :-1]
    assert inner.mean() == pytest.approx(density, rel=0.02), seed
    # A periodogram scatters by itself: means of columns over 127 lines, neighbours correlated.
    assert inner.mean(axis=1).std() / density < 0.2, seed
    assert found.joints == ()


def test_a_line_that_turns_with_the_joint_and_one_that_does_not():
    rows = np.arange(round(600 * RATE_HZ))
    time_s = rows / RATE_HZ
    speed = 0.2 + 0.8 * (time_s / time_s[-1])
    angle = np.cumsum(speed) / RATE_HZ
    order = 200.0
    signal = np.sin(order * angle) + np.sin(2.0 * np.pi * 50.0 * time_s)
    found = watched(signal, angle=angle)
    assert [each.joint for each in found.joints] == ['turning']
    turning = found.joints[0]
    hz = found.frequency_hz
    inside = np.isfinite(turning.psd).all(axis=1) & (turning.speed_rad_s > 0.2)
    below = hz < 45.0
    for at, psd in zip(turning.speed_rad_s[inside], turning.psd[inside], strict=True):
        expected = order * at / (2.0 * np.pi)
        width = order * (turning.speed_rad_s[1] - turning.speed_rad_s[0]) / (2.0 * np.pi)
        assert abs(hz[below][np.argmax(psd[below])] - expected) < 0.5 * width + 1.0
        assert abs(hz[~below][np.argmax(psd[~below])] - 50.0) < 0.3
    mean, least, most = turning.window_rad_s[0]
    assert least < mean < most
    assert mean == pytest.approx(speed[: round(20 * RATE_HZ)].mean(), rel=1e-3)


def test_columns_join_without_losing_anything_and_show_where_nothing_was():
    columns = Columns(1.0, 8, 2)
    for value in (0.0, 3.0, 5.0):
        columns.add(value, np.array([value, 1.0]))
    assert len(columns) == 6
    assert np.isnan(columns.mean[1]).all()
    columns.add(17.0, np.array([17.0, 1.0]))
    assert columns.width == 4.0
    assert columns.middle.tolist() == [2.0, 6.0, 10.0, 14.0, 18.0]
    np.testing.assert_allclose(columns.mean[[0, 1, 4], 0], [1.5, 5.0, 17.0])
    assert np.isnan(columns.mean[2:4]).all()


def test_memory_stays_the_same_for_a_long_recording():
    columns = Columns(2.0, 600, 4)
    psd = np.ones(4)
    for second in range(0, 86_400, 2):
        columns.add(float(second), psd)
    assert len(columns) <= 600
    np.testing.assert_array_equal(columns.mean, 1.0)


def test_a_gap_of_the_recording_is_a_gap_of_the_picture():
    signal = np.random.default_rng(5).standard_normal(round(20 * RATE_HZ))
    watch = SpectrogramWatch()
    for start_s in (0, 60):
        samples = Samples(signal[:, None], RATE_HZ, (Channel('a'),), FIRST_NS + start_s * SECOND)
        watch.add(Window(0, samples))
    found = watch.found()
    assert len(found.time_s) == 40
    assert np.isnan(found.psd[10:30]).all()
    assert np.isfinite(found.psd[np.r_[:10, 30:40]]).all()


def test_speeds_need_angles_all_along():
    stamps = FIRST_NS + np.arange(0, 10 * SECOND, SECOND // 100)
    angle = 0.5 * np.sin(2.0 * np.pi * (stamps - FIRST_NS) / SECOND)
    joints = JointSamples(stamps, ('a',), angle[:, None], angle[:, None] * np.nan)
    # A sine of amplitude a and frequency f travels 4 a f.
    found = mean_speeds(joints, FIRST_NS, FIRST_NS + 4 * SECOND)
    assert found[0] == pytest.approx(4 * 0.5 * 1.0, rel=0.01)
    assert mean_speeds(joints, FIRST_NS + 9 * SECOND, FIRST_NS + 11 * SECOND) is None
    assert mean_speeds(None, 0, 1) is None


def test_motors_turn_as_often_as_their_gears_say():
    robot = load_robot('irb6660_205_190')
    names = tuple(robot.joint_names)
    turns = motor_turns(robot, names)
    ratios = [joint.drive.gear_ratio for joint in robot.spec.joints]
    assert turns[0] == (pytest.approx(abs(ratios[0])),)
    # The parallel rod couples axes 2 and 3: a serial joint 2 turns one motor or both.
    assert all(len(each) >= 1 for each in turns)
    assert motor_turns(None, names) == [()] * len(names)
    assert motor_turns(robot, ('another',)) == [()]


def test_data_of_the_chart_hold_the_band_alone():
    signal = np.random.default_rng(6).standard_normal(round(60 * RATE_HZ))
    found = watched(signal)
    spans = [SimpleNamespace(start_ns=0, end_ns=SECOND, modes=(), harmonics=()) for _ in range(5)]
    data = spectrogram_data(found, spans, (10.0, 30.0))
    assert data['low_hz'] == pytest.approx(9.75)
    assert data['n_rows'] * data['row_hz'] == pytest.approx(20.5)
    assert data['time']['n_columns'] == 30
    assert spectrogram_data(found, spans, (200.0, 300.0)) is None
    assert spectrogram_data(None, spans, (10.0, 30.0)) is None
