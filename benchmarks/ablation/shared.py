"""Runs on one record with one stage off after the other share what does not depend on it."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, ExitStack
import time
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.ablation.stages import FITS, place_of, Stage
from benchmarks.families.judge import judge, Verdict
from benchmarks.families.record import Record
from modal_core.channel import Channel
from modal_core.errors import ModalAnalysisError
from modal_core.samples import Samples
from oma_identifier.identify import identify_parts
from oma_identifier.settings import IdentificationSettings


class Shared:
    """What runs on one record have in common and is computed once.

    Parameters
    ----------
    kept : dict
        Results by what they are of.
    stage : Stage or None
        That is off.
    """

    def __init__(self) -> None:
        self.kept: dict[Any, Any] = {}
        self.stage: Stage | None = None

    def clear(self) -> None:
        """Forget a record."""
        self.kept.clear()

    @contextmanager
    def without(self, stage: Stage | None) -> Iterator[None]:
        """Switch a stage off, and keep what does not depend on it."""
        self.stage = stage
        with ExitStack() as stack:
            for name, instead in (stage.off if stage else {}).items():
                stack.enter_context(patch.object(*place_of(name), instead))
            for name, of in (
                ('identify.band_sources', self._sources),
                ('identify.line_evidence', self._evidence),
                ('refine_found.line_at', self._line),
                ('selection.band_selector.identify_band', self._band),
                ('selection.ssi_poles.BandIdentification.influence', self._influence),
                ('refinement.refinement.STAGES', self._stages),
            ):
                where, attribute = place_of(name)
                stack.enter_context(patch.object(where, attribute, of(getattr(where, attribute))))
            yield

    def _sources(self, compute: Callable[..., Any]) -> Callable[..., Any]:
        def sources(parts: Any, settings: Any, progress: Any = None) -> Any:
            return self._once(('sources', len(parts[0].acceleration)), compute, parts, settings)

        return sources

    def _band(self, compute: Callable[..., Any]) -> Callable[..., Any]:
        def band(source: Any, settings: Any) -> Any:
            return self._once(('band', id(source)), compute, source, settings, keep=source)

        return band

    def _evidence(self, compute: Callable[..., Any]) -> Callable[..., Any]:
        def evidence(samples: Any, found: Any) -> Any:
            modes = tuple((m.frequency_hz, m.damping_ratio) for m in found.modes)
            lines = tuple(found.harmonics.frequency_hz)
            return self._once(('evidence', modes, lines), compute, samples, found)

        return evidence

    def _line(self, compute: Callable[..., Any]) -> Callable[..., Any]:
        def line(samples: Any, frequency_hz: float, weight: Any = None) -> Any:
            seen = None if weight is None else weight.tobytes()
            key = ('line', id(samples.acceleration), frequency_hz, seen)
            return self._once(key, compute, samples, frequency_hz, weight, keep=samples)

        return line

    def _influence(self, compute: Callable[..., Any]) -> Callable[..., Any]:
        shared = self

        def influence(band: Any, rows: Any) -> Any:
            key = ('influence', id(band), rows.tobytes())
            return shared._once(key, compute, band, rows, keep=band)

        return influence

    def _stages(self, stages: Sequence[Callable[[Any], Any]]) -> tuple[Callable[[Any], Any], ...]:
        return tuple(
            self._stage(stage, tuple(before.__name__ for before in stages[: place + 1]))
            for place, stage in enumerate(stages)
        )

    def _stage(self, stage: Callable[[Any], Any], so_far: tuple[str, ...]) -> Any:
        by_stage = self.stage is not None and self.stage.reach == FITS
        own = by_stage and not any('STAGES' in name for name in self.stage.off)
        # What follows the decision is of the decision.
        decides = 'decide' in so_far and self.stage is not None
        namespace = self.stage.name if own or decides else ''

        def run(of: Any) -> Any:
            values = of.record.spectra.values
            record = (float(np.abs(values[:, ::37]).sum()), of.record.usable.tobytes())
            modes, candidates = (
                tuple((mode.frequency_hz, mode.damping_ratio) for mode in given)
                for given in (of.record.modes, of.record.candidates)
            )
            return self._once((namespace, so_far, record, modes, candidates), stage, of)

        return run

    def _once(self, key: Any, compute: Callable[..., Any], *given: Any, keep: Any = None) -> Any:
        if key not in self.kept:
            self.kept[key] = compute(*given), keep
        return self.kept[key][0]


def verdict_of(record: Record, stage: Stage | None, shared: Shared) -> Verdict:
    """Identify a record as one stretch, with a stage off."""
    names = [f'ch{number}' for number in range(1, record.acceleration.shape[1] + 1)]
    channels = tuple(Channel(name) for name in names)
    samples = Samples(np.asarray(record.acceleration), record.rate_hz, channels)
    settings = IdentificationSettings()
    start = time.process_time()
    try:
        with shared.without(stage):
            found = identify_parts([samples], settings)
    except ModalAnalysisError as error:
        verdict = judge((), (), record)
        verdict.failed = f'{type(error).__name__}: {error}'
    else:
        verdict = judge(tuple(found.modes), tuple(found.harmonics), record)
    verdict.cpu_s = time.process_time() - start
    return verdict
