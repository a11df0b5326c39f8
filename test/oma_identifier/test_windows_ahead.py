"""Windows of a recording in two processes give what one process gives."""

from dataclasses import fields, is_dataclass, replace
import logging
import os
import signal

import numpy as np
import pytest

from modal_core.errors import IdentificationError, ModalAnalysisError
from modal_core.measurements import JointSamples, SampleBlock
from modal_core.work.beside import can_work_beside
from oma_identifier.motion import never
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from oma_identifier.window_finder import WindowFinder
from oma_identifier.windows_ahead import WindowsAhead

RATE_HZ, START_NS = 64.0, 1_000_000_000_000
SETTINGS = IdentificationSettings(window_s=20.0, hop_s=10.0)
pytestmark = pytest.mark.skipif(not can_work_beside(), reason='one processor')


@pytest.fixture
def record(structure):
    """A record of 65 s, six windows; seed 41."""
    known = structure((4.0, 9.0, 9.4, 21.0), (0.02, 0.015, 0.02, 0.03))
    return known.simulate(np.random.default_rng(41), 65.0, RATE_HZ)


def measurements(samples, moves):
    """Yield a second of samples, and of a joint that travels, at a time."""
    rate = int(RATE_HZ)
    units = tuple(channel.unit for channel in samples.channels)
    for second in range(len(samples.acceleration) // rate):
        stamp_ns = START_NS + second * 10**9
        if moves:
            at = second + np.arange(50) / 50.0
            angle = 0.5 * np.sin(0.4 * at)[:, None]
            stamps = START_NS + np.rint(1e9 * at).astype(np.int64)
            yield JointSamples(stamps, ('joint_1',), angle, np.full((50, 1), np.nan))
        rows = samples.acceleration[second * rate : (second + 1) * rate].astype(np.float32)
        yield SampleBlock(
            '/b', stamp_ns, second * rate, RATE_HZ, samples.channel_names, rows, units
        )


def run(samples, identify, pipeline, moves=False):
    for measurement in measurements(samples, moves):
        pipeline.add(measurement)
        for window in pipeline.windows():
            yield from identify(window)
    for window in pipeline.finish():
        yield from identify(window)


def in_one_process(samples, moves=False, spoil=lambda window: window):
    pipeline = IdentificationPipeline(SETTINGS)
    found = list(run(samples, lambda w: [pipeline.identify(spoil(w))], pipeline, moves))
    return [*found, pipeline.whole()]


def in_two_processes(samples, moves=False, spoil=lambda window: window):
    pipeline = IdentificationPipeline(SETTINGS)
    with WindowsAhead(pipeline) as ahead:
        found = list(run(samples, lambda w: ahead.identify(spoil(w)), pipeline, moves))
        found += ahead.rest()
    return [*found, pipeline.whole()]


def numbers(value):
    """Return everything a result holds, to compare to the last bit."""
    if is_dataclass(value):
        return [numbers(getattr(value, each.name)) for each in fields(value)]
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    return [numbers(each) for each in value] if isinstance(value, (tuple, list)) else repr(value)


@pytest.mark.parametrize('moves', [False, True], ids=['still', 'arm that travels'])
def test_results_are_the_same_to_the_last_bit(record, moves):
    found, expected = in_two_processes(record, moves), in_one_process(record, moves)
    assert len(found) == len(expected) == 7
    assert all(len(result.modes) for result in found)
    assert numbers(found) == numbers(expected)


def test_a_travelling_arm_with_sensors_of_two_kinds_needs_no_single_process(record):
    """What tells a peak of the motion from a mode is handed to the other process as well."""
    channels = tuple(
        replace(channel, unit='m/s' if place == 0 else channel.unit)
        for place, channel in enumerate(record.channels)
    )
    mixed = replace(record, channels=channels)
    assert numbers(in_two_processes(mixed, True)) == numbers(in_one_process(mixed, True))


def test_work_is_really_done_in_another_process(record, monkeypatch):
    find = WindowFinder.find

    def found_here(self, samples, explains):
        found = find(self, samples, explains)
        assert explains is never, 'so that nobody asks for it'
        return replace(found, doubtful_hz=(1.0,) if os.getpid() != here else ())

    here = os.getpid()
    monkeypatch.setattr(WindowFinder, 'find', found_here)
    flags = [result.quality.flags for result in in_two_processes(record)[:-1]]
    assert all('line_or_mode' in each for each in flags), flags
    short = replace(record, acceleration=record.acceleration[: int(21 * RATE_HZ)])
    (window, _) = in_two_processes(short)
    assert 'line_or_mode' not in window.quality.flags, 'one window is worth no process'


def test_windows_that_cannot_be_identified_stay_in_their_place(record, monkeypatch):
    find = WindowFinder.find

    def sometimes(self, samples, explains):
        if samples.start_ns == START_NS + 20 * 10**9:
            raise IdentificationError('nothing to see')
        return find(self, samples, explains)

    def spoil(window):
        if window.index != 1:
            return window
        return replace(window, quality=replace(window.quality, identifiable=False, reason='bad'))

    monkeypatch.setattr(WindowFinder, 'find', sometimes)
    found = in_two_processes(record, spoil=spoil)
    assert [result.quality.reason for result in found[:4]] == ['', 'bad', 'nothing to see', '']
    assert numbers(found) == numbers(in_one_process(record, spoil=spoil))


def test_what_is_no_fault_of_the_samples_ends_the_identification(record, monkeypatch):
    def fails(self, samples, explains):
        raise ZeroDivisionError('of the program')

    monkeypatch.setattr(WindowFinder, 'find', fails)
    with pytest.raises(ZeroDivisionError, match='of the program'):
        in_two_processes(record)


def test_a_process_ended_from_outside_is_one_clear_line(record, monkeypatch):
    monkeypatch.setattr(WindowFinder, 'find', lambda *_: os.kill(os.getpid(), signal.SIGKILL))
    with pytest.raises(ModalAnalysisError, match='ended from outside'):
        in_two_processes(record)


def test_reasons_are_said_in_this_process(record):
    said = []
    handler = logging.Handler()
    handler.emit = lambda entry: said.append(entry.getMessage())
    logger = logging.getLogger('oma_identifier')
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    try:
        found = in_two_processes(record)
    finally:
        logger.setLevel(level)
        logger.removeHandler(handler)
    assert any('refined' in line for line in said), said
    assert numbers(found) == numbers(in_one_process(record))
