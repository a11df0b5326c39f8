"""Options several commands share."""

from pathlib import Path
import re
from typing import Annotated, Any

from rich.markup import escape
import typer

from modal_core.errors import SettingsError
from modal_core.settings.schema import SettingField

RecordingPath = Annotated[
    Path,
    typer.Argument(
        help='rosbag2 folder, .mcap, .db3, ROS 1 .bag, array as .npy, .csv, .tsv or .txt, or of '
        'another program: .npz, .uff, .mat, .h5, .nc, .wav, .lvm, .tdms, .mf4.',
        show_default=False,
    ),
]
Json = Annotated[bool, typer.Option('--json', help='Print one JSON object, for programs.')]
Topics = Annotated[
    list[str] | None,
    typer.Option(
        '--topic', help='Use only this topic, or array of a file; may be given more than once.'
    ),
]
LayoutPath = Annotated[
    Path | None,
    typer.Option('--layout', help='Sensor layout: links, places and directions of the channels.'),
]
Effects = Annotated[
    list[Path] | None,
    typer.Option(
        '--effects',
        help="Folder (or file) with effects of one's own, which are programs; may be given more "
        'than once.',
        show_default=False,
    ),
]
SampleRate = Annotated[
    float | None, typer.Option('--sample-rate-hz', help='Rate of a plain array.')
]
Unit = Annotated[
    str | None,
    typer.Option(
        '--unit', help='Unit of a plain array: m/s^2, g, mm/s, um, "50 m/s^2", ...; else m/s^2.'
    ),
]
Mark = Annotated[
    str | None,
    typer.Option(
        '--mark',
        help='Channel or column that is high while the robot moves: only that part is used.',
    ),
]
Spindle = Annotated[
    str | None,
    typer.Option(
        '--spindle',
        help="Topic, channel or column with the spindle's speed \\[rpm], unless its name says "
        'Hz or rad/s: its orders are followed by it. Else the topic /spindle_speed_rpm, or lines '
        'that move are found.',
    ),
]
Channels = Annotated[
    str | None,
    typer.Option(
        '--channels',
        help="Names of a plain array's columns: a,b,c; with units: time \\[ms],a \\[g]; - for "
        'none.',
    ),
]
Export = Annotated[
    list[Path] | None,
    typer.Option(
        '--export',
        help='File of another program with the modes: .uff, .mat, .nc, .parquet or .csv; may be '
        'given more than once.',
    ),
]
ExportTable = Annotated[
    list[Path] | None,
    typer.Option(
        '--export',
        help='File of another program with the table: .mat, .nc, .parquet or .csv; may be given '
        'more than once.',
    ),
]
ExportSamples = Annotated[
    list[Path] | None,
    typer.Option(
        '--export',
        help='File of another program with the samples, on one clock and in SI units: .uff, .mat,'
        ' .nc, .parquet or .csv; may be given more than once.',
    ),
]
RobotName = Annotated[
    str | None,
    typer.Option(
        '--robot',
        help='Robot by name or folder: its rigid motion and drive lines, predicted from joint '
        'states, are taken out; its sensors.yaml is the layout unless --layout names another.',
    ),
]
POSE_HELP = (
    'Name of a pose, controller angles j1,j2,... in degrees (of joints that slide in metres), or a'
    ' recording made there.'
)
Serial = Annotated[
    bool,
    typer.Option(
        '--serial',
        help='The angles given are those of the serial joints, as in joint_states, not those of'
        ' the controller axes; they differ where a rod couples axes.',
    ),
]
Namespace = Annotated[
    str, typer.Option(help='ROS namespace of all nodes of a cell: one for each cell of a domain.')
]


def setting_option(setting: SettingField, changes: bool = False) -> Any:
    """Return the option of a setting: its name, its type and its words.

    With ``changes`` nothing is set unless the option is given: the help tells what holds then.
    """
    flag = f'--{setting.name.replace("_", "-")}'
    if setting.kind is bool:
        flag += f'/--no-{setting.name.replace("_", "-")}'
    words = setting.text[0].upper() + setting.text[1:]
    if setting.automatic:
        words += f'; else {setting.automatic}'
    kind: Any = str if setting.many else setting.kind
    if setting.many:
        words += '; separated by commas'
    if changes and setting.default != ():
        words += f'; else {setting.default}'
    kind = kind | None if setting.automatic or changes else kind
    return Annotated[kind, typer.Option(flag, help=escape(words) + '.')]


def check_namespace(namespace: str) -> None:
    """Refuse what is no ROS namespace; empty is the root.

    Raises
    ------
    SettingsError
        It is none.
    """
    if not re.fullmatch(r'/?([A-Za-z_]\w*(/[A-Za-z_]\w*)*/?)?', namespace, re.ASCII):
        raise SettingsError(
            'not a ROS namespace',
            where='--namespace',
            found=namespace,
            expected='letters, digits and _, parts separated by /',
        )


def stated_pair(text: str) -> tuple[str, str]:
    """Split ``name=value``.

    Raises
    ------
    SettingsError
        It is no such pair.
    """
    name, found, value = text.partition('=')
    if not (found and name.strip() and value.strip()):
        raise SettingsError(
            'not a tolerance', where='--tolerance', found=text, expected='stiffness=0.4'
        )
    return name.strip(), value.strip()


def channel_names(channels: str | None) -> tuple[str, ...] | None:
    """Split a comma-separated list of channel names."""
    if channels is None:
        return None
    return tuple(name.strip() for name in channels.split(','))


def numbers(text: str, where: str) -> tuple[float, ...]:
    """Split a comma-separated list of numbers.

    Raises
    ------
    SettingsError
        One is not a number.
    """
    try:
        return tuple(float(part) for part in text.split(',') if part.strip())
    except ValueError as error:
        raise SettingsError(
            'not numbers', where=where, found=text, expected='numbers separated by commas'
        ) from error
