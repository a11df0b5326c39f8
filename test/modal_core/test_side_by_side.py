"""Work in forked processes."""

import os
import signal
import sys
import threading
import time

import numpy as np
import pytest

from modal_core.errors import ModalAnalysisError, ModelError
from modal_core.work.side_by_side import side_by_side


def test_results_come_in_order():
    offset = np.arange(3.0)  # there without being passed
    found = side_by_side(lambda item: offset + item, range(7))
    np.testing.assert_array_equal(found, [offset + item for item in range(7)])


@pytest.mark.parametrize('n_items', [1, 4])
def test_what_is_done_is_told(n_items):
    told = []
    side_by_side(abs, range(n_items), told.append)
    assert told == [number / n_items for number in range(1, n_items + 1)]


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one processor')
def test_work_runs_in_other_processes_that_do_not_fork_again():
    def work(_):
        return os.getpid(), side_by_side(lambda _: os.getpid(), range(2))

    for own, inner in side_by_side(work, range(4)):
        assert own != os.getpid()
        assert inner == [own, own]


def test_error_of_work_is_raised_here():
    def work(item):
        if item == 2:
            raise ModelError('no such arm', where='item 2', found=2.5, expected='less')
        return item

    with pytest.raises(ModelError, match='no such arm') as error:
        side_by_side(work, range(4))
    assert error.value.where == 'item 2'
    assert side_by_side(abs, [-1, 2]) == [1, 2], 'and what follows works'


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one processor')
def test_process_that_is_killed_is_one_clear_line():
    def work(item):
        if item == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    with pytest.raises(ModalAnalysisError, match='ended from outside'):
        side_by_side(work, range(3))
    assert side_by_side(abs, [-1, 2]) == [1, 2], 'and what follows works'


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one processor')
def test_processes_write_past_the_display_of_their_parent():
    """A display refreshed while a child is forked stays locked in the child for ever."""

    class Display:
        def write(self, text):
            raise AssertionError(f'written to: {text}')

        def flush(self):
            pass

    def work(_):
        print('to standard error', file=sys.stderr)
        return sys.stderr is sys.__stderr__

    kept, sys.stderr = sys.stderr, Display()
    try:
        assert all(side_by_side(work, range(4)))
    finally:
        sys.stderr = kept


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one processor')
def test_a_signal_ends_the_work_whenever_it_comes_and_no_thread_complains(monkeypatch):
    """Its exception was lost while processes were forked; later the pool's thread learned of it.

    Forking takes some ms: signals come at forty moments of the first twenty, then at 0.2 s.
    """
    complaints = []
    monkeypatch.setattr(threading, 'excepthook', complaints.append)
    monkeypatch.setattr(sys, 'unraisablehook', complaints.append)

    def end(number, _):
        raise SystemExit(128 + number)

    def ended_after(wait_s):
        timer = threading.Timer(wait_s, os.kill, (os.getpid(), signal.SIGTERM))
        with pytest.raises(SystemExit):
            timer.start()
            side_by_side(lambda item: time.sleep(5.0 if item > 1 else 0.0), range(6))
        timer.join()

    before = signal.signal(signal.SIGTERM, end)
    try:
        for wait_s in [*np.linspace(0.0, 0.02, 40), *[0.2] * 8]:
            ended_after(wait_s)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert not complaints, [str(item.exc_value) for item in complaints]
    assert side_by_side(abs, [-1, 2]) == [1, 2], 'and what follows works'
