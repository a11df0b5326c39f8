"""Where model and measurement disagree, and what the model lacks."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from autonomous_modal_analysis.api.modal_plots import new_axes
from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.robot import Layout, read_layout, read_robot, Robot
from autonomous_modal_analysis.console.terminal import no_progress, ProgressCallback
from modal_core.errors import SettingsError
from modal_core.files.version import software
from modal_reports import percent
from modal_reports.palette import on_white
from model_gap.campaign import Campaign, campaign_layout, read_campaign
from model_gap.comparison import compare_model, ModelComparison
from model_gap.find_gap import find_gap, GapResult
from model_gap.gap_json import found_effects, gap_mapping, over_noise
from model_gap.quick_look import QuickLook
from model_gap.report import effect_words, headline
from model_gap.result_folder import ResultFolder
from model_gap.search import SearchSettings
from model_gap.stated import stated_settings
from model_gap.trajectory import is_encoder_campaign


@dataclass(eq=False, repr=False)
class ModelGap(Result):
    """The gap between a model and a campaign of recordings, and what explains it.

    Parameters
    ----------
    result : GapResult
        Verdict, effects, and the gap by place.
    """

    result: GapResult
    _comparison: ModelComparison | None = field(default=None, init=False)

    @property
    def verdict(self) -> str:
        """``named``, ``ambiguous``, ``unexplained`` or ``none``."""
        return str(self.result.decision.verdict.value)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why not ``named``, for people."""
        return self.result.decision.reasons

    @property
    def next_experiments(self) -> tuple[str, ...]:
        """What to record next to decide."""
        return self.result.decision.experiments

    @property
    def effects(self) -> list[dict[str, Any]]:
        """What the model lacks: type, location, and parameters with value, sigma and unit.

        ``other_places`` lists the same for the places where it explains as well.
        """
        return found_effects(self.result)

    @property
    def gap_before(self) -> float:
        """Part of the response the model does not explain, in held-out poses; NaN without any."""
        return self.result.gap_before_heldout

    @property
    def gap_after(self) -> float:
        """The same with the effects added."""
        return self.result.gap_after_heldout

    def compare(self, progress: ProgressCallback = no_progress) -> ModelComparison:
        """Return model and measurement mode by mode; made when it is first asked for.

        Parameters
        ----------
        progress : callable
            Told the fraction done, 0..1.
        """
        if self._comparison is None:
            self._comparison = compare_model(self.result, progress)
        return self._comparison

    def headline(self) -> str:
        """Say the verdict, what was found, and the gap before and after."""
        return (
            f'{self.verdict}: {headline(self.result)}; gap in held-out poses '
            f'{percent(self.gap_before)} before, {percent(self.gap_after)} after, '
            f'noise {percent(self.result.noise_floor)}'
        )

    def columns(self) -> Columns:
        """Return the gap by sensor, joint, mode, band, pose, level and record.

        Before and after in units of the noise: 1 is noise alone; ``share`` is of the whole gap
        before.
        """
        places = self.result.where
        return {
            'kind': [place.kind for place in places],
            'name': [place.name for place in places],
            'over_noise_before': [over_noise(place.before) for place in places],
            'over_noise_after': [over_noise(place.after) for place in places],
            'share': [place.share for place in places],
        }

    def shown(self) -> Columns:
        """Return the effects as texts."""
        return {'effect': effect_words(self.result)}

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama gap --json`` prints; makes the comparison."""
        return gap_mapping(self.result, self.compare())

    def save(self, folder: str | Path) -> None:
        """Write gap.json, model_updated.yaml and report.html, as ``ama gap --out``.

        Raises
        ------
        OSError
            The folder cannot be made or written to.
        """
        place = ResultFolder(Path(folder))
        place.prepare()
        place.write_found(self.result)
        place.write_compared(self.result, self.compare())

    def export(self, path: str | Path) -> None:
        """Write the gap by sensor, joint, mode, band, pose, level and record as one table.

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
        from autonomous_modal_analysis.export import export_table, Table

        about = {'result': self.headline(), 'software': software()}
        export_table(Path(path), Table.of(self.columns(), about))

    def plot_gap(self, kind: str = 'sensor', ax: Any = None) -> Any:
        """Draw the gap by place, before and after.

        Parameters
        ----------
        kind : str
            ``sensor``, ``joint``, ``mode``, ``band``, ``pose``, ``level`` or ``record``.
        ax : matplotlib Axes or None
            Where to; None: a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ModalAnalysisError
            matplotlib is not installed, or there is no such kind.
        """
        places = [place for place in self.result.where if place.kind == kind]
        if not places:
            known = ', '.join(dict.fromkeys(place.kind for place in self.result.where))
            raise SettingsError('no such places', where='kind', found=kind, expected=known)
        ax = new_axes(ax, height_in=1.2 + 0.3 * len(places))
        rows = np.arange(len(places), 0, -1)
        before = [over_noise(place.before) or 0.0 for place in places]
        after = [over_noise(place.after) or 0.0 for place in places]
        ax.barh(rows + 0.2, before, 0.4, color=on_white('before'), label='before')
        ax.barh(rows - 0.2, after, 0.4, color=on_white('after'), label='after')
        ax.axvline(1.0, c=on_white('soft'), lw=0.8)
        ax.set_yticks(rows, [place.name for place in places])
        ax.set_xlabel('gap in units of the noise')
        ax.legend(fontsize='small')
        return ax


