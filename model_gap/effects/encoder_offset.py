"""The zero of an encoder is not where the model has it: the arm stands otherwise than recorded."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, Nuisance, offset_joint
from model_gap.effects.effect import Effect, EffectParameter, Scene


class EncoderOffset(Effect):
    """q_j → q_j + δ in every pose."""

    type = 'encoder_offset'
    equation = 'q_j -> q_j + δ, in every pose alike'
    source = 'zero errors of joints; Mooring, Roth and Driels (1991), Manipulator Calibration'
    signature = 'static gravity is turned about one joint in all sensors beyond it; modes follow'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_rotation': 'a pose with the wrist turned by 90°: the mount turns, the joint stays',
        'joint_stiffness': 'read static gravity with the joint 45° and 135° from upright',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per joint that turns."""
        joints = scene.model.robot.joints
        return [cls(joint.name) for joint in joints if not joint.prismatic]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return how much further the joint stands than it says."""
        return (EffectParameter('offset', 'rad', 0.05, -0.35, 0.35),)

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return it in degrees."""
        size = np.degrees(numbers['offset'])
        return f'The encoder of {place} reads wrong: the joint stands {size:+.2f}° further'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Turn what the joint carries."""
        return cell.with_spec(offset_joint(cell.spec, str(self.location), values[0]))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return the offset that the encoder's tolerance has come to."""
        own = (tolerance.what, tolerance.joint) == ('encoder', self.location)
        return [(tolerance.sigma * deviations,)] if own else ()

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return one and four degrees to either side."""
        return [(float(np.radians(angle)),) for angle in (-4.0, -1.0, 1.0, 4.0)]
