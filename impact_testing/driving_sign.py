"""Whether a point that is said to be hit answers as one does: with the force, in every mode.

At the point that is struck, in its direction, a mode of a passive structure with symmetric
matrices answers with the sign of its mass: 2j ω_d R = φ² / m.  Modes with it and modes against it
say that the hammer struck elsewhere; all against it say that force or sensor has the other sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit import ModalModel, refitted
from impact_testing.modes import driving_phase, nearer_than_told
from impact_testing.responses import PointData

Real = NDArray[np.float64]
BEYOND = 5.0
"""Deviations of its phase by which a mode is off a quarter turn: of Gaussian ones one in three
million is so far off.  Of 42 healthy random tests (0.5 to 5 %, 2 to 5 modes) none was blamed."""
QUARTER = 0.25 * np.pi
"""A mode within so much of a real one, or of one against it, says something; complex ones of close
pairs between do not."""


@dataclass(frozen=True, slots=True)
class DrivingSign:
    """How modes answer at a point that is said to be hit.

    Parameters
    ----------
    point : int
        Number of the recording.
    name : str
        Channel.
    with_hz, against_hz : tuple of float [Hz]
        Modes that answer with the force, and against it.
    """

    point: int
    name: str
    with_hz: tuple[float, ...]
    against_hz: tuple[float, ...]

    @property
    def mixed(self) -> bool:
        """Whether no driving point is like this."""
        return bool(self.with_hz and self.against_hz)


def driving_signs(
    data: Sequence[PointData], model: ModalModel, reported: Sequence[int]
) -> tuple[DrivingSign, ...]:
    """Return how the reported modes answer at each driving point.

    Modes within the half-width of another are left out: their shapes turn into one another.
    """
    places, near = model.places, nearer_than_told(model.pole)
    covariances = model.covariances()
    found = []
    for number, (each, place) in enumerate(zip(data, places.into, strict=True)):
        if place >= places.n_channels:
            continue
        hz: tuple[list[float], list[float]] = ([], [])
        for mode in (n for n in reported if not near[n]):
            pole = complex(model.pole[mode])
            phase, std = _phase(pole, complex(model.shape[mode, place]), place, covariances[mode])
            off = min(phase, np.pi - phase)
            if off < QUARTER and 0.5 * np.pi - off > BEYOND * std:
                hz[int(phase > 0.5 * np.pi)].append(abs(pole) / (2.0 * np.pi))
        name = each.frf.spectra.record.point
        found.append(DrivingSign(number, name, tuple(hz[0]), tuple(hz[1])))
    return tuple(found)


def without_wrong_points(
    data: Sequence[PointData], model: ModalModel, signs: Sequence[DrivingSign]
) -> ModalModel:
    """Give points that are no driving points places of their own, so that they scale nothing.

    One whose modes all answer against the force is none where another's all answer with it.
    """
    some_with = any(each.with_hz for each in signs)
    wrong = [each.point for each in signs if each.mixed or (each.against_hz and some_with)]
    return refitted(data, model, wrong) if wrong else model


def all_against(signs: Sequence[DrivingSign]) -> bool:
    """Tell whether every mode at every driving point answers against the force."""
    return any(each.against_hz for each in signs) and not any(each.with_hz for each in signs)


def turned(data: Sequence[PointData]) -> list[PointData]:
    """Return points whose forces have the other sign."""
    found = []
    for each in data:
        spectra = each.frf.spectra
        pulses = [replace(pulse, force_n=-pulse.force_n) for pulse in spectra.pulses]
        record = replace(spectra.record, force_n=-spectra.record.force_n)
        fresh = replace(spectra.with_force(pulses), record=record)
        frf = replace(each.frf, spectra=fresh)
        found.append(replace(each, frf=frf, corrected_n=-each.corrected_n))
    return found


def remarks_on_signs(signs: Sequence[DrivingSign]) -> tuple[str, ...]:
    """Return what is to be said of them."""
    said = []
    for each in signs:
        if each.mixed:
            few = min(each.with_hz, each.against_hz, key=len)
            at = ', '.join(f'{hz:.4g}' for hz in few)
            said.append(
                f'at {each.name} the answer to the force has one sign in the'
                f' mode{"s" if len(few) > 1 else ""} at {at} Hz and the other in the rest: no'
                ' point that is struck answers so, the hammer struck elsewhere; name the channel'
                ' at the point that was hit'
            )
    if all_against(signs):
        names = ', '.join(dict.fromkeys(each.name for each in signs if each.against_hz))
        said.append(
            f'force and response have opposite signs at {names} in every mode: the force was'
            ' turned round; check the polarity of hammer and sensor, or put - before the channel'
            ' where the hammer struck against it'
        )
    return tuple(said)


def _phase(pole: complex, value: complex, place: int, covariance: Real) -> tuple[float, float]:
    """Return the size of the phase of 2j ω_d ψ² / p² and its standard deviation [rad]."""
    direction = np.zeros(len(covariance))
    direction[2 * place : 2 * place + 2] = np.array([-value.imag, value.real]) / abs(value) ** 2
    direction[-2:] = np.array([pole.imag, -pole.real]) / abs(pole) ** 2
    phase = abs(driving_phase(pole, value))
    return phase, 2.0 * float(np.sqrt(direction @ covariance @ direction))
