"""No dead numbers: every parameter of every effect moves the prediction, on every robot."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import ModelError
from modal_core.files.share import share_path
from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.read_campaign import read_campaign
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.effects import CATALOGUE, Scene
from model_gap.predict.predict import Predictor
from model_gap.search.screen import larger
from model_gap.search.search import preloads
from model_gap.search.thresholds import SEARCH
from structural_model import load_layout, load_robot
from test.support.hidden_campaign import make_campaign
from test.support.hidden_campaign import SENSORS as OF_IRB
from test.support.write_campaign import write_campaign

pytestmark = pytest.mark.slow
SEED = 3
# Rigid arms have no accelerations to predict; their laws are tested in trajectory/test_laws.
ROBOTS = sorted(
    path.name for path in share_path('config', 'robots').iterdir() if load_robot(path.name).n_dof
)
# Of sigma, rms: a tenth of what an effect must do to be offered at all.
LEAST = 1e-3
# Its amplitude is fitted in every record: of a line that is not there nothing can be moved.
FREE = ('tonal_disturbance',)


@pytest.fixture(scope='module', params=ROBOTS)
def seen(request, tmp_path_factory):
    """A scene and what the sensors would read of a cell, in units of the noise."""
    folder = share_path('config', 'robots', request.param)
    robot = load_robot(folder)
    sensors = OF_IRB
    if not {link for _, link, _ in OF_IRB} <= set(robot.link_names):
        given = load_layout(request.param, 'sensors_light')
        sensors = tuple((item.name, item.frame_id, item.position_m) for item in given)
    options = {'n_fit': 2, 'n_held': 0, 'duration': 6.0, 'levels': (1.0,), 'sensors': sensors}
    records = make_campaign(folder, (), SEED, **options)
    place = tmp_path_factory.mktemp('campaign')
    write_campaign(place, records, robot.joint_names, sensors)
    campaign = read_campaign(place, robot)
    spectra = [record_spectra(item, Band(), 60) for item in campaign.records]
    layout = SensorLayout(tuple(Sensor(name, link, where) for name, link, where in sensors))
    bare = CellModel(explicit_damping(robot.spec), layout.channels)
    names = tuple(sensor.name for sensor in layout)
    scene = Scene(robot, names, bare, (23.0,), preload_rad=preloads(robot, campaign))
    predictor = Predictor(robot, spectra)

    def read(cell):
        pairs = zip(predictor.predict(cell), spectra, strict=True)
        return np.concatenate([(one / np.sqrt(it.noise_power)).ravel() for one, it in pairs])

    return scene, read


def rms(change):
    return float(np.sqrt(np.mean(np.abs(change) ** 2)))


def starts(effect, scene, read, bare):
    """The starts that are screened: made larger where they move too little."""
    found = []
    for start in effect.starts(scene):
        values, moved = tuple(start), 0.0
        for _ in range(SEARCH.most_grown):
            try:
                moved = rms(read(effect.apply(scene.cell, values, scene)) - bare)
            except ModelError:  # so much mass is not there to be taken away
                break
            new = larger(effect, values, scene)
            if moved >= SEARCH.least_moved or new == values:
                break
            values = new
        found.append((moved, values))
    return sorted(found, reverse=True)


def others(item, value):
    """A step away; and where that is not seen, as of a pull at a stiff link, all the way."""
    inner = item.inner(value)
    step = 0.3 if item.log else 0.3 * max(item.scale, abs(inner))
    near = item.value(inner - step)
    yield item.value(inner + step) if near == value else near
    yield item.high


@pytest.mark.parametrize(
    'kind', [kind for kind in CATALOGUE if kind.type not in FREE], ids=lambda kind: kind.type
)
def test_every_parameter_moves_the_prediction(kind, seen):
    scene, read = seen
    bare = read(scene.cell)
    places = list(kind.instances(scene))
    for effect in {id(it): it for it in (*places[:1], *places[-1:])}.values():
        screened = starts(effect, scene, read, bare)
        if screened[0][0] < SEARCH.least_seen:
            continue  # it is not offered there
        # Details are free once a fit is good: never where it can hardly be seen.
        faint = screened[0][0] < 10.0 * SEARCH.least_seen
        whole = (None if faint else effect.detailed()) or effect
        dead = dict.fromkeys(item.name for item in whole.parameters(scene))
        # The strongest, the middle, the weakest: friction that sticks tells nothing of its speed.
        for _, start in (screened[0], screened[len(screened) // 2], screened[-1]):
            items = whole.parameters(scene)
            values = [*start, *(item.neutral for item in items[len(start) :])]
            here = read(whole.apply(scene.cell, values, scene))
            for number, item in enumerate(items):
                for other in others(item, values[number]):
                    moved = [*values[:number], other, *values[number + 1 :]]
                    if rms(read(whole.apply(scene.cell, moved, scene)) - here) > LEAST:
                        dead.pop(item.name, None)
                        break
            if not dead:
                break
        assert not dead, (kind.type, effect.location, effect.variant, list(dead))
