"""A name that is not known is never passed over: the error tells the names that come nearest."""

import inspect
import os
from pathlib import Path
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from autonomous_modal_analysis.cli import app
from autonomous_modal_analysis.commands.campaign import campaign
from autonomous_modal_analysis.commands.plan import plan
from autonomous_modal_analysis.commands.replay import replay
from autonomous_modal_analysis.console.option_groups import grouped, IN_DEGREES, Playing, Wish
from autonomous_modal_analysis.executables import NODES as MODULES
from autonomous_modal_analysis.live.cell import (
    BESIDE_EMULATOR,
    cell_commands,
    FOR_VIEWERS,
    NODES,
    parameter_file,
)
from autonomous_modal_analysis.live.node_tables import check_file, parameters_of_node, TABLES
from excitation_planner.request import PlanRequest
from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError, ModelError, RecordingError, SettingsError
from modal_core.settings.schema import settings_of
from modal_recordings.tables import array_options
from model_gap.campaign.campaign_file import read_campaign_file
from robot_bridge.playback_settings import PlaybackSettings
from structural_model.robot_files import load_robot

CELL_NODES = tuple(name for name, _, _ in NODES)


def test_every_node_has_its_table():
    assert set(TABLES) == set(MODULES)


@pytest.mark.parametrize('name', CELL_NODES)
def test_the_files_shipped_name_nothing_unknown(name):
    check_file(name, parameter_file(name))


@pytest.mark.parametrize(
    ('node', 'given', 'nearest'),
    [
        ('oma_identifier', 'windows_s', 'window_s'),
        ('excitation_planner', 'duration', 'duration_s'),
        ('robot_bridge', 'hearbeat_timeout_s', 'heartbeat_timeout_s'),
        ('abb_emulator', 'bandwidth_hz', 'servo.bandwidth_hz'),
    ],
)
def test_a_parameter_no_node_has_is_refused_before_a_node_starts(node, given, nearest):
    with pytest.raises(SettingsError, match='unknown parameter') as caught:
        cell_commands(parameters={node: {given: 1.0}})
    assert node in str(caught.value) and given in str(caught.value)
    assert nearest in str(caught.value.expected)


def test_the_command_line_refuses_it_in_one_line():
    for text in ('oma_identifier.windows_s=30', 'oma_identifier.windows_s:=30'):
        ended = CliRunner().invoke(app, ['up', '--parameter', text])
        assert isinstance(ended.exception, SettingsError)
        line = str(ended.exception)
        assert 'unknown parameter' in line and 'expected window_s' in line and '\n' not in line


def test_values_have_the_node_s_type_and_range():
    commands = cell_commands(
        parameters={'excitation_planner': {'duration_s': 60, 'use_sim_time': True}}
    )
    given = next(item for item in commands if item.name == 'excitation_planner').parameters
    assert given == {'duration_s': 60.0, 'use_sim_time': True}
    assert isinstance(given['duration_s'], float)
    for value in (1e9, 'long', True, [60.0]):
        with pytest.raises(SettingsError, match='duration_s'):
            cell_commands(parameters={'excitation_planner': {'duration_s': value}})


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('/**: {ros__parameters: {windows_s: 30.0}}', 'unknown parameter.*window_s'),
        ('oma_identifier: {ros__parameters: {windows_s: 30.0}}', 'unknown parameter.*window_s'),
        ('cell: {oma_identifier: {ros__parameters: {hops: 3.0}}}', 'unknown parameter.*hop_s'),
        ('oma_identifer: {ros__parameters: {window_s: 30.0}}', 'unknown node.*oma_identifier'),
        ('/**: {ros__parameters: [window_s, 30.0]}', 'no parameters of a node'),
        ('/**: {ros__parameter: {window_s: 30.0}}', 'no parameters of a node'),
    ],
)
def test_a_parameter_file_with_a_slip_is_refused(tmp_path, text, words):
    path = tmp_path / 'identifier.yaml'
    path.write_text(text)
    with pytest.raises(SettingsError, match=words):
        check_file('oma_identifier', path)


def test_a_file_for_several_nodes_is_fine(tmp_path):
    path = tmp_path / 'all.yaml'
    path.write_text(
        '/**: {ros__parameters: {use_sim_time: true}}\n'
        '/cell_1/robot_bridge: {ros__parameters: {port: 6511}}\n'
        'oma_identifier: {ros__parameters: {window_s: 30.0, qos_overrides: {a: 1}}}\n'
    )
    for name in ('oma_identifier', 'robot_bridge', 'excitation_planner'):
        check_file(name, path)


@pytest.mark.node
@pytest.mark.parametrize(
    ('node', 'given', 'nearest'),
    [('oma_identifier', 'windows_s:=30.0', 'window_s'), ('replay', 'rates:=2.0', 'rate')],
)
def test_a_node_alone_refuses_it_too(node, given, nearest):
    """As `ros2 run` and launch files start it, where no command has looked before."""
    ended = subprocess.run(
        [sys.executable, '-m', MODULES[node], '--ros-args', '-p', given],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, 'ROS_DOMAIN_ID': '86'},
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    (line,) = ended.stderr.strip().splitlines()
    assert 'unknown parameter' in line and f'expected {nearest}' in line


