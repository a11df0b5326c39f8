"""Parameters of the bridge: names, meaning, ranges; settings out of their values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from ipaddress import ip_address
from pathlib import Path
from typing import Any

from excitation_planner.rapid_options import RapidOptions
from modal_core.errors import BridgeError
from modal_core.settings.node_parameter import NodeParameter, parameters_of
from modal_core.settings.schema import from_parameters
from robot_bridge.backends import BACKENDS, BackendSettings, is_real, ROS2_CONTROL
from robot_bridge.operator import FlowSettings
from robot_bridge.player import PlayerSettings
from robot_bridge.web_password import web_password

MEGABYTE = 1_000_000
# An emulated controller shares this machine's processors with everything else, and while it stands
# still so does its arm.
EMULATED_LINK_TIMEOUT_S = 0.25
REAL_LINK_CYCLES = 3
MOST_MISSED_OF_REAL = 25
# From the last beat or packet to standstill; what is shipped takes 0.18 s.
LONGEST_STOP_OF_REAL_S = 0.5


_P = NodeParameter
OWN = (
    _P('autostart', 'configure and activate as soon as the node is up', True),
    _P('robot', 'robot of config/robots, or its folder', 'irb6660_205_190'),
    _P('backend', f'one of {", ".join(BACKENDS)}', BackendSettings().name),
    _P('bind_address', 'interface to listen on; wildcards are refused', '127.0.0.1'),
    _P('port', 'EGM port', 6510, 1, 65535),
    _P(
        'controller_name',
        'what ~/arm must name, for example its serial number; empty: controller_address:port',
        '',
    ),
    _P(
        'rws_password_file',
        'file with its password; empty: the variable AMA_RWS_PASSWORD, or the one ABB ships',
        '',
    ),
    _P(
        'link_timeout_s',
        'silence that counts as a lost link [s]; 0: three cycles, or emulator_link_timeout_s',
        0.0,
        0.0,
        10.0,
    ),
    _P(
        'emulator_link_timeout_s',
        'the same of an emulator on this machine [s]; never of a real arm',
        EMULATED_LINK_TIMEOUT_S,
        0.001,
        10.0,
    ),
    _P(
        'packet_log',
        'MCAP file for every EGM packet; empty: with a real controller, one in the ROS log folder',
        '',
    ),
    _P('packet_log_mb', 'room for the packet logs of one run [MB]', 500.0, 1.0, 1e6),
    _P(
        'move_emulator',
        'even in a dry run an emulator on this machine is moved; a real arm never is',
        False,
    ),
    _P('speed_override', '0..1, live: scales the motion', 1.0, 0.0, 1.0),
)
PARAMETERS = (
    *OWN,
    *parameters_of(BackendSettings),
    *parameters_of(RapidOptions, 'rapid.'),
    *parameters_of(FlowSettings),
    *parameters_of(PlayerSettings),
)
LIVE = frozenset({'speed_override', 'autostart'})


@dataclass(frozen=True, slots=True)
class BridgeSettings:
    """What one bridge is made from.

    Parameters
    ----------
    robot : str
        Robot of config/robots, or its folder.
    backend : BackendSettings
        How the arm is moved.
    bind_address, port : str, int
        Where to listen.
    point_speed_m_s : float [m/s]
        Plans with a faster point of the arm are refused.
    packet_log : Path or None
        MCAP file for every EGM packet.
    packet_log_bytes : int
        Room for it.
    speed_override : float
        0..1, at the beginning.
    controller : str
        What a release must name.
    """

    robot: str
    backend: BackendSettings
    bind_address: str
    port: int
    point_speed_m_s: float
    packet_log: Path | None
    packet_log_bytes: int
    speed_override: float
    controller: str


def settings_from(values: Mapping[str, Any], log_file: Path) -> BridgeSettings:
    """Return settings from parameter values.

    Parameters
    ----------
    values : mapping
        Of every parameter.
    log_file : Path
        Packet log of a real controller, when no other is named.

    Raises
    ------
    BridgeError
        A value that cannot be meant.
    """
    backend = _backend(values)
    named = Path(values['packet_log']) if values['packet_log'] else None
    return BridgeSettings(
        robot=values['robot'],
        backend=backend,
        bind_address=values['bind_address'],
        port=values['port'],
        point_speed_m_s=values['point_speed_m_s'],
        packet_log=named or (log_file if is_real(backend) else None),
        packet_log_bytes=round(values['packet_log_mb'] * MEGABYTE),
        speed_override=values['speed_override'],
        controller=values['controller_name'] or _own_name(values),
    )


def _own_name(values: Mapping[str, Any]) -> str:
    """Return what a controller without a name is called."""
    if values['backend'] == ROS2_CONTROL:
        return str(values['trajectory_action'])
    return f'{values["controller_address"]}:{values["port"]}'


def _backend(values: Mapping[str, Any]) -> BackendSettings:
    _check_address(values['controller_address'])
    chosen = BackendSettings(name=values['backend'], **from_parameters(BackendSettings, values))
    # An unknown backend is refused by name later on.
    if chosen.name in BACKENDS and is_real(chosen) and not values['dry_run']:
        _check_watchdogs(values)
    if values['move_emulator'] and not is_real(chosen):
        values = {**values, 'dry_run': False}
    link_timeout_s = values['link_timeout_s']
    if link_timeout_s == 0.0:
        real_s = REAL_LINK_CYCLES * values['cycle_s']
        # Joint states come through an executor and a middleware, not in a controller's cycle.
        punctual = is_real(chosen) and chosen.name != ROS2_CONTROL
        link_timeout_s = real_s if punctual else values['emulator_link_timeout_s']
    flow = FlowSettings(
        link_timeout_s=link_timeout_s,
        player=PlayerSettings(**from_parameters(PlayerSettings, values)),
        **from_parameters(FlowSettings, values),
    )
    password = web_password(values['rws_password_file']) if chosen.rws_address else ''
    rapid = RapidOptions(**from_parameters(RapidOptions, values, 'rapid.'))
    return replace(chosen, flow=flow, rapid=rapid, rws_password=password)


def _check_watchdogs(values: Mapping[str, Any]) -> None:
    """Refuse what leaves a real arm without its operator or its link."""
    if values['heartbeat_timeout_s'] == 0.0:
        raise BridgeError(
            'a real arm moves only while the operator holds to run',
            where='heartbeat_timeout_s',
            found='0 s',
            expected='more than 0 s, 0.13 s for a heartbeat of 10 Hz',
        )
    for name in ('heartbeat_timeout_s', 'link_timeout_s'):
        stop_s = values[name] + values['stop_ramp_s']
        if stop_s > LONGEST_STOP_OF_REAL_S:
            raise BridgeError(
                'a real arm would go on for too long',
                where=f'{name} + stop_ramp_s',
                found=f'{stop_s:g} s',
                expected=f'at most {LONGEST_STOP_OF_REAL_S:g} s',
            )
    if values['most_missed_cycles'] > MOST_MISSED_OF_REAL:
        raise BridgeError(
            'too many for a real arm',
            where='most_missed_cycles',
            found=values['most_missed_cycles'],
            expected=f'at most {MOST_MISSED_OF_REAL}',
        )


def _check_address(address: str) -> None:
    """Refuse a name: packets come with numbers, so a name would never be heard."""
    try:
        ip_address(address)
    except ValueError as error:
        raise BridgeError(
            'not an IP address', where='controller_address', found=address or 'nothing'
        ) from error
