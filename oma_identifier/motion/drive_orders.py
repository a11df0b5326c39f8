"""Lines of the drives: ripple of motors and gears, predicted from the joint states.

What a motor or its gear does once or several times a turn follows the angle of the shaft, not the
time.  The responses are demodulated by a multiple of that angle (order tracking), so that a line
that moves with speed stands still; it is told from the structure by its neighbourhood, then taken
out of the samples, which leaves no line behind that a pole could sit on.

References
----------
Vold and Leuridan (1993), SAE Technical Paper 931288, doi:10.4271/931288 (order tracking);
Thomson (1982), doi:10.1109/PROC.1982.12433, Section XIII (F test for a line);
Goodman (1963), doi:10.1214/aoms/1177704250 (complex Wishart; Hotelling's ratio).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.numbers.chance import fisher_tail
from modal_core.numbers.indicators import normalise
from modal_core.samples import Samples
from oma_identifier.motion.thresholds import MOTION
from oma_identifier.spectra import Line, line_at

ORDERS = (1.0, 2.0, 3.0, 4.0, 6.0, 12.0)
"""Per turn of the motor: unbalance, misalignment, pole pairs and slots."""
N_PARTS = 24
NEIGHBOURS = tuple(range(4, 12))
"""Bins to either side, outside the main lobe of the taper, that tell what noise would be there."""
MOST_TRACKED = 6


@dataclass(frozen=True, slots=True)
class DriveOrder:
    """One order of one drive that stands out of the responses.

    Parameters
    ----------
    drive : int
        Which drive.
    order : float
        Times the motor shaft turns.
    lowest_hz, highest_hz : float [Hz]
        Where it moved in the window.
    line : Line
        At its mean frequency.
    """

    drive: int
    order: float
    lowest_hz: float
    highest_hz: float
    line: Line


@dataclass(frozen=True, slots=True)
class WithoutOrders:
    """Samples with the drives' lines taken out.

    Parameters
    ----------
    samples : Samples
        What is left.
    orders : tuple of DriveOrder
        What was taken out.
    """

    samples: Samples
    orders: tuple[DriveOrder, ...]

    @property
    def lines(self) -> tuple[Mode, ...]:
        """The orders as harmonics at their mean frequencies."""
        return tuple(
            Mode(order.line.frequency_hz, 0.0, normalise(order.line.shape), harmonic=True)
            for order in self.orders
        )


def remove_drive_orders(
    samples: Samples, angle: NDArray[np.float64], orders: Sequence[float] = ORDERS
) -> WithoutOrders:
    """Find and take out the orders of all drives, the strongest evidence first.

    Parameters
    ----------
    samples : Samples
        One window.
    angle : (n_samples, n_drives) array [rad]
        Of the motor shafts, at the samples.
    orders : sequence of float
        Multiples of the shaft's turns to look for.
    """
    tracks = [
        _Track(drive, order, order * angle[:, drive], samples.sample_rate_hz)
        for drive in range(angle.shape[1])
        for order in orders
    ]
    found = []
    for track in tracks:
        if not track.is_line:
            continue
        order = _test(samples, track)
        if order.line.chance < MOTION.order_chance:
            samples = replace(samples, acceleration=_without(samples.widened(), track))
            found.append(order)
    return WithoutOrders(samples, tuple(found))


class _Track:
    """Phase of one order over the window."""

    def __init__(
        self, drive: int, order: float, phase: NDArray[np.float64], sample_rate_hz: float
    ) -> None:
        self.drive, self.order, self.phase = drive, order, phase
        self.rate_hz = sample_rate_hz
        turning = np.gradient(phase) * sample_rate_hz / (2.0 * np.pi)
        # Where a drive rests or reverses there is no line.
        self.frequency_hz = np.abs(turning)
        self.duration_s = len(phase) / sample_rate_hz

    @property
    def is_line(self) -> bool:
        """Whether the shaft turns often enough, and slowly enough for the sample rate."""
        turns = abs(float(self.phase[-1] - self.phase[0])) / (2.0 * np.pi)
        highest = float(self.frequency_hz.max())
        return turns >= MOTION.fewest_turns and highest < MOTION.highest_order * self.rate_hz

    @property
    def moves(self) -> bool:
        """Whether the line is wider than a line at constant speed would be."""
        return bool(np.ptp(self.frequency_hz) * self.duration_s > 1.0)

    def frames(self) -> tuple[int, int]:
        """Return number and length of the segments."""
        return N_PARTS, len(self.phase) // N_PARTS


def _test(samples: Samples, track: _Track) -> DriveOrder:
    mean_hz = float(track.frequency_hz.mean())
    if track.moves:
        line = Line(mean_hz, _shape(samples.widened(), track), _chance(samples, track))
    else:
        line = line_at(samples, mean_hz)
    low, high = float(track.frequency_hz.min()), float(track.frequency_hz.max())
    return DriveOrder(track.drive, track.order, low, high, line)


def _chance(samples: Samples, track: _Track) -> float:
    """Return the probability that noise stands out of its neighbourhood like this."""
    data = samples.widened()
    data = data[:, np.argsort(data.std(axis=0))[::-1][:MOST_TRACKED]]
    scale = data.std(axis=0)
    n_segments, length = track.frames()
    used = n_segments * length
    turned = np.exp(-1j * track.phase[:used])[:, None] * (data[:used] - data.mean(axis=0)) / scale
    taper = np.blackman(length + 2)[1:-1]
    blocks = turned.reshape(n_segments, length, -1) * taper[:, None]
    bins = np.array([0, *NEIGHBOURS, *(-near for near in NEIGHBOURS)])
    rows = np.exp(-2j * np.pi * np.outer(bins, np.arange(length)) / length)
    ratios = _stand_out(np.einsum('bl,slc->sbc', rows, blocks))
    # A line is there all along; a mode it crosses stands out of its neighbourhood in the segments
    # of the crossing, so those that say most are not asked.
    asked = np.sort(ratios)[: round(MOTION.segments_asked * n_segments)]
    n_channels, n_beside = data.shape[1], 2 * len(NEIGHBOURS)
    return float(
        fisher_tail(
            asked.mean() / MOTION.order_stands_out,
            2 * n_channels * len(asked),
            2 * (n_beside - n_channels + 1) * len(asked),
        )
    )


def _stand_out(spectra: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return Hotelling's ratio of the first bin to the others, per segment; 1 by chance.

    The covariance of the neighbourhood tells directions that modes fill from those they leave
    empty, in which a faint line is seen.
    """
    middle, beside = spectra[:, 0], spectra[:, 1:]
    n_beside, n_channels = beside.shape[1:]
    covariance = np.einsum('sbc,sbd->scd', beside, beside.conj())
    power = np.trace(covariance, axis1=1, axis2=2).real
    covariance += (1e-12 * power + 1e-300)[:, None, None] * np.eye(n_channels)
    solved = np.linalg.solve(covariance, middle[:, :, None])[:, :, 0]
    distance = np.sum(middle.conj() * solved, axis=1).real
    return np.asarray(distance * (n_beside - n_channels + 1) / n_channels)


