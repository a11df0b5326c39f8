"""A sensor is heavy enough to load the arm."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.places import unused_name
from model_gap.effects.sensor_effect import SensorEffect
from structural_model.description import MassSpec


class SensorMass(SensorEffect):
    """M += m_s J_sᵀJ_s."""

    type = 'sensor_mass'
    equation = 'M += m_s J_sᵀJ_s'
    source = 'mass loading; Ewins (2000), Modal Testing, sec. 3.4'
    signature = 'modes that move the sensor fall slightly'
    says = '{place} weighs {mass:.3g} kg itself'
    moves_poles = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'payload': 'move the sensor to the neighbouring link: the shift goes with it',
        'joint_stiffness': 'take the sensor off and repeat',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the mass."""
        return (EffectParameter('mass', 'kg', 1.0, 0.0, 12.0),)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Fix the mass where the sensor is."""
        row = next(iter(self.rows(cell).values()))
        channel = cell.channels[row]
        name = unused_name(f'gap_{self.sensor}', cell.spec.masses)
        item = MassSpec(name, channel.frame_id, values[0], channel.position_m)
        return cell.with_spec(dataclasses.replace(cell.spec, masses=(*cell.spec.masses, item)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return a few masses."""
        return [(0.5,), (1.5,), (4.0,)]
