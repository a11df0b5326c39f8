"""What gravity shows to be wrong once the arm is known: what was found bends it too.

A counterbalance, a load or a soft spring turns the links at rest, and the sensors on them, as an
encoder or a gain that is off seems to.  Before the dynamics nothing else is there to explain it.
"""

from collections.abc import Sequence
import dataclasses

from model_gap.campaign import Campaign
from model_gap.cell import Tolerances
from model_gap.gravity.at_rest import rest_of
from model_gap.gravity.faults import Fault, PUT_RIGHT
from model_gap.gravity.weigh import weigh
from model_gap.hypothesis import Hypothesis
from structural_model import FlexibleJointModel, ModelSpec


def weighed_again(
    faults: Sequence[Fault],
    found: Hypothesis,
    given: FlexibleJointModel,
    campaign: Campaign,
    tolerances: Tolerances,
) -> tuple[Fault, ...]:
    """Return what gravity shows to be wrong of an arm as it was found.

    Parameters
    ----------
    faults : sequence of Fault
        What it showed of the arm as it was given: where nothing, nothing is asked.
    found : Hypothesis
        Effects and tolerances of the corrected model.
    given : FlexibleJointModel
        Where its joints and its base stand is asked anew.
    campaign : Campaign
        As it was recorded.
    tolerances : Tolerances
        Of gains and mounts.
    """
    if not faults:
        return ()
    tolerant = found.tolerant
    standing = tolerant.with_spec(standing_as(tolerant.spec, given))
    arm = dataclasses.replace(given, spec=found.add_effects(standing).spec)
    again = weigh(rest_of(arm, campaign), tolerances)
    if not same_put_right(faults, again):
        return again
    # Numbers that were put right and refined since are those of the model that was searched.
    return (
        *(fault for fault in faults if fault.kind in PUT_RIGHT),
        *(fault for fault in again if fault.kind not in PUT_RIGHT),
    )


def same_put_right(one: Sequence[Fault], other: Sequence[Fault]) -> bool:
    """Return whether the same is put right before the dynamics, or may be: rivals are open."""
    places = [[_places(fault) for fault in it if fault.kind in PUT_RIGHT] for it in (one, other)]
    return len(places[0]) == len(places[1]) and all(
        any(own & its for its in places[1]) for own in places[0]
    )


def _places(fault: Fault) -> set[tuple[str, str]]:
    return {(it.kind.value, it.place) for it in (fault, fault.rival) if it is not None}


def standing_as(spec: ModelSpec, given: FlexibleJointModel) -> ModelSpec:
    """Return a spec whose joints and base stand as a model has them."""
    joints = zip(spec.joints, given.spec.joints, strict=True)
    return dataclasses.replace(
        spec,
        joints=tuple(
            dataclasses.replace(one, offset_rad=other.offset_rad) for one, other in joints
        ),
        gravity_m_s2=given.spec.gravity_m_s2,
    )
