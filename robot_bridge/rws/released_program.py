"""A program as it was released, and whether a controller holds that and no other."""

from collections.abc import Sequence
from dataclasses import dataclass
import re

from modal_core.errors import BridgeError

# Written in front of a module by some controllers.
FILE_HEADER = re.compile(r'\A\s*%%%.*?%%%', re.DOTALL)
# In a text in quotes ! is a letter.
COMMENT = re.compile(r'(?P<text>"[^"\n]*")|![^\n\r]*')


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
        """Tell whether a text is this module, letter for letter but for case and spaces.

        Comments and what is played are compared apart: a comment whose line did not end where it
        ended takes in the statement behind it, with the same letters.
        """
        return all(read(found) == read(self.text) for read in (_letters, _played))

    def check_place(self, axes_deg: Sequence[float]) -> None:
        """Refuse an arm that stands elsewhere.

        Raises
        ------
        BridgeError
            An axis away from the start of the plan.
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


def _played(text: str) -> str:
    return _letters(COMMENT.sub(lambda match: match['text'] or ' ', text))


def _letters(text: str) -> str:
    return ''.join(FILE_HEADER.sub('', text).split()).casefold()
