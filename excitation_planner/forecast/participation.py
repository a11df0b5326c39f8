"""Which modes the planned motion will show at the sensors, and how well they will be known.

With mass-normalised shapes mode i obeys η'' + 2ζωη' + ω²η = φᵢᵀ B a(t): B a is the force on the
flexible coordinates per joint acceleration.  At resonance a sensor of modal constant c sees the
acceleration density c² S_F / (4ζ²), to be compared with the sensor's own noise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion import PredictedSpectrum
from excitation_planner.signals import NOISES
from modal_core.channel import Channel
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# A mode whose resonance stands less than this above the noise at its best sensor is missed. Played
# for 60 s (random pulses in 14 random poses, weak noise in three), 67 of 69 of those above were
# found; of those from 10 dB to here 6 of 22, where others are 30 dB stronger hardly one.
VISIBLE_DB = 18.0
# Of the band of an excitation that ends at an edge, what the identifier analyses: the corner looks
# like a mode (as oma_identifier's COVARIANCE.below_edge; a test compares them).
PART_OF_BAND = 0.95
# Half widths of the frequency range one mode informs about, in units of ζ f.
BANDWIDTHS = 12.0
N_INTEGRATION = 2001


@dataclass(frozen=True, slots=True)
class ModeForecast:
    """What to expect of one mode.

    Parameters
    ----------
    frequency_hz, damping_ratio : float [Hz], [-]
        Of the model at the pose.
    modal_force_density : float [N²/Hz for unit modal mass]
        One-sided density of the modal force at the natural frequency.
    joint_share : tuple of float
        Part of the modal force's power that each joint brings.
    signal_to_noise_db : float [dB]
        At the best sensor, resonance over noise.
    best_channel : str
        That sensor's channel; empty without sensors.
    frequency_std_hz, damping_ratio_std : float [Hz], [-]
        Smallest standard deviations any unbiased method can reach with this record.
    reason : str
        Why the mode would be missed; empty when it will be seen.
    cure : str
        What would reach it; empty when it will be seen.
    """

    frequency_hz: float
    damping_ratio: float
    modal_force_density: float
    joint_share: tuple[float, ...]
    signal_to_noise_db: float
    best_channel: str
    frequency_std_hz: float
    damping_ratio_std: float
    reason: str = ''
    cure: str = ''

    @property
    def missed(self) -> bool:
        """True when the plan would not show this mode."""
        return bool(self.reason)


@dataclass(frozen=True, slots=True)
class ModeParticipation:
    """Modes of the model at a pose, as the planner needs them.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Natural frequencies and damping ratios.
    drive : (n_modes, n_joints) array
        φᵀB, modal force per joint acceleration, mass-normalised shapes.
    response : (n_channels, n_modes) array
        Acceleration of each channel per modal acceleration.
    channel_names : tuple of str
        Rows of ``response``.
    joint_names : tuple of str
        Columns of ``drive``: the controller axes.
    """

    frequency_hz: Array
    damping_ratio: Array
    drive: Array
    response: Array
    channel_names: tuple[str, ...]
    joint_names: tuple[str, ...]


def mode_participation(
    model: FlexibleJointModel, q: Array, channels: tuple[Channel, ...], highest_hz: float
) -> ModeParticipation:
    """Return drive and response of the model's modes up to a frequency."""
    modes = model.modes(q, channels)
    keep = modes.frequency_hz <= highest_hz
    return ModeParticipation(
        frequency_hz=modes.frequency_hz[keep],
        damping_ratio=modes.damping_ratio[keep],
        drive=modes.shapes[:, keep].T @ model.input_matrix(q) @ np.linalg.inv(model.axes.matrix),
        response=modes.channel_shapes[:, keep],
        channel_names=tuple(channel.name for channel in channels),
        joint_names=model.axis_names,
    )


def forecast(
    modes: ModeParticipation,
    spectrum: PredictedSpectrum,
    noise_density: float,
    duration_s: float,
    analysed_hz: float = np.inf,
) -> tuple[ModeForecast, ...]:
    """Predict modal force, signal to noise and standard deviations of every mode.

    Parameters
    ----------
    modes : ModeParticipation
        Modes, drive and response at the pose.
    spectrum : PredictedSpectrum
        Of the joint accelerations; joints are taken as independent.
    noise_density : float [(m/s²)²/Hz]
        Of one sensor channel, one-sided.
    duration_s : float [s]
        Length of the record.
    analysed_hz : float [Hz]
        Where the identifier's own band ends; see :func:`analysed_hz`.
    """
    shares = modes.drive**2 * spectrum.at(modes.frequency_hz)
    return tuple(
        _with_edge(
            _forecast_one(modes, index, shares[index], noise_density, duration_s), analysed_hz
        )
        for index in range(len(modes.frequency_hz))
    )


def analysed_hz(signal: str, band_high_hz: float) -> float:
    """Return where the band ends that is analysed of a signal, below the edge of its spectrum."""
    return PART_OF_BAND * band_high_hz if signal in NOISES else np.inf


