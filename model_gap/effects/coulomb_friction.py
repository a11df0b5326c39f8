"""Dry friction in one joint."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import BETWEEN_LINKS, CellModel, JointForce, marked
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.laws import FrictionLaw, JointFrictionLaw, JointLaw

WHOLE_JOINT = 'whole joint'
# In the gear, and on the whole joint.
Laws = tuple[type[JointLaw], type[JointLaw]]
# Of the joint's own compliance.  What gives way more is a lossy spring rather than friction.
MOST_YIELDING = 0.12


class CoulombFriction(DetailedEffect):
    """τ_c·tanh(v/v₀), v the twist rate of the gear or the speed of the whole joint.

    Before it slides it gives way like a spring, rigid until a fit is good.
    """

    type = 'coulomb_friction'
    equation = (
        "τ_f = τ_c tanh(w/v_0), w = v - p τ_f'/k, "
        "v = e' (in the gear) or q' + e' (between the links)"
    )
    source = 'Coulomb friction; Armstrong-Hélouvry et al. (1994), doi:10.1016/0005-1098(94)90209-7'
    signature = 'damping falls as amplitude rises; sticks at low amplitude; odd harmonics'
    says = '{place} has dry friction of {torque:.3g} N m'
    amplitude_dependent = True
    laws: ClassVar[Laws] = (FrictionLaw, JointFrictionLaw)
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_damping': 'a third, lower amplitude level: viscous damping keeps its ratio',
        'backlash': 'a pose with gravity off the joint: play rattles, friction does not',
        'cubic_stiffness': 'a third, lower level: friction then damps more',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return two per flexible joint: in the gear, and on the whole joint."""
        gear = [cls(*place) for place in scene.joint_places]
        whole = [cls(joint, WHOLE_JOINT) for joint in scene.flexible_joints]
        return gear + whole

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return level and transition speed, and how stiff it is before it slides."""
        first = (
            EffectParameter('torque', 'N m', 1.5, 0.05, 5000.0, neutral=20.0, log=True),
            EffectParameter('transition_speed', 'rad/s', 1.0, 2e-5, 0.1, neutral=1e-3, log=True),
        )
        return (*first, *self.presliding)

    @property
    def presliding(self) -> tuple[EffectParameter, ...]:
        """The compliance before it slides, where that is free."""
        if not self.details:
            return ()
        return (EffectParameter('presliding_compliance', '1', 0.05, 0.0, MOST_YIELDING),)

    @property
    def place(self) -> str:
        """Name of the joint torque."""
        whole = self.variant == WHOLE_JOINT
        return marked(str(self.location), BETWEEN_LINKS if whole else self.variant)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        return self.with_torque(cell, values[:2], values[2:])

    def with_torque(
        self, cell: CellModel, numbers: Sequence[float], presliding: Sequence[float]
    ) -> CellModel:
        """Return a cell with the torque, in the gear or on the whole joint; rigid unless free."""
        values = (*numbers, *(presliding or (0.0,)))
        law = self.laws[self.variant == WHOLE_JOINT]
        force = JointForce(self.place, law, values)
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return levels over two decades."""
        return [(level, 1e-3) for level in (4.0, 15.0, 50.0, 160.0, 500.0)]
