"""Modes over the level of their motion, for people and for programs."""

from collections.abc import Sequence
import math

from rich.markup import escape

from autonomous_modal_analysis.compared.mode_levels import ModeLevels
from autonomous_modal_analysis.console.terminal import narrow_table, OUTPUT
from autonomous_modal_analysis.identified.results import plain
from modal_reports import FREQUENCY
from oma_identifier.levels import Law, LevelLaw, LEVELS, OwnShare, QuantityLaw

NAME_WIDTH = 12
"""Of a channel's name: with numbers as wide as these a row has 80 columns."""
NAMED = (Law.CUBIC, Law.PLAY, Law.FRICTION)
"""Laws that are told of what is there; the others only of what the levels leave open."""


def show_levels(levels: Sequence[ModeLevels]) -> None:
    """Print one row per mode; modes without a law below, with the reason."""
    table = narrow_table('modes over the level of their motion')
    for heading in ('Hz', 'at', 'mm rms', 'stiffness %', 'law', 'damping %', 'law'):
        right = heading != 'at' and heading != 'law'
        no_wrap = heading != 'law'
        table.add_column(heading, justify='right' if right else 'left', no_wrap=no_wrap)
    table.columns[1].max_width = NAME_WIDTH
    for each in levels:
        if each.law is not None:
            table.add_row(*_row(each, each.law))
    OUTPUT.print(table)
    for line in level_notes(levels):
        OUTPUT.print(line, soft_wrap=True, markup=False)


def level_notes(levels: Sequence[ModeLevels]) -> tuple[str, ...]:
    """Say of each mode why it has no law, or no damping told as that of others is."""
    said = ((each.mode.frequency_hz, _note(each)) for each in levels)
    return tuple(f'{hz:.4g} Hz: {note}' for hz, note in said if note)


def _note(levels: ModeLevels) -> str:
    law = levels.law
    if law is None:
        return f'no law, {levels.reason}'
    said = [*_unsure('stiffness', law.stiffness, levels, 1.0)]
    if law.damping.laws == (Law.UNKNOWN,):
        said.append(
            "damping not told from the frequency's own variation, as with other modes; this mode"
            ' alone excited, or levels in smaller steps, would tell'
        )
    else:
        omega = 2.0 * math.pi * law.mode.frequency_hz
        said.extend(_unsure('damping', law.damping, levels, 1.0 / omega))
        said.extend(_longer(law, levels))
    if law.by_amplitude:
        said.append(
            "damping by the amplitude alone, for the width has the frequency's own variation in"
            ' it, as with other modes'
        )
    said += _of_others('stiffness', law.stiffness, law.stiffness_share)
    said += _of_others('damping', law.damping, law.damping_share)
    return '; '.join(said)


def _of_others(what: str, law: QuantityLaw, share: OwnShare) -> list[str]:
    """Say what part of a change is by the motion of other modes, where they have one."""
    if Law.CUBIC not in law.laws or not share.others_told:
        return []
    own = f'{100.0 * share.value:.0f} ± {100.0 * share.std:.0f} %'
    return [f'of what {what} gains {own} are by its own motion, the rest by that of other modes']


def _longer(law: LevelLaw, levels: ModeLevels) -> list[str]:
    """Say how long records tell cubic damping to 10 %; of stiffness the force's colour counts."""
    cubic = law.damping.cubic
    if law.damping.laws != (Law.CUBIC,) or cubic.slope_std < 0.1 * abs(cubic.slope):
        return []
    now_s = max(motion.duration_s for *_, motion in levels.points)
    needed_s = now_s * (cubic.slope_std / (0.1 * cubic.slope)) ** 2
    return [f'damping to 10 % takes records of {needed_s:.2g} s']


def _unsure(what: str, law: QuantityLaw, levels: ModeLevels, to_m: float) -> list[str]:
    """Say what the levels do not tell of a law, and what would."""
    if len(law.laws) > 1:
        level = f'one of {1e3 * to_m * law.another_level:.2g} mm rms'
        more = level if math.isfinite(law.another_level) else 'longer recordings'
        return [f'the levels do not tell which law {what} has; {more} would']
    if len(levels.points) == LEVELS.fewest_levels and law.laws[0] in NAMED:
        return [f'that {what} is {law.words} is assumed, {len(levels.points)} levels fit any law']
    return []


