"""The result as gap.json: fixed keys first, what else is known after them."""

from dataclasses import asdict
from importlib.metadata import version
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.files.atomic_file import write_text
from model_gap.calibration import calibration, mounts
from model_gap.comparison import comparison_mapping, ModelComparison
from model_gap.decide import open_places, Verdict
from model_gap.find_gap import GapResult
from model_gap.hypothesis import Hypothesis, known_effects
from model_gap.named_at_rest import named_at_rest
from model_gap.search import Candidate
from structural_model.description import KnownEffect

PACKAGES = ('autonomous_modal_analysis', 'numpy', 'scipy', 'pin')


def gap_mapping(result: GapResult, comparison: ModelComparison | None = None) -> dict[str, Any]:
    """Return the content of gap.json as plain values.

    Parameters
    ----------
    result : GapResult
        Of :func:`find_gap`.
    comparison : ModelComparison or None
        Of :func:`compare_model`; None leaves the tables of the comparison out.
    """
    search, decision = result.search, result.decision
    first = search.rounds[0].before
    fastest_hz = max(record.sample_rate_hz for record in search.campaign.records)
    band = search.settings.band.within(fastest_hz)
    return {
        'verdict': decision.verdict.value,
        'effects': found_effects(result),
        'candidates': [
            {
                'round': number,
                'accepted': any(item is other for other in decision.accepted),
                **_candidate(item),
            }
            for number, step in enumerate(search.rounds, start=1)
            for item in step.candidates
        ],
        'where': [
            {
                'kind': item.kind,
                'name': item.name,
                'over_noise_before': over_noise(item.before),
                'over_noise_after': over_noise(item.after),
                'share': _number(item.share),
            }
            for item in result.where
        ],
        'gap_before': _number(result.gap_before),
        'gap_after': _number(result.gap_after),
        'gap_before_heldout': _number(result.gap_before_heldout),
        'gap_after_heldout': _number(result.gap_after_heldout),
        'noise_floor': _number(result.noise_floor),
        'reasons': list(decision.reasons),
        'next_experiments': list(decision.experiments),
        'over_noise_with_tolerances_only': over_noise(first.misfit),
        'over_noise_with_tolerances_only_heldout': over_noise(search.rounds[0].heldout_before),
        'screened': [
            {
                'type': item.effect.type,
                'location': item.effect.location,
                'variant': item.effect.variant,
                'promised_gain': _number(item.gain),
            }
            for item in search.rounds[0].trials[:40]
        ],
        'tolerances': _tolerances(result.final),
        'gravity': [
            {
                'kind': item.kind.value,
                'place': item.place,
                'values': list(item.values),
                'sigma': _number(item.sigma),
                'log_evidence_gain': _number(item.gain),
                'words': item.words(),
            }
            for item in result.faults_at_rest
        ],
        'encoders_told_by_gravity_deg': {
            joint: _number(sigma) for joint, sigma in result.encoders_told.items()
        },
        'calibration': [
            {**asdict(item), 'sigma': _number(item.sigma)} for item in calibration(result)
        ],
        'mounts': [
            {**asdict(item), 'sigma_deg': _number(item.sigma_deg)} for item in mounts(result)
        ],
        'least_seen': [
            {
                'type': item.effect.type,
                'location': item.effect.location,
                'variant': item.effect.variant,
                'parameter': item.number.name,
                'unit': item.number.unit,
                'value': _number(item.value),
            }
            for item in result.least_seen
        ],
        'excitation': search.campaign.excitation,
        'comparison': None if comparison is None else comparison_mapping(comparison),
        'remarks': list(search.campaign.remarks),
        'notes': list(search.notes),
        'band_hz': [band.low_hz, band.high_hz],
        'lines_hz': list(search.scene.lines_hz),
        'fitting': [item.record.name for item in search.data.fitting.records],
        'heldout': [item.record.name for item in search.data.heldout.records],
        'seed': result.seed,
        'versions': {name: _version(name) for name in PACKAGES},
    }


def accepted_effects(result: GapResult) -> tuple[KnownEffect, ...]:
    """Return the effects that were accepted, at their final values: gravity's come first."""
    decision = result.decision
    if decision.verdict not in (Verdict.NAMED, Verdict.AMBIGUOUS):
        return ()
    found = candidate_effects(decision.accepted[-1]) if decision.accepted else ()
    return (*named_at_rest(result.faults_at_rest, result.calibrated), *found)


def placed_effects(result: GapResult) -> list[tuple[KnownEffect, tuple[KnownEffect, ...]]]:
    """Return each accepted effect, and the same at the places that it is not told from."""
    others = {
        item.effect.key: tuple(
            candidate_effects(other)[-1]
            for other in open_places(result.search.rivals, item.effect)
        )
        for item in result.decision.accepted
    }
    return [(it, others.get((it.type, it.location), ())) for it in accepted_effects(result)]


def found_effects(result: GapResult) -> list[dict[str, Any]]:
    """Return the accepted effects as gap.json lists them."""
    return [
        {**_effect(item), 'other_places': [_effect(other) for other in others]}
        for item, others in placed_effects(result)
    ]


def candidate_effects(candidate: Candidate) -> tuple[KnownEffect, ...]:
    """Return all effects of a candidate's hypothesis with values and standard deviations."""
    hypothesis = candidate.fit.hypothesis
    items = hypothesis.parameters
    slopes = [
        item.slope(float(inner)) for item, inner in zip(items, hypothesis.inner, strict=True)
    ]
    return known_effects(hypothesis, candidate.fit.covariance * np.outer(slopes, slopes))


def _effect(effect: KnownEffect) -> dict[str, Any]:
    return {
        'type': effect.type,
        'location': effect.location or None,
        'variant': effect.variant,
        'parameters': {
            item.name: {
                'value': _number(item.value),
                'sigma': _number(item.sigma),
                'unit': item.unit,
            }
            for item in effect.parameters
        },
    }


def write_gap_json(
    result: GapResult, path: Path, comparison: ModelComparison | None = None
) -> None:
    """Write gap.json, whole or not at all."""
    text = json.dumps(
        gap_mapping(result, comparison), indent=2, allow_nan=False, ensure_ascii=False
    )
    write_text(path, text + '\n')


def _candidate(item: Candidate) -> dict[str, Any]:
    return {
        **_effect(candidate_effects(item)[-1]),
        'log_evidence_gain': _number(item.gain),
        'over_noise': over_noise(item.fit.misfit),
        'over_noise_heldout': over_noise(item.heldout_misfit),
    }


def _tolerances(hypothesis: Hypothesis) -> list[dict[str, Any]]:
    """Return the tolerances that moved most, in standard deviations."""
    values = hypothesis.tolerance_values
    order = np.argsort(-np.abs(values))[:12]
    return [
        {'name': hypothesis.tolerances[place].name, 'deviations': _number(float(values[place]))}
        for place in order
    ]


def over_noise(misfit: float) -> float | None:
    """Return what is left over as an amplitude in units of the noise: 1 is noise alone."""
    return _number(math.sqrt(misfit)) if misfit >= 0.0 else None


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _version(name: str) -> str:
    try:
        return version(name)
    except ImportError:
        return 'unknown'
