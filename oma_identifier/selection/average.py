"""The mean of the members of a cluster that the data determine best, and its deviation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.selection.cluster import Cluster
from oma_identifier.selection.identified_band import IdentifiedBand
from oma_identifier.selection.selected_pole import SelectedPole
from oma_identifier.selection.thresholds import SELECTION


@dataclass(frozen=True, slots=True)
class Trials:
    """The members of a cluster whose standard deviations are compared, by model order.

    Parameters
    ----------
    rows : (n_trials,) int array
        Rows of the poles.
    series : (n_blocks, n_trials) complex array [rad/s]
        What each block of time does to them.
    blur : float
        The least of their deviations, in half-power half-widths.
    """

    rows: NDArray[np.int64]
    series: NDArray[np.complex128]
    blur: float


def trials_of(band: IdentifiedBand, clusters: Sequence[Cluster]) -> list[Trials]:
    """Return the trials of all clusters, whose gradients are cheaper together."""
    if not clusters:
        return []
    rows = [cluster.members[_places(len(cluster), band.trials)] for cluster in clusters]
    together = np.concatenate(rows)
    series = band.influence(together)
    # The variance of a complex pole is that of frequency and damping together.
    variance = np.mean(np.abs(series) ** 2, axis=0) / len(series) / 2.0
    blur = np.sqrt(variance) / -band.poles.pole[together].real
    ends = np.cumsum([len(each) for each in rows])
    parts = zip(rows, np.split(series, ends[:-1], axis=1), np.split(blur, ends[:-1]), strict=True)
    return [Trials(each, own, float(least.min())) for each, own, least in parts]


def _places(n_members: int, shares: Sequence[float]) -> list[int]:
    return sorted({round(share * (n_members - 1)) for share in shares})


def average(band: IdentifiedBand, cluster: Cluster, trials: Trials) -> SelectedPole:
    """Average the best determined members, with the deviation of that average.

    The members' influence series are averaged like the members themselves, so the deviation of
    the average is exact to first order however strongly the model orders are correlated.
    """
    rows, series = trials.rows, trials.series
    good = _agreeing(band.poles.pole[rows], series)
    pole = complex(np.mean(band.poles.pole[rows[good]]))
    deviation = band.deviation(series[:, good].mean(axis=1), pole)
    shape = mean_shape(band.poles.shape[:, rows[good]])
    return SelectedPole(band, cluster, pole, shape, deviation, trials.blur)


def _agreeing(poles: NDArray[np.complex128], series: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return which members to average: precise, and not biased by too low a model order.

    Members of higher order have less bias and more scatter.  The anchor is the most precise
    member whose differences to those of higher order are no larger than such differences
    scatter; the others must agree with the anchor in the same way.
    """
    n_blocks = len(series)
    variance = np.mean(np.abs(series) ** 2, axis=0) / n_blocks
    spread = np.mean(np.abs(series[:, :, None] - series[:, None]) ** 2, axis=0) / n_blocks
    differs = np.abs(poles[:, None] - poles) ** 2
    surprise = np.divide(differs, spread, out=np.zeros_like(differs), where=spread > 0.0)
    anchor = len(poles) - 1
    for member in np.argsort(variance):
        above = surprise[member, member + 1 :]
        if len(above) == 0 or _median(above) <= SELECTION.biased:
            anchor = int(member)
            break
    near = surprise[anchor] <= 2.0 * SELECTION.biased
    near[anchor] = True
    return np.asarray(near & (variance <= SELECTION.within * variance[anchor]))


def mean_shape(shapes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the direction that the columns share, scaled like the first of them."""
    left, values, _ = np.linalg.svd(shapes / np.linalg.norm(shapes, axis=0), full_matrices=False)
    return np.asarray(left[:, 0] * values[0])


def _median(values: NDArray[np.float64]) -> float:
    """Return the median; numpy's own takes several times as long for so few values."""
    ordered = np.sort(values)
    middle = len(ordered) // 2
    return float(ordered[middle] + ordered[~middle]) / 2.0
