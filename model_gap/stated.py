"""What model, campaign and options state of a search: effects of one's own, and tolerances."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from modal_core.errors import SettingsError
from model_gap.campaign import Campaign
from model_gap.effects import with_own_effects
from model_gap.search import SearchSettings
from structural_model import FlexibleJointModel


def stated_settings(
    model: FlexibleJointModel,
    campaign: Campaign,
    settings: SearchSettings | None = None,
    effects: Iterable[str | Path] = (),
    tolerances: Mapping[str, object] | None = None,
) -> SearchSettings:
    """Return the settings of a search as they are stated, the later one counts.

    Parameters
    ----------
    model : FlexibleJointModel
        Its file may state how roughly it is known.
    campaign : Campaign
        Its file may state that as well, and name the effects of one's own that it needs.
    settings : SearchSettings or None
        To begin with; its tolerances count instead of those of the two files.
    effects : iterable of path
        Folders or files with effects of one's own, those that the campaign needs among them.
    tolerances : dict of str to number or None
        By kind or by name.

    Raises
    ------
    SettingsError
        An effect cannot be loaded, a tolerance is none, or the campaign needs effects that
        nobody asked for.
    """
    size = settings.tolerances if settings else SearchSettings().tolerances
    if settings is None:
        size = size.stated(dict(model.spec.tolerances), f'{model.robot_name}: tolerances')
        size = size.stated(campaign.tolerances, 'campaign.yaml: tolerances')
    settings = settings or SearchSettings()
    folders = [Path(item) for item in effects]
    _refuse_unasked(campaign.effects, folders)
    return replace(
        settings,
        catalogue=with_own_effects(settings.catalogue, folders),
        tolerances=size.stated(tolerances or {}, 'tolerance'),
    )


def _refuse_unasked(needed: Iterable[Path], asked: Iterable[Path]) -> None:
    """Effects are programs: whoever wrote a campaign's file cannot decide that they run here."""
    there = {path.resolve() for path in asked}
    for path in needed:
        if path.resolve() not in there:
            raise SettingsError(
                'the campaign needs effects, which are programs and are not run unasked',
                where='campaign.yaml: effects',
                found=path,
                advice='read them, then give this folder as effects too',
            )
