"""Stability lobes: the cut that does not chatter, and the pose to take it in."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

from machining.cut_settings import CutSettings, KINDS
from machining.lobes import Lobes, stability_lobes
from machining.task import read_response, read_tool_modes, ToolResponse
from modal_core.errors import SettingsError
from modal_core.files.json_file import load_json
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.schema import read_values
from modal_core.tool_modes import ToolModes

if TYPE_CHECKING:
    from autonomous_modal_analysis.console.terminal import ProgressCallback
    from autonomous_modal_analysis.cut_pose import PoseChoice

TABLE, MAP_KIND = '.csv', 'workspace_map'
LARGEST_BYTES = 200_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPose:
    """Which pose of a map a cut is made in.

    Parameters
    ----------
    pose : str or sequence of float [deg]
        As :meth:`autonomous_modal_analysis.Robot.pose` takes it.
    serial : bool
        The angles are those of serial joints.
    turn_deg : float [deg]
        How far the tool may be turned about the spindle either way; 0: the pose is not free.
    robot, sensors : str
        Of the map.
    """

    pose: str | Sequence[float]
    serial: bool = False
    turn_deg: float = 0.0
    robot: str = 'irb6660_205_190'
    sensors: str = 'sensors'


@dataclass(frozen=True, eq=False, repr=False)
class LobesResult:
    """Limits of a cut over spindle speed, and what to do.

    Parameters
    ----------
    found : Lobes
        Charts, proposals, remarks.
    name : str
        Of the tool.
    choice : PoseChoice or None
        Of the poses that were looked at; None where the tool is not of a map.
    controller_deg : callable or None
        Takes serial joint angles [rad] to what the controller shows [deg].
    """

    found: Lobes
    name: str
    choice: 'PoseChoice | None' = None
    controller_deg: Callable[[Any], Any] | None = None

    def __repr__(self) -> str:
        """Say what is proposed."""
        best = self.found.proposals[:1]
        said = [f'{1e3 * each.depth_m:.3g} mm at {each.speed_rpm:.0f} rpm' for each in best]
        return f'<LobesResult: {"".join(said) or "no cut proposed"}>'

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama lobes --json`` prints."""
        from autonomous_modal_analysis.lobes_report import lobes_json

        return lobes_json(self.found, self.poses)

    @property
    def poses(self) -> list[dict[str, Any]]:
        """Poses that were looked at, as plain values; the best is marked, empty without a map."""
        if self.choice is None or self.controller_deg is None:
            return []
        return [
            {
                'turn_deg': pose.turn_deg,
                'pose_deg': self.controller_deg(pose.turned.q).tolist(),
                'best': pose is self.choice.best,
                'feed_deg': pose.proposal.feed_deg if pose.proposal else None,
                'speed_rpm': pose.proposal.speed_rpm if pose.proposal else None,
                'depth_m': pose.proposal.depth_m if pose.proposal else None,
                'reason': pose.reason,
            }
            for pose in self.choice.poses
        ]

    def export(self, path: str | Path) -> None:
        """Write the limits over spindle speed as one table, as lobes.csv has them.

        Parameters
        ----------
        path : path
            Ends in .mat, .nc, .parquet or .csv.

        Raises
        ------
        ModalAnalysisError
            No such kind, or a library that it needs is not installed.
        OSError
            It cannot be written.
        """
        from autonomous_modal_analysis.export import export_table
        from autonomous_modal_analysis.lobes_report import lobes_table

        export_table(Path(path), lobes_table(self.found, self.name))

    def save(self, folder: str | Path) -> None:
        """Write lobes.json, lobes.csv and report.html into a folder, made when missing.

        Raises
        ------
        OSError
            It cannot be written to.
        """
        from autonomous_modal_analysis.lobes_report import save_lobes

        save_lobes(Path(folder), self.found, self.name, self.poses)


