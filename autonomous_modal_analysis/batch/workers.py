"""Processes that work on a batch: on this machine, or those of a Dask scheduler."""

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import logging
from multiprocessing import resource_tracker
import signal
from typing import Any

from autonomous_modal_analysis.api.optional import optional
from modal_core.errors import BatchError
from modal_core.files.version import suite_version
from modal_core.work.side_by_side import n_processors, signals_wait

LOOPBACK = '127.0.0.1'
MEMORY = {'MALLOC_TRIM_THRESHOLD_': 2**28, 'MALLOC_MMAP_THRESHOLD_': 2**25}
"""Bytes that a process keeps rather than giving them back.  Dask has its workers return all above
64 kB at once, and every window takes it anew: 400,000 page faults a recording of two minutes, and
2.6 s of processor time instead of 1.7."""
CONNECT_S = 5.0
"""A scheduler answers in milliseconds; beyond, nobody waits in vain for a wrong address."""


@contextmanager
def connected(scheduler: str | None, n_workers: int | None) -> Iterator[Any]:
    """Yield a Dask client; processes started here end with the block.

    Parameters
    ----------
    scheduler : str or None
        Address of a running scheduler, ``tls://host:8786``; certificates are those of Dask's own
        configuration.  None: processes on this machine.
    n_workers : int or None
        How many processes on this machine; None: one per processor.

    Raises
    ------
    BatchError
        Nobody answers there, it has no worker, or its workers have another version.
    MissingError
        distributed is not installed.
    """
    distributed = optional('distributed')
    logging.getLogger('distributed').setLevel(logging.CRITICAL)
    with ExitStack() as stack:
        if scheduler is None:
            with signals_wait(), _deaf_processes():
                cluster = _local(distributed, n_workers or n_processors())
            stack.enter_context(cluster)
            client = stack.enter_context(distributed.Client(cluster, set_as_default=False))
        else:
            client = stack.enter_context(_joined(distributed, scheduler))
            _check_workers(client, scheduler)
        stack.enter_context(client.as_current())
        yield client


@contextmanager
def _deaf_processes() -> Iterator[None]:
    """Start processes that Ctrl-C, which a terminal sends to all, does not reach.

    Who started them ends them: half a cluster cannot be closed, and what is still loading would
    write a traceback.
    """
    # Python's own helper process, once it has to be started, would let the signal through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _local(distributed: Any, n_workers: int) -> Any:
    """Start processes; only who has the certificate made for this run may send them work."""
    set_ = optional('dask').config.set
    with set_({f'distributed.nanny.pre-spawn-environ.{name}': n for name, n in MEMORY.items()}):
        return distributed.LocalCluster(
            n_workers=n_workers,
            threads_per_worker=1,
            host=LOOPBACK,
            dashboard_address=None,
            security=distributed.Security.temporary(),
            silence_logs=logging.CRITICAL,
        )


def _joined(distributed: Any, scheduler: str) -> Any:
    try:
        return distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as error:
        raise BatchError(
            'no Dask scheduler answers',
            where=scheduler,
            found=error,
            expected='an address such as tls://host:8786',
        ) from error


def _check_workers(client: Any, scheduler: str) -> None:
    versions = client.run(_version)
    if not versions:
        raise BatchError('the scheduler has no worker', where=scheduler)
    for worker, version in versions.items():
        if version != suite_version():
            raise BatchError(
                'a worker has another version of the suite',
                where=worker,
                found=version or 'none',
                expected=suite_version(),
            )


def _version() -> str:
    return suite_version()
