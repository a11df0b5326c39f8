"""What gears have beyond springs and dampers: the figures, and the effects that set them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from abb_emulator.mechanics.arm_effect import ArmEffect
from abb_emulator.mechanics.arm_structure import check_place
from abb_emulator.of_axes import of_axes
from modal_core.settings.schema import setting

N_AXES = 6
NONE = (0.0,) * N_AXES


@dataclass(frozen=True, slots=True)
class GearSettings:
    """Nonlinear torques of each drive, on controller axes; zeros are a linear arm.

    Parameters
    ----------
    friction_nm : (6,) tuple [N m]
        Coulomb friction against the rate of the twist.
    friction_speed_rad_s : float [rad/s]
        Rate at which friction is developed.
    backlash_rad : (6,) tuple [rad]
        Half of the free play.
    hardening_1_rad2 : (6,) tuple [1/rad²]
        α of k y (1 + α y²).
    speed_stiffness_s_rad : (6,) tuple [s/rad]
        β of k (1 + β |speed of the axis|).
    slip_share, slip_limit_rad : (6,) tuple, (6,) tuple [rad]
        A further spring of this share that slips at this twist (Dahl).
    stick_share, stick_limit_rad : (6,) tuple, (6,) tuple [rad]
        The same over the angle of the axis and the twist together: friction between links, which
        sticks while the joint stands and slides while it runs.
    drift_change, drift_time_s : (6,) tuple, (6,) tuple [s]
        k (1 + change (1 - exp(-t / time))) since the arm was switched on.
    """

    friction_nm: tuple[float, ...] = setting(
        NONE, 'Coulomb friction against the rate of the twist [N m]', 0.0, 1e6
    )
    friction_speed_rad_s: float = setting(
        1e-3, 'rate at which friction is developed [rad/s]', 1e-9, 100.0
    )
    backlash_rad: tuple[float, ...] = setting(NONE, 'half of the free play [rad]', 0.0, 1.0)
    hardening_1_rad2: tuple[float, ...] = setting(
        NONE, 'α of k y (1 + α y²) [1/rad²]', -1e12, 1e12
    )
    speed_stiffness_s_rad: tuple[float, ...] = setting(
        NONE, 'β of k (1 + β |speed of the axis|) [s/rad]', -1e6, 1e6
    )
    slip_share: tuple[float, ...] = setting(
        NONE, 'share of the stiffness of a further spring that slips', 0.0, 100.0
    )
    slip_limit_rad: tuple[float, ...] = setting(
        (1e-4,) * N_AXES, 'twist at which it slips [rad]', 1e-12, 1.0
    )
    stick_share: tuple[float, ...] = setting(
        NONE, 'share of the stiffness of a spring that a standing joint adds', 0.0, 100.0
    )
    stick_limit_rad: tuple[float, ...] = setting(
        (1e-3,) * N_AXES, 'travel of the joint at which that slips [rad]', 1e-12, 1.0
    )
    drift_change: tuple[float, ...] = setting(
        NONE, 'change of k (1 + change (1 - exp(-t / time))) since switched on', -1.0, 100.0
    )
    drift_time_s: tuple[float, ...] = setting(
        (600.0,) * N_AXES, 'time of that change [s]', 1e-3, 1e9
    )


# Effect: its values and the settings they are added to, or put in place of.
ADDED = {
    'coulomb_friction': {'torque': 'friction_nm'},
    'backlash': {'half_gap': 'backlash_rad'},
    'cubic_stiffness': {'alpha': 'hardening_1_rad2'},
    'speed_dependent_stiffness': {'beta': 'speed_stiffness_s_rad'},
    'hysteresis': {'share': 'slip_share'},
    'presliding': {'share': 'stick_share'},
    'thermal_drift': {'change': 'drift_change'},
}
REPLACED = {
    'hysteresis': {'limit': 'slip_limit_rad'},
    'presliding': {'limit': 'stick_limit_rad'},
    'thermal_drift': {'time_constant': 'drift_time_s'},
}


def gears_with_effects(
    settings: GearSettings, effects: Sequence[ArmEffect], joint_names: Sequence[str]
) -> GearSettings:
    """Return the settings with the effects that are torques in gears; others do nothing.

    An arm of another number of axes than six has as many values each; its gears have only what
    effects give them.

    Raises
    ------
    SettingsError
        No such joint, or settings of six axes for an arm that has other ones.
    """
    settings = of_axes(settings, len(joint_names))
    for effect in effects:
        if effect.type not in ADDED:
            continue
        check_place(effect, joint_names)
        axis = list(joint_names).index(effect.place)
        for table, keep in ((ADDED, 1.0), (REPLACED, 0.0)):
            for name, target in table.get(effect.type, {}).items():
                values = list(getattr(settings, target))
                values[axis] = keep * values[axis] + effect.number(name)
                change: dict[str, Any] = {target: tuple(values)}
                settings = replace(settings, **change)
    return settings
