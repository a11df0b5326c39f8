"""The layouts of viewers that are shipped ask for topics that the nodes publish, and no others."""

import json
from pathlib import Path
import re
from xml.etree import ElementTree

import pytest
import yaml

VIEWS = Path(__file__).resolve().parents[1] / 'config' / 'views'
TOPICS = Path(__file__).resolve().parents[1] / 'docs' / 'reference' / 'topics.md'


# What a display or a curve takes; a panel of raw messages takes any.
ROBOT, MARKERS, NUMBER = 'std_msgs/String', 'visualization_msgs/MarkerArray', 'std_msgs/Float64'
TAKES = {
    'rviz_default_plugins/MarkerArray': MARKERS,
    'rviz_default_plugins/RobotModel': ROBOT,
    'topicToRender': 'diagnostic_msgs/DiagnosticArray',
    'topicPath': '',
    'data': NUMBER,
    'position': 'sensor_msgs/JointState',
}


def topics_of_rviz():
    displays = yaml.safe_load((VIEWS / 'cell.rviz').read_text())['Visualization Manager'][
        'Displays'
    ]
    kinds = ('Topic', 'Description Topic')
    return [
        (display[kind]['Value'], TAKES[display['Class']])
        for display in displays
        for kind in kinds
        if kind in display
    ]


def topics_of_foxglove():
    panels = json.loads((VIEWS / 'cell.foxglove.json').read_text())['configById']
    arm = panels['3D!arm']
    found = [(topic, MARKERS) for topic in arm['topics']]
    found += [(layer['topic'], ROBOT) for layer in arm['layers'].values() if 'topic' in layer]
    for panel in panels.values():
        for path in panel.get('paths', ()):
            topic, field = path['value'].rsplit('.', 1)
            found.append((topic, TAKES[field]))
        keys = ('topicPath', 'topicToRender')
        found += [(panel[key], TAKES[key]) for key in keys if key in panel]
    return found


def topics_of_plotjuggler():
    curves = ElementTree.parse(VIEWS / 'cell.plotjuggler.xml').getroot().iter('curve')
    names = [curve.get('name').rsplit('/', 1) for curve in curves]
    return [(re.sub(r'/joint_\d$', '', topic), TAKES[field]) for topic, field in names]


def documented():
    """Return patterns of the topics in the table of topics, and their types."""
    rows = re.findall(r'^\| (`.+?) \| `(.+?)`.*?\| (.+?) \|.*\|$', TOPICS.read_text(), re.M)
    patterns = []
    for names, kind, publishers in rows:
        for name in re.findall(r'`(.+?)`', names):
            for publisher in re.findall(r'\w+', publishers):
                full = name.replace('~', f'/{publisher}') if name.startswith('~') else name
                full = full if full.startswith('/') else f'/{full}'
                pattern = re.escape(full).replace('<id>', r'\d+').replace(r'\*', r'\w+')
                patterns.append((pattern, kind))
    return patterns


@pytest.mark.parametrize('topics', [topics_of_rviz, topics_of_foxglove, topics_of_plotjuggler])
def test_views_show_topics_there_are_of_the_types_they_take(topics):
    patterns = documented()
    found = topics()
    assert len(found) >= 2
    for topic, takes in found:
        kinds = {kind for pattern, kind in patterns if re.fullmatch(pattern, topic)}
        assert kinds, topic
        assert takes in kinds or not takes, (topic, kinds)


def test_every_panel_of_the_layout_is_placed():
    layout = json.loads((VIEWS / 'cell.foxglove.json').read_text())
    placed = re.findall(r'"(\w+!\w+)"', json.dumps(layout['layout']))
    assert sorted(placed) == sorted(layout['configById'])


# Of the plugin descriptions of rviz_default_plugins, and of rviz_common's own panels.
RVIZ_CLASSES = {
    f'rviz_default_plugins/{name}'
    for name in ('Grid', 'MarkerArray', 'MoveCamera', 'Orbit', 'RobotModel', 'TF')
} | {'rviz_common/Displays', 'rviz_common/Views', ''}


def test_the_layout_of_rviz_names_classes_there_are():
    def classes(item):
        if isinstance(item, dict):
            yield from [item['Class']] if 'Class' in item else []
            item = list(item.values())
        for part in item if isinstance(item, list) else ():
            yield from classes(part)

    assert set(classes(yaml.safe_load((VIEWS / 'cell.rviz').read_text()))) <= RVIZ_CLASSES


def test_the_layout_of_plotjuggler_is_a_tree_of_areas_of_the_sizes_it_states():
    root = ElementTree.parse(VIEWS / 'cell.plotjuggler.xml').getroot()
    assert root[0].tag == 'tabbed_widget'
    for tab in root.iter('Tab'):
        assert len(tab.findall('Container')) == int(tab.get('containers'))
    for splitter in root.iter('DockSplitter'):
        sizes = [float(size) for size in splitter.get('sizes').split(';')]
        assert len(splitter) == len(sizes) == int(splitter.get('count'))
        assert sum(sizes) == pytest.approx(1.0) and splitter.get('orientation') in '-|'
    for plot in root.iter('plot'):
        assert plot.get('mode') == 'TimeSeries' and plot.findall('curve')
