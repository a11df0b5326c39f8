"""Linear algebra in one thread."""

from threadpoolctl import threadpool_info, threadpool_limits

from oma_identifier.one_thread import one_thread


def n_threads():
    return {pool['filepath']: pool['num_threads'] for pool in threadpool_info()}


def test_one_thread_inside_and_as_many_as_before_afterwards():
    with threadpool_limits(limits=2):
        before = n_threads()
        assert before
        with one_thread(), one_thread():
            assert set(n_threads().values()) == {1}
        assert n_threads() == before
