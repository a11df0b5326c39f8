"""What is simpler is tried from where a law with more numbers has come to."""

from dataclasses import replace

import pytest

from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit import fit
from model_gap.search import EVIDENCE_BETWEEN, Search
from model_gap.search.refine import rough_fits
from model_gap.search.screen import Trial

SEED = 29
MASS_KG, CENTRE = 32.0, (0.07, 0.08, -0.03)
TOOL = {
    'type': 'payload', 'link': 'flange', 'mass': MASS_KG, 'com': CENTRE,
    'gyration': (0.09, 0.08, 0.1),
}  # fmt: skip


def test_a_payload_is_found_where_only_a_swinging_mass_was_begun(campaign_of, robot):
    campaign = campaign_of([TOOL], SEED, n_fit=2, n_held=0, duration=12.0, levels=(1.0,))
    search = Search.begin(robot, campaign, simulated=True)
    current = fit(search.nominal, search.data.fitting, relinearise=0)
    swinging = TunedMass('link_6', 'x', details=True)
    start = 30.0, 45.0, 0.3, 0.1, 0.1, -0.03, -0.2, -0.3
    trial = Trial(swinging, start, 1000.0, search.nominal)
    best, *others = rough_fits(replace(search, current=current, trials=(trial,)))
    assert best.hypothesis.effects[-1].key == ('payload', 'flange'), f'seed {SEED}'
    mass, *place = best.hypothesis.values()[-1][:4]
    assert mass == pytest.approx(MASS_KG, rel=0.1), f'seed {SEED}'
    assert place == pytest.approx(CENTRE, abs=0.02), f'seed {SEED}'
    assert all(best.log_evidence > item.log_evidence + EVIDENCE_BETWEEN for item in others), (
        f'seed {SEED}'
    )
