"""Parameters of the identifier node: names, meaning, ranges; settings out of their values."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from modal_core.channel import SensorLayout
from modal_core.errors import SettingsError
from modal_core.yaml_file import load_yaml
from oma_identifier.settings import IdentificationSettings, LARGEST_ORDER


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


SETTINGS = (
    NodeParameter('window_s', 'length of one window [s]', 60.0, 1.0, 86400.0),
    NodeParameter('hop_s', 'time between windows [s]; 0: half a window', 0.0, 0.0, 86400.0),
    NodeParameter('min_frequency_hz', 'lower end of the band [Hz]; 0: automatic', 0.0, 0.0, 1e5),
    NodeParameter('max_frequency_hz', 'upper end of the band [Hz]; 0: automatic', 0.0, 0.0, 1e5),
    NodeParameter('min_order', 'lowest model order', 2, 2, LARGEST_ORDER),
    NodeParameter('max_order', 'highest model order', 60, 2, LARGEST_ORDER),
    NodeParameter('block_rows', 'block rows of the Hankel matrix; 0: automatic', 0, 0, 500),
    NodeParameter('n_references', 'reference channels; 0: automatic', 0, 0, 1000),
    NodeParameter('max_damping_ratio', 'poles damped more are no modes', 0.15, 0.001, 0.5),
    NodeParameter('method', 'identification method', 'ssi_cov'),
)
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
AUTOMATIC = ('hop_s', 'min_frequency_hz', 'max_frequency_hz', 'block_rows', 'n_references')


def settings_from(values: Mapping[str, object]) -> IdentificationSettings:
    """Return settings from parameter values.

    Raises
    ------
    SettingsError
        Naming the parameter, the value and the allowed range.
    """
    for parameter in SETTINGS:
        check_range(parameter, values[parameter.name])
    names = [parameter.name for parameter in SETTINGS]
    chosen = {name: values[name] for name in names}
    for name in AUTOMATIC:
        chosen[name] = chosen[name] or None
    return IdentificationSettings(**chosen)  # type: ignore[arg-type]


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
