"""Guard what others wrote: an exception or a wrong answer of a method is one line, with its place.

Calls happen deep inside a search: without it, what is wrong in a user's file would end as a
traceback through ours, or as a number that is not one.
"""

from collections.abc import Callable, Mapping
import dataclasses
from functools import wraps
import inspect
import math
import re
from string import Formatter
from types import MappingProxyType
from typing import Any

import numpy as np

from modal_core.errors import ModalAnalysisError, SettingsError
from model_gap.cell import CellModel, Filter
from model_gap.effects.code_place import CodePlace
from model_gap.effects.effect import Effect, EffectParameter, Scene

# (answer, where, arguments) -> answer
Check = Callable[[Any, CodePlace, tuple[Any, ...]], Any]


def guarded(kind: type[Effect], where: CodePlace) -> type[Effect]:
    """Return an effect's class, its own methods telling in one line what goes wrong in them."""
    if '_guarded' in vars(kind):
        return kind
    for name, member in list(vars(kind).items()):
        check = CHECKS.get(name)
        if isinstance(member, classmethod | staticmethod):
            told = _told(member.__func__, where.inside(f'{name}()'), check)
            setattr(kind, name, type(member)(told))
        elif isinstance(member, property) and member.fget:
            setattr(kind, name, property(_told(member.fget, where.inside(name), check)))
        elif inspect.isfunction(member):
            setattr(kind, name, _told(member, where.inside(f'{name}()'), check))
    kind._guarded = True  # type: ignore[attr-defined]
    return kind


def _told(method: Callable[..., Any], where: CodePlace, check: Check | None) -> Callable[..., Any]:
    @wraps(method)
    def call(*args: Any, **words: Any) -> Any:
        try:
            found = method(*args, **words)
        except ModalAnalysisError:
            raise
        # Somebody's sys.exit() would end the search without a word.
        except (Exception, SystemExit) as error:
            raise SettingsError(
                f'effect fails: {type(error).__name__}: {error}', where=where.of(error)
            ) from error
        return check(found, where, args) if check else found

    return call


def _refuse(what: str, where: CodePlace, found: object, expected: str) -> None:
    raise SettingsError(what, where=where, found=found, expected=expected)


def _instances(found: Any, where: CodePlace, given: tuple[Any, ...]) -> list[Effect]:
    if not isinstance(found, list | tuple) or not all(isinstance(it, Effect) for it in found):
        _refuse('wrong answer', where, found, 'a list of effects')
    for effect in found:
        _check_words(effect, where.file, given[1])
    return list(found)


def _check_words(effect: Effect, file: str, scene: Scene) -> None:
    """Refuse a sentence that names no parameter, where it is made of ``says``."""
    kind = type(effect)
    if kind.in_words.__func__ is not Effect.in_words.__func__:  # type: ignore[attr-defined]
        return
    forms = filter(None, (effect, effect.detailed()))
    names = ['place', *dict.fromkeys(it.name for form in forms for it in form.parameters(scene))]
    fields = (field for _, field, _, _ in Formatter().parse(kind.says) if field is not None)
    for name in (re.split(r'[.[]', field)[0] for field in fields):
        if name not in names:
            where = CodePlace(file, f'class {kind.__name__}: says')
            _refuse('not a parameter', where, f'{{{name}}}', ', '.join(names))


def _parameters(
    found: Any, where: CodePlace, given: tuple[Any, ...]
) -> tuple[EffectParameter, ...]:
    if not isinstance(found, list | tuple) or not all(
        isinstance(item, EffectParameter) for item in found
    ):
        _refuse('wrong answer', where, found, 'a tuple of EffectParameter')
    for item in found:
        numbers = (item.scale, item.low, item.high, item.neutral)
        right = all(isinstance(it, int | float) and math.isfinite(it) for it in numbers)
        if not (right and item.scale > 0.0 and item.low < item.high):
            _refuse('impossible parameter', where, item, 'finite, scale > 0, low < high')
        if item.log and not (item.neutral > 0.0 and item.low > 0.0):
            _refuse('impossible parameter', where, item, 'neutral > 0 and low > 0 where log')
    names = [item.name for item in found]
    if len(set(names)) < len(names):
        _refuse('two parameters of one name', where, ', '.join(names), 'different names')
    return tuple(found)


def _starts(found: Any, where: CodePlace, given: tuple[Any, ...]) -> list[tuple[float, ...]]:
    try:
        values = [tuple(float(value) for value in start) for start in found]
    except (TypeError, ValueError):
        values = []
    effect, scene = given[:2]
    ranges = effect.parameters(scene)
    count = len(ranges)
    if any(len(start) != count for start in values) and not getattr(effect, 'details', False):
        _refuse('wrong answer', where, values[0], f'{count} numbers in each start')
    if not values or not all(math.isfinite(value) for start in values for value in start):
        _refuse('wrong answer', where, found, 'a list of starts, each with finite values')
    for item, value in (pair for start in values for pair in zip(ranges, start, strict=False)):
        if not _is_within(value, item):
            _refuse(
                'start outside the range of its parameter',
                where,
                f'{item.name} {value:g}',
                f'{item.low:g} to {item.high:g} {item.unit}'.strip(),
            )
    return values


def _is_within(value: float, item: EffectParameter) -> bool:
    """Return whether a parameter may have a value; a grid may round beyond its ends."""
    ends = (item.low, item.high)
    return item.low <= value <= item.high or any(math.isclose(value, end) for end in ends)


def _cell(found: Any, where: CodePlace, given: tuple[Any, ...]) -> CellModel:
    if not isinstance(found, CellModel):
        _refuse('wrong answer', where, type(found).__name__, 'a CellModel')
    for name in ('spec', 'channels', 'forces', 'ripples', 'tones'):
        if not _are_numbers(getattr(found, name)):
            _refuse('not a number in the cell', where, name, 'numbers')
    before = given[1]
    known = {*before.inputs, *before.outputs}
    inputs, outputs = (
        tuple(step if step in known else _step(step, where) for step in steps)
        for steps in (found.inputs, found.outputs)
    )
    checked: CellModel = dataclasses.replace(found, inputs=inputs, outputs=outputs)
    return checked


def _are_numbers(item: Any) -> bool:
    """Return whether nothing inside is NaN; infinite is what is rigid."""
    if isinstance(item, float | np.floating):
        return not math.isnan(item)
    if isinstance(item, tuple):
        return all(_are_numbers(part) for part in item)
    if dataclasses.is_dataclass(item) and not isinstance(item, type):
        return all(_are_numbers(getattr(item, it.name)) for it in dataclasses.fields(item))
    return True


def _step(step: Filter, where: CodePlace) -> Filter:
    """Return a filter that is told of when it fails or its answer is none."""

    def call(omega: Any, spectra: Any) -> Any:
        found = np.asarray(told(omega, spectra))
        if found.shape != spectra.shape:
            _refuse('wrong shape from a filter', where, found.shape, f'{spectra.shape}')
        if wrong := int((~np.isfinite(found)).sum()):
            count = f'{wrong} of {found.size} values'
            _refuse('NaN or infinite values from a filter', where, count, 'numbers')
        return found

    told = _told(step, where, None)
    return call


CHECKS: Mapping[str, Check] = MappingProxyType(
    {
        'instances': _instances,
        'parameters': _parameters,
        'starts': _starts,
        'few_starts': _starts,
        'apply': _cell,
    }
)
