"""The verdict in words."""

from collections.abc import Iterable, Sequence
import math

from modal_reports import capital, percent, with_sigma
from model_gap.calibration import calibration, calibration_words, encoder_words, mounts
from model_gap.decide import Verdict
from model_gap.effects import CATALOGUE, Effect
from model_gap.find_gap import GapResult
from model_gap.gap_json import accepted_effects, placed_effects
from model_gap.report.least_seen_words import least_seen_words
from model_gap.travelled import compares_none
from structural_model.description import KnownEffect

NO_GAP = 'Model and robot agree: what differs is noise and known tolerance'
TOO_LITTLE = 'No gap shows in what was recorded, which is too little to say that there is none'
TRAVELLED = 'The joints travel too far in these recordings to compare them with the model'
STRANGE = 'There is a gap, and nothing in the catalogue explains it'


def headline(result: GapResult) -> str:
    """Return the verdict as one plain sentence."""
    verdict = result.decision.verdict
    if verdict is Verdict.NONE:
        return TOO_LITTLE if result.decision.experiments else NO_GAP
    if verdict is Verdict.UNEXPLAINED:
        return TRAVELLED if compares_none(result.travelled) else STRANGE
    catalogue = result.search.settings.catalogue
    found = '; '.join(
        sentence(effect, catalogue, others) for effect, others in placed_effects(result)
    )
    if verdict is Verdict.NAMED:
        return found
    if result.decision.only_places:
        return f'{found}. Which of these places it is, these recordings do not tell'
    return f'Perhaps: {found[:1].lower()}{found[1:]}. This is not certain yet'


def sentence(
    effect: KnownEffect,
    catalogue: Iterable[type[Effect]] = CATALOGUE,
    others: Sequence[KnownEffect] = (),
) -> str:
    """Return what an effect says of the robot, in its own class's words.

    Parameters
    ----------
    effect : KnownEffect
        With its numbers.
    catalogue : iterable of Effect types
        That of the search.
    others : sequence of KnownEffect
        The same at other places where it may be as well.
    """
    # Gravity names what a narrower catalogue of a search may not have.
    kind = {kind.type: kind for kind in (*CATALOGUE, *catalogue)}[effect.type]
    numbers = {item.name: item.value for item in effect.parameters}
    places = dict.fromkeys(place_words(item) for item in (effect, *others))
    return capital(kind.in_words(' or '.join(places), numbers))


def place_words(effect: KnownEffect) -> str:
    """Return where an effect is, as people say it."""
    place = effect.location or 'the robot'
    if place.startswith('sensor:'):
        axis = f'axis {effect.variant} of ' if effect.variant in ('x', 'y', 'z') else ''
        return f'{axis}sensor {place.removeprefix("sensor:")}'
    return place.replace('_', ' ')


def effect_words(result: GapResult) -> list[str]:
    """Return one line per effect: what, where, how much."""
    return [
        effect.type.replace('_', ' ') + '; or'.join(map(_placed, (effect, *others)))
        for effect, others in placed_effects(result)
    ]


def _placed(effect: KnownEffect) -> str:
    """Return where an effect is, and how much."""
    numbers = ', '.join(
        f'{item.name.replace("_", " ")} {with_sigma(item.value, item.sigma, item.unit)}'
        for item in effect.parameters
    )
    return effect.where + (f': {numbers}' if numbers else '')


def named_springs(result: GapResult) -> list[str]:
    """Return the joints whose spring is named with a factor, which no tolerance is told from."""
    return [it.location for it in accepted_effects(result) if it.type == 'joint_stiffness']


def gravity_words(result: GapResult) -> list[str]:
    """Return what gravity tells before any dynamics, and of which encoders it tells nothing."""
    lines = [fault.words() for fault in result.faults_at_rest]
    untold = [joint for joint, sigma in result.encoders_told.items() if not math.isfinite(sigma)]
    if untold and lines:
        lines.append(f'it does not tell the zero of {", ".join(untold)}')
    return lines


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
    lines += [f'gravity: {line}' for line in gravity_words(result)]
    lines += calibration_words(calibration(result), mounts(result), named_springs(result))
    lines += encoder_words(result)
    lines += [f'would be named: {line}' for line in least_seen_words(result.least_seen)]
    lines += [f'note: {line}' for line in result.search.notes]
    return lines
