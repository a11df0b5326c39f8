"""The catalogue of physical effects: one file per effect, one explicit list.

In comes a robot model; out go its variants with an effect at a place and of a size.  An effect
changes masses, springs and dampers, adds a law of a joint, a line, or a fault of a sensor.
"""

from model_gap.effects.backlash import Backlash
from model_gap.effects.base_compliance import BaseCompliance
from model_gap.effects.cable import Cable
from model_gap.effects.clock_drift import ClockDrift
from model_gap.effects.command_delay import CommandDelay
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.cubic_damping import CubicDamping
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.effect import Effect, EffectParameter, Hanging, same, Scene
from model_gap.effects.encoder_offset import EncoderOffset
from model_gap.effects.end_stop import EndStop
from model_gap.effects.foundation_mode import FoundationMode
from model_gap.effects.gravity_compensator import GravityCompensator
from model_gap.effects.hysteresis import Hysteresis
from model_gap.effects.joint_damping import JointDamping
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.link_flexibility import LinkFlexibility
from model_gap.effects.load_friction import LoadFriction
from model_gap.effects.own_effects import GROUP, with_own_effects
from model_gap.effects.payload import Payload
from model_gap.effects.places import (
    arm_mass,
    centre,
    moving_links,
    on_link,
    reach,
    turned,
    turns,
)
from model_gap.effects.rod_spring import RodSpring
from model_gap.effects.sensor_axis_swap import SensorAxisSwap
from model_gap.effects.sensor_delay import delay_step, SensorDelay
from model_gap.effects.sensor_gain import SensorGain
from model_gap.effects.sensor_mass import SensorMass
from model_gap.effects.sensor_mount_resonance import SensorMountResonance
from model_gap.effects.sensor_polarity import SensorPolarity
from model_gap.effects.sensor_position import SensorPosition
from model_gap.effects.sensor_rotation import SensorRotation
from model_gap.effects.sensor_unit import SensorUnit
from model_gap.effects.servo_compliance import ServoCompliance
from model_gap.effects.speed_dependent_stiffness import SpeedDependentStiffness
from model_gap.effects.stiffness_drift import StiffnessDrift
from model_gap.effects.stribeck_friction import StribeckFriction
from model_gap.effects.tonal_disturbance import TonalDisturbance
from model_gap.effects.transmission_error import TransmissionError
from model_gap.effects.tuned_mass import swinging, TunedMass

CATALOGUE: tuple[type[Effect], ...] = (
    Payload,
    JointStiffness,
    JointDamping,
    BaseCompliance,
    FoundationMode,
    LinkFlexibility,
    RodSpring,
    GravityCompensator,
    ServoCompliance,
    TunedMass,
    Cable,
    CoulombFriction,
    StribeckFriction,
    LoadFriction,
    Backlash,
    CubicStiffness,
    SpeedDependentStiffness,
    Hysteresis,
    EndStop,
    CubicDamping,
    StiffnessDrift,
    TransmissionError,
    TonalDisturbance,
    CommandDelay,
    ClockDrift,
    EncoderOffset,
    SensorGain,
    SensorUnit,
    SensorPolarity,
    SensorAxisSwap,
    SensorRotation,
    SensorPosition,
    SensorDelay,
    SensorMountResonance,
    SensorMass,
)

__all__ = [
    'CATALOGUE',
    'GROUP',
    'Effect',
    'EffectParameter',
    'Hanging',
    'Scene',
    'arm_mass',
    'centre',
    'delay_step',
    'moving_links',
    'on_link',
    'reach',
    'same',
    'swinging',
    'turned',
    'turns',
    'with_own_effects',
]
