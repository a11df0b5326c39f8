"""Parameters of the identifier node: names, meaning, ranges; settings out of their values."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from modal_core.channel import SensorLayout
from modal_core.errors import SettingsError
from modal_core.schema import from_parameters, Setting, settings_of, SWITCH
from modal_core.yaml_file import load_yaml
from oma_identifier.settings import IdentificationSettings


@dataclass(frozen=True, slots=True)
class NodeParameter:
    """One parameter of the node.

    Parameters
    ----------
    name, description : str
        What it is; 0 or an empty text means "chosen by the node" where the description says so.
    default : value
        Also gives the type.
    low, high : float or None
        Range of a number.
    read_only : bool
        Cannot be changed while the node runs.
    """

    name: str
    description: str
    default: float | int | str | tuple[str, ...]
    low: float | None = None
    high: float | None = None
    read_only: bool = False


def _node_parameter(setting: Setting) -> NodeParameter:
    default = setting.to_parameter(setting.default)
    low, text = setting.low, setting.text
    if setting.automatic:
        low = None if low is None else 0.0
        text += f'; {default}: {setting.automatic}'
    if isinstance(default, str) and setting.kind is bool:
        text += f' (one of {", ".join(SWITCH)})'
    return NodeParameter(setting.name, text, default, low, setting.high)


SETTINGS = tuple(_node_parameter(item) for item in settings_of(IdentificationSettings))
OTHERS = (
    NodeParameter(
        'topics',
        'topics of responses; empty: all of a known type in the namespace',
        ('',),
        read_only=True,
    ),
    NodeParameter('joint_states_topic', 'topic of joint states', 'joint_states', read_only=True),
    NodeParameter(
        'plan_topic',
        'topic of plans: while the bridge plays one, an automatic band ends below its edge',
        'excitation_planner/excitation_plan',
        read_only=True,
    ),
    NodeParameter(
        'bridge_topic', "topic of the bridge's state", 'robot_bridge/state', read_only=True
    ),
    NodeParameter('layout_file', 'YAML file of the sensors; empty: none', '', read_only=True),
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
    for parameter in SETTINGS:
        check_range(parameter, values[parameter.name])
    return IdentificationSettings(**from_parameters(IdentificationSettings, values))


def check_range(parameter: NodeParameter, value: object) -> None:
    """Refuse a value of another type or out of range.

    Raises
    ------
    SettingsError
        Naming the parameter, the value and the allowed range.
    """
    if parameter.low is None or parameter.high is None:
        return
    kind = type(parameter.default)
    if isinstance(value, bool) or not isinstance(value, kind):
        raise SettingsError(
            'wrong type', where=parameter.name, found=repr(value), expected=kind.__name__
        )
    if not parameter.low <= value <= parameter.high:  # type: ignore[operator]
        raise SettingsError(
            'out of range',
            where=parameter.name,
            found=value,
            expected=f'{parameter.low:g} to {parameter.high:g}',
        )


def load_layout_file(path: str) -> SensorLayout | None:
    """Return the sensor layout of a YAML file; None for an empty path.

    Raises
    ------
    SettingsError, LayoutError
        The file cannot be read or is malformed.
    """
    if not path:
        return None
    return SensorLayout.from_mapping(load_yaml(Path(path)), name=path)
