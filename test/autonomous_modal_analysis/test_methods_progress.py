"""Every method is told by name before it is at work, with the part of all that is done."""

from types import SimpleNamespace

import numpy as np

from autonomous_modal_analysis.demos import methods_beside
from autonomous_modal_analysis.demos.methods_beside import every_method
from modal_core.errors import IdentificationError
from modal_core.mode import ModeSet
from oma_identifier.methods import CATALOGUE


def test_each_method_is_named_with_its_number(monkeypatch):
    def refuse(*_):
        raise IdentificationError('nothing')

    monkeypatch.setattr(methods_beside, 'identify_by', refuse)
    found = SimpleNamespace(
        identification=SimpleNamespace(modes=ModeSet((), (), 'ssi_cov')), parts=(None,)
    )
    told = []
    results = every_method(found, (), np.ones(1), np.ones(1), lambda *said: told.append(said))
    asked = [each.name for each in CATALOGUE if not each.needs_inputs and each.name != 'ssi_cov']
    said = [f'{name}, {n + 1} of {len(asked)}' for n, name in enumerate(asked)]
    assert [stage for _, stage in told] == said
    parts = [part for part, _ in told]
    assert parts[0] == 0.0 and parts == sorted(parts) and parts[-1] < 1.0
    assert len(results) == len(asked) + 1