def _envelope(data: NDArray[np.float64], track: _Track) -> NDArray[np.complex128]:
    """Return the slowly varying amplitude of the order, (n_samples, n_channels)."""
    turned = np.exp(-1j * track.phase)[:, None] * (data - data.mean(axis=0))
    if not track.moves:
        return np.broadcast_to(2.0 * turned.mean(axis=0), turned.shape)
    _, length = track.frames()
    hop = max(1, length // 2)
    window = np.hanning(2 * hop + 1)[:-1]
    n_frames = len(data) // hop + 2
    padded = np.zeros((n_frames * hop + 2 * hop, data.shape[1]), dtype=complex)
    padded[hop : hop + len(data)] = turned
    inside = np.zeros(len(padded))
    inside[hop : hop + len(data)] = 1.0
    envelope = np.zeros_like(padded)
    for frame in range(n_frames):
        here = slice(frame * hop, frame * hop + 2 * hop)
        weight = float(window @ inside[here])
        if weight > 0.0:
            envelope[here] += window[:, None] * (2.0 * (window @ padded[here]) / weight)
    return np.asarray(envelope[hop : hop + len(data)])


def _without(data: NDArray[np.float64], track: _Track) -> NDArray[np.float64]:
    turn = np.exp(1j * track.phase)[:, None]
    return np.asarray(data - (_envelope(data, track) * turn).real)


def _shape(data: NDArray[np.float64], track: _Track) -> NDArray[np.complex128]:
    """Return the direction in which the order moves the channels most."""
    envelope = _envelope(data, track)[:: max(1, len(data) // 2000)]
    values, vectors = np.linalg.eigh(envelope.T @ envelope.conj())
    return np.asarray(vectors[:, -1] * np.sqrt(max(values[-1], 1e-300) / len(envelope)))
