"""The colours: readable on their ground, told apart by everyone, in one place."""

from pathlib import Path
import re

import numpy as np
import pytest

from modal_reports import HeatScale, Page, palette, render

ROOT = Path(__file__).resolve().parents[2]
TEXT = ('ink', 'soft', 'bad', 'harmonic', 'candidate', 'before', 'after', 'measured', 'accent')
DRAWN = ('accent', 'harmonic', 'candidate', 'spectrum', 'before', 'after', 'measured')
# Told apart by colour: curves before and after, modes and harmonics and candidates.
APART = (('before', 'after'), ('accent', 'candidate'), ('accent', 'bad'), ('before', 'measured'))
# Machado, Oliveira and Fernandes (2009), doi 10.1109/TVCG.2009.113, severity 1, linear RGB.
BLIND = {
    'protan': [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
               [-0.003882, -0.048116, 1.051998]],
    'deutan': [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
               [-0.011820, 0.042940, 0.968881]],
}  # fmt: skip


def linear(colour):
    share = np.array([int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)])
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """Return CIELAB of linear sRGB, white D65."""
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    f = np.cbrt(np.clip(xyz @ rgb, 1e-4, None) / np.array([0.9505, 1.0, 1.089]))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize('side', [0, 1], ids=['light', 'dark'])
def test_text_and_drawings_stand_out_of_their_ground(side):
    for ground in ('paper', 'panel'):
        for names, least in ((TEXT, 4.5), (DRAWN, 3.0)):
            for name in names:
                ratio = palette.contrast(palette.ROLES[name][side], palette.ROLES[ground][side])
                assert ratio >= least, f'{name} on {ground}: {ratio:.2f}'


@pytest.mark.parametrize('side', [0, 1], ids=['light', 'dark'])
@pytest.mark.parametrize('eyes', ['all cones', *BLIND])
def test_colours_with_a_meaning_are_told_apart(side, eyes):
    seen = np.array(BLIND.get(eyes, np.eye(3)))
    for one, other in APART:
        first, second = (lab(seen @ linear(palette.ROLES[name][side])) for name in (one, other))
        # A difference of 2.3 is just noticeable (Mahy et al. 1994); thin lines need much more.
        assert np.linalg.norm(first - second) > 20.0, f'{one} and {other}, {eyes}'


@pytest.mark.parametrize('side', [0, 1], ids=['light', 'dark'])
def test_curves_without_a_role_stand_out_and_the_first_are_told_apart(side):
    colours = [pair[side] for pair in palette.SERIES]
    ground = palette.ROLES['paper'][side]
    assert min(palette.contrast(colour, ground) for colour in colours) >= 3.0
    for seen in (np.eye(3), *map(np.array, BLIND.values())):
        one, two, three = (lab(seen @ linear(colour)) for colour in colours[:3])
        for first, second in ((one, two), (one, three), (two, three)):
            assert np.linalg.norm(first - second) > 20.0


@pytest.mark.parametrize('side', [0, 1], ids=['light', 'dark'])
def test_heat_grows_evenly_and_its_numbers_can_be_read(side):
    colours = [pair[side] for pair in palette.HEAT]
    lightness = np.array([lab(linear(colour))[0] for colour in colours])
    assert np.all(np.diff(lightness) * (1 if side else -1) > 2.0)
    inks = re.findall(r'--heat-ink-\d:(#\w+)', palette.style_sheet())
    inks = inks[side * 8 : side * 8 + 8]
    for ink, colour in zip(inks, colours, strict=True):
        assert palette.contrast(ink, colour) >= 4.5, (ink, colour)


def test_a_step_of_the_heat_stands_for_its_share_of_the_scale():
    linear_scale, decades = HeatScale(0.0, 1.0), HeatScale(1.0, 100.0, logarithmic=True)
    assert [linear_scale.step(value) for value in (-1.0, 0.0, 0.5, 1.0, 7.0)] == [0, 0, 4, 7, 7]
    assert [decades.step(value) for value in (0.0, 1.0, 10.0, 100.0)] == [0, 0, 4, 7]


def test_no_report_has_a_colour_of_its_own():
    """A colour is changed in the palette, or it is changed nowhere."""
    colour = re.compile(r'#[0-9a-fA-F]{3,8}\b(?![\w-])|\b(?:rgb|hsl)a?\(')
    folders = ('modal_reports', 'autonomous_modal_analysis', 'model_gap/report', 'examples')
    files = [
        path
        for folder in folders
        for path in sorted((ROOT / folder).rglob('*'))
        if path.suffix in ('.py', '.css', '.js', '.j2') and path.parent.name != 'vendor'
    ]
    assert len(files) > 60
    for path in files:
        if path.name != 'palette.py':
            found = colour.findall(path.read_text(encoding='utf-8'))
            assert not found, f'{path.relative_to(ROOT)}: {found}'


def test_a_changed_colour_is_in_every_report(monkeypatch, tmp_path):
    template = tmp_path / 'empty.html.j2'
    template.write_text("{% extends 'page.html.j2' %}")
    monkeypatch.setattr(palette, 'ROLES', {**palette.ROLES, 'accent': ('#123456', '#abcdef')})
    for charts in (None, {'stabilisation': {}}):
        page = render(Page('kind', 'title', template, {}, charts))
        assert '--accent:#123456;' in page
        assert '--accent:#abcdef;' in page


def test_every_colour_that_is_asked_for_is_there():
    known = set(re.findall(r'--([\w-]+):', palette.style_sheet()))
    asked = set()
    for path in (*(ROOT / 'modal_reports').rglob('static/*'), *ROOT.glob('*/report/**/*.css')):
        text = path.read_text(encoding='utf-8')
        asked |= set(re.findall(r'var\(--([\w-]+)\)', text))
        asked |= set(re.findall(r"modal\.colour\('([\w-]+)'\)", text))
    assert asked and asked <= known, asked - known
