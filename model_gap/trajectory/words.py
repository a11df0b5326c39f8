"""What was found, for people."""

from collections.abc import Sequence
import math

import numpy as np

from modal_reports import capital, listed, percent, significant, with_sigma
from model_gap.trajectory.encoder_gap import (
    EncoderGap,
    gap_share,
    Law,
    left_share,
    noise_share,
    Quantity,
)
from model_gap.trajectory.gear_told import GearTold
from model_gap.trajectory.term import TORQUE
from model_gap.trajectory.twist_terms import JointStiffness

ROUGH = 0.5
# Standard deviations: once in 370 numbers by chance.
DISAGREE = 3.0


def place_words(location: str) -> str:
    """Return a place as people say it."""
    return location.replace('_', ' ')


def law_words(law: Law) -> str:
    """Return what, where, how much, and what it is worth."""
    effect = law.effect
    numbers = ', '.join(
        f'{item.name.replace("_", " ")} '
        + (with_sigma(item.value, item.sigma, item.unit) if item.sigma > 0.0 else _plain(item))
        for item in effect.parameters
    )
    name = f'{effect.type.replace("_", " ")} at {place_words(effect.location)}'
    gap = f'held-out gap {percent(law.without)} without it, {percent(law.all_in)} with it'
    doubt = f'; or {listed(law.rivals)}' if law.rivals else ''
    return f'{name}: {numbers} ({gap}{doubt})'


def _plain(item: object) -> str:
    value, unit = getattr(item, 'value', 0.0), getattr(item, 'unit', '1')
    return f'{value:.2g}' + ('' if unit == '1' else f' {unit}')


def headline(gap: EncoderGap) -> str:
    """Return the laws that change the prediction most, in plain sentences."""
    sure = sorted(
        (law for law in gap.laws if not law.rivals), key=lambda law: law.all_in - law.without
    )
    said = [sentence(law) for law in sure[:5]]
    return '; '.join(said) if said else 'nothing beyond the tolerances of the model'


def sentence(law: Law) -> str:
    """Return what a law says of the robot."""
    numbers = {item.name: item.value for item in law.effect.parameters}
    return capital(law.term.sentence(numbers))


def error_lines(quantity: Quantity, heldout: Sequence[str]) -> list[str]:
    """Return the rms errors of the held-out recordings, before and after, by axis."""
    lines = []
    factor, unit = (1.0, 'N m') if quantity.name == TORQUE else (1e6, 'µrad')
    for place, row in enumerate(quantity.rows):
        before, after, noise = (
            float(np.sqrt(np.mean([part[name][place] ** 2 for name in heldout])))
            for part in (quantity.before, quantity.after, quantity.noise)
        )
        lines.append(
            f'{quantity.name} of {row}, held out: {factor * before:.0f} {unit} before, '
            f'{factor * after:.0f} {unit} after ({percent(after / before)}), '
            f'noise {significant(factor * noise, 2)} {unit}'
        )
    return lines


def gap_line(quantity: Quantity, heldout: Sequence[str]) -> str:
    """Return what is left over of the gap, beside what noise leaves and what is measured."""
    return (
        f'{quantity.name}, held-out gap after: {percent(gap_share(quantity, heldout))}, noise '
        f'{percent(noise_share(quantity, heldout))}; left over '
        f'{percent(left_share(quantity, heldout))} of what is measured'
    )