def _with_edge(mode: ModeForecast, highest_hz: float) -> ModeForecast:
    if mode.missed or mode.frequency_hz <= highest_hz:
        return mode
    reason = f"above {highest_hz:g} Hz, where the analysed band ends, below the excitation's edge"
    return replace(mode, reason=reason)


def _forecast_one(
    modes: ModeParticipation, index: int, shares: Array, noise_density: float, duration_s: float
) -> ModeForecast:
    force = float(np.sum(shares))
    frequency_hz = float(modes.frequency_hz[index])
    damping_ratio = float(modes.damping_ratio[index])
    response = np.abs(modes.response[:, index])
    best = int(np.argmax(response)) if len(response) else -1
    at_best = response[best] ** 2 if best >= 0 else 0.0
    resonance = force / (4.0 * damping_ratio**2)
    ratio = at_best * resonance / noise_density
    together = float(np.sum(response**2)) * force / noise_density
    std = cramer_rao_std(frequency_hz, damping_ratio, together, duration_s)
    return ModeForecast(
        frequency_hz=frequency_hz,
        damping_ratio=damping_ratio,
        modal_force_density=force,
        joint_share=tuple(float(share) for share in shares / max(force, 1e-300)),
        signal_to_noise_db=float(10.0 * np.log10(max(ratio, 1e-30))),
        best_channel=modes.channel_names[best] if best >= 0 else '',
        frequency_std_hz=std.frequency_hz,
        damping_ratio_std=std.damping_ratio,
        reason=_why_missed(modes, index, ratio),
    )


def _why_missed(modes: ModeParticipation, index: int, ratio: float) -> str:
    if 10.0 * np.log10(max(ratio, 1e-30)) >= VISIBLE_DB:
        return ''
    if not len(modes.channel_names):
        return 'no sensor'
    seen = np.max(np.abs(modes.response[:, index]))
    largest = np.max(np.abs(modes.response))
    if seen < 0.03 * largest:
        return 'no sensor moves with it'
    drive = np.abs(modes.drive[index])
    if np.max(drive) < 0.03 * np.max(np.abs(modes.drive)):
        return 'no joint drives it in this pose'
    strongest = modes.joint_names[int(np.argmax(drive))]
    return f'too little excitation at its frequency; {strongest} drives it most'


@dataclass(frozen=True, slots=True)
class ModeStd:
    """Smallest standard deviations of one mode.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the natural frequency.
    damping_ratio : float
        Of the damping ratio.
    """

    frequency_hz: float
    damping_ratio: float


def cramer_rao_std(
    frequency_hz: float, damping_ratio: float, force_to_noise: float, duration_s: float
) -> ModeStd:
    """Return the Cramér-Rao bound of a mode seen above noise.

    Along the mode shape the periodogram of the record has the expectation
    E(f) = S D(f; f₀, ζ) + N with D the acceleration response, and each of its lines carries the
    information ∂ln E ∂ln E.  Summed over the lines around the resonance and inverted for
    (ln f₀, ln ζ, ln S).  Without noise it is Au's law σ_f/f = sqrt(ζ/(2π f T)),
    σ_ζ/ζ = 1/sqrt(2π f ζ T), a little above it for the finite band.

    Parameters
    ----------
    frequency_hz, damping_ratio : float [Hz], [-]
        The mode.
    force_to_noise : float
        Sum over channels of response² times modal force density over noise density.
    duration_s : float [s]
        Length of the record.

    References
    ----------
    Whittle (1953); Au (2014), Uncertainty law in ambient modal identification,
    doi:10.1016/j.ymssp.2013.07.016.
    """
    half_width = min(BANDWIDTHS * damping_ratio, 0.95)
    ratio = np.linspace(1.0 - half_width, 1.0 + half_width, N_INTEGRATION)
    gap, loss = 1.0 - ratio**2, 2.0 * damping_ratio * ratio
    squared = gap**2 + loss**2
    signal = force_to_noise * ratio**4 / squared
    of_signal = signal / (signal + 1.0)
    # d ln D with D = r⁴ / squared and r = f / f₀.
    by_ratio = 4.0 - (-4.0 * gap * ratio**2 + 2.0 * loss**2) / squared
    slopes = of_signal[:, None] * np.column_stack(
        (-by_ratio, -2.0 * loss**2 / squared, np.ones_like(ratio))
    )
    lines_per_step = duration_s * frequency_hz * (ratio[1] - ratio[0])
    information = slopes.T @ slopes * lines_per_step
    if np.linalg.cond(information) > 1e14:
        return ModeStd(float('inf'), float('inf'))
    covariance = np.linalg.inv(information)
    return ModeStd(
        frequency_hz=frequency_hz * float(np.sqrt(covariance[0, 0])),
        damping_ratio=damping_ratio * float(np.sqrt(covariance[1, 1])),
    )
