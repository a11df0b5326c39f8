"""What gravity names and puts right before the dynamics, with what vibration tells of it then."""

from collections.abc import Collection, Sequence
import dataclasses

import numpy as np

from model_gap.cell import encoder_of
from model_gap.decide import Decision, Verdict
from model_gap.fit import Fit
from model_gap.gravity import Fault, Kind
from structural_model.description import KnownEffect, KnownNumber

# Deviations: an offset that is no more than that may be none.
CLEARLY = 3.0
Number = tuple[float, float]


def named_at_rest(faults: Sequence[Fault], fit: Fit | None) -> tuple[KnownEffect, ...]:
    """Return units and encoder offsets as effects.

    What else is wrong with one sensor's axes or mount is named by what vibration shows of it.

    Parameters
    ----------
    faults : sequence of Fault
        What gravity shows.
    fit : Fit or None
        Of the arm as gravity has put it right, its encoders free.
    """
    units = [fault.place for fault in faults if fault.kind is Kind.UNIT]
    found = [KnownEffect('sensor_unit', f'sensor:{place}', kept_in='layout') for place in units]
    for joint, (value, sigma) in _offsets(faults, fit).items():
        if abs(value) > CLEARLY * sigma:
            number = KnownNumber('offset', value, sigma, 'rad')
            found.append(KnownEffect('encoder_offset', joint, parameters=(number,)))
    return tuple(found)


def _offsets(faults: Sequence[Fault], fit: Fit | None) -> dict[str, Number]:
    """Return the offset of every encoder that may be wrong, and its deviation [rad]."""
    wrong = [fault for fault in faults if fault.kind is Kind.ENCODER]
    found = {fault.place: (fault.values[0], fault.sigma) for fault in wrong}
    if fit is None:
        return found
    size = len(fit.hypothesis.tolerances)
    covariance = np.linalg.inv(fit.precision)[:size, :size]
    rivals = [fault.rival.place for fault in wrong if fault.rival]
    for number, item in enumerate(fit.hypothesis.tolerances):
        for joint in dict.fromkeys((*found, *rivals)):
            if item.name == encoder_of(joint):
                more = item.sigma * float(fit.hypothesis.tolerance_values[number])
                sigma = item.sigma * float(np.sqrt(covariance[number, number]))
                found[joint] = found.get(joint, (0.0, 0.0))[0] + more, sigma
    return found


def with_faults(decision: Decision, faults: Sequence[Fault], fit: Fit | None) -> Decision:
    """Return a verdict that counts what gravity named and put right before the dynamics."""
    untold = [fault.words() for fault in faults if fault.kind is Kind.UNTOLD]
    if untold:
        reasons = (*decision.reasons, *untold)
        return dataclasses.replace(decision, verdict=Verdict.UNEXPLAINED, reasons=reasons)
    too_little = decision.verdict is Verdict.NONE and bool(decision.experiments)
    own = named_at_rest(faults, fit)
    places = {str(item.effect.location) for item in decision.accepted}
    open_ = [fault for fault in faults if not _settled(fault, own, places)]
    telling = tuple(fault.telling for fault in open_)
    decision = dataclasses.replace(
        decision,
        experiments=(*decision.experiments, *telling),
        only_places=decision.only_places and not open_,
    )
    if not own or decision.verdict in (Verdict.UNEXPLAINED, Verdict.AMBIGUOUS):
        return decision
    if too_little or open_:
        reasons = (*decision.reasons, *(fault.words() for fault in open_))
        return dataclasses.replace(decision, verdict=Verdict.AMBIGUOUS, reasons=reasons)
    return dataclasses.replace(decision, verdict=Verdict.NAMED)


def _settled(fault: Fault, found: Sequence[KnownEffect], places: Collection[str]) -> bool:
    """Return whether it is the only explanation, or vibration tells which of two it is.

    A sensor that was put right by its unit and were not in g would read ten times too much.
    """
    if fault.rival is None or fault.kind not in (Kind.ENCODER, Kind.UNIT):
        return True
    if fault.kind is Kind.UNIT:
        return f'sensor:{fault.place}' not in places
    two = {fault.place, fault.rival.place}
    encoders = fault.rival.kind is Kind.ENCODER
    return encoders and len(two & {effect.location for effect in found}) == 1
