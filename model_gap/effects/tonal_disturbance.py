"""A machine hums: a steady line that the motion does not explain."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.joint_vector import marked
from model_gap.setup import Setup, Tone

FORCE = 'force'


class TonalDisturbance(Effect):
    """A sinusoidal torque in a joint or force on a link, free in amplitude in every record."""

    type = 'tonal_disturbance'
    equation = 'f(t) = Re F_r exp(i ω t) in record r, at one place'
    source = 'harmonic disturbance; Brincker and Ventura (2015), Introduction to OMA, sec. 7.2'
    signature = 'a line at a fixed frequency in every pose and level, not coherent with the motion'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {
        'transmission_error': 'change the joint speed by 20 %: the lines move in proportion',
        'tuned_mass': 'switch the excitation off: a tone stays',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint and one per moving link, when a line was seen."""
        if not scene.lines_hz:
            return []
        joints = [cls(*place) for place in scene.joint_places]
        return joints + [cls(link, FORCE) for link in scene.model.link_names[1:]]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the frequency; amplitudes are found record by record."""
        line = scene.lines_hz[0]
        return (EffectParameter('frequency', 'Hz', 0.01, 0.97 * line, 1.03 * line, line),)

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Add the line."""
        place = str(self.location)
        force = self.variant == FORCE
        tone = Tone(values[0], place if force else marked(place, self.variant), force)
        return dataclasses.replace(setup, tones=(*setup.tones, tone))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the line that was seen."""
        return [(scene.lines_hz[0],)]