def lobes(
    tool: str | Path | ToolModes | ToolResponse,
    cut: str | Path | Mapping[str, Any] | None = None,
    *,
    tool_channels: Sequence[str] = (),
    response: str = KINDS[0],
    at: MapPose | None = None,
    progress: 'ProgressCallback | None' = None,
    **changes: Any,
) -> LobesResult:
    """Return the limiting depths of a cut over spindle speed, with the chance of chatter.

    Parameters
    ----------
    tool : path, ToolModes or ToolResponse
        Modes at the tool (YAML, JSON of a map, modes.json of a tap test), or a table of its
        frequency response (.csv); or the file of a map, with ``at``.
    cut : path, mapping or None
        Fields of :class:`machining.cut_settings.CutSettings`, as YAML or as they are.
    tool_channels : sequence of str
        Of a tap test: the channels along x, y and z of the tool; - where there is none.
    response : str
        What a table holds: ``receptance``, ``mobility`` or ``accelerance``.
    at : MapPose or None
        Of a map: the pose; where it leaves the turn about the spindle free, the best is taken.
    progress : callable or None
        Takes the fraction done.
    **changes
        Fields of the cut that override the others.

    Returns
    -------
    LobesResult

    Raises
    ------
    ModalAnalysisError
        The tool's modes have no mass, the cut lacks a coefficient, or a number is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import autonomous_modal_analysis as ama
    >>> from modal_core.tool_modes import ToolModes
    >>> tool = ToolModes(np.array([922.0]), np.array([0.011]), np.array([[5.0, 0.0, 0.0]]))
    >>> cut = {'n_teeth': 2, 'diameter_mm': 10, 'tangential_n_mm2': 600, 'radial_n_mm2': 200}
    >>> found = ama.lobes(tool, cut, feed_deg=[0], min_speed_rpm=9000, n_speeds=5)
    >>> round(1e3 * float(found.found.charts[0].periods.depth_m[0]), 2)
    3.01
    """
    given = load_yaml(Path(cut)) if isinstance(cut, str | Path) else dict(cut or {})
    where = cut if isinstance(cut, str | Path) else ''
    read_values(CutSettings, given, where)
    settings = CutSettings.from_mapping(given | changes, where)
    told = progress or (lambda _: None)
    if isinstance(tool, str | Path) and _is_map(Path(tool)):
        return _lobes_of_map(Path(tool), at, settings, told)
    if at is not None:
        raise SettingsError(
            'only a map has poses', where=tool, advice='give the map.json of `ama map measure`'
        )
    known = (
        tool
        if isinstance(tool, ToolModes | ToolResponse)
        else _read(Path(tool), tool_channels, response)
    )
    name = str(tool) if isinstance(tool, str | Path) else 'tool'
    return LobesResult(stability_lobes(known, settings, told), name)


def _is_map(path: Path) -> bool:
    if path.suffix != '.json':
        return False
    data = load_json(path, LARGEST_BYTES)
    return isinstance(data, dict) and data.get('kind') == MAP_KIND


def _lobes_of_map(
    path: Path, at: MapPose | None, settings: CutSettings, progress: 'ProgressCallback'
) -> LobesResult:
    """Return the lobes in the best of the poses that the task allows."""
    # With the library of rigid bodies, some 50 MB.

    from autonomous_modal_analysis.cut_pose import choose_pose
    from autonomous_modal_analysis.pose import parse_pose
    from structural_model import load_layout, load_robot
    from workspace_map import load_map

    if at is None:
        raise SettingsError('a map knows many poses', where=path, advice='give --pose-deg')
    model = load_robot(at.robot)
    known, _ = load_map(path, model, load_layout(at.robot, at.sensors))
    pose = parse_pose(model, at.pose, at.serial)
    choice = choose_pose(known, pose, settings, at.turn_deg, lambda part: progress(0.5 * part))
    assert choice.best.tool is not None  # noqa: S101  a pose without is not chosen
    found = stability_lobes(choice.best.tool, settings, lambda part: progress(0.5 + 0.5 * part))

    return LobesResult(found, str(path), choice, model.shown_axes)


def _read(path: Path, channels: Sequence[str], response: str) -> ToolModes | ToolResponse:
    if path.suffix == TABLE:
        return read_response(path, response)
    return read_tool_modes(path, channels)
