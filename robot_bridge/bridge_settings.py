"""Parameters of the bridge: names, meaning, ranges; settings out of their values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from ipaddress import ip_address
from pathlib import Path
from typing import Any

from modal_core.errors import BridgeError
from robot_bridge.backends import BACKENDS, BackendSettings, is_real
from robot_bridge.operator import FlowSettings
from robot_bridge.player import PlayerSettings
from robot_bridge.web_password import web_password

MEGABYTE = 1_000_000
# An emulated controller shares this machine's processors with everything else.
EMULATED_LINK_TIMEOUT_S = 0.25
REAL_LINK_CYCLES = 3
MOST_MISSED_OF_REAL = 25
# From the last beat or packet to standstill; what is shipped takes 0.18 s.
LONGEST_STOP_OF_REAL_S = 0.5


@dataclass(frozen=True, slots=True)
class BridgeParameter:
    """One parameter of the node.

    Parameters
    ----------
    name, text : str
        What it is.
    default : value
        Also gives the type.
    span : (low, high) tuple or None
        Range of a number.
    """

    name: str
    default: bool | int | float | str
    text: str
    span: tuple[float, float] | None = None


_P = BridgeParameter
PARAMETERS = (
    _P('autostart', True, 'configure and activate as soon as the node is up'),
    _P('robot', 'irb6660_205_190', 'robot of config/robots, or its folder'),
    _P('backend', 'emulator', f'one of {", ".join(BACKENDS)}'),
    _P('method', 'egm', 'emulator only: egm guidance, or a rapid program'),
    _P('guidance_enabled', False, 'let EGM guidance move a real arm'),
    _P('dry_run', True, 'go through everything and send nothing to the controller'),
    _P('bind_address', '127.0.0.1', 'interface to listen on; wildcards are refused'),
    _P('port', 6510, 'EGM port', (1, 65535)),
    _P('controller_address', '127.0.0.1', 'the only host listened to'),
    _P(
        'controller_name',
        '',
        'what ~/arm must name, for example its serial number; empty: controller_address:port',
    ),
    _P('rapid_file', 'AmaExcitation.mod', 'RAPID backends: where the module of a plan goes'),
    _P('rws_address', '', 'web services of the controller, host or host:port; empty: none'),
    _P('rws_user', 'Default User', 'account of the web services'),
    _P(
        'rws_password_file',
        '',
        'file with its password; empty: the variable AMA_RWS_PASSWORD, or the one ABB ships',
    ),
    _P('cycle_s', 0.004032, 'period of the controller [s]', (0.001, 0.1)),
    _P(
        'link_timeout_s',
        0.0,
        'silence that counts as a lost link [s]; 0: three cycles, 0.25 s for the emulator',
        (0.0, 10.0),
    ),
    _P('most_missed_cycles', 3, 'packets in a row that may be missing while moving', (0, 10_000)),
    _P(
        'heartbeat_timeout_s',
        0.13,
        'silence of the operator that stops; 0: none asked, emulator only [s]',
        (0.0, 10.0),
    ),
    _P(
        'start_tolerance_deg',
        0.2,
        'distance from the start pose allowed at start [deg]',
        (0.0, 5.0),
    ),
    _P(
        'max_following_error_deg',
        2.0,
        'distance from the reference that stops [deg]',
        (0.01, 90.0),
    ),
    _P('ramp_in_s', 1.0, 'time over which the amplitude grows [s]', (0.01, 60.0)),
    _P('stop_ramp_s', 0.05, 'time from an abort to standstill [s]', (0.004, 5.0)),
    _P(
        'point_speed_m_s',
        0.25,
        'plans with a faster point of the arm are refused [m/s]',
        (0.001, 10.0),
    ),
    _P(
        'packet_log',
        '',
        'MCAP file for every EGM packet; empty: with a real controller, one in the ROS log folder',
    ),
    _P('packet_log_mb', 500.0, 'room for the packet logs of one run [MB]', (1.0, 1e6)),
    _P('speed_override', 1.0, '0..1, live: scales the motion', (0.0, 1.0)),
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
        controller=values['controller_name'] or f'{values["controller_address"]}:{values["port"]}',
    )


def _backend(values: Mapping[str, Any]) -> BackendSettings:
    _check_address(values['controller_address'])
    chosen = BackendSettings(
        name=values['backend'],
        method=values['method'],
        guidance_enabled=values['guidance_enabled'],
        controller_address=values['controller_address'],
        rapid_file=Path(values['rapid_file']),
        rws_address=values['rws_address'],
        rws_user=values['rws_user'],
    )
    # An unknown backend is refused by name later on.
    if chosen.name in BACKENDS and is_real(chosen) and not values['dry_run']:
        _check_watchdogs(values)
    link_timeout_s = values['link_timeout_s']
    if link_timeout_s == 0.0:
        real_s = REAL_LINK_CYCLES * values['cycle_s']
        link_timeout_s = real_s if is_real(chosen) else EMULATED_LINK_TIMEOUT_S
    player = PlayerSettings(ramp_in_s=values['ramp_in_s'], stop_ramp_s=values['stop_ramp_s'])
    names = (
        'cycle_s',
        'most_missed_cycles',
        'heartbeat_timeout_s',
        'start_tolerance_deg',
        'max_following_error_deg',
        'dry_run',
    )
    flow = FlowSettings(
        link_timeout_s=link_timeout_s, player=player, **{name: values[name] for name in names}
    )
    password = web_password(values['rws_password_file']) if chosen.rws_address else ''
    return replace(
        chosen, flow=flow, rws_password=password, point_speed_m_s=values['point_speed_m_s']
    )


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
