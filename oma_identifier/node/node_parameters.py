"""Parameters of the identifier node: names, meaning, ranges; settings out of their values."""

from collections.abc import Mapping
from pathlib import Path

from modal_core.channel import SensorLayout
from modal_core.layouts.layout_file import layout_from_file
from modal_core.settings.node_parameter import NodeParameter, parameters_of
from modal_core.settings.schema import from_parameters
from oma_identifier.settings import IdentificationSettings

SETTINGS = parameters_of(IdentificationSettings)
OTHERS = (
    NodeParameter(
        'topics',
        'topics of responses; empty: all of a known type in the namespace',
        ('',),
        read_only=True,
    ),
    NodeParameter('joint_states_topic', 'topic of joint states', 'joint_states', read_only=True),
    NodeParameter(
        'spindle_topic',
        "topic of the spindle's speed, std_msgs/Float64 [rpm] unless its name ends in _hz or"
        ' _rad_s: it tells how lines move; nobody there, or empty: the responses tell it',
        'spindle_speed_rpm',
        read_only=True,
    ),
    NodeParameter(
        'plan_topic',
        'topic of plans: while the bridge plays one, an automatic band ends below its edge',
        'excitation_planner/excitation_plan',
        read_only=True,
    ),
    NodeParameter(
        'bridge_topic', "topic of the bridge's state", 'robot_bridge/state', read_only=True
    ),
    NodeParameter(
        'predicted_modes_topic',
        'topic of the modes a map predicts: by them a mode keeps its id at poses not seen before',
        'modal_map/predicted_modes',
        read_only=True,
    ),
    NodeParameter(
        'layout_file',
        'YAML file of the sensors, no others are taken; empty: all are, and drawn where the'
        ' robot that the plan names has sensors of these names',
        '',
        read_only=True,
    ),
    NodeParameter(
        'shown_mode',
        'id of the mode on ~/mode_shapes; 0: one after the other',
        0,
        0,
        10**9,
    ),
    NodeParameter(
        'robot',
        'robot whose motion is predicted from joint states and taken out; empty: none',
        '',
        read_only=True,
    ),
    NodeParameter('base_frame', 'frame named in the results', 'base_link', read_only=True),
    NodeParameter(
        'checkpoint_file',
        'file that keeps the ids of modes, the last result beside it as .last; empty: none',
        '',
        read_only=True,
    ),
)
PARAMETERS = (*SETTINGS, *OTHERS)


def settings_from(values: Mapping[str, object]) -> IdentificationSettings:
    """Return settings from parameter values.

    Raises
    ------
    SettingsError
        Naming the parameter, the value and the allowed range.
    """
    checked = {item.name: item.read(values[item.name]) for item in SETTINGS}
    return IdentificationSettings(**from_parameters(IdentificationSettings, checked))


def load_layout_file(path: str) -> SensorLayout | None:
    """Return the sensor layout of a YAML file; None for an empty path.

    Raises
    ------
    SettingsError, LayoutError
        The file cannot be read or is malformed.
    """
    if not path:
        return None
    return layout_from_file(Path(path))
