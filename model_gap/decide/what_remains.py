"""What is left over, described where nothing explains it: at which frequency, level, pose, sensor.

And what to record next to see it better.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_gap.fit import pose_groups
from model_gap.hypothesis import Hypothesis
from model_gap.search import Search

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RemainderLimits:
    """When a part of what is left over is worth saying.

    Parameters
    ----------
    half_width : float
        Of the band that counts as one resonance, relative: some widths of a lightly damped mode.
    resonance_share : float
        Of what is left over, in such a band: of an even spectrum from 3 to 60 Hz it would be 5 %.
    same_frequency : float
        Most that the resonance moves from pose to pose, relative; those of an arm move more.
    level_ratio : float
        Of what is left over to the response, between two levels; 1 where all is linear.
    most_of_it : float
        Share of one pose or one sensor.
    """

    half_width: float = 0.08
    resonance_share: float = 0.4
    same_frequency: float = 0.04
    level_ratio: float = 1.4
    most_of_it: float = 0.7


LIMITS = RemainderLimits()


@dataclass(frozen=True)
class Remainder:
    """Something that is seen of what is left over.

    Parameters
    ----------
    words : str
        What.
    next_recording : str
        What would show more of it.
    """

    words: str
    next_recording: str


@dataclass(frozen=True)
class Part:
    """What is left over in one record.

    Parameters
    ----------
    pose : int
        Its number.
    level : str
        Amplitude level.
    sensors : tuple of str
        Of every channel.
    frequency_hz : (n_bins,) array [Hz]
        Bins.
    excess, response : (n_channels, n_bins) array
        |Y - Ŷ|²/σ² - 1, and |Y|²/σ².
    natural_hz : (n_modes,) array [Hz]
        Natural frequencies of the model at the pose.
    """

    pose: int
    level: str
    sensors: tuple[str, ...]
    frequency_hz: Array
    excess: Array
    response: Array
    natural_hz: Array = field(default_factory=lambda: np.zeros(0))


def what_remains(search: Search, hypothesis: Hypothesis) -> tuple[Remainder, ...]:
    """Return what can be said of what a hypothesis leaves over, the most telling first."""
    return described(_parts(search, hypothesis))


def described(parts: Sequence[Part]) -> tuple[Remainder, ...]:
    """Return what can be said of what is left over in some records."""
    if sum(float(part.excess.sum()) for part in parts) <= 0.0:
        return ()
    found = (_resonance(parts), _amplitude(parts), _one_pose(parts), _one_sensor(parts))
    said = tuple(item for item in found if item is not None)
    return said or (
        Remainder(
            'it is spread over frequencies, levels, poses and sensors',
            'record more poses far apart, each joint moving alone in some of them, a sensor on '
            'every link and one on the base plate',
        ),
    )


def _parts(search: Search, hypothesis: Hypothesis) -> list[Part]:
    sensors = tuple(channel.sensor for channel in search.campaign.layout.channels)
    pose_of = {
        record.name: group + 1
        for record, group in zip(
            search.campaign.records, pose_groups(search.campaign), strict=True
        )
    }
    found = []
    for predictor in (search.data.fitting, search.data.heldout):
        if not predictor.records:
            continue
        cell = hypothesis.cell()
        squares = predictor.squares(cell)
        natural_hz = [
            np.unique(np.abs(system.poles[system.poles.imag > 0.0])) / (2.0 * np.pi)
            for system in predictor.systems(cell.spec, cell.channels)
        ]
        for item, square, group in zip(predictor.records, squares, predictor.groups, strict=True):
            found.append(
                Part(
                    pose_of[item.record.name],
                    item.record.level,
                    sensors,
                    item.frequency_hz,
                    square - item.seen,
                    item.squares(item.measured),
                    natural_hz[group],
                )
            )
    return found


def _resonance(parts: Sequence[Part]) -> Remainder | None:
    """Say where what is left over stands in one narrow band, the same one in every pose."""
    poses = sorted({part.pose for part in parts})
    peaks, shares = [], []
    for pose in poses:
        own = [part for part in parts if part.pose == pose]
        peak, share = _narrow(own)
        peaks.append(peak)
        shares.append(share)
    middle = float(np.median(peaks))
    apart = np.abs(np.array(peaks) / middle - 1.0)
    if len(poses) < 2 or np.median(shares) < LIMITS.resonance_share:
        return None
    if np.mean(apart < LIMITS.same_frequency) < 2.0 / 3.0:
        return None
    if _owned(parts, middle):
        return Remainder(
            f'{np.median(shares):.0%} of it is around {middle:.1f} Hz, where the model has a '
            'natural frequency in every pose: that mode is damped or held otherwise',
            f'record two more amplitude levels, moving around {middle:.1f} Hz only, each joint '
            'alone: which of them turns that mode, and does it depend on amplitude',
        )
    return Remainder(
        f'{np.median(shares):.0%} of it is a resonance at {middle:.1f} Hz, at the same frequency '
        'in every pose, that no link of the model owns: the foundation, a hose, a mount',
        f'record with a sensor on the base plate and one on each hose or mount, moving around '
        f'{middle:.1f} Hz only; then the same with the hoses tied down',
    )


def _owned(parts: Sequence[Part], frequency_hz: float) -> bool:
    """Return whether the model has a natural frequency there, in two poses of three."""
    near = [
        bool(np.any(np.abs(part.natural_hz / frequency_hz - 1.0) < LIMITS.same_frequency))
        for part in parts
    ]
    return float(np.mean(near)) >= 2.0 / 3.0


def _narrow(parts: Sequence[Part]) -> tuple[float, float]:
    """Return the middle of the narrow band with the largest share, and the share."""
    frequency = np.concatenate([part.frequency_hz for part in parts])
    power = np.concatenate([np.maximum(part.excess.sum(axis=0), 0.0) for part in parts])
    order = np.argsort(frequency)
    frequency, power = frequency[order], power[order]
    total = np.r_[0.0, np.cumsum(power)]
    low = np.searchsorted(frequency, frequency * (1.0 - LIMITS.half_width))
    high = np.searchsorted(frequency, frequency * (1.0 + LIMITS.half_width), side='right')
    inside = total[high] - total[low]
    best = int(np.argmax(inside))
    band = slice(low[best], high[best])
    middle = float(np.average(frequency[band], weights=power[band] + 1e-300))
    return middle, float(inside[best] / max(total[-1], 1e-300))


def _amplitude(parts: Sequence[Part]) -> Remainder | None:
    """Say whether what is left over grows otherwise than the response."""
    levels = _shares(parts, lambda part: part.level)
    if len(levels) < 2:
        return None
    least, most = (pick(levels, key=lambda name: levels[name]) for pick in (min, max))
    if levels[most] < LIMITS.level_ratio * max(levels[least], 1e-9):
        return None
    return Remainder(
        f'it depends on amplitude: {levels[most]:.1%} of the response at level {most}, '
        f'{levels[least]:.1%} at level {least}',
        'record a third amplitude level, half the lowest or twice the highest, in the same poses',
    )


def _shares(parts: Sequence[Part], of: Callable[[Part], Hashable]) -> dict[Hashable, float]:
    """Return what is left over as a fraction of the response, an amplitude."""
    found = {}
    for name in dict.fromkeys(of(part) for part in parts):
        own = [part for part in parts if of(part) == name]
        left = max(sum(float(part.excess.sum()) for part in own), 0.0)
        found[name] = float(np.sqrt(left / sum(float(part.response.sum()) for part in own)))
    return found


def _one_pose(parts: Sequence[Part]) -> Remainder | None:
    left: dict[int, float] = {}
    for part in parts:
        left[part.pose] = left.get(part.pose, 0.0) + max(float(part.excess.sum()), 0.0)
    most = max(left, key=lambda pose: left[pose])
    if len(left) < 3 or left[most] < LIMITS.most_of_it * sum(left.values()):
        return None
    return Remainder(
        f'{left[most] / sum(left.values()):.0%} of it is in pose {most} only',
        f'record pose {most} once more, and two poses near it: does it come back, and where does '
        'it end',
    )


def _one_sensor(parts: Sequence[Part]) -> Remainder | None:
    left: dict[str, float] = {}
    for part in parts:
        for row, sensor in enumerate(part.sensors):
            left[sensor] = left.get(sensor, 0.0) + max(float(part.excess[row].sum()), 0.0)
    most = max(left, key=lambda sensor: left[sensor])
    if len(left) < 3 or left[most] < LIMITS.most_of_it * sum(left.values()):
        return None
    return Remainder(
        f'{left[most] / sum(left.values()):.0%} of it is in what sensor {most} reads',
        f'look at the mount, place and cable of sensor {most}, and record with another one there',
    )
