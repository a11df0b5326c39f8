"""Many fits at once."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import logging

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.effects import Effect
from model_gap.fit.fit import Array, Fit
from model_gap.hypothesis import Hypothesis

log = logging.getLogger(__name__)
Numbers = tuple[tuple[Effect, ...], Array, Array]


def fits(work: Callable[[Hypothesis], Fit], starts: Sequence[Hypothesis]) -> list[Fit | None]:
    """Return the fit that ``work`` makes of every start; None of an impossible arm."""

    def away(start: Hypothesis) -> tuple[Numbers, tuple[float, float, Array, Array]] | None:
        try:
            found = work(start)
        except ModelError:
            return None
        rest = found.misfit, found.log_evidence, found.covariance, found.precision
        return numbers_of(found.hypothesis), rest

    found = side_by_side(away, starts)
    for start, item in zip(starts, found, strict=True):
        if item is None:
            log.debug('%s dropped: not a possible arm', list(start.effects))
    return [
        Fit(with_numbers(start, item[0]), *item[1]) if item else None
        for start, item in zip(starts, found, strict=True)
    ]


def numbers_of(hypothesis: Hypothesis) -> Numbers:
    """Return what a fit changes: arm and tolerances themselves need not be sent around."""
    return hypothesis.effects, hypothesis.tolerance_values, hypothesis.inner


def with_numbers(start: Hypothesis, numbers: Numbers) -> Hypothesis:
    """Return a hypothesis with what a fit of it found."""
    effects, tolerance_values, inner = numbers
    return replace(start, effects=effects, tolerance_values=tolerance_values, inner=inner)
