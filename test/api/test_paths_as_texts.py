"""What reads a file or a folder takes its path as text too."""

from pathlib import Path

import pytest

from autonomous_modal_analysis.identified.chosen_poles import read_poles
from autonomous_modal_analysis.read_results import read_modes
from machining.task import read_response, read_tool_modes
from modal_core.errors import ModalAnalysisError
from modal_history.pruning import prune
from modal_history.reader import HistoryReader
from modal_history.store import HistoryWriter
from modal_recordings import open_recording
from model_gap.campaign import campaign_layout, read_campaign
from model_gap.trajectory import is_encoder_campaign, read_encoder_campaign, read_encoder_recording
from structural_model import load_layout, load_robot, save_robot
from structural_model.description import load_urdf
from workspace_map import load_map, load_other_map

ROBOT = 'generic_arm_6'


@pytest.fixture(scope='module')
def model():
    return load_robot(ROBOT)


@pytest.fixture(scope='module')
def layout():
    return load_layout(ROBOT)


READERS = {
    'a recording': lambda path, *_: open_recording(path),
    'a campaign': lambda path, model, _: read_campaign(path, model),
    'layout of a campaign': lambda path, *_: campaign_layout(path, None),
    'a campaign of encoders': lambda path, model, _: read_encoder_campaign(path, model),
    'a recording of encoders': lambda path, *_: read_encoder_recording(path, 6),
    'a URDF': lambda path, *_: load_urdf(path),
    'a robot': lambda path, *_: load_robot(path),
    'a layout': lambda path, *_: load_layout(path),
    'a map': load_map,
    "another arm's map": load_other_map,
    'a response': lambda path, *_: read_response(path),
    'modes of a tool': lambda path, *_: read_tool_modes(path),
    'a history': lambda path, *_: HistoryReader(path),
    'a history to write': lambda path, *_: HistoryWriter(path),
    'a history to shorten': lambda path, *_: prune(path),
    'results': lambda path, *_: read_modes(path),
    'picked poles': lambda path, *_: read_poles(path),
}


@pytest.mark.parametrize('name', READERS)
def test_a_reader_says_the_same_of_a_path_and_of_its_text(name, model, layout, tmp_path):
    missing = tmp_path / 'none' / 'there'
    said = []
    for given in (Path(missing), str(missing)):
        with pytest.raises(ModalAnalysisError) as error:
            READERS[name](given, model, layout)
        said.append(str(error.value))
    assert said[0] == said[1]
    assert str(missing) in said[0]


def test_a_robot_is_written_to_a_folder_named_in_text(model, tmp_path):
    save_robot(model, str(tmp_path / 'arm'))
    assert load_robot(str(tmp_path / 'arm')).robot_name == model.robot_name


def test_a_folder_named_in_text_may_be_one_of_encoders(tmp_path):
    assert not is_encoder_campaign(str(tmp_path))
