"""How Sphinx builds this documentation: `make docs`, or rosdoc2 on the ROS build farm.

What is only nice to have may be missing there, and is left out: theme, notebooks, copy button.
"""

import ast
from importlib.util import find_spec
from pathlib import Path
import re
import sys
import xml.etree.ElementTree as ElementTree


def _source_tree() -> Path:
    """Return the folder of ``package.xml``.

    rosdoc2 reads this file from a ``conf.py`` of its own elsewhere, which names it.
    """
    this = Path(__file__).resolve()
    named = [Path(name) for name in re.findall(r'open\("(.+?conf\.py)"\)', this.read_text())]
    for start in (this, *named):
        for folder in start.parents:
            if (folder / 'package.xml').is_file() and (folder / 'docs').is_dir():
                return folder
    raise FileNotFoundError(f'{this}: no folder above with package.xml and docs')


def _installed(*names: str) -> list[str]:
    return [name for name in names if find_spec(name.split('.')[0])]


ROOT = _source_tree()
sys.path[:0] = [str(ROOT), str(ROOT / 'docs')]
_package = ElementTree.parse(ROOT / 'package.xml').getroot()  # noqa: S314

project = _package.findtext('name')
_title = project.replace('_', ' ').capitalize()
author = _package.findtext('maintainer')
copyright = f'{author}. Licence: {_package.findtext("license")}'  # noqa: A001
version = release = _package.findtext('version')

extensions = [
    'sphinx.ext.autodoc',
    'generated_pages',
    *(_installed('myst_nb') or ['myst_parser']),
    *(_installed('numpydoc') or ['sphinx.ext.napoleon']),
    *_installed('sphinx_copybutton'),
]
# What other pages include is no page of its own; rosdoc2 adds pages of one room's modules.
exclude_patterns = [
    'autonomous_modal_analysis*.rst',
    'modules.rst',
    '__readme_include.rst',
    '_build',
    '**/.ipynb_checkpoints',
    'generated_pages',
    'reference/generated/*.md',
]
source_suffix = {'.rst': 'restructuredtext', '.md': 'markdown'}
if 'myst_nb' in extensions:
    source_suffix = {'.rst': 'restructuredtext', '.md': 'myst-nb', '.ipynb': 'myst-nb'}
root_doc = 'index'

myst_enable_extensions = ['colon_fence', 'deflist', 'dollarmath']
myst_heading_anchors = 4
# Notebooks are kept with what they gave; a test runs them.
nb_execution_mode = 'off'

# Members are listed where they are defined, in the order they are written.
# Thousands of functions in every page's table of contents would take minutes.
toc_object_entries = False
# A source that a docstring lists without a mark in its text is fine.
suppress_warnings = ['ref.citation']
autodoc_member_order = 'bysource'
autodoc_typehints = 'none'
numpydoc_show_class_members = False
numpydoc_xref_param_type = False


def _not_installed() -> list[str]:
    """Return what the code imports and this machine lacks; autodoc takes stand-ins for it."""
    wanted = set()
    for path in ROOT.glob('*/**/*.py'):
        if (path.relative_to(ROOT).parts[0]) in _ROOMS:
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Import):
                    wanted |= {alias.name.split('.')[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    wanted.add(node.module.split('.')[0])
    return sorted(name for name in wanted if name not in _ROOMS and find_spec(name) is None)


from generated_pages.place import rooms  # noqa: E402

_ROOMS = rooms()
autodoc_mock_imports = _not_installed()

html_theme = (_installed('furo') or _installed('sphinx_rtd_theme') or ['alabaster'])[0]
# `--live` in a help text is two hyphens.
smartquotes = False
html_title = f'{_title} {release}'
html_static_path = ['_static']
html_css_files = ['site.css']
html_show_sphinx = False

# Theme and parser are chosen above; the pages bring their own reference of modules.
rosdoc2_settings = {
    'override_theme': html_theme != 'furo',
    'support_markdown': False,
    'enable_autodoc': False,
    'enable_intersphinx': False,
    'automatically_extend_intersphinx_mapping': False,
}
