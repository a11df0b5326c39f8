"""Laws must predict recordings that took no part better than the model does without them."""

from collections.abc import Sequence
import dataclasses

import numpy as np

from model_gap.trajectory.fit import Fit, fit_terms
from model_gap.trajectory.predict import predicted
from model_gap.trajectory.search import Found, judged
from model_gap.trajectory.term import Array, Term, TORQUE, Track, TWIST

# A law that is right gains on new data what it gained on the old; one that shrinks the squared
# error by less than this share of it is not shown to.
LEAST_SHARE = 0.01


def errors(track: Track, found: Found, fit: Fit) -> Array:
    """Return the mean square of what laws leave over, by row."""
    layout = found.problem.layout
    left = track.left(layout.terms[0].quantity) - predicted(track, layout, fit)
    return np.asarray(np.mean(left**2, axis=0))


def square_before(track: Track, quantity: str) -> Array:
    """Return the mean square of what the model leaves over, by row.

    Of twists without their mean: what an encoder counts from is a convention.
    """
    left = track.left_by_model(quantity)
    if quantity == TWIST:
        left = left - left.mean(axis=0)
    return np.asarray(np.mean(left**2, axis=0))


def heldout_square(found: Found, fit: Fit, heldout: Sequence[Track]) -> float:
    """Return the squared error as a share of that before, see :func:`share_of`."""
    quantity = found.problem.layout.terms[0].quantity
    after = np.mean([errors(track, found, fit) for track in heldout], axis=0)
    before = np.mean([square_before(track, quantity) for track in heldout], axis=0)
    return share_of(after, before, size_of(heldout, quantity))


def size_of(tracks: Sequence[Track], quantity: str) -> Array:
    """Return how much every row of a quantity varies, as a mean square."""
    motions = [track.motion for track in tracks]
    shown = [item.torque_nm if quantity == TORQUE else item.twist_rad for item in motions]
    return np.asarray(np.mean([np.var(item, axis=0) for item in shown], axis=0))


def share_of(after: Array, before: Array, size: Array) -> float:
    """Return one mean square as a share of another, every axis in units of what it shows."""
    scale = np.maximum(size, 1e-12 * size.max(initial=1e-300))
    return float(np.sum(after / scale) / np.sum(before / scale))


def confirmed(found: Found, heldout: Sequence[Track]) -> tuple[Found, tuple[Term, ...]]:
    """Return the laws that held-out recordings confirm, and those they do not.

    Parameters
    ----------
    found : Found
        Of the fitted recordings.
    heldout : sequence of Track
        The others.
    """
    layout = found.problem.layout
    accepted, dropped = list(found.accepted), []
    while accepted:
        whole = heldout_square(
            found, fit_terms(found.sums, layout, (*found.free, *accepted)), heldout
        )
        worth = {
            item: heldout_square(
                found,
                fit_terms(
                    found.sums,
                    layout,
                    (*found.free, *(other for other in accepted if other != item)),
                ),
                heldout,
            )
            / whole
            - 1.0
            for item in accepted
        }
        least = min(worth, key=lambda item: worth[item])
        if worth[least] >= LEAST_SHARE:
            break
        accepted.remove(least)
        dropped.append(layout.terms[least])
    return judged(dataclasses.replace(found, accepted=tuple(accepted))), tuple(dropped)