def _row(levels: ModeLevels, law: LevelLaw) -> tuple[str, ...]:
    stiffness, damping = added_at_largest(levels, law)
    return (
        FREQUENCY.number(law.mode.frequency_hz, law.frequency_std_hz),
        escape(levels.channel),
        moves_mm(levels),
        stiffness,
        law.stiffness.words,
        damping,
        law.damping.words,
    )


def moves_mm(levels: ModeLevels) -> str:
    """Return the smallest and the largest motion [mm rms]."""
    smallest, largest = levels.points[0][2], levels.points[-1][2]
    return f'{1e3 * smallest.displacement_m:.2g}-{1e3 * largest.displacement_m:.2g}'


def added_at_largest(levels: ModeLevels, law: LevelLaw) -> tuple[str, str]:
    """Return what the level adds to stiffness and to damping at the largest motion [%]."""
    largest = levels.points[-1][2]
    return (
        _change(law.mode.stiffness, largest.square_m2, law.stiffness),
        _change(law.mode.damping, largest.square_m2_s2, law.damping),
    )


def _change(start: float, square: float, law: QuantityLaw) -> str:
    """Return what a cubic term adds at the largest level, over what there is without."""
    if start <= 0.0 or not law.may_be_cubic:
        return '-'
    change, std = (
        100.0 * value * square / start for value in (law.cubic.slope, law.cubic.slope_std)
    )
    return f'{change:+.1f} ± {std:.1f}'


def levels_json(names: Sequence[str], levels: Sequence[ModeLevels]) -> dict[str, object]:
    """Return modes over levels as plain values, in SI units; without standard deviation null."""
    return {
        'levels': [
            {
                'channel': each.channel,
                'points': _points_json(names, each),
                'law': None if each.law is None else _law_json(each.law),
                'reason': each.reason,
            }
            for each in levels
        ]
    }


def _points_json(names: Sequence[str], levels: ModeLevels) -> list[dict[str, object]]:
    if levels.stiffness is None:
        return []
    return [
        {
            'recording': names[number],
            'frequency_hz': plain(mode.frequency_hz),
            'damping_ratio': plain(mode.damping_ratio),
            'displacement_m': plain(motion.displacement_m),
            'velocity_m_s': plain(motion.velocity_m_s),
            'stiffness': plain(float(stiffness)),
            'stiffness_std': plain(float(std)),
        }
        for (number, mode, motion), stiffness, std in zip(
            levels.points, levels.stiffness.value, levels.stiffness.std, strict=True
        )
    ]


def _law_json(law: LevelLaw) -> dict[str, object]:
    return {
        'frequency_hz': plain(law.mode.frequency_hz),
        'frequency_std_hz': plain(law.frequency_std_hz),
        'damping_ratio': plain(law.mode.damping_ratio),
        'damping_ratio_std': plain(law.damping_ratio_std),
        'cubic_stiffness': plain(law.mode.cubic_stiffness),
        'cubic_stiffness_std': plain(law.cubic_stiffness_std),
        'cubic_damping': plain(law.mode.cubic_damping),
        'cubic_damping_std': plain(law.cubic_damping_std),
        'stiffness_own_share': plain(law.stiffness_share.value),
        'stiffness_own_share_std': plain(law.stiffness_share.std),
        'damping_own_share': plain(law.damping_share.value),
        'damping_own_share_std': plain(law.damping_share.std),
        'stiffness_law': law.stiffness.words,
        'damping_law': law.damping.words,
        'damping_by_amplitude': law.by_amplitude,
        'stiffness_laws': _laws_json(law.stiffness),
        'damping_laws': _laws_json(law.damping),
    }


def _laws_json(law: QuantityLaw) -> list[dict[str, object]]:
    """Return each law with how likely it is beside the likeliest, and the chance of its χ²."""
    return [
        {
            'law': fit.law.value,
            'likelihood': plain(math.exp(fit.evidence - law.fits[0].evidence)),
            'chance': plain(fit.chance),
        }
        for fit in law.fits
    ]
