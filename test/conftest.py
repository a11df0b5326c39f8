"""Fixtures every room's tests share."""

from collections.abc import Callable, Iterator
import gc
import os
from pathlib import Path
import zlib

import numpy as np
import pytest

from test.support.domains import ros_domain

# Two BLAS threads make small LAPACK calls ten times slower than one.
for variable in ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
    os.environ[variable] = '1'
os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ.setdefault('ROS_PYTHON_CHECK_FIELDS', '1')

DATA = Path(
    os.environ.get('AMA_TEST_DATA', Path(__file__).resolve().parents[2] / 'shared' / 'data')
)


SLOW_SHARE = os.environ.get('AMA_SLOW_SHARE', '0/1')
"""Which share of the slow tests runs: 1/5 is the second of five.  None is left out by itself."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out the slow tests of other shares; all cases of a test are of one."""
    which, n_shares = map(int, SLOW_SHARE.split('/'))
    runs = [
        not item.get_closest_marker('slow')
        or zlib.crc32(item.nodeid.partition('[')[0].encode()) % n_shares == which
        for item in items
    ]
    if not all(runs):
        left_out = [item for item, run in zip(items, runs, strict=True) if not run]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item, run in zip(items, runs, strict=True) if run]


def pytest_collection_finish() -> None:
    """Leave what was loaded alone: 344,000 objects held everything up for 0.22 s at a time.

    Operators and heartbeats of the tests of nodes run in this process.
    """
    gc.collect()
    gc.freeze()


@pytest.fixture
def record_property(record_property) -> Callable[[str, object], None]:
    """Record figures as plain numbers: those of numpy do not pass between pytest's processes."""

    def record(name: str, value: object) -> None:
        record_property(name, value.tolist() if isinstance(value, np.generic) else value)

    return record


@pytest.fixture(scope='session')
def data_path():
    """Return a function that finds a measured data set or skips the test."""

    def find(*parts: str) -> Path:
        path = DATA.joinpath(*parts)
        if not path.exists():
            pytest.skip(
                f'measured data {"/".join(parts)} is not in {DATA};'
                ' set AMA_TEST_DATA to the folder that has it'
            )
        return path

    return find


@pytest.fixture
def ros_context() -> Iterator[object]:
    """Yield an own rclpy context in a ROS domain of this test process."""
    rclpy = pytest.importorskip('rclpy')
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain())
    yield context
    rclpy.try_shutdown(context=context)
