"""A link bends or twists."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.effects.base_compliance import softest
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.setup import Setup
from structural_model.spec import HingeSpec, Spring

AXES = {'x': (1.0, 0.0, 0.0), 'y': (0.0, 1.0, 0.0), 'z': (0.0, 0.0, 1.0)}


class LinkFlexibility(Effect):
    """A virtual hinge half-way along the link, about one of its axes."""

    type = 'link_flexibility'
    equation = 'virtual hinge with 1/k = c about one axis of the link'
    source = 'virtual joints; Mousavi et al. (2018), doi:10.1007/s00170-017-0052-0'
    signature = 'relative motion inside one link, out of reach of the joints'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'turn the next joint by 90°: its axis leaves the bending plane',
        'base_compliance': 'two sensors on the link, one at each end',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per axis of every link with a span."""
        return [
            cls(link, axis)
            for link, place in spans(scene)
            if not _divided(scene, link)
            for axis in AXES
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the compliance and how lossy it is."""
        unit = 0.3 / softest(scene)
        return (
            EffectParameter('compliance', 'rad/(N m)', unit, 0.0, 300.0 * unit),
            EffectParameter('loss_time', 's', 0.7, 1e-5, 1e-2, neutral=4e-4, log=True),
        )

    def probe(self, setup: Setup, scene: Scene) -> tuple[Setup, str] | None:
        """Return the hinge, all but rigid."""
        stiff = (1e-4 * 0.3 / softest(scene), 4e-4)
        return self.apply(setup, stiff, scene), self.name

    @property
    def name(self) -> str:
        """Name of the hinge."""
        return f'gap_{self.location}_{self.variant}'

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Divide the link."""
        compliance, loss = max(values[0], 1e-14), values[1]
        hinge = HingeSpec(
            name=self.name,
            link=str(self.location),
            position_m=dict(spans(scene))[str(self.location)],
            axis=AXES[self.variant],
            spring=Spring(1.0 / compliance, loss / compliance),
        )
        return setup.with_spec(dataclasses.replace(setup.spec, hinges=(*setup.spec.hinges, hinge)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return compliances over three decades."""
        unit = 0.3 / softest(scene)
        return [(float(unit * f), 4e-4) for f in np.geomspace(0.02, 60.0, 16)]


def spans(scene: Scene) -> list[tuple[str, tuple[float, float, float]]]:
    """Return every moving link with the middle of its way to the next joint."""
    robot = scene.model.robot
    found = []
    frames = {
        int(f.parentJoint): f.name
        for f in reversed(list(robot.model.frames))
        if f.type.name == 'BODY'
    }
    for index in range(1, len(robot.joints)):
        place = np.array(robot.model.jointPlacements[index + 1].translation)
        if np.linalg.norm(place) > 0.05:
            middle = place / 2.0
            found.append((frames[index], (float(middle[0]), float(middle[1]), float(middle[2]))))
    return found


def _divided(scene: Scene, link: str) -> bool:
    spec = scene.setup.spec
    taken = [item.link for item in spec.beams] + [item.link for item in spec.hinges]
    return link in taken
