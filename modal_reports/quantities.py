"""The quantities of modal analysis: their names, their units for people, their numbers."""

from dataclasses import dataclass, replace
import math

from modal_reports.numbers import deviation_text, Number, value_text, with_sigma
from modal_reports.words import capital


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number is.

    Parameters
    ----------
    name : str
        In the field's words.
    unit : str
        For people; empty for none.
    factor : float
        Times this the number in SI units (a fraction, rad, s) is in that unit.
    """

    name: str
    unit: str = ''
    factor: float = 1.0

    @property
    def label(self) -> str:
        """Name and unit."""
        return f'{self.name} [{self.unit}]' if self.unit else self.name

    @property
    def heading(self) -> str:
        """Name and unit, with a capital."""
        return capital(self.label)

    def of(self, what: str) -> 'Quantity':
        """Return the quantity of something: ``measured frequency``."""
        return replace(self, name=f'{what} {self.name}')

    def text(self, value: Number, std: Number = None) -> str:
        """Return a value with deviation and unit: ``3.420 ± 0.018 Hz``."""
        return with_sigma(self._shown(value), self._shown(std), self.unit)

    def number(self, value: Number, std: Number = None) -> str:
        """Return a value with its deviation, for a column that has the unit above it."""
        return with_sigma(self._shown(value), self._shown(std))

    def pair(self, value: Number, std: Number) -> tuple[str, str]:
        """Return value and deviation apart, rounded together."""
        shown, deviation = self._shown(value), self._shown(std)
        return value_text(shown, deviation), deviation_text(shown, deviation)

    def _shown(self, number: Number) -> Number:
        return None if number is None else self.factor * number


FREQUENCY = Quantity('frequency', 'Hz')
DAMPING = Quantity('damping', '%', 100.0)
MPC = Quantity('MPC')
MPD = Quantity('MPD', '°', math.degrees(1.0))
MAC = Quantity('MAC')
PHASE = Quantity('phase', '°', math.degrees(1.0))
