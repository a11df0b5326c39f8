"""Overload: windows are skipped and counted, the queue never grows, the thread ends when told."""

import threading
import time

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.node.worker import IdentificationWorker, Job, MOST_WAITING


class SlowPipeline:
    """Identifies nothing until it is let go."""

    def __init__(self):
        self.gate = threading.Event()
        self.seen = []

    def identify(self, window):
        self.gate.wait(20.0)
        self.seen.append(window.index)
        if window.index == 1:
            raise IdentificationError('cannot be identified')
        return window.index


def window(index):
    return Window(index, Samples(np.zeros((2, 1)), 1.0, (Channel('a'),)))


def test_windows_that_come_too_fast_are_skipped_and_counted():
    published, failed = [], []
    worker = IdentificationWorker(published.append, failed.append)
    pipeline = SlowPipeline()
    taken = [worker.submit(Job(pipeline, window(index))) for index in range(50)]
    n_taken = sum(taken)
    assert n_taken == MOST_WAITING + 1
    assert taken == [True] * n_taken + [False] * (50 - n_taken)
    assert worker.n_skipped == 50 - n_taken
    pipeline.gate.set()
    assert worker.wait_idle(10.0)
    assert pipeline.seen == list(range(n_taken))
    # One bad window is told and ends nothing.
    assert published == [0, 2] and len(failed) == 1 and 'window 1' in failed[0]
    assert worker.submit(Job(pipeline, window(99)))
    assert worker.wait_idle(10.0) and published[-1] == 99
    worker.stop(5.0)


def test_a_window_that_must_not_be_skipped_is_kept():
    published = []
    worker = IdentificationWorker(published.append, published.append)
    pipeline = SlowPipeline()
    for index in (0, 2, 3, 4, 5, 6):
        assert worker.submit(Job(pipeline, window(index)), may_skip=False)
    pipeline.gate.set()
    assert worker.wait_idle(10.0)
    assert published == [0, 2, 3, 4, 5, 6] and worker.n_skipped == 0
    worker.stop(5.0)


def test_stop_drops_what_waits():
    pipeline, published = SlowPipeline(), []
    worker = IdentificationWorker(published.append, published.append)
    for index in (0, 2, 3):
        worker.submit(Job(pipeline, window(index)))
    deadline = time.monotonic() + 5.0
    while worker.n_waiting > 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    threading.Timer(0.2, pipeline.gate.set).start()
    worker.stop(10.0)
    assert published == [0]


@pytest.mark.parametrize('error', [MemoryError('4 GiB'), RuntimeError('changed'), KeyError('a')])
def test_whatever_a_window_ends_with_the_next_one_is_identified(error):
    published, failed = [], []

    class Failing:
        def identify(self, window):
            if window.index == 0:
                raise error
            return window.index

    worker = IdentificationWorker(published.append, failed.append)
    for index in (0, 1):
        worker.submit(Job(Failing(), window(index)))
    assert worker.wait_idle(10.0)
    assert published == [1] and type(error).__name__ in failed[0]
    worker.stop(5.0)
