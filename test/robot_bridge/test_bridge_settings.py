"""What the bridge is when nobody says anything, and what it refuses to be."""

from ipaddress import ip_address
from pathlib import Path

import pytest

from modal_core.errors import BridgeError
from modal_core.files.share import share_path
from modal_core.files.yaml_file import load_yaml
from robot_bridge.bridge_settings import PARAMETERS, settings_from

LOG = Path('egm_now.mcap')
DEFAULTS = {item.name: item.default for item in PARAMETERS}


def settings(**changes):
    return settings_from({**DEFAULTS, **changes}, LOG)


def test_out_of_the_box_nothing_can_move_and_nobody_else_is_heard():
    chosen = settings()
    flow = chosen.backend.flow
    assert flow.dry_run and not chosen.backend.guidance_enabled
    assert ip_address(chosen.bind_address).is_loopback
    assert ip_address(chosen.backend.controller_address).is_loopback
    assert chosen.point_speed_m_s == 0.25
    # From the last beat of 10 Hz to standstill below 0.2 s, two cycles on the way.
    assert 0.1 < flow.heartbeat_timeout_s
    assert flow.heartbeat_timeout_s + flow.player.stop_ramp_s + 2 * flow.cycle_s < 0.2
    assert chosen.packet_log is None


@pytest.mark.parametrize(
    'real', [{'backend': 'abb_egm'}, {'backend': 'abb_rapid'}, {'controller_address': '10.0.0.1'}]
)
def test_a_real_controller_has_a_watchdog_of_three_cycles_and_a_log(real):
    chosen = settings(**real)
    flow = chosen.backend.flow
    assert flow.link_timeout_s == pytest.approx(3 * flow.cycle_s)
    assert flow.most_missed_cycles == 3
    assert chosen.packet_log == LOG
    assert settings(packet_log='mine.mcap', **real).packet_log == Path('mine.mcap')
    assert settings(link_timeout_s=0.02, **real).backend.flow.link_timeout_s == 0.02


@pytest.mark.parametrize(
    'loose',
    [
        {'heartbeat_timeout_s': 0.0},
        {'heartbeat_timeout_s': 0.6},
        {'link_timeout_s': 10.0},
        {'stop_ramp_s': 2.0},
        {'most_missed_cycles': 200},
    ],
)
def test_a_real_arm_is_not_moved_without_its_watchdogs(loose):
    for real in ({'backend': 'abb_egm'}, {'backend': 'abb_rapid'}):
        with pytest.raises(BridgeError, match=next(iter(loose))):
            settings(dry_run=False, **real, **loose)
        assert settings(dry_run=True, **real, **loose).backend.flow.dry_run
    assert not settings(dry_run=False, **loose).backend.flow.dry_run


def test_the_emulated_one_may_wait_for_this_machine():
    assert settings().backend.flow.link_timeout_s == 0.25


def test_what_moves_an_emulator_moves_no_real_arm():
    """Neither by another backend nor by calling a real controller an emulator."""
    moved = {'move_emulator': True, 'emulator_link_timeout_s': 2.0}
    flow = settings(**moved).backend.flow
    assert not flow.dry_run and flow.link_timeout_s == 2.0
    for real in (
        {'backend': 'abb_egm'},
        {'backend': 'abb_rapid'},
        {'controller_address': '10.0.0.1'},
    ):
        flow = settings(**moved, **real).backend.flow
        assert flow.dry_run and flow.link_timeout_s < 0.02


@pytest.mark.parametrize('address', ['', 'robot', 'localhost', '10.0.0.1:80', '0.0.0.0.0'])
def test_the_controller_is_named_by_its_number(address):
    with pytest.raises(BridgeError, match='controller_address'):
        settings(controller_address=address)


def test_the_parameter_file_names_known_parameters_and_their_types():
    given = load_yaml(share_path('config') / 'bridge.yaml')['/**']['ros__parameters']
    rapid = {f'rapid.{name}': value for name, value in given.pop('rapid').items()}
    for name, value in {**given, **rapid}.items():
        assert type(value) is type(DEFAULTS[name]), name
        assert value == DEFAULTS[name], f'{name}: the file and the node differ'


def test_every_number_has_a_range_that_holds_its_default():
    for item in PARAMETERS:
        if isinstance(item.default, int | float) and not isinstance(item.default, bool):
            low, high = item.span
            assert low <= item.default <= high, item.name
