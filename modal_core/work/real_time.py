"""Ask the system to run the calling thread before all others."""

from collections.abc import Iterator
from contextlib import contextmanager
import os


def ask_for_real_time(priority: int) -> bool:
    """Ask the scheduler to run this thread first; return whether it agreed."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError):
        return False
    return True


@contextmanager
def in_real_time(priority: int) -> Iterator[bool]:
    """Run the block before all others, as far as the scheduler agrees; yield whether it did."""
    agreed = ask_for_real_time(priority)
    try:
        yield agreed
    finally:
        if agreed:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
