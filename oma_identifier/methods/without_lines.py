"""Methods that take the lines of machines out of the samples, then identify what is left.

Lines that move with a speed are followed first (:mod:`oma_identifier.moving_lines`).  Lines of
constant frequency are then found among the poles as by every method; where there are any they are
fitted and taken out too, and what is left is identified again.

Left in, lines bend modes of subspaces and autoregressive models many half-widths away, by more
than scatter tells: 60 s of 12 milled structures with steady lines (simulated), frequencies more
than 3 deviations off before and after: ssi_data 7 of 39, 1 of 45; var 4 of 36, 1 of 45.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.methods.banded import BandedMethod
from oma_identifier.motion import never, PeakTest
from oma_identifier.moving_lines import Gain, with_moving, without_moving
from oma_identifier.selection import Identified, is_same_line, with_lines
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import without_lines

Real = NDArray[np.float64]


@dataclass(frozen=True)
class WithoutLines:
    """Takes lines out, then asks another method, whose standard deviations it has.

    Parameters
    ----------
    name : str
        As in settings and results.
    method : BandedMethod
        Asked what is in the samples that are left.
    gain : callable
        By which lines that move are taken out.
    """

    name: str
    method: BandedMethod
    gain: Gain
    needs_inputs: ClassVar[bool] = False

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: Real | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch."""
        left, moving = without_moving(samples, self.gain)
        found = self.method.identify(left, settings, None, explains)
        lines_hz = tuple(found.sure_lines_hz)
        if lines_hz:
            again = self.method.identify(without_lines(left, lines_hz), settings, None, explains)
            found = with_lines(again, [one for one in found.harmonics if _is_new(one, again)])
        found = with_moving(found, moving)
        return replace(
            found,
            modes=replace(found.modes, method=self.name),
            harmonics=replace(found.harmonics, method=self.name),
        )


def _is_new(line: Mode, found: Identified) -> bool:
    return not any(is_same_line(line.frequency_hz, one.frequency_hz) for one in found.harmonics)
