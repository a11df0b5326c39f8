import pytest

from modal_core.atomic_file import atomic_path, write_text
from modal_core.errors import ModalAnalysisError, SettingsError
from modal_core.share import share_path
from modal_core.yaml_file import LARGEST_FILE_BYTES, load_yaml


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
