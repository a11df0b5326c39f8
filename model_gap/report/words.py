"""The verdict in words."""

import math

from model_gap.decide import Verdict
from model_gap.find_gap import GapResult
from model_gap.gap_json import found_effects

HEADLINES = {
    Verdict.NAMED: 'The model lacks something, and it has a name',
    Verdict.AMBIGUOUS: 'Something is missing; two explanations cannot be told apart yet',
    Verdict.UNEXPLAINED: 'There is a gap that nothing in the catalogue explains',
    Verdict.NONE: 'No gap beyond noise and known tolerance',
}


def headline(result: GapResult) -> str:
    """Return the verdict as one sentence."""
    return HEADLINES[result.decision.verdict]


def effect_words(result: GapResult) -> list[str]:
    """Return one line per effect: what, where, how much."""
    lines = []
    for effect in found_effects(result):
        place = f' at {effect["location"]}' if effect['location'] else ''
        variant = f' ({effect["variant"]})' if effect['variant'] else ''
        numbers = ', '.join(
            number_words(name, item) for name, item in effect['parameters'].items()
        )
        lines.append(
            f'{effect["type"].replace("_", " ")}{place}{variant}'
            + (f': {numbers}' if numbers else '')
        )
    return lines


def number_words(name: str, item: dict[str, object]) -> str:
    """Return a parameter with deviation and unit."""
    unit = '' if item['unit'] == '1' else f' {item["unit"]}'
    return f'{name.replace("_", " ")} {item["value"]:.4g} ± {item["sigma"]:.2g}{unit}'


def percent(value: float) -> str:
    """Return a fraction as per cent."""
    if not math.isfinite(value):
        return '–'
    return f'{100.0 * value:.1f} %'


def summary_lines(result: GapResult) -> list[str]:
    """Return what the command line prints."""
    lines = [f'{result.decision.verdict.value}: {headline(result)}']
    lines += [f'  {line}' for line in effect_words(result)]
    lines += [f'  because {line}' for line in result.decision.reasons]
    lines += [f'  next: {line}' for line in result.decision.experiments]
    lines.append(
        f'gap, held-out poses: {percent(result.gap_before_heldout)} before, '
        f'{percent(result.gap_after_heldout)} after, noise {percent(result.noise_floor)}'
    )
    lines.append(
        f'gap, fitted poses: {percent(result.gap_before)} before, '
        f'{percent(result.gap_after)} after'
    )
    lines += [f'note: {line}' for line in result.search.campaign.notes]
    return lines
