"""A quick look: healthy or not, and where, from little data."""

from dataclasses import replace

import pytest

from model_gap.campaign import read_campaign
from model_gap.effects import CATALOGUE
from model_gap.quick_look import LIMITS, of_few, quick_look, State
from model_gap.report import FirstPage, look_lines
from model_gap.result_folder import ResultFolder
from test.model_gap.conftest import ROBOT
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

pytestmark = pytest.mark.slow
SEED = 47
SOFT = {'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.6}
SIZE = {'n_fit': 2, 'n_held': 1, 'duration': 8.0}


@pytest.fixture(scope='module')
def folder_of(robot, tmp_path_factory):
    def make(*effects):
        folder = tmp_path_factory.mktemp('campaign')
        records = make_campaign(ROBOT, effects, SEED, **SIZE)
        write_campaign(folder, records, robot.joint_names, SENSORS)
        return folder

    return make


@pytest.fixture(scope='module')
def soft(robot, folder_of):
    return quick_look(robot, read_campaign(folder_of(SOFT), robot))


def test_a_healthy_arm_is_said_to_be_so_with_nothing_else(robot, folder_of):
    look = quick_look(robot, read_campaign(folder_of(), robot))
    assert look.state is State.HEALTHY, f'seed {SEED}: {look}'
    assert look.where == look.reasons == ()
    assert look_lines(look)[0].startswith('healthy: ')
    assert look.to_dict()['notes'] == list(look.notes)
    assert look_lines(look)[1:] == [f'note: {line}' for line in look.notes]


def test_a_gap_is_seen_and_placed(soft):
    assert soft.state is State.GAP, f'seed {SEED}: {soft}'
    assert any('joint_2' in line for line in soft.where), soft.where
    assert any('is measured at' in line for line in soft.where), soft.where
    said = soft.to_dict()
    assert said['state'] == 'gap' and said['reasons'] and said['over_noise'] > 0.0


def test_notes_of_the_recordings_are_told(soft, tmp_path):
    away = replace(soft, notes=('p0: the joint states stand 9 deg away from its pose',))
    assert look_lines(away)[-1] == f'note: {away.notes[0]}'
    FirstPage.of_look('x', away).write(tmp_path / 'page.html')
    assert 'Note: p0: the joint states stand 9 deg' in (tmp_path / 'page.html').read_text()


def test_the_first_page_says_so_and_that_it_goes_on(soft, tmp_path):
    folder = ResultFolder(tmp_path)
    (tmp_path / 'gap.json').write_text('{}')
    folder.write_first('an arm <b>', soft)
    page = (tmp_path / 'report.html').read_text()
    assert 'There is a gap between model and robot' in page and 'are being sought' in page
    assert 'an arm &lt;b&gt;' in page
    assert not (tmp_path / 'gap.json').exists(), 'what an older search found'
    assert FirstPage.of_look('x', soft).lines


def test_only_the_beginning_of_a_few_recordings_is_looked_at(robot, folder_of):
    folder = folder_of()
    first = read_campaign(folder, robot, most=2)
    assert [item.name for item in first.records] == ['p0_l0.mcap', 'p0_l1.mcap']
    whole = read_campaign(folder, robot)
    longer = replace(
        whole,
        records=tuple(
            replace(item, name=f'{item.name} {number}', pose=item.pose + 1.0 * number)
            for item in whole.records
            for number in range(4)
        ),
    )
    few = of_few(longer)
    # Levels of one pose differ by what the arm swings.
    poses = {(item.name.split('_')[0], item.name.split(' ')[1]) for item in few.records}
    assert len(few.records) == 2 * len(poses)
    assert len(poses) <= LIMITS.fitted_poses + LIMITS.heldout_poses
    assert all(len(it.acceleration) <= LIMITS.seconds * it.sample_rate_hz for it in few.records)


def test_general_laws_have_a_special_case_of_the_catalogue():
    types = {kind.type for kind in CATALOGUE}
    general = [kind for kind in CATALOGUE if kind.special_case]
    assert general and {kind.special_case for kind in general} <= types
