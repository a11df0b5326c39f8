"""Groups poles of different model orders that are estimates of the same mode."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage

from modal_core.numbers.indicators import mac
from oma_identifier.selection.stabilise import BandPoles
from oma_identifier.selection.thresholds import SELECTION

FAR = 10.0


@dataclass(frozen=True, slots=True)
class Cluster:
    """Poles that estimate one mode, at most one per model order.

    Parameters
    ----------
    members : (n_members,) int array
        Rows of the poles, by model order.
    centre : int
        Row of the pole nearest to all others: the representative.
    """

    members: NDArray[np.int64]
    centre: int

    def __len__(self) -> int:
        """Return the number of model orders that agree."""
        return len(self.members)


def cluster_poles(poles: BandPoles, candidates: NDArray[np.int64]) -> list[Cluster]:
    """Cluster candidate poles by average linkage.

    Parameters
    ----------
    poles : BandPoles
        All poles.
    candidates : (n_candidates,) int array
        Rows that passed the hard and soft criteria.
    """
    if len(candidates) < 2:
        return []
    distance = pole_distance(poles, candidates)
    tree = linkage(distance[np.triu_indices(len(distance), 1)], 'average')
    label = fcluster(tree, SELECTION.cluster_cut, 'distance')
    together = np.argsort(label, kind='stable')
    ends = np.cumsum(np.bincount(label)[1:])
    order = poles.model_order[candidates]
    return [
        _cluster(candidates, order, distance, local) for local in np.split(together, ends[:-1])
    ]


def pole_distance(poles: BandPoles, rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return |Δs| over the half-power half-width plus 1 - MAC, (n_rows, n_rows) array.

    The half-width ζω is the natural unit: two poles closer than it cannot be told apart in a
    spectrum, whatever their frequency.
    """
    pole = poles.pole[rows]
    width = np.maximum(-pole.real, SELECTION.least_relative_step * np.abs(pole))
    mean_width = np.sqrt(width[:, None] * width[None])
    apart = np.abs(pole[:, None] - pole[None]) / mean_width
    shape = 1.0 - mac(poles.shape[:, rows], poles.shape[:, rows])
    distance = np.minimum(apart + shape / 0.5, FAR)
    np.fill_diagonal(distance, 0.0)
    return np.asarray((distance + distance.T) / 2.0)


def _cluster(
    candidates: NDArray[np.int64],
    orders: NDArray[np.int64],
    distance: NDArray[np.float64],
    local: NDArray[np.int64],
) -> Cluster:
    if len(local) == 1:
        return Cluster(candidates[local], int(candidates[local[0]]))
    order = orders[local]
    total = distance[local[:, None], local].sum(axis=1)
    if not (order[1:] > order[:-1]).all():
        # At most one pole per model order: the one nearest to the others.
        best = np.lexsort((total, order))
        local = local[best[np.unique(order[best], return_index=True)[1]]]
        total = distance[local[:, None], local].sum(axis=1)
    return Cluster(candidates[local], int(candidates[local[np.argmin(total)]]))