def not_told(gap: EncoderGap) -> list[str]:
    """Return what the data do not tell, one line each, with what to record."""
    lines = []
    for quantity in gap.quantities:
        for term in quantity.unconfirmed:
            lines.append(
                f'{term.label}: fits the recordings it was sought in and does not help in those '
                'held out; it is not in the model'
            )
    for law in gap.laws:
        for item in law.effect.parameters:
            if item.sigma > ROUGH * abs(item.value):
                advice = f': {law.term.experiment}' if law.term.experiment else ''
                lines.append(
                    f'{item.name.replace("_", " ")} of {law.term.label} is known only to '
                    f'{with_sigma(item.value, item.sigma, item.unit)}{advice}'
                )
    lines += _disagreeing(gap)
    lines += _gears_not_told(gap)
    encoders = set(gap.tracks[0].motion.encoders)
    blind = [name for place, name in enumerate(gap.model.axis_names) if place not in encoders]
    if blind:
        lines.append(f'gears of {listed(blind)}: no encoder behind them, no stiffness or play')
    return lines


def _disagreeing(gap: EncoderGap) -> list[str]:
    """Return the numbers on which fitted and held-out recordings do not agree."""
    lines = []
    for law in gap.laws:
        for one, two in zip(law.fitted.parameters, law.heldout.parameters, strict=True):
            spread = math.hypot(one.sigma, two.sigma)
            if spread > 0.0 and abs(one.value - two.value) > DISAGREE * spread:
                lines.append(
                    f'{one.name.replace("_", " ")} of {law.term.label}: '
                    f'{with_sigma(one.value, one.sigma, one.unit)} in the fitted recordings, '
                    f'{with_sigma(two.value, two.sigma, two.unit)} in those held out: the law is '
                    'not the whole truth, and its σ says so'
                )
    return lines


def confirmed_lines(gap: EncoderGap) -> list[str]:
    """Return the gears whose springs are the model's, as well as the campaign tells."""
    return [
        f'stiffness of the gear of {place_words(gear.row)} within {percent(gear.within)} of the '
        f"model's {gear.model:.3g} N m/rad: {with_sigma(gear.stiffness, gear.sigma, 'N m/rad')}"
        for quantity in gap.quantities
        for gear in quantity.gears
        if gear.confirmed
    ]


def _gears_not_told(gap: EncoderGap) -> list[str]:
    """Return the gears with an encoder whose stiffness the campaign does not show."""
    return [
        f'stiffness of the gear of {place_words(gear.row)}: {_told(gear)}, its load varies by '
        f'{significant(gear.load_nm, 2)} N m (rms) only: {JointStiffness.experiment}'
        for quantity in gap.quantities
        for gear in quantity.gears
        if not gear.confirmed
    ]


def _told(gear: GearTold) -> str:
    if math.isinf(gear.model):
        return f'above {gear.least:.2g} N m/rad, no more is told'
    if gear.within < 1.0:
        return f"within {percent(gear.within, 0)} of the model's, no better"
    return f"nothing that the model's {gear.model:.3g} N m/rad does not say"


def unexplained_lines(gap: EncoderGap) -> list[str]:
    """Return what data alone explain and no law does, one line each."""
    lines = []
    for quantity, row, rival in gap.unexplained:
        kind, joint = rival.input
        lines.append(
            f'{quantity} of {place_words(row)}: a smooth function learnt from data takes the '
            f'held-out error from {percent(rival.laws / rival.before)} to '
            f'{percent(rival.beside / rival.before)} of what it was; it goes with the {kind} of '
            f'{place_words(gap.model.axis_names[joint])}, and no law of the catalogue does'
        )
    return lines


def summary_lines(gap: EncoderGap) -> list[str]:
    """Return what the command line prints."""
    heldout = [item.name for item in gap.campaign.heldout]
    lines = [f'{gap.verdict.value}: {headline(gap)}']
    lines += [f'  {law_words(law)}' for law in gap.laws]
    for quantity in gap.quantities:
        lines += error_lines(quantity, heldout)
        lines.append(gap_line(quantity, heldout))
    lines += [f'confirmed: {line}' for line in confirmed_lines(gap)]
    lines += [f'unexplained: {line}' for line in unexplained_lines(gap)]
    lines += [f'not told: {line}' for line in not_told(gap)]
    lines += [f'note: {line}' for line in gap.campaign.remarks]
    return lines
