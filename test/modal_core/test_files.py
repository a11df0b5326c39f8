import os
import re
import resource
import signal

import pytest

from modal_core.errors import ModalAnalysisError, SettingsError
from modal_core.files.atomic_file import atomic_path, write_text
from modal_core.files.json_file import load_json
from modal_core.files.real_path import real_path
from modal_core.files.share import share_path
from modal_core.files.yaml_file import LARGEST_FILE_BYTES, load_yaml
from modal_core.words.printable import printable
from test.support.work import counted_calls

MOST_CALLS = 50_000


def test_an_error_is_one_line_with_place_finding_expectation_and_advice():
    error = ModalAnalysisError(
        'rate\nmissing', where='a.npy', found=None, expected='rate_hz', advice='add it'
    )
    assert str(error) == 'a.npy: rate missing (expected rate_hz); add it'


def test_a_failed_write_leaves_the_old_file_and_no_remains(tmp_path):
    path = tmp_path / 'result.json'
    write_text(path, 'old')

    def write_half():
        with atomic_path(path) as temporary:
            temporary.write_text('half')
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_half()
    assert path.read_text() == 'old'
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    """The system names no file where the disk is full, and the temporary one elsewhere."""
    (tmp_path / 'folder').mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        write_text(tmp_path / 'folder', 'x')
    assert caught.value.filename == str(tmp_path / 'folder') and '.part' not in str(caught.value)
    with pytest.raises(OSError, match='too long') as caught:
        write_text(tmp_path / ('n' * 250), 'x')
    assert caught.value.filename == str(tmp_path / ('n' * 250))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match='too large') as caught:
            write_text(tmp_path / 'full', 'x' * 2000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert caught.value.filename == str(tmp_path / 'full')
    assert [path.name for path in tmp_path.iterdir()] == ['folder']


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('a: [1, 2', 'not YAML'),
        ('- 1\n- 2', 'not a mapping'),
        ('', 'not a mapping'),
        ('a: &x [1]\nb: *x', 'aliases'),
        ('!!python/object/apply:os.system [ls]', 'not YAML'),
        ('a: ' + 'x' * LARGEST_FILE_BYTES, 'too large'),
    ],
)
def test_bad_yaml_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / 'settings.yaml'
    path.write_text(text)
    with pytest.raises(SettingsError, match=words) as caught:
        load_yaml(path)
    assert str(path) in str(caught.value)


def test_a_missing_yaml_is_named(tmp_path):
    with pytest.raises(SettingsError, match=r'none\.yaml'):
        load_yaml(tmp_path / 'none.yaml')


def test_binary_is_not_yaml(tmp_path):
    path = tmp_path / 'x.yaml'
    path.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(SettingsError):
        load_yaml(path)


def test_shipped_files_are_found():
    assert share_path('package.xml').is_file()
    with pytest.raises(SettingsError, match='nothing_here'):
        share_path('nothing_here')


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('[' * 20_000, 'nested too deeply'),
        ('{a: ' * 5_000, 'nested too deeply'),
        ('a:\n' + ''.join(f'{" " * n}b:\n' for n in range(1, 500)), 'nested too deeply'),
        ('- ' * 20_000, 'nested too deeply'),
        ('rate: 1\nrate: 2\n', 'key given twice'),
        ('? [a]\n: b\n', 'not YAML'),
        ('a: ' + '9' * 10_000, 'not YAML'),
        ('a: [1, -' + '9' * 400 + ']', 'line 1, column 8: number too large'),
        ('password: "secret\\q"', 'not YAML'),
    ],
)
def test_hostile_yaml_costs_nothing_and_its_words_are_not_repeated(tmp_path, text, words):
    path = tmp_path / 'x.npy.yaml'
    path.write_text(text)
    with counted_calls() as calls, pytest.raises(SettingsError, match=words) as caught:
        load_yaml(path)
    # 20 kB of brackets took more than a minute; now none takes a thousand calls.
    assert calls() < MOST_CALLS
    assert len(str(caught.value)) < 300 + len(str(path)) and 'secret' not in str(caught.value)


def test_pipes_devices_and_folders_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / 'pipe.yaml')
    (tmp_path / 'zero.yaml').symlink_to('/dev/zero')
    (tmp_path / 'folder.yaml').mkdir()
    for name in ('pipe', 'zero', 'folder'):
        with pytest.raises(SettingsError, match='not a regular file'):
            load_yaml(tmp_path / f'{name}.yaml')


def test_links_that_lead_in_a_circle_are_a_path_that_cannot_be_opened(tmp_path):
    (tmp_path / 'one').symlink_to('two')
    (tmp_path / 'two').symlink_to('one')
    (tmp_path / 'x').symlink_to(tmp_path / 'nothing' / '..' / 'y')
    assert real_path(tmp_path / 'x') == tmp_path.resolve() / 'y'
    with pytest.raises(OSError, match='symbolic links'):
        real_path(tmp_path / 'one').open()
    with pytest.raises(SettingsError, match='symbolic links'):
        load_yaml(tmp_path / 'one')


def test_json_is_read_or_refused_in_one_line(tmp_path):
    path = tmp_path / 'modes.json'
    for text in ('[' * 200_000, '{"a": ', 'root:x:0:0', '"\udcff"'):
        path.write_text(text, errors='surrogateescape')
        with pytest.raises(SettingsError, match=re.escape(str(path))) as caught:
            load_json(path, 1_000_000)
        assert ':x:0' not in str(caught.value)
    path.write_text('{"a": [1' + '0' * 400 + ']}')
    with pytest.raises(SettingsError, match='number too large'):
        load_json(path, 1000)
    path.write_text('{"a": [1]}')
    assert load_json(path, 100) == {'a': [1]}


def test_what_others_wrote_cannot_steer_a_terminal():
    hostile = 'elbow\x1b]0;owned\x07\x1b[31m\u202egnp\u2066\x9b2J\x7f\ud800\u200b'
    line = str(ModalAnalysisError('unknown\r\n\x1b[2J', where=hostile, found=hostile * 100_000))
    assert line.isprintable() and len(line) < 3000
    assert r'\x1b]0;owned\x07' in line and r'\u202e' in line
    assert printable('Ünïcode 加速度 ± σ °\xa0m/s²') == 'Ünïcode 加速度 ± σ °\xa0m/s²'
