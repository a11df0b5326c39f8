"""What the measuring chain did to force and responses, and both without it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from impact_testing.measuring_chain.corner import Corner
from impact_testing.measuring_chain.delay import earlier, force_delay, ForceDelay
from impact_testing.measuring_chain.response_corner import without_corner
from impact_testing.responses import PointData, PointFrf, PointSpectra

ALIKE = 3.0
"""Deviations by which two corners differ that are one."""


@dataclass(frozen=True, slots=True)
class MeasuringChain:
    """What force and responses passed.

    Parameters
    ----------
    of_force, of_responses : Corner
        High-passes; those that are sure were undone.
    delay : ForceDelay
        Of the force against the responses; taken out where it is sure.
    """

    of_force: Corner
    of_responses: Corner
    delay: ForceDelay

    def doubt(self, frequency_hz: float) -> float:
        """Return how wrong sizes of responses may be for a corner, as a share.

        A corner c makes responses 1 - |H| = (c / f)² / 2 too small.  Where phases do not tell,
        they may have passed what the force did.  Two corners, of sensor and converter, turn
        phases as one of their sum does, and make responses smaller by up to half as much: one
        like the force's is no sum.
        """
        force, own = self.of_force, self.of_responses
        if not own.sure:
            return 0.5 * (force.hz / frequency_hz) ** 2 if force.sure else 0.0
        alike = force.sure and abs(own.hz - force.hz) < ALIKE * np.hypot(own.std_hz, force.std_hz)
        of_two = 0.0 if alike else 0.125 * own.hz**2
        return float(np.hypot(of_two, own.hz * own.std_hz)) / frequency_hz**2


def without_chain(
    spectra: Sequence[PointSpectra], lines: slice, of_force: Corner
) -> tuple[list[PointData], MeasuringChain]:
    """Return FRFs as they are without what responses passed, and the force's delay.

    Parameters
    ----------
    spectra : sequence of PointSpectra
        Their forces are without what these passed.
    lines : slice
        Of the band.
    of_force : Corner
        That was undone, where it is sure.
    """

    def undone(corner: Corner) -> list[PointData]:
        clear = [each.with_corner(2.0 * np.pi * corner.hz) for each in spectra]
        return [PointData.of(PointFrf(each), lines) for each in clear]

    data = [PointData.of(PointFrf(each), lines) for each in spectra]
    data, corner = without_corner(data, undone, of_force)
    delay = force_delay(data)
    return (
        earlier(data, delay.seconds) if delay.sure else data,
        MeasuringChain(of_force, corner, delay),
    )
