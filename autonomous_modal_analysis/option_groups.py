"""Options that several commands share as a whole, each group one record.

A command marked with :func:`grouped` takes such a record where its help shows the single options.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, fields, is_dataclass, MISSING
import inspect
from typing import Any, cast, TYPE_CHECKING

from autonomous_modal_analysis.options import (
    channel_names,
    Channels,
    LayoutPath,
    RecordingPath,
    RobotName,
    SampleRate,
    setting_option,
    Topics,
    Unit,
)
from modal_core.channel import SensorLayout
from modal_core.schema import parameter_values, settings_of
from oma_identifier.settings import IdentificationSettings

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult
    from autonomous_modal_analysis.api.recording import Recording
    from autonomous_modal_analysis.api.settings import Settings
    from autonomous_modal_analysis.terminal import ProgressCallback


@dataclass(frozen=True, slots=True)
class Source:
    """Which recording, what of it, and how a plain array is to be read."""

    recording: RecordingPath
    topic: Topics = None
    sample_rate_hz: SampleRate = None
    unit: Unit = None
    channels: Channels = None

    def open(self, to_look: bool = False) -> 'Recording':
        """Open the recording; ``to_look`` also when it has nothing to identify.

        Raises
        ------
        RecordingError
            It cannot be read.
        """
        import autonomous_modal_analysis as ama

        return ama.open(
            self.recording,
            topics=tuple(self.topic) if self.topic else None,
            sample_rate_hz=self.sample_rate_hz,
            unit=self.unit,
            channel_names=channel_names(self.channels),
            to_look=to_look,
        )

    def parameters(self) -> dict[str, object]:
        """Return the same as parameters of the replay node."""
        return {
            'recording': str(self.recording.resolve()),
            'topics': self.topic or [''],
            'sample_rate_hz': self.sample_rate_hz or 0.0,
            'unit': self.unit or '',
            'channels': list(channel_names(self.channels) or ('',)),
        }


@dataclass(frozen=True, slots=True)
class Identifier:
    """How a recording is identified."""

    settings: IdentificationSettings = field(default_factory=IdentificationSettings)
    layout: LayoutPath = None
    robot: RobotName = None

    def identify(self, recording: 'Recording', progress: 'ProgressCallback') -> 'ModalResult':
        """Identify a recording.

        Raises
        ------
        ModalAnalysisError
            A setting is out of range, there is no such robot or layout, or the recording cannot
            be identified.
        """
        settings = cast('Settings', asdict(self.settings))
        robot = self.robot or None
        return recording.identify(layout=self.layout, robot=robot, progress=progress, **settings)

    def sensors(self) -> SensorLayout | None:
        """Return the sensor layout: the one named, else the robot's own.

        Raises
        ------
        ModalAnalysisError
            It cannot be read, or does not fit the robot.
        """
        from autonomous_modal_analysis.api.robot import read_robot, sensors_of

        model = read_robot(self.robot) if self.robot else None
        return sensors_of(self.robot, model, self.layout)

    def parameters(self) -> dict[str, object]:
        """Return the same as parameters of the identifier node."""
        from structural_model.robot_files import robot_folder

        layout = self.layout.resolve() if self.layout else ''
        if self.robot and not layout:
            layout = robot_folder(self.robot) / 'sensors.yaml'
        return {
            **parameter_values(self.settings),
            'layout_file': str(layout),
            'robot': self.robot or '',
        }


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Let a command take groups of options; its own options stand after them."""
    groups: dict[str, type[Any]] = {}
    options: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if is_dataclass(parameter.annotation):
            groups[name] = parameter.annotation  # type: ignore[assignment]
            options.extend(_options(groups[name], parameter.kind))
        else:
            options.append(parameter)

    def run(**values: Any) -> None:
        made = {name: _take(group, values) for name, group in groups.items()}
        command(**made, **values)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__annotations__ = {item.name: item.annotation for item in options}
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return run


def _options(group: type[Any], kind: Any) -> Iterator[inspect.Parameter]:
    """Yield the options of a group: its fields, and the settings of those that are settings."""
    for item in fields(group):
        if is_dataclass(item.type):
            for each in settings_of(cast(type[Any], item.type)):
                yield inspect.Parameter(
                    each.name, kind, default=each.default, annotation=setting_option(each)
                )
        else:
            default = inspect.Parameter.empty if item.default is MISSING else item.default
            yield inspect.Parameter(item.name, kind, default=default, annotation=item.type)


def _take(group: type[Any], values: dict[str, Any]) -> Any:
    """Take the values of a group's options out of all values."""
    return group(
        **{
            item.name: _take(cast(type[Any], item.type), values)
            if is_dataclass(item.type)
            else values.pop(item.name)
            for item in fields(group)
        }
    )
