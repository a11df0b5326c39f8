"""What became of a record with a fault: right, flagged, or wrong and sure of it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
import math
import time

import numpy as np

from benchmarks.faults.scene import Scene
from modal_core.errors import ModalAnalysisError
from modal_core.measurements import Measurement
from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import WindowResult
from oma_identifier.settings import IdentificationSettings

SETTINGS = IdentificationSettings(window_s=20.0, hop_s=10.0)
NEAR = 0.05
"""Share of a frequency within which a mode may be the true one."""
SIGMAS = 3.0
SMALLEST_LOSS = 1e-4
"""Loss of MAC that is none: a shape right to 1 %, which clocks in step to 1 % of a step give."""


@dataclass
class Published:
    """What a run published of modes, counted.

    Parameters
    ----------
    n_values : int
        Frequencies, damping ratios and shapes with a deviation.
    outside : list of str
        Those beyond three deviations, and modes that are none, that nothing flags.
    n_flagged : int
        The same under a flag.
    """

    n_values: int = 0
    outside: list[str] = field(default_factory=list)
    n_flagged: int = 0


@dataclass
class Outcome:
    """One run.

    Parameters
    ----------
    cpu_s : float [s]
        Processor time.
    n_windows, n_identified : int
        Windows that came out, and those with modes.
    flags : set of str
        All flags of windows and channels, and counters of the buffer.
    refusal, crash : str
        The one line of a refusal; the exception of a crash.
    results : list of WindowResult
        Windows, and the whole record last.
    """

    cpu_s: float = 0.0
    n_windows: int = 0
    n_identified: int = 0
    flags: set[str] = field(default_factory=set)
    refusal: str = ''
    crash: str = ''
    results: list[WindowResult] = field(default_factory=list)


def run(measurements: Iterable[Measurement]) -> Outcome:
    """Put measurements through the pipeline as the node does, and the whole record after them."""
    outcome = Outcome()
    pipeline = IdentificationPipeline(SETTINGS)
    start = time.process_time()
    try:
        for result in _results(pipeline, measurements):
            outcome.results.append(result)
        outcome.n_windows = len(outcome.results)
        outcome.results.append(pipeline.whole())
    except ModalAnalysisError as error:
        outcome.refusal = str(error)
    except Exception as error:  # noqa: BLE001 - any crash is a finding
        outcome.crash = f'{type(error).__name__}: {error}'
    outcome.cpu_s = time.process_time() - start
    outcome.n_identified = sum(bool(len(result.modes)) for result in outcome.results)
    outcome.flags = {flag for result in outcome.results for flag in _flags(result)}
    outcome.flags |= set(pipeline.buffer.counters.reasons)
    return outcome


def _results(
    pipeline: IdentificationPipeline, measurements: Iterable[Measurement]
) -> Iterator[WindowResult]:
    for measurement in measurements:
        pipeline.add(measurement)
        for window in pipeline.windows():
            yield pipeline.identify(window)
    for window in pipeline.finish():
        yield pipeline.identify(window)


def _flags(result: WindowResult) -> set[str]:
    quality = result.quality
    found = {*quality.flags, *(flag for each in quality.channels for flag in each.flags)}
    if quality.reason:
        found.add('reason')
    return found


def judge(outcome: Outcome, scene: Scene, expected: set[str]) -> Published:
    """Hold all that was published against the truth.

    Parameters
    ----------
    outcome : Outcome
        The run.
    scene : Scene
        Its truth.
    expected : set of str
        Flags the same record has without the fault: they excuse nothing.
    """
    published = Published()
    counters = outcome.flags - set().union(*map(_flags, outcome.results), set())
    for result in outcome.results:
        excused = (_flags(result) | counters) - expected
        for mode in result.modes:
            _judge_mode(published, mode, result, scene, excused=bool(excused))
    return published


def _judge_mode(
    published: Published, mode: Mode, result: WindowResult, scene: Scene, *, excused: bool
) -> None:
    wrong = list(_deviations(published, mode, result.modes.channel_names, scene))
    if excused:
        published.n_flagged += len(wrong)
    else:
        where = 'whole' if result.index < 0 else f'window {result.index}'
        published.outside += [f'{where}: {what}' for what in wrong]


def _deviations(
    published: Published, mode: Mode, names: Sequence[str], scene: Scene
) -> Iterator[str]:
    """Yield what is beyond three deviations from the truth."""
    plant = scene.plant
    away = np.abs(plant.frequency_hz / mode.frequency_hz - 1.0)
    if not len(away) or away.min() > NEAR:
        yield f'no mode at {mode.frequency_hz:.4g} Hz'
        return
    true = int(np.argmin(away))
    pairs = {
        'frequency': (mode.frequency_hz, plant.frequency_hz[true], mode.frequency_std_hz),
        'damping': (mode.damping_ratio, plant.damping_ratio[true], mode.damping_ratio_std),
    }
    for what, (found, truth, std) in pairs.items():
        if math.isfinite(std):
            published.n_values += 1
            if abs(found - truth) > SIGMAS * std:
                yield f'{what} {found:.5g} ± {std:.2g} for {truth:.5g}'
    yield from _shape_deviation(published, mode, names, scene, true)


def _shape_deviation(
    published: Published, mode: Mode, names: Sequence[str], scene: Scene, true: int
) -> Iterator[str]:
    rows = scene.shape_rows(tuple(names))
    known = np.isfinite(mode.shape)
    if len(rows) != len(names) or not math.isfinite(mode.mac_loss) or known.sum() < 2:
        return
    published.n_values += 1
    truth = scene.plant.shapes[rows, true]
    loss = 1.0 - float(mac(mode.shape[known], truth[known])[0, 0])
    if loss > max(SMALLEST_LOSS, mode.mac_loss + SIGMAS * mode.mac_loss_std):
        yield f'shape of {mode.frequency_hz:.4g} Hz: MAC loss {loss:.2g} for {mode.mac_loss:.2g}'