def test_files_with_a_slip_name_what_was_meant(tmp_path):
    with pytest.raises(LayoutError, match='position_m'):
        SensorLayout.from_mapping({'sensors': [{'name': 'a', 'frame_id': 'b', 'position': [1]}]})
    with pytest.raises(LayoutError, match=r'unknown field.*sensors'):
        SensorLayout.from_mapping({'sensors': [{'name': 'a', 'frame_id': 'b'}], 'sensor': []})
    (tmp_path / 'a.csv.yaml').write_text('sample_rate: 100')
    with pytest.raises(RecordingError, match='expected sample_rate_hz'):
        array_options(tmp_path / 'a.csv')
    model = tmp_path / 'model.yaml'
    model.write_text('robot_nam: x')
    with pytest.raises(ModelError, match='expected robot_name'):
        load_robot(model)
    request = tmp_path / 'request.yaml'
    request.write_text('durations_s: 3')
    ended = CliRunner().invoke(app, ['plan', '--request', str(request)])
    assert 'request.yaml: unknown field' in str(ended.exception)
    assert 'expected duration_s' in str(ended.exception)


def test_a_campaign_refuses_slips_and_tells_what_it_does_not_read(tmp_path):
    (tmp_path / 'a.mcap').write_bytes(b'')
    path = tmp_path / 'campaign.yaml'
    for text in (
        'recordings: [{file: a.mcap, lvel: 1}]',
        'recordings: [{file: a.mcap}]\nsensor: []',
    ):
        path.write_text(text)
        with pytest.raises(SettingsError, match=r'unknown field.*(level|sensors)'):
            read_campaign_file(tmp_path)
    path.write_text('recordings: [{file: a.mcap, temperature_c: 21}]\ndate: today')
    remarks = read_campaign_file(tmp_path).remarks
    assert remarks == (
        'campaign.yaml: date is not read',
        'campaign.yaml: temperature_c is not read',
    )


def test_node_and_command_line_have_the_same_settings():
    of_request = {item.name for item in settings_of(PlanRequest)}
    assert of_request <= {item.name for item in parameters_of_node('excitation_planner')}
    for command in (plan, campaign):
        options = set(inspect.signature(grouped(command)).parameters)
        assert of_request - set(IN_DEGREES) <= options, command
    of_playback = {item.name for item in settings_of(PlaybackSettings)}
    assert of_playback <= {item.name for item in parameters_of_node('replay')}
    assert of_playback <= set(inspect.signature(grouped(replay)).parameters)


def test_options_override_the_file_of_a_request(tmp_path):
    path = tmp_path / 'request.yaml'
    path.write_text('{seed: 3, joint_weights: [1, 0.5], duration_s: 20}')
    wish = Wish(request=Path(path), changes={'duration_s': 12.0})
    request = wish.plan_request(seed=9, band_low_hz=4.0)
    assert (request.seed, request.duration_s, request.band_low_hz) == (3, 12.0, 4.0)
    assert request.joint_weights == (1.0, 0.5)
    assert Playing().parameters()['rate'] == 1.0


def test_a_folder_without_a_file_for_viewers_starts_the_other_nodes(tmp_path):
    """A folder of before there was such a node, of a robot that node would not know."""
    for name in CELL_NODES:
        file = parameter_file(name)
        if name not in FOR_VIEWERS:
            (tmp_path / file.name).write_text(file.read_text())
    started = [command.name for command in cell_commands(tmp_path)]
    assert started == [name for name in CELL_NODES if name not in FOR_VIEWERS]


@pytest.mark.parametrize(
    ('without', 'given', 'moves'),
    [
        ((), {}, True),
        (('abb_emulator',), {}, None),
        ((), {'dry_run': True}, False),
    ],
    ids=['beside an emulator', 'beside a real controller', 'a dry run asked for'],
)
def test_only_a_cell_with_an_emulator_moves_one(without, given, moves):
    commands = cell_commands(None, without, {'robot_bridge': given})
    (bridge,) = [command for command in commands if command.name == 'robot_bridge']
    assert bridge.parameters.get('move_emulator') is moves
    assert 'move_emulator' in BESIDE_EMULATOR


def test_the_node_that_keeps_results_starts_where_a_file_is_named():
    started = [command.name for command in cell_commands()]
    assert 'modal_history' not in started and 'oma_identifier' in started
    kept = cell_commands(parameters={'modal_history': {'history': 'arm.history'}})
    assert kept[-1].name == 'modal_history'


def test_the_node_of_a_map_starts_where_a_map_is_named():
    started = [command.name for command in cell_commands()]
    assert 'modal_map' not in started
    named = cell_commands(parameters={'modal_map': {'map': 'map.json'}})
    assert named[-1].name == 'modal_map'


def test_a_cut_without_a_map_is_refused_in_one_line(tmp_path):
    cut = tmp_path / 'cut.yaml'
    cut.write_text('n_teeth: 2\n')
    ended = CliRunner().invoke(app, ['up', '--cut', str(cut)])
    assert isinstance(ended.exception, SettingsError)
    assert 'a cut without a map' in str(ended.exception)
