"""What our identifier makes of a record: the modes that `ama identify` prints first."""

from collections.abc import Sequence
from dataclasses import replace
import time

import numpy as np

from autonomous_modal_analysis.api.array import identify
from autonomous_modal_analysis.api.modal_result import ModalResult
from benchmarks.families.judge import judge, Verdict
from benchmarks.families.record import Record
from modal_core.mode import Mode

CHANNEL = 'ch'
"""What `identify` calls columns, with their number from 1."""


def ours(record: Record) -> Verdict:
    """Identify the whole record with the defaults; a refusal or a crash finds nothing."""
    start = time.process_time()
    try:
        result = identify(record.acceleration, record.rate_hz)
    except Exception as error:  # noqa: BLE001 - any crash is a finding
        verdict = judge((), (), record)
        verdict.failed = f'{type(error).__name__}: {error}'
    else:
        n_channels = record.acceleration.shape[1]
        modes = [_over_all(mode, result.channel_names, n_channels) for mode in result.modes]
        verdict = judge(modes, tuple(result.harmonics), record)
        verdict.notes += _said(result)
    verdict.cpu_s = time.process_time() - start
    return verdict


def _said(result: ModalResult) -> list[str]:
    """Return what the result says about the data."""
    quality = result.found.whole.quality
    flags = {*quality.flags, *(flag for each in quality.channels for flag in each.flags)}
    said = [f'flags: {", ".join(sorted(flags - {"partial"}))}'] if flags - {'partial'} else []
    return said if len(result) else [*said, f'said: {result.headline()}']


def _over_all(mode: Mode, names: Sequence[str], n_channels: int) -> Mode:
    """Return the mode with its shape over all channels, NaN where one took no part."""
    rows = [int(name.removeprefix(CHANNEL)) - 1 for name in names]
    shape = np.full(n_channels, complex(np.nan, np.nan))
    shape[rows] = mode.shape
    if mode.shape_std is None:
        return replace(mode, shape=shape)
    std = np.full(n_channels, complex(np.nan, np.nan))
    std[rows] = mode.shape_std
    return replace(mode, shape=shape, shape_std=std)
