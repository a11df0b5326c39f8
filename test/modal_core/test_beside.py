"""Work beside this process, one item after the other."""

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from modal_core.errors import ModalAnalysisError, ModelError
from modal_core.work.beside import Beside, can_work_beside
from modal_core.work.side_by_side import side_by_side

pytestmark = pytest.mark.skipif(not can_work_beside(), reason='one processor')


class Running:
    """Remembers what it has seen."""

    def __init__(self):
        self.total = 0.0

    def __call__(self, rows):
        if len(rows) == 0:
            raise ModelError('no rows', where='item', found=0, expected='some')
        self.total = self.total + rows.sum(axis=0)
        return self.total


def test_results_come_in_order_from_a_process_that_remembers():
    rows = [np.random.default_rng(seed).normal(size=(40_000, 7)) for seed in range(4)]
    work = Running()
    work(rows[0])
    with Beside(work) as beside:
        for each in rows[1:]:
            beside.put(each)  # none of which waits for the one before
        found = [beside.result() for _ in rows[1:]]
    assert np.array_equal(work.total, rows[0].sum(axis=0)), 'nothing changes here'
    for each in rows[1:]:
        work(each)
    assert np.array_equal(found[-1], work.total), 'bit for bit'


def test_what_arrives_is_the_same_to_the_last_bit_and_may_be_changed():
    given = {'wide': np.arange(5e4), 'single': np.float32([0.1]), 'none': np.empty((0, 3)), 'n': 7}
    with Beside(lambda item: item) as beside:
        beside.put(given)
        found = beside.result()
    assert found.keys() == given.keys()
    for name in ('wide', 'single', 'none'):
        assert found[name].dtype == given[name].dtype
        assert np.array_equal(found[name], given[name])
    found['wide'] += 1.0


def test_error_is_raised_here_and_work_goes_on():
    with Beside(Running()) as beside:
        beside.put(np.ones((0, 2)))
        beside.put(np.ones((3, 2)))
        with pytest.raises(ModelError, match='no rows') as error:
            beside.result()
        assert error.value.where == 'item'
        assert list(beside.result()) == [3.0, 3.0]


def test_process_that_is_killed_is_one_clear_line():
    with Beside(lambda _: os.kill(os.getpid(), signal.SIGKILL)) as beside:
        beside.put(1)
        with pytest.raises(ModalAnalysisError, match='ended from outside'):
            beside.result()


def test_end_waits_for_no_work():
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), Beside(time.sleep) as beside:
        beside.put(600.0)
        raise KeyboardInterrupt
    assert time.monotonic() - began < 60.0


def test_it_ends_with_its_parent():
    script = (
        'import os, time\n'
        'from modal_core.work.beside import Beside\n'
        'with Beside(lambda _: os.getpid()) as beside:\n'
        '    beside.put(0)\n'
        '    print(beside.result(), flush=True)\n'
        '    beside._process.join()\n'
    )
    parent = subprocess.Popen([sys.executable, '-c', script], stdout=subprocess.PIPE, text=True)
    own = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()
    for _ in range(200):
        if not _is_alive(own):
            return
        time.sleep(0.05)
    raise AssertionError('it goes on without its parent')


def _is_alive(process):
    try:
        state = Path(f'/proc/{process}/stat').read_text(encoding='ascii')
        return state.rsplit(')')[1].split()[0] != 'Z'
    except OSError:
        return False


def test_processes_of_others_do_not_fork_again():
    with Beside(lambda _: (can_work_beside(), side_by_side(lambda _: os.getpid(), range(2)))) as b:
        b.put(0)
        may, inner = b.result()
    assert not may
    assert len(set(inner)) == 1
    assert not any(side_by_side(lambda _: can_work_beside(), range(2)))
