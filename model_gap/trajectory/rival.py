"""A rival from data alone: what any smooth law of motion and load could still explain.

Kernel ridge regression (the mean of a Gaussian process) of what is left over on angles, speeds,
their directions and loads, with width and penalty chosen by leaving out blocks of the fitted
recordings; judged, like the laws, by recordings that took no part (Rasmussen and Williams 2006).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import itertools
import math

import numpy as np
from scipy.spatial.distance import cdist

from model_gap.trajectory.motion import RATE_HZ
from model_gap.trajectory.term import Array, Track

WIDTHS, PENALTIES = (1.0, 2.0, 4.0, 8.0), (1e-3, 1e-2, 1e-1, 1.0)
# Of a block that is left out, or judged as one: a residual agrees with itself for less.
BLOCK_S = 1.0
# Below it a direction is not known [rad/s].
SLOW = 0.01
MOST_SAMPLES = 1500
# The rival beats the laws where it takes away a tenth of the squared error they leave in held-out
# recordings, and is better in the mean of the blocks: by chance in one axis of a hundred.
LEAST_SHARE, DEVIATIONS = 0.1, 2.33
INPUTS = ('angle', 'speed', 'direction', 'load')


@dataclass(frozen=True)
class Rival:
    """What the rival makes of one axis.

    Parameters
    ----------
    before, alone, beside, laws : float
        Rms error held out: of the model, of the rival instead of all laws, of the rival on top of
        them, and of the laws.
    significance : float
        How much better it is on top of them, in standard deviations over blocks.
    input : (str, int)
        What tells most of what the laws leave over: angle, speed, direction or load, of a joint.
    shape : (2, n_bins) array
        That input, and the mean of what is left over there.
    """

    before: float
    alone: float
    beside: float
    laws: float
    significance: float
    input: tuple[str, int]
    shape: Array

    @property
    def beats(self) -> bool:
        """Whether it explains what the laws do not."""
        share = 1.0 - (self.beside / self.laws) ** 2 if self.laws > 0.0 else 0.0
        return share > LEAST_SHARE and self.significance > DEVIATIONS

    @property
    def upsets(self) -> bool:
        """Whether that is a tenth of the gap there was, not of a small rest alone."""
        taken = self.laws**2 - self.beside**2
        return self.beats and taken > LEAST_SHARE * self.before**2


def inputs_of(track: Track, axis: int, own: bool) -> Array:
    """Return what the rival knows of every sample, (n, n_inputs).

    Parameters
    ----------
    track : Track
        The recording.
    axis : int
        Joint that is looked at.
    own : bool
        Only of this axis; else of all.
    """
    speed = track.motion.speed_over(0.0)
    every = (track.motion.joint_rad, speed, np.tanh(speed / SLOW), track.load_nm)
    chosen = [axis] if own else list(range(track.n_joints))
    return np.concatenate([item[:, chosen] for item in every], axis=1)


def rival_of(
    tracks: Sequence[Track],
    count: int,
    joint: int,
    before: Sequence[Array],
    after: Sequence[Array],
) -> Rival:
    """Return what data alone make of one axis.

    Parameters
    ----------
    tracks : sequence of Track
        All recordings.
    count : int
        How many of them are learnt from; the others judge.
    joint : int
        Of the axis.
    before, after : sequence of (n,) array
        What the model, and the laws, leave over along every recording.
    """
    fitting, heldout = tracks[:count], tracks[count:]
    alone = _learnt(fitting, joint, np.concatenate(before[:count]))
    rest = _learnt(fitting, joint, np.concatenate(after[:count]))
    old, left = np.concatenate(before[count:]), np.concatenate(after[count:])
    beside = left - np.concatenate([rest.predict(track) for track in heldout])
    instead = old - np.concatenate([alone.predict(track) for track in heldout])
    pairs = [*zip(_blocks(left), _blocks(beside), strict=True)]
    pairs += [*zip(_blocks(rest.target), _blocks(rest.left_out), strict=True)]
    significance = _significance(pairs, 1e-6 * _rms(left) ** 2 + 1e-300)
    name, shape = _shape(tracks, np.concatenate(after))
    return Rival(_rms(old), _rms(instead), _rms(beside), _rms(left), significance, name, shape)


def _significance(pairs: Sequence[tuple[Array, Array]], tiny: float) -> float:
    """Return how far the mean gain of the blocks is above nought, in standard errors.

    Gains are logarithms of ratios, so that a large block is one block.  Of the fitted recordings
    the rival's error is that of blocks it did not learn from, the laws' that of their own fit.
    """
    gain = np.array(
        [math.log(np.mean(one**2) + tiny) - math.log(np.mean(two**2) + tiny) for one, two in pairs]
    )
    spread = float(np.std(gain, ddof=1)) / math.sqrt(len(gain))
    return float(gain.mean()) / spread if spread > 0.0 else 0.0


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _blocks(values: Array) -> list[Array]:
    count = max(4, int(len(values) / RATE_HZ / BLOCK_S))
    return np.array_split(values, count)


@dataclass(frozen=True)
class _Learnt:
    joint: int
    own: bool
    known: Array
    centre: Array
    scale: Array
    width: float
    weights: Array
    target: Array
    left_out: Array

    def predict(self, track: Track) -> Array:
        """Return the prediction along a recording."""
        return self._at((inputs_of(track, self.joint, self.own) - self.centre) / self.scale)

    def _at(self, inputs: Array) -> Array:
        if not len(self.weights):
            return np.zeros(len(inputs))
        return np.asarray(_kernel(inputs, self.known, self.width) @ self.weights)


def _shape(tracks: Sequence[Track], left: Array) -> tuple[tuple[str, int], Array]:
    """Return the input that tells most of what is left over, and the mean of it there."""
    joints = tracks[0].n_joints
    inputs = np.concatenate([inputs_of(track, 0, own=False) for track in tracks])
    labels = [(kind, joint) for kind in INPUTS for joint in range(joints)]
    curves = [_binned(inputs[:, place], left) for place in range(inputs.shape[1])]
    best = int(np.argmax([float(np.var(curve[1])) for curve in curves]))
    return labels[best], curves[best]


def _binned(values: Array, left: Array, bins: int = 15) -> Array:
    """Return the means of both over shares of the samples, ordered by the first."""
    order = np.argsort(values, kind='stable')
    parts = np.array_split(order, bins)
    return np.array([[item[part].mean() for part in parts] for item in (values, left)])


def _kernel(one: Array, two: Array, width: float) -> Array:
    squares = cdist(one, two, 'sqeuclidean') / one.shape[1]
    return np.asarray(np.exp(-0.5 * squares / width**2))


def _learnt(tracks: Sequence[Track], joint: int, target: Array) -> _Learnt:
    """Return the regression whose width and penalty predict blocks that were left out best."""
    step = max(1, len(target) // MOST_SAMPLES)
    found: list[tuple[float, _Learnt]] = []
    block = max(1, int(RATE_HZ * BLOCK_S / step))
    for own, width in itertools.product((True, False), WIDTHS):
        raw = np.concatenate([inputs_of(track, joint, own) for track in tracks])[::step]
        centre, scale = raw.mean(axis=0), np.maximum(raw.std(axis=0), 1e-9)
        known, values = (raw - centre) / scale, target[::step]
        kernel = _kernel(known, known, width)
        for penalty in PENALTIES:
            inside = kernel + penalty * np.eye(len(kernel))
            weights = np.asarray(np.linalg.solve(inside, values), dtype=float)
            errors = _left_out(kernel, values, penalty, block)
            learnt = _Learnt(joint, own, known, centre, scale, width, weights, values, errors)
            found.append((float(np.mean(errors**2)), learnt))
    error, best = min(found, key=lambda item: item[0])
    nothing = error >= float(np.mean(target**2))
    return replace(best, weights=np.zeros(0), left_out=best.target) if nothing else best


def _left_out(kernel: Array, values: Array, penalty: float, block: int) -> Array:
    """Return the errors of every block, predicted from all others."""
    inverse = np.linalg.inv(kernel + penalty * np.eye(len(kernel)))
    solved = inverse @ values
    errors = []
    for begin in range(0, len(values), block):
        part = slice(begin, begin + block)
        errors.append(np.linalg.solve(inverse[part, part], solved[part]))
    return np.concatenate(errors)
