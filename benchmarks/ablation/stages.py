"""The stages of selection and refinement, and what stands in their place when they are off."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np

from modal_core.numbers.indicators import mac
from oma_identifier.likelihood import ForceCourse
from oma_identifier.likelihood.thresholds import LIKELIHOOD
from oma_identifier.refinement.stages import STAGES

SELECTION, FITS, DECISION = 'selection', 'fits', 'decision'
ROOT = 'oma_identifier'


def place_of(name: str) -> tuple[Any, str]:
    """Return module or class, and attribute of it."""
    where, attribute = name.rsplit('.', 1)
    try:
        return import_module(f'{ROOT}.{where}'), attribute
    except ModuleNotFoundError:
        module, owner = where.rsplit('.', 1)
        return getattr(import_module(f'{ROOT}.{module}'), owner), attribute


@dataclass(frozen=True)
class Stage:
    """A stage that can be switched off.

    Parameters
    ----------
    name : str
        What it does; in results of before also of stages that are gone.
    reach : str
        What it changes: the selection, the fits of the refinement, or what is made of them.
    off : mapping of str to object
        What stands in the place of what when it is off.
    """

    name: str
    reach: str
    off: Mapping[str, Any]


def _stages_without(name: str) -> dict[str, Any]:
    return {'refinement.refinement.STAGES': tuple(s for s in STAGES if s.__name__ != name)}


def _first(first: Any, *_: Any, **__: Any) -> Any:
    return first


def _no(*_: Any, **__: Any) -> bool:
    return False


def _yes(*_: Any, **__: Any) -> bool:
    return True


def _nothing(*_: Any, **__: Any) -> None:
    return None


def _empty(*_: Any, **__: Any) -> list[Any]:
    return []


def _steady(spectra: Any, _: Any) -> ForceCourse:
    return ForceCourse(np.empty(0), spectra.durations_s[0])


def _third(_: Any, __: Any, third: Any, *___: Any) -> Any:
    return third


def _no_test(*_: Any, **__: Any) -> Callable[..., None]:
    return _nothing


def _plain_test(test: Any, *_: Any) -> Any:
    return SimpleNamespace(line_at=lambda frequency_hz: test(frequency_hz, None))


def _alike(first: Any, second: Any) -> bool:
    width = max(-first.pole.real, -second.pole.real)
    shapes = first.physical_shape, second.physical_shape
    return abs(first.pole - second.pole) <= 2.0 * width and float(mac(*shapes)[0, 0]) > 0.9


def _no_outside(*given: Any) -> Any:
    module = import_module(f'{ROOT}.refinement.whole_shapes')
    _, _, group, band, _ = given
    count, n = len(band.scale), len(group)
    return module._Outside(
        np.zeros((count, n), complex), np.zeros((n, count, 0), complex), np.zeros((n, count, n))
    )


STAGES_OFF = (
    # Selection.
    Stage(
        'line test',
        SELECTION,
        {'identify.line_tester': _no_test, 'refine_found.line_tester': _no_test},
    ),
    Stage(
        'line seen by its own shape',
        SELECTION,
        {'selection.join_bands.FilteredLineTest': _plain_test},
    ),
    Stage('undamped poles suspected', SELECTION, {'selection.join_bands.undamped': _empty}),
    Stage('narrow modes shown', SELECTION, {'selection.join_bands.is_shown': _yes}),
    Stage('modes that lines explain', SELECTION, {'identify.without_explained': _first}),
    Stage('lines removed, identified again', SELECTION, {'refine_found.without_lines': _first}),
    Stage('peaks asked for', SELECTION, {'selection.selection._peaks': _yes}),
    Stage('peaks of loud moments', SELECTION, {'identify.without_moments': _first}),
    Stage('sense beside others', SELECTION, {'selection.selection.beside_others': _first}),
    Stage('many orders speak', SELECTION, {'selection.selection._widest': lambda *_: 0.0}),
    Stage('edge of excited band', SELECTION, {'selection.selection.is_edge': _no}),
    Stage('take turns at orders', SELECTION, {'selection.distinct.is_same_mode': _alike}),
    Stage(
        'best members averaged',
        SELECTION,
        {'selection.average._agreeing': lambda poles, _: np.ones(len(poles), bool)},
    ),
    Stage(
        'overlapping modes told apart',
        SELECTION,
        {'selection.band_selector.identify_canonical': _nothing},
    ),
    # Fits.
    Stage(
        'slope of the force',
        FITS,
        {'likelihood.force_prior.LIKELIHOOD': replace(LIKELIHOOD, slope_std=1e-3)},
    ),
    Stage(
        'tails of other modes',
        FITS,
        {
            'likelihood.modes_beside._largest': _empty,
            'likelihood.modes_beside.LIKELIHOOD': replace(LIKELIHOOD, most_remainders=0),
        },
    ),
    Stage('other modes projected out', FITS, {'likelihood.modes_beside._apart': _nothing}),
    Stage(
        'noise by factors',
        FITS,
        {
            'likelihood.reduced_band.noise_scale': lambda plain, _: import_module(
                f'{ROOT}.likelihood.noise_scale'
            ).unexplained_scale(plain)
        },
    ),
    Stage(
        'prior on shapes',
        FITS,
        {'likelihood.shape_prior.LIKELIHOOD': replace(LIKELIHOOD, complexity=1e3)},
    ),
    Stage('ends of the record', FITS, {'likelihood.group_fits.without_ends': _third}),
    Stage(
        'averages divided',
        FITS,
        {'likelihood.group_fits.LIKELIHOOD': replace(LIKELIHOOD, most_divisions=0)},
    ),
    Stage('superfluous modes', FITS, _stages_without('leave_out_superfluous')),
    Stage('second pass', FITS, {'refinement.stages.PASSES': 1}),
    Stage('missing modes', FITS, _stages_without('take_in_missing')),
    Stage('forces of a narrow band', FITS, _stages_without('tell_narrow_forces')),
    # Decision.
    Stage('refinement', SELECTION, {'settings.IdentificationSettings.refines_record': False}),
    Stage(
        'labels',
        FITS,
        {'refinement.stages.undo_label_switching': lambda now, fits, _: (now, fits)},
    ),
    Stage('course of the forces', DECISION, {'refinement.refinement.ForceCourse.of': _steady}),
    Stage('bent under few forces', DECISION, {'refinement.stages._bent': _empty}),
    Stage('motion with the force', DECISION, {'refinement.acceptance.moves_with_force': _no}),
    Stage('shape alike', DECISION, {'refinement.adopt.is_alike': _yes}),
    Stage('poles agree', DECISION, {'refinement.adopt._agree': _yes}),
    Stage('told apart', DECISION, {'refinement.adopt.repeated': lambda _: set()}),
    Stage('new modes tested', DECISION, {'refine_found.without_doubtful': _first}),
    Stage('shapes in all channels', DECISION, {'refinement.whole_shapes._outside': _no_outside}),
)
