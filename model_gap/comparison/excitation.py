"""What shook the arm, how well that is known, and what follows for the comparison."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_gap.campaign import Campaign
from model_gap.comparison.spectra_pairs import SpectraPair, used_bands
from model_gap.comparison.thresholds import LIMITS


@dataclass(frozen=True)
class BandMotion:
    """The known motion in one band, over all joints and recordings.

    Parameters
    ----------
    low_hz, high_hz : float [Hz]
        The band.
    motion, noise : float [rad/s²]
        Root mean square of the joint accelerations, and of their noise.
    """

    low_hz: float
    high_hz: float
    motion: float
    noise: float

    @property
    def noise_share(self) -> float:
        """Noise over motion."""
        return self.noise / self.motion if self.motion > 0.0 else float('inf')


@dataclass(frozen=True)
class Excitation:
    """The known excitation.

    Parameters
    ----------
    source : str
        What it was taken from.
    rate_hz, highest_hz : float [Hz]
        Of the joint states; up to where they are used.
    effort_recorded : bool
        Joint efforts are there; they are not needed for the comparison.
    bands : tuple of BandMotion
        Motion and noise by band.
    statement : tuple of str
        What limits the comparison, for people.
    """

    source: str
    rate_hz: float
    highest_hz: float
    effort_recorded: bool
    bands: tuple[BandMotion, ...]
    statement: tuple[str, ...]


def excitation(campaign: Campaign, pairs: Sequence[SpectraPair]) -> Excitation:
    """State what excitation is known, and how well."""
    bands = tuple(_band(pairs, low, high) for low, high in used_bands(pairs))
    said = [
        f'The excitation is the motor-side motion from recorded {campaign.excitation}'
        f' at {campaign.motion_rate_hz:.0f} Hz, used up to {campaign.motion_band_hz:.0f} Hz;'
        f' the command is not used. Joint efforts were '
        f'{"recorded, and are not needed" if campaign.effort_recorded else "not recorded"}.'
    ]
    for limit, text in (
        (LIMITS.lost, 'nothing can be concluded there'),
        (LIMITS.weak, 'small differences there are noise of the joint states, and count as such'),
    ):
        weak = [band for band in bands if band.noise_share > limit]
        weak = (
            weak
            if limit == LIMITS.lost
            else [band for band in weak if band.noise_share <= LIMITS.lost]
        )
        if weak:
            names = ', '.join(f'{band.low_hz:g}–{band.high_hz:g} Hz' for band in weak)
            worst = max(min(band.noise_share, 10.0) for band in weak)
            said.append(
                f'In {names} the noise of the motion is {100.0 * worst:.0f} % of it: {text}.'
            )
    if len(said) == 1:
        worst = max((band.noise_share for band in bands), default=0.0)
        said.append(f'Its noise is at most {100.0 * worst:.2g} % of the motion in every band.')
    return Excitation(
        source=campaign.excitation,
        rate_hz=campaign.motion_rate_hz,
        highest_hz=campaign.motion_band_hz,
        effort_recorded=campaign.effort_recorded,
        bands=bands,
        statement=tuple(said),
    )


def _band(pairs: Sequence[SpectraPair], low: float, high: float) -> BandMotion:
    motion, noise = [], []
    for pair in pairs:
        inside = pair.inside(low, high)
        if not inside.any():
            continue
        record = pair.item.record
        spectra = pair.item.motor_acceleration[:, inside, 1]
        motion.append(np.mean(np.sum(np.abs(spectra) ** 2, axis=0)) / record.sample_rate_hz)
        density = record.motion_noise.acceleration_density(pair.item.omega[inside, 1])
        noise.append(float(np.mean(density.sum(axis=0))) if density.size else 0.0)
    width = 2.0 * (high - low)
    return BandMotion(
        low, high, float(np.sqrt(np.mean(motion) * width)), float(np.sqrt(np.mean(noise) * width))
    )
