"""Which backend a name stands for."""

from dataclasses import dataclass, field
from ipaddress import ip_address
from pathlib import Path

from excitation_planner.rapid_options import RapidOptions
from modal_core.errors import BridgeError
from modal_core.settings.schema import setting
from robot_bridge.backends.backend import Backend
from robot_bridge.backends.guidance_backend import GuidanceBackend
from robot_bridge.backends.rapid_backend import RapidBackend
from robot_bridge.backends.trajectory_backend import TrajectoryBackend
from robot_bridge.operator import FlowSettings, OperatorFlow, StreamFlow
from robot_bridge.rws import RwsAccess, RwsClient
from robot_bridge.trajectory import TrajectoryControl
from structural_model.flexible_joint_model import FlexibleJointModel

ROS2_CONTROL = 'ros2_control'
BACKENDS = ('abb_egm', 'abb_rapid', 'emulator', ROS2_CONTROL)
METHODS = ('egm', 'rapid')
# What a controller itself allows in manual mode (ISO 10218-1, reduced speed).
REDUCED_SPEED_M_S = 0.25


@dataclass(frozen=True, slots=True)
class BackendSettings:
    """What a backend is made from.

    Parameters
    ----------
    name : str
        One of ``BACKENDS``.
    method : str
        Of the emulator: ``egm`` or ``rapid``.
    guidance_enabled : bool
        Let EGM guidance move a real arm.
    controller_address : str
        The only host listened to.
    rapid_file : str
        Where the module of a plan goes.
    rws_address, rws_certificate, rws_user, rws_password : str
        Web services that load, start and stop programs and tell the mode; no address: by hand.
    trajectory_action : str
        Action of a robot under ros2_control.
    point_speed_m_s : float [m/s]
        Fastest point of the arm in any plan.
    rapid : RapidOptions
        How modules are written.
    flow : FlowSettings
        Limits of the operator flow.
    """

    name: str = 'emulator'
    method: str = setting('egm', 'emulator only: egm guidance, or a rapid program')
    guidance_enabled: bool = setting(False, 'let EGM guidance move a real arm')
    controller_address: str = setting('127.0.0.1', 'the only host listened to')
    rapid_file: str = setting(
        'AmaExcitation.mod', 'RAPID backends: where the module of a plan goes'
    )
    rws_address: str = setting(
        '', 'web services of the controller, [http[s]://]host[:port]; empty: none'
    )
    rws_certificate: str = setting(
        '', 'HTTPS of RobotWare 7: SHA-256 of its certificate, or PEM file of who vouches for it'
    )
    rws_user: str = setting('Default User', 'account of the web services')
    rws_password: str = field(default='', repr=False)
    trajectory_action: str = setting(
        'joint_trajectory_controller/follow_joint_trajectory',
        'ros2_control: action of its joint trajectory controller',
    )
    point_speed_m_s: float = setting(
        REDUCED_SPEED_M_S, 'plans with a faster point of the arm are refused [m/s]', 0.001, 10.0
    )
    rapid: RapidOptions = field(default_factory=RapidOptions)
    flow: FlowSettings = field(default_factory=FlowSettings)


def make_backend(
    settings: BackendSettings,
    model: FlexibleJointModel,
    trajectories: TrajectoryControl | None = None,
) -> Backend:
    """Return the backend of a name.

    Parameters
    ----------
    settings : BackendSettings
        What it is made from.
    model : FlexibleJointModel
        The robot.
    trajectories : TrajectoryControl or None
        Controller of a robot under ros2_control.

    Raises
    ------
    BridgeError
        Unknown name or method, or guidance of a real arm that is not enabled.
    """
    name, method = settings.name, settings.method
    if name == 'replay':
        raise BridgeError('recordings are played by a node of their own', advice='start replay')
    if name not in BACKENDS:
        raise BridgeError('unknown backend', found=name, expected=', '.join(BACKENDS))
    if method not in METHODS:
        raise BridgeError('unknown method', found=method, expected=', '.join(METHODS))
    if name == ROS2_CONTROL:
        if trajectories is None:
            raise BridgeError('no controller of trajectories', where=name)
        if settings.point_speed_m_s > REDUCED_SPEED_M_S and not settings.flow.dry_run:
            raise BridgeError(
                'ros2_control does not tell the operating mode',
                where='point_speed_m_s',
                found=f'{settings.point_speed_m_s:g} m/s',
                expected=f'at most {REDUCED_SPEED_M_S:g} m/s',
            )
        return TrajectoryBackend(name, StreamFlow(settings.flow), trajectories)
    control = None
    if settings.rws_address:
        control = RwsClient(
            RwsAccess(
                settings.rws_address,
                settings.rws_user,
                settings.rws_password,
                certificate=settings.rws_certificate,
                unit=settings.rapid.mechanical_unit,
            )
        )
    if name == 'abb_rapid' or (name == 'emulator' and method == 'rapid'):
        flow = StreamFlow(settings.flow)
        return RapidBackend(name, flow, model, Path(settings.rapid_file), control, settings.rapid)
    real = is_real(settings) and not settings.flow.dry_run
    if real and not settings.guidance_enabled:
        raise BridgeError(
            'guidance is not enabled',
            where=name,
            advice='read docs/reference/abb.md, then set guidance_enabled true, or method rapid',
        )
    fast = settings.point_speed_m_s > REDUCED_SPEED_M_S
    if real and fast and control is None:
        raise BridgeError(
            'EGM does not tell the operating mode',
            where='point_speed_m_s',
            found=f'{settings.point_speed_m_s:g} m/s',
            expected=f'at most {REDUCED_SPEED_M_S:g} m/s, or rws_address',
        )
    return GuidanceBackend(name, OperatorFlow(settings.flow), control if fast else None)


def is_real(settings: BackendSettings) -> bool:
    """Tell whether a real arm may be behind it: an emulator is on this machine only."""
    # Calling a real controller an emulator must not be the way around a question.
    return settings.name != 'emulator' or not is_loopback(settings.controller_address)


def is_loopback(address: str) -> bool:
    """Tell whether an address is of this machine only."""
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return False
