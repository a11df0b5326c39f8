"""What people install from: it says one version, and names what is there."""

import json
from pathlib import Path
import re

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]


def test_one_version_is_stated_everywhere():
    stated = {
        'setup.py': re.search(r"version='([^']+)'", (ROOT / 'setup.py').read_text())[1],
        'package.xml': re.search(r'<version>(.+?)<', (ROOT / 'package.xml').read_text())[1],
        'CITATION.cff': yaml.safe_load((ROOT / 'CITATION.cff').read_text())['version'],
        'oma_msgs': re.search(r'<version>(.+?)<', (ROOT / 'oma_msgs/package.xml').read_text())[1],
        'oma_msgs wheel': re.search(
            r'^version = "(.+)"', (ROOT / 'oma_msgs/pyproject.toml').read_text(), re.M
        )[1],
    }
    assert len(set(stated.values())) == 1, stated
    # What comes after a release is under Forthcoming, as catkin has it.
    released = re.search(
        r'^(\d\S+) \(\d{4}-\d\d-\d\d\)$', (ROOT / 'CHANGELOG.rst').read_text(), re.M
    )
    assert released is not None and released[1] in stated.values()
    cited = yaml.safe_load((ROOT / 'CITATION.cff').read_text())
    assert str(cited['date-released']) in released[0]


def test_the_citation_names_what_the_format_requires():
    cited = yaml.safe_load((ROOT / 'CITATION.cff').read_text())
    assert {'cff-version', 'message', 'title', 'authors'} <= set(cited)
    assert cited['license'] in (ROOT / 'setup.py').read_text()


@pytest.mark.parametrize('file', ['Dockerfile', 'docs/howto/install.md'])
def test_extras_and_wheels_that_are_named_exist(file):
    text = (ROOT / file).read_text()
    extras = re.search(r'extras_require=\{(.*?)\n    \},', (ROOT / 'setup.py').read_text(), re.S)[
        1
    ]
    known = set(re.findall(r"^        '(\w+)': \[", extras, re.M))
    named = {each for group in re.findall(r'whl\)\[([\w,]+)\]', text) for each in group.split(',')}
    assert named and named <= known
    built = re.search(r'pip wheel .*', (ROOT / 'Makefile').read_text())[0]
    for wheel in re.findall(r'(\w+_msgs)-\*\.whl', text):
        assert f'./{wheel}' in built and (ROOT / wheel / 'package.xml').is_file()


def test_the_development_container_makes_what_make_knows():
    made = json.loads((ROOT / '.devcontainer/devcontainer.json').read_text())['onCreateCommand']
    target = made.rpartition('make ')[2].replace('.venv', '$(VENV)')
    assert f'\n{target}:' in (ROOT / 'Makefile').read_text()
