"""Calibration: what a campaign tells of a model's numbers within their tolerances."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_reports import with_sigma
from model_gap.cell import Nuisance, RELATIVE
from model_gap.decide import Verdict
from model_gap.find_gap import GapResult
from model_gap.fit import Fit
from model_gap.hypothesis import STRETCHED

Array = NDArray[np.float64]
# Of the prior's deviation: the data then say at least as much as was known before.
DETERMINED = math.sqrt(0.5)
# A mount is told to be turned from here on: one of a thousand straight ones (χ² of 3).
TURNED = 4.03

# In new deviations: what is told in words to have moved, and how much of it.
CLEARLY, MOST_TOLD = 3.0, 8


@dataclass(frozen=True)
class Calibrated:
    """One number of the model as the campaign tells it.

    Parameters
    ----------
    name : str
        Which.
    value, sigma : float
        A factor, metres, or degrees; its standard deviation, NaN where something stays
        unexplained: the number may stand for that.
    unit : str
        ``1``, ``m`` or ``deg``.
    deviations : float
        From nominal, in tolerances.
    moved : float
        From nominal, in new deviations as if nothing were unexplained; 0 where not determined.
    determined : bool
        The campaign tells at least as much of it as was known before.
    """

    name: str
    value: float
    sigma: float
    unit: str
    deviations: float
    moved: float
    determined: bool

    @property
    def stretched(self) -> bool:
        """Whether it is farther off than ordinary imperfection is."""
        return abs(self.deviations) > STRETCHED


@dataclass(frozen=True)
class Mount:
    """How a sensor turned out to be turned.

    Parameters
    ----------
    sensor : str
        Its name.
    angle_deg, sigma_deg : float [deg]
        By how much, about whatever axis; σ is NaN where something stays unexplained.
    """

    sensor: str
    angle_deg: float
    sigma_deg: float


def calibration(result: GapResult) -> tuple[Calibrated, ...]:
    """Return every number that has a tolerance; none where the model stays as it was given."""
    fit = result.calibrated
    if fit is None:
        return ()
    tolerances = fit.hypothesis.tolerances
    deviations = np.sqrt(np.diag(_covariance(result, fit)))
    known = _is_explained(result)
    return tuple(
        _calibrated(item, float(moved), float(left), known)
        for item, moved, left in zip(
            tolerances, fit.hypothesis.tolerance_values, deviations, strict=True
        )
        if item.sigma > 0.0
    )


def _is_explained(result: GapResult) -> bool:
    """Return whether noise is all that is left, as standard deviations take it to be."""
    return result.decision.verdict is not Verdict.UNEXPLAINED


def _calibrated(item: Nuisance, moved: float, left: float, known: bool) -> Calibrated:
    amount, sigma = item.sigma * moved, item.sigma * left
    unit = item.unit
    if unit == RELATIVE:
        amount = math.exp(amount)
        sigma *= amount
    elif unit == 'rad':
        amount, sigma, unit = math.degrees(amount), math.degrees(sigma), 'deg'
    determined = left < DETERMINED
    sigma = sigma if known else math.nan
    away = abs(moved) / left if determined else 0.0
    return Calibrated(item.name, amount, sigma, unit, moved, away, determined)


def mounts(result: GapResult) -> tuple[Mount, ...]:
    """Return the sensors that are turned, however little that is, the most turned first."""
    fit = result.calibrated
    if fit is None:
        return ()
    covariance = _covariance(result, fit)
    places: dict[str, list[int]] = {}
    for number, item in enumerate(fit.hypothesis.tolerances):
        if item.what == 'rotation':
            places.setdefault(item.sensor, []).append(number)
    found = []
    for sensor, rows in places.items():
        sizes = np.degrees([fit.hypothesis.tolerances[row].sigma for row in rows])
        turned = fit.hypothesis.tolerance_values[rows] * sizes
        spread = covariance[np.ix_(rows, rows)] * np.outer(sizes, sizes)
        if turned @ np.linalg.solve(spread, turned) > TURNED**2:
            angle = float(np.linalg.norm(turned))
            along = turned / angle
            sigma = float(np.sqrt(along @ spread @ along))
            found.append(Mount(sensor, angle, sigma if _is_explained(result) else math.nan))
    return tuple(sorted(found, key=lambda item: -item.angle_deg))


def tolerances_left(result: GapResult) -> dict[str, float]:
    """Return how roughly the calibrated model is known, by name, as a model file states it.

    Of what was known worse than usual, and never better than usual: another day, another campaign.
    """
    fit = result.calibrated
    if fit is None:
        return {}
    usual = {item.name: item.sigma for item in result.search.usual_tolerances}
    covariance = _covariance(result, fit)
    found = {}
    for number, item in enumerate(fit.hypothesis.tolerances):
        if item.sigma > usual.get(item.name, item.sigma):
            left = item.sigma * float(np.sqrt(covariance[number, number]))
            found[item.name] = item.stated(max(left, usual[item.name]))
    return found


def _covariance(result: GapResult, fit: Fit) -> Array:
    """Return that of the tolerances, in prior deviations: with what encoders explain as well."""
    size, other = len(fit.hypothesis.tolerances), result.other_encoders
    covariance = np.asarray(np.linalg.inv(fit.precision)[:size, :size])
    return covariance if other is None else covariance + np.outer(other.apart, other.apart)


def encoder_words(result: GapResult) -> list[str]:
    """Return which encoders would explain as well what was calibrated."""
    if result.other_encoders is None or not _is_explained(result):
        return []
    return [
        f'what is calibrated may stand for the encoder of {joint}: that it stands '
        f'{with_sigma(value, sigma, "deg")} further explains the recordings as well; deviations '
        'contain that'
        for joint, (value, sigma) in result.other_encoders.offsets.items()
    ]


def calibration_words(
    items: Sequence[Calibrated], turned: Sequence[Mount], named: Collection[str] = ()
) -> list[str]:
    """Return the calibration in a few lines: what moved, what stays open, what went too far.

    Parameters
    ----------
    items : sequence of Calibrated
        All numbers.
    turned : sequence of Mount
        Sensors.
    named : collection of str
        Joints whose spring has a factor of its own: it holds what the tolerance would.
    """
    lines = []
    moved = [item for item in items if item.moved > CLEARLY and 'rotation' not in item.name]
    if moved:
        moved = sorted(moved, key=lambda item: -item.moved)[:MOST_TOLD]
        doubt = '' if math.isfinite(moved[0].sigma) else ' (or standing for what is unexplained)'
        lines.append(f'calibrated{doubt}: {", ".join(map(_words, moved))}')
    if turned:
        mounted = [f'{it.sensor} by {with_sigma(it.angle_deg, it.sigma_deg)}°' for it in turned]
        lines.append(f'mounts turned, within tolerance: {", ".join(mounted)}')
    open_ = [item.name for item in items if not item.determined and _is_open(item, named)]
    if open_:
        lines.append(f'not determined by this campaign: {", ".join(open_)}')
    lines += [
        f'{item.name} is {abs(item.deviations):.1f} of its tolerances away'
        for item in items
        if item.stretched
    ]
    return lines


def _is_open(item: Calibrated, named: Collection[str]) -> bool:
    own = any(item.name == f'stiffness of {joint}' for joint in named)
    return item.name.startswith(('stiffness', 'base stiffness')) and not own


def _words(item: Calibrated) -> str:
    if item.unit == RELATIVE:
        return f'{item.name} {with_sigma(item.value, item.sigma)} times nominal'
    sign = '+' if item.value > 0.0 else ''
    if item.unit == 'm':
        return f'{item.name} {sign}{with_sigma(1e3 * item.value, 1e3 * item.sigma, "mm")}'
    return f'{item.name} {sign}{with_sigma(item.value, item.sigma)}°'
