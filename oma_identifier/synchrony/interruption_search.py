"""Which sensors are not heard in which blocks of a window: those without which all others go on.

What a sensor shows is a filtered sum of what the others show.  It is not heard where that held for
most of the time, and next to nothing of it is left while the others go on as before.  A sensor
turned round, amplified or exchanged still follows the others: that is another matter.

References
----------
Rousseeuw and Leroy (1987), Robust Regression and Outlier Detection, ch. 2 (fits that keep to the
part that agrees best).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.block_regression import BlockRegression, Left, usual
from oma_identifier.synchrony.thresholds import SYNCHRONY

MOST_SUSPECTS = 4
"""Sensors that are tried first: is it without them that all others go on?  With one, one of 21
records (seeds 984000 to 984020) tells of a sensor that was heard; twelve are no better."""
ROWS_PER_COLUMN = 10
"""Rows from where on a fit to a stretch alone tells whether it follows the others otherwise.
Without asking, one of the same records tells of a sensor that was heard."""

Real = NDArray[np.float64]
Places = NDArray[np.int64]
Marks = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Follows:
    """How a channel follows the others, in their units.

    Parameters
    ----------
    names : tuple of str
        Channels it is regressed on, itself among them.
    weights : (n_columns,) array
        See :meth:`BlockRegression.weights`.
    usual, said : float
        Power that is left of it in a block, and power of the prediction.
    """

    names: tuple[str, ...]
    weights: Real
    usual: float
    said: float


class InterruptionSearch:
    """Looks for the sensors without which all others go on as before.

    Parameters
    ----------
    regression : BlockRegression
        Of a window.
    sensors : sequence of int array
        Places of each sensor's channels in it.
    names : tuple of str
        Of the channels.
    before : mapping of str to Follows
        How channels followed the others in earlier windows.

    Attributes
    ----------
    known : dict of str to Follows
        The same of this one, of channels that it tells of.
    """

    def __init__(
        self,
        regression: BlockRegression,
        sensors: Sequence[Places],
        names: tuple[str, ...],
        before: Mapping[str, Follows],
    ) -> None:
        self._regression, self._sensors = regression, sensors
        self._names, self._before = names, before
        self._weights: dict[int, Real] = {}
        self._usual: dict[int, float] = {}
        self.known: dict[str, Follows] = {}
        self._lost: dict[int, bool] = {}

    def marks(self) -> dict[int, Marks]:
        """Return the blocks in which channels are not heard, by place."""
        every = [own for own in self._sensors if self._regression.is_live[own].all()]
        active, out = list(every), list[Places]()
        while len(active) > SYNCHRONY.fewest_witnesses:
            weights, left = self._fit(active)
            marked, _ = self._look(active, left)
            if not out:
                marked |= self._no_longer(active)
            if not marked.any():
                break
            out.append(active.pop(self._worst(active, marked)))
        else:
            # Too few are left to bear witness: the structure changed, or nobody knows.
            return {}
        if 2 * len(out) > len(every):
            return {}
        others = np.concatenate(active)
        self._remember(others, weights, left)
        calm = left.surprise(left.loudness).mean(axis=1) < SYNCHRONY.others_go_on
        return self._of_those(out, others, calm, left.loudness)

    def _fit(self, active: list[Places]) -> tuple[Real, Left]:
        """Return how each sensor follows the other ones, and what that leaves."""
        others = np.concatenate(active)
        return self._regression.robust(others, active, others)

    def _look(self, active: list[Places], left: Left) -> tuple[Marks, Marks]:
        """Return which sensors break in which blocks, and which lack what others say there.

        Of (n_sensors, n_blocks).
        """
        lacking = _is_lacking(left)
        places = np.concatenate(active).tolist()
        self._lost = dict(zip(places, _is_lost(left), strict=True))
        marked = _is_told(left) & lacking & (left.surprise(left.loudness) > SYNCHRONY.surprising)
        return _by_sensor(marked, active), _by_sensor(lacking, active)

    def _no_longer(self, active: list[Places]) -> Marks:
        """Return the same of sensors that nothing tells of now, by what they were before."""
        marked = np.zeros((len(active), self._regression.n_blocks), dtype=bool)
        for number, own in enumerate(active):
            for place in own.tolist():
                if self._lost[place]:
                    marked[number] |= self._as_before(place)[1]
        return marked

    def _worst(self, active: list[Places], marked: Marks) -> int:
        """Return the sensor without which the fewest others break."""
        count = marked.sum(axis=1)
        hottest = np.argsort(-count, kind='stable')[:MOST_SUSPECTS]

        def broken_without(number: int) -> tuple[int, int]:
            rest = [own for k, own in enumerate(active) if k != number]
            broken, lacking = self._look(rest, self._fit(rest)[1])
            broken |= lacking & np.delete(marked, number, axis=0)
            return int(broken.sum()), -int(count[number])

        return min((int(number) for number in hottest if count[number]), key=broken_without)

    def _of_those(
        self, out: list[Places], others: Places, calm: Marks, loudness: Real
    ) -> dict[int, Marks]:
        """Return the blocks in which each is not heard while the others go on."""
        found = {}
        for own in out:
            weights, left = self._regression.robust(own, [], others)
            lost = _is_lost(left)
            fresh = (
                _is_told(left)
                & _is_lacking(left)
                & (left.surprise(loudness) > SYNCHRONY.surprising)
            )
            self._remember(own, weights, left)
            for number, place in enumerate(own.tolist()):
                self._weights[place], marked = weights[number], fresh[:, number]
                self._usual[place] = float(usual(left.left[:, number]))
                if lost[number]:
                    before, marked = self._as_before(place)
                    self._weights[place] = weights[number] if before is None else before
                marked = marked & calm
                if marked.any() and not self._follows_otherwise(place, marked, others):
                    found[place] = marked
        return found

    def _as_before(self, place: int) -> tuple[Real | None, Marks]:
        """Return how a channel followed the others before, and where it no longer does."""
        regression, known = self._regression, self._before.get(self._names[place])
        none = np.zeros(regression.n_blocks, dtype=bool)
        if known is None or known.names != self._names:
            return None, none
        own = regression.scale[place]
        weights = known.weights * regression.column_scale / own
        left = regression.left(weights[None], np.array([place]))
        loudness = np.maximum(1.0, left.said / (known.said / own**2 + 1e-300))
        surprise = left.left / (known.usual / own**2 * loudness + 1e-300)
        marked = (_is_lacking(left) & (surprise > SYNCHRONY.surprising))[:, 0]
        self._usual[place] = known.usual / own**2
        return weights, marked

    def _follows_otherwise(self, place: int, marked: Marks, others: Places) -> bool:
        """Tell whether a channel follows the others in marked blocks in another way."""
        regression, target = self._regression, np.array([place])
        n_columns = len(others) * (2 * regression.n_lags + 1)
        if marked.sum() * regression.n_rows < ROWS_PER_COLUMN * n_columns:
            return False
        weights = regression.weights(target, [], others, marked.astype(float))
        left = regression.left(weights, target)
        shown, said, common = (each[marked].sum() for each in (left.shown, left.said, left.common))
        return bool(common**2 > SYNCHRONY.follows * shown * said)

    def _remember(self, places: Places, weights: Real, left: Left) -> None:
        regression = self._regression
        for number, place in enumerate(places.tolist()):
            if _is_told(left)[number]:
                own = regression.scale[place]
                self.known[self._names[place]] = Follows(
                    self._names,
                    weights[number] * own / regression.column_scale,
                    float(usual(left.left[:, number])) * own**2,
                    float(usual(left.said[:, number])) * own**2,
                )

    def physical(self, place: int) -> Real:
        """Return the weights of a channel's prediction in the units of the samples."""
        regression = self._regression
        scale = regression.scale[place] / regression.column_scale
        return np.asarray(self._weights[place] * scale)

    def usual_left(self, place: int) -> float:
        """Return the standard deviation of what a prediction usually leaves [unit]."""
        return math.sqrt(self._usual[place]) * float(self._regression.scale[place])


def _is_told(left: Left) -> Marks:
    """Tell which channels the others explain in most blocks."""
    return np.asarray(usual(left.share) < SYNCHRONY.unexplained)


def _is_lost(left: Left) -> Marks:
    """Tell which channels most blocks do not show to follow the others."""
    return np.asarray(usual(left.share) > SYNCHRONY.lost)


def _is_lacking(left: Left) -> Marks:
    """Tell in which blocks nothing of what the others say is shown, or nobody can hear it.

    What passes close to a sensor, as a vehicle on a bridge, adds to what the others say.
    """
    drowned = left.left * SYNCHRONY.heard > left.said
    unheard = drowned | (left.coherence < SYNCHRONY.heard)
    return np.asarray(unheard & (left.share > SYNCHRONY.gone))


def _by_sensor(of_channels: Marks, sensors: Sequence[Places]) -> Marks:
    """Return what holds of any channel of each sensor, (n_sensors, n_blocks)."""
    ends = np.cumsum([len(own) for own in sensors])[:-1]
    return np.array([part.any(axis=1) for part in np.split(of_channels, ends, axis=1)])
