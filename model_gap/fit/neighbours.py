"""The same effect on the next link: what a fit at one link can hide from the search."""

from modal_core.errors import ModelError
from model_gap.effects import moving_links
from model_gap.fit.fit import descend, Descent
from model_gap.fit.linearise import tolerance_columns
from model_gap.fit.thresholds import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor


def neighbours(best: Hypothesis, predictor: Predictor) -> list[Hypothesis]:
    """Return the last effect moved to the links next to its own, roughly fitted there.

    An absorber or a hinge explains much from the link beside its own, once its place and direction
    are free: the right link must then be among those that are compared.  A link that was tried
    before is tried again: from numbers that fit next door the way is short.

    Parameters
    ----------
    best : Hypothesis
        With an effect on a link last.
    predictor : Predictor
        Of the records the rough fit is made on.

    Returns
    -------
    list of Hypothesis
        One per link, its best axis; none for effects that are not on links.
    """
    effect, scene = best.effects[-1], best.scene
    links = moving_links(scene)
    if effect.location not in links or not effect.on_links:
        return []
    own = links.index(str(effect.location))
    near = [link for link in links if abs(links.index(link) - own) == 1]
    last = len(best.effects) - 1
    base, values = best.without(last), best.values()[last]
    columns = tolerance_columns(base, predictor)
    found: dict[str, Descent] = {}
    for other in type(effect).instances(scene):
        link = str(other.location)
        if link not in near:
            continue
        start = base.with_effect(other, values[: len(other.parameters(scene))])
        try:
            down = descend(start.with_details() or start, predictor, columns, FIT.axis_steps)
        except ModelError:
            continue  # not a possible arm
        if link not in found or down.objective < found[link].objective:
            found[link] = down
    starts = [down.hypothesis for down in found.values()]
    return [descend(start, predictor, columns, FIT.link_steps).hypothesis for start in starts]
