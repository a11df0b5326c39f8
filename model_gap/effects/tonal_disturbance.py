"""A machine hums: a steady line that the motion does not explain."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, marked, Tone
from model_gap.effects.effect import Effect, EffectParameter, Scene

FORCE = 'force'
ORDERS = ', orders '
# Lines this close to a multiple of another are its harmonics [Hz].
SAME_LINE_HZ = 0.03
MOST_ORDERS = 6
DIVISORS = (1, 2, 3)


class TonalDisturbance(Effect):
    """A periodic torque in a joint or force on a link, free in amplitude in every record.

    Parameters
    ----------
    location : str
        Joint or link.
    variant : str
        Kind of place, and the harmonics when there are others than the first.
    line_hz : float or None [Hz]
        Where the fundamental was seen; None: the strongest line of a scene.
    """

    type = 'tonal_disturbance'
    equation = 'f(t) = Re sum_n F_rn exp(i n ω t) in record r, at one place'
    source = 'harmonic disturbance; Brincker and Ventura (2015), Introduction to OMA, sec. 7.2'
    signature = 'a line at a fixed frequency in every pose and level, not coherent with the motion'
    says = 'Something shakes {place} steadily at {frequency:.4g} Hz'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {
        'transmission_error': 'change the joint speed by 20 %: the lines move in proportion',
        'tuned_mass': 'switch the excitation off: a tone stays',
        'tonal_disturbance': 'switch off one machine after the other',
    }

    def __init__(
        self, location: str | None = None, variant: str = '', line_hz: float | None = None
    ) -> None:
        super().__init__(location, variant)
        self.line_hz = line_hz
        self.kind, _, orders = variant.partition(ORDERS)
        self.orders = tuple(int(order) for order in orders.split()) or (1,)

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per family of lines and flexible joint or moving link."""
        places = [*scene.joint_places, *((link, FORCE) for link in scene.model.link_names[1:])]
        return [
            cls(location, kind + _orders(orders), line)
            for line, orders in families(scene.lines_hz)
            for location, kind in places
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the frequency; amplitudes are found record by record."""
        line = self.line_hz or scene.lines_hz[0]
        return (EffectParameter('frequency', 'Hz', 0.01, 0.97 * line, 1.03 * line, line),)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the lines."""
        place = str(self.location)
        force = self.kind == FORCE
        where = place if force else marked(place, self.kind)
        tone = Tone(values[0], where, force, self.orders)
        return dataclasses.replace(cell, tones=(*cell.tones, tone))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the line that was seen."""
        return [(self.line_hz or scene.lines_hz[0],)]

    @property
    def free_numbers(self) -> int:
        """An amplitude and a phase of every harmonic, along every axis."""
        return 2 * len(self.orders) * (3 if self.kind == FORCE else 1)


def families(lines_hz: Sequence[float]) -> list[tuple[float, tuple[int, ...]]]:
    """Return fundamentals and their harmonics among lines, strongest line first."""
    left = list(lines_hz)
    found = []
    while left:
        tries = [(left[0] / divisor, _multiples(left[0] / divisor, left)) for divisor in DIVISORS]
        line, members = max(tries, key=lambda item: len(item[1]))
        found.append((line, tuple(sorted(members))))
        left = [other for other in left if other not in members.values()]
    return found


def _multiples(line: float, lines: Sequence[float]) -> dict[int, float]:
    orders = {round(other / line): other for other in reversed(lines)}
    return {
        order: other
        for order, other in orders.items()
        if 1 <= order <= MOST_ORDERS and abs(other - order * line) < SAME_LINE_HZ
    }


def _orders(orders: Sequence[int]) -> str:
    return '' if tuple(orders) == (1,) else ORDERS + ' '.join(map(str, orders))
