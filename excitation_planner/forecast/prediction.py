"""What the planner foresees of a plan, in more detail than the message carries."""

from dataclasses import dataclass

from excitation_planner.bounds import Envelope
from excitation_planner.forecast.participation import ModeForecast
from excitation_planner.forecast.torque_projection import TorqueProjection
from excitation_planner.motion import PredictedSpectrum, Whiteness


@dataclass(frozen=True, slots=True)
class PlanPrediction:
    """Forecast of one plan.

    Parameters
    ----------
    spectrum : PredictedSpectrum
        Of the joint accelerations.
    whiteness : tuple of Whiteness or None
        Per joint in the excited band; None for a joint that does not move.
    flatness_db : float [dB]
        Largest over smallest density in the excited band.
    projection : TorqueProjection
        D(τ) of the torques on the structure, where on the path it is weakest.
    modes : tuple of ModeForecast
        Every model mode up to the asked frequency, also those that would be missed.
    envelope : Envelope
        Largest use of every limit.
    sliding_share : tuple of float
        Part of the time each controller axis slides: has gone through presliding since it turned.
    notices : tuple of str
        What a person should know before releasing the plan.
    """

    spectrum: PredictedSpectrum
    whiteness: tuple[Whiteness | None, ...]
    flatness_db: float
    projection: TorqueProjection
    modes: tuple[ModeForecast, ...]
    envelope: Envelope
    sliding_share: tuple[float, ...] = ()
    notices: tuple[str, ...] = ()

    @property
    def missed(self) -> tuple[ModeForecast, ...]:
        """Modes the plan would not show at the given sensors."""
        return tuple(mode for mode in self.modes if mode.missed)
