"""Stability lobes: the cut that does not chatter."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

from machining.cut_settings import CutSettings, KINDS
from machining.lobes import Lobes, stability_lobes
from machining.task import read_response, read_tool_modes, ToolResponse
from modal_core.schema import read_values
from modal_core.tool_modes import ToolModes
from modal_core.yaml_file import load_yaml

if TYPE_CHECKING:
    from autonomous_modal_analysis.terminal import ProgressCallback

TABLE = '.csv'


@dataclass(frozen=True, eq=False, repr=False)
class LobesResult:
    """Limits of a cut over spindle speed, and what to do.

    Parameters
    ----------
    found : Lobes
        Charts, proposals, remarks.
    name : str
        Of the tool.
    """

    found: Lobes
    name: str

    def __repr__(self) -> str:
        """Say what is proposed."""
        best = self.found.proposals[:1]
        said = [f'{1e3 * each.depth_m:.3g} mm at {each.speed_rpm:.0f} rpm' for each in best]
        return f'<LobesResult: {"".join(said) or "no cut proposed"}>'

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama lobes --json`` prints."""
        from autonomous_modal_analysis.lobes_report import lobes_json

        return lobes_json(self.found)

    def save(self, folder: str | Path) -> None:
        """Write lobes.json, lobes.csv and report.html into a folder, made when missing.

        Raises
        ------
        OSError
            It cannot be written to.
        """
        from autonomous_modal_analysis.lobes_report import save_lobes

        save_lobes(Path(folder), self.found, self.name)


def lobes(
    tool: str | Path | ToolModes | ToolResponse,
    cut: str | Path | Mapping[str, Any] | None = None,
    *,
    tool_channels: Sequence[str] = (),
    response: str = KINDS[0],
    progress: 'ProgressCallback | None' = None,
    **changes: Any,
) -> LobesResult:
    """Return the limiting depths of a cut over spindle speed, with the chance of chatter.

    Parameters
    ----------
    tool : path, ToolModes or ToolResponse
        Modes at the tool (YAML, JSON of a map, modes.json of a tap test), or a table of its
        frequency response (.csv).
    cut : path, mapping or None
        Fields of :class:`machining.cut_settings.CutSettings`, as YAML or as they are.
    tool_channels : sequence of str
        Of a tap test: the channels along x, y and z of the tool; - where there is none.
    response : str
        What a table holds: ``receptance``, ``mobility`` or ``accelerance``.
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
    known = (
        tool
        if isinstance(tool, ToolModes | ToolResponse)
        else _read(Path(tool), tool_channels, response)
    )
    name = str(tool) if isinstance(tool, str | Path) else 'tool'
    return LobesResult(stability_lobes(known, settings, progress or (lambda _: None)), name)


def _read(path: Path, channels: Sequence[str], response: str) -> ToolModes | ToolResponse:
    if path.suffix == TABLE:
        return read_response(path, response)
    return read_tool_modes(path, channels)
