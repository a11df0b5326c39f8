"""A program as it was released, and whether a controller holds that and no other."""

from collections.abc import Sequence
from dataclasses import dataclass
import re

from modal_core.errors import BridgeError

# Written in front of a module by some controllers.
FILE_HEADER = re.compile(r'\A\s*%%%.*?%%%', re.DOTALL)
# What stands for an axis that is not there.
NOT_CONNECTED = 1e8


@dataclass(frozen=True, slots=True)
class ReleasedProgram:
    """A module, and where the arm must stand when it is started.

    Parameters
    ----------
    name, text : str
        Of the module.
    start_deg : (6,) tuple [deg]
        Axis angles at the start of the plan.
    tolerance_deg : float [deg]
        Largest distance of any axis from it.
    """

    name: str
    text: str
    start_deg: tuple[float, ...]
    tolerance_deg: float

    def is_text(self, found: str) -> bool:
        """Tell whether a text is this module, letter for letter but for case and spaces."""
        return _letters(found) == _letters(self.text)

    def check_place(self, axes_deg: Sequence[float], external: Sequence[float]) -> None:
        """Refuse an arm that stands elsewhere.

        Raises
        ------
        BridgeError
            An axis away from the start of the plan, or an external axis it says nothing of.
        """
        for number, (found, start) in enumerate(zip(axes_deg, self.start_deg, strict=True), 1):
            # Written so that NaN is refused too.
            if not abs(found - start) <= self.tolerance_deg:
                raise BridgeError(
                    f'axis {number} is not at the start pose of the plan',
                    where='jointtarget',
                    found=f'{found:.3f} deg',
                    expected=f'{start:.3f} +- {self.tolerance_deg:g} deg',
                    advice='jog there, or release and run an approach plan',
                )
        for letter, place in zip('abcdef', external, strict=True):
            if not abs(place) > NOT_CONNECTED:
                raise BridgeError(
                    f'there is an external axis {letter}, of which the plan says nothing',
                    where='jointtarget',
                    found=f'{place:g}',
                    expected='none',
                    advice='deactivate it, or load and start the module at the pendant',
                )


def _letters(text: str) -> str:
    return ''.join(FILE_HEADER.sub('', text).split()).casefold()
