"""What our identifier makes of a record: the modes that `ama identify` prints first."""

import time

from autonomous_modal_analysis.api.array import identify
from autonomous_modal_analysis.api.modal_result import ModalResult
from benchmarks.families.judge import judge, Verdict
from benchmarks.families.record import Record


def ours(record: Record) -> Verdict:
    """Identify the whole record with the defaults; a refusal or a crash finds nothing."""
    start = time.process_time()
    try:
        result = identify(record.acceleration, record.rate_hz)
    except Exception as error:  # noqa: BLE001 - any crash is a finding
        verdict = judge((), (), record)
        verdict.failed = f'{type(error).__name__}: {error}'
    else:
        verdict = judge(tuple(result.modes), tuple(result.harmonics), record)
        verdict.notes += _said(result)
    verdict.cpu_s = time.process_time() - start
    return verdict


def _said(result: ModalResult) -> list[str]:
    """Return what the result says about the data."""
    quality = result.found.whole.quality
    flags = {*quality.flags, *(flag for each in quality.channels for flag in each.flags)}
    said = [f'flags: {", ".join(sorted(flags - {"partial"}))}'] if flags - {'partial'} else []
    return said if len(result) else [*said, f'said: {result.headline()}']
