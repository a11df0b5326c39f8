"""Work in forked processes."""

import os

import numpy as np
import pytest

from modal_core.errors import ModelError
from modal_core.side_by_side import side_by_side


def test_results_come_in_order():
    offset = np.arange(3.0)  # there without being passed
    found = side_by_side(lambda item: offset + item, range(7))
    np.testing.assert_array_equal(found, [offset + item for item in range(7)])


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