def campaign_of(
    folder: str | Path,
    model: Robot,
    layout: Layout | None = None,
    progress: ProgressCallback = no_progress,
    most: int | None = None,
    seconds: float = np.inf,
) -> Campaign:
    """Read a campaign, at most so many recordings and seconds of each; the rest as :func:`gap`."""
    robot, place = read_robot(model), Path(folder)
    if is_encoder_campaign(place):
        raise SettingsError(
            'recordings of encoders and torques, not of accelerations',
            where=place,
            advice='model_gap.trajectory.find_encoder_gap takes them, and the command `ama gap`',
        )
    sensors = read_layout(layout)
    if sensors is None:
        sensors = campaign_layout(place, str(model) if isinstance(model, str | Path) else None)
    return read_campaign(place, robot, sensors, progress, most, seconds)


def gap(
    campaign: str | Path | Campaign,
    model: Robot,
    *,
    layout: Layout | None = None,
    settings: SearchSettings | None = None,
    effects: Iterable[str | Path] = (),
    tolerances: Mapping[str, object] | None = None,
    seed: int = 0,
    progress: ProgressCallback = no_progress,
    first: Callable[[QuickLook], None] = lambda _: None,
) -> ModelGap:
    """Find where simulation and measurement disagree, name the missing effect, add it.

    Parameters
    ----------
    campaign : path or Campaign
        Folder of recordings with campaign.yaml; ``ama campaign`` makes one.
    model : str, path or FlexibleJointModel
        Robot by name, its folder, or its model.yaml.
    layout : SensorLayout, mapping, path or None
        None: the campaign's own, else the robot's.
    settings : SearchSettings or None
        Band, tolerances and catalogue of effects; None: the defaults.
    effects : iterable of path
        Folders or files with effects of one's own.  They are programs: those that
        ``campaign.yaml`` says it needs are not run unless they are given here too.
    tolerances : dict of str to float or None
        How roughly the model is known, by kind (``stiffness``: 0.4) or by name (``stiffness of
        joint_2``: 0.1); they count before those of ``campaign.yaml``, which count before the
        model's.
    seed : int
        Of the draw of held-out poses.
    progress : callable
        Told the fraction done of the search, 0..1.
    first : callable
        Told, while the search goes on, what can be said before any effect is tried.

    Returns
    -------
    ModelGap

    Raises
    ------
    ModalAnalysisError
        The campaign cannot be read, does not fit the robot, the model has no flexibility, or an
        effect of one's own fails.
    """
    data = campaign if isinstance(campaign, Campaign) else campaign_of(campaign, model, layout)
    robot = read_robot(model)
    stated = stated_settings(robot, data, settings, effects, tolerances)
    return ModelGap(find_gap(robot, data, stated, seed, progress, first))
