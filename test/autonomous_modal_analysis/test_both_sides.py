"""What a node has as a parameter the command line has as an option, and the other way round."""

import inspect
from pathlib import Path
import sys

import pytest

from abb_emulator.run_plan import ArmOptions
from autonomous_modal_analysis.commands.history import alarms
from autonomous_modal_analysis.commands.identify import identify
from autonomous_modal_analysis.commands.plan import plan
from autonomous_modal_analysis.commands.replay import replay
from autonomous_modal_analysis.commands.up import up
from autonomous_modal_analysis.commands.watch import watch
from autonomous_modal_analysis.console.option_groups import grouped
from autonomous_modal_analysis.live.cell import cell_commands, NODES
from autonomous_modal_analysis.live.node_tables import parameters_of_node, TABLES
from modal_core.errors import SettingsError

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / 'docs')]

from generated_pages.sides import option_of, SIDES  # noqa: E402

COMMANDS = {
    'oma_identifier': identify,
    'excitation_planner': plan,
    'modal_dashboard': watch,
    'modal_history': alarms,
    'replay': replay,
}


def options(command):
    return set(inspect.signature(grouped(command)).parameters)


def parameters(node):
    return {item.name for item in parameters_of_node(node)}


def arm_options():
    """Return the names under which a file of the emulated arm takes its settings."""
    found = set()
    for item in parameters_of_node('abb_emulator'):
        group, _, name = item.name.rpartition('.')
        alone = {name: item.default}
        try:
            ArmOptions.from_mapping({group: alone} if group else alone)
        except SettingsError as error:
            assert 'unknown option' in str(error), error
        else:
            found.add(item.name)
    return found


def test_every_node_has_its_side():
    assert list(SIDES) == list(TABLES)


@pytest.mark.parametrize('node', COMMANDS)
def test_a_setting_is_on_both_sides_or_it_is_said_why_not(node):
    side, own, there = SIDES[node], parameters(node), options(COMMANDS[node])
    same = own & there
    assert set(side.renamed) | set(side.only_node) == own - same, 'parameters'
    assert set(side.renamed.values()) <= there
    of_others = options(identify) if node == 'replay' else set()
    rest = there - same - set(side.renamed.values()) - of_others
    assert set(side.only_command) == rest, 'options'
    assert all((*side.only_node.values(), *side.only_command.values()))


def test_an_emulated_arm_is_the_same_in_a_file():
    side = SIDES['abb_emulator']
    assert parameters('abb_emulator') - arm_options() == set(side.only_node)
    assert set(side.only_command) <= set(ArmOptions.__dataclass_fields__)


@pytest.mark.parametrize('node', [name for name, _, _ in NODES])
def test_every_parameter_of_a_live_node_can_be_given_on_the_command_line(node):
    assert {'parameter', *SIDES['robot_bridge'].renamed.values()} <= options(up)
    for item in parameters_of_node(node):
        found = cell_commands(None, (), {node: {item.name: item.default}})
        (given,) = [command.parameters for command in found if command.name == node] or [None]
        assert given is None or item.name in given, item.name
        assert option_of(node, item.name)
    with pytest.raises(SettingsError, match='unknown parameter'):
        cell_commands(None, (), {node: {'no_such_parameter': 1}})
