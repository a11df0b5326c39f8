"""The period of rows: from coarse times, late ones, with rows missing, and begun anew."""

import numpy as np
import pytest

from modal_recordings.tables import row_period_s

SEED = 12


def clock(kind, rng):
    """Return times of rows with period 1."""
    n = int(rng.integers(300, 5000))
    rows = np.arange(n)
    if 'gaps' in kind:
        lost = [np.arange(a, a + rng.integers(1, 40)) for a in rng.integers(5, n - 50, 4)]
        rows = np.delete(rows, np.concatenate(lost))
    time = rows.astype(float)
    if 'late' in kind:
        time += 0.2 * np.abs(rng.normal(size=len(time)))
        time += rng.uniform(0.0, 3.0, len(time)) * (rng.random(len(time)) < 0.02)
    if 'wrong' in kind:
        time[rng.integers(1, n - 1, 3)] += rng.choice([-1.0, 1.0], 3) * 10.0 ** rng.uniform(
            2, 9, 3
        )
    if 'anew' in kind:
        time = np.concatenate([time[: n // 3], time])
    tick = {'coarse': 0.7, 'coarser': 1.25, 'nearly': 0.9}.get(kind.split()[0])
    return time if tick is None else np.floor(time / tick) * tick


@pytest.mark.parametrize(
    ('kind', 'rel'),
    [('even', 1e-12), ('gaps', 1e-12), ('anew', 1e-12), ('late', 1e-3), ('late gaps', 2e-3),
     ('wrong', 1e-9), ('coarse', 1e-4), ('coarse gaps', 2e-3), ('coarser', 3e-4),
     ('nearly', 5e-4)],
)  # fmt: skip
def test_the_period_is_that_of_the_clock(kind, rel):
    """Seed 12: a hundred clocks each."""
    rng = np.random.default_rng(SEED)
    periods = np.array([row_period_s(clock(kind, rng)) for _ in range(100)])
    assert np.abs(periods - 1.0).max() < rel, np.abs(periods - 1.0).max()
    # As near as the limits are in the worst of a hundred, most are a tenth of it.
    assert np.median(np.abs(periods - 1.0)) < max(0.1 * rel, 1e-12)


def test_rows_that_share_their_times_have_no_step():
    assert row_period_s(np.repeat(np.arange(100.0), 4)) == 0.0
