from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'autonomous_modal_analysis'
ROOMS = (
    'abb_emulator',
    'autonomous_modal_analysis',
    'excitation_planner',
    'impact_testing',
    'machining',
    'modal_core',
    'modal_dashboard',
    'modal_history',
    'modal_recordings',
    'modal_reports',
    'model_gap',
    'oma_identifier',
    'robot_bridge',
    'structural_model',
    'workspace_map',
)
# The message definitions a recording is read with, copied into the wheel from their one source.
DEFINITIONS = 'modal_recordings.oma_msgs_definitions'


def shared_files(folder):
    """Return data_files entries that keep the folder's tree under share/<package>."""
    places = {}
    for file in sorted(Path(folder).rglob('*')):
        if file.is_file() and '__pycache__' not in file.parts:
            places.setdefault(f'share/{PACKAGE}/{file.parent}', []).append(str(file))
    return list(places.items())


setup(
    name=PACKAGE,
    version='0.2.0',
    packages=[
        *find_packages(include=[name for room in ROOMS for name in (room, f'{room}.*')]),
        DEFINITIONS,
    ],
    package_dir={DEFINITIONS: 'oma_msgs/msg'},
    package_data={
        **{
            room: ['py.typed', '**/*.html', '**/*.js', '**/*.css', '**/*.j2', '**/*.txt']
            for room in ROOMS
        },
        DEFINITIONS: ['*.msg'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        *shared_files('config'),
        *shared_files('launch'),
    ],
    python_requires='>=3.11',
    install_requires=[
        'setuptools',
        'aiohttp>=3.9',
        'apsw',
        'defusedxml>=0.7',
        'jinja2>=3.1',
        'lz4>=4.3',
        'markupsafe>=2.1',
        'mcap>=1.2',
        'numba>=0.59',
        'numpy>=1.26',
        'pin>=3.2',
        'protobuf>=4.25',
        'pyuff>=2.5',
        'pyyaml>=6.0',
        'rich>=13.7',
        'rosbags>=0.11',
        'scipy>=1.11',
        'threadpoolctl>=3.1',
        'typer>=0.12',
        'zstandard>=0.22',
    ],
    extras_require={
        # oma_msgs is built from ./oma_msgs, see the Makefile.
        'ros': ['ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces'],
        # Tables and pictures of the Python API.
        'tables': ['pandas>=2.0'],
        'parquet': ['pandas>=2.0', 'pyarrow>=15'],
        'plots': ['matplotlib>=3.8'],
        # ama batch; its workers on this machine take work from who has a certificate.
        'batch': ['cryptography>=42', 'distributed>=2024.5'],
        # Recordings of other programs; npTDMS and asammdf are LGPL, so never required.
        'hdf': ['h5py>=3.10'],
        'tdms': ['npTDMS>=1.7'],
        'mdf': ['asammdf>=7.4'],
        'test': [
            # Clients that others wrote: the emulator is held against them.
            'abb-robot-client>=0.4',
            'ABBRobotEGM>=1.0.7',
            'rwsuis>=0.2',
            'rwswrap>=0.1',
            'asammdf>=7.4',
            'cryptography>=42',
            'distributed>=2024.5',
            'h5py>=3.10',
            'hypothesis>=6.100',
            'matplotlib>=3.8',
            'mypy>=1.13',
            'npTDMS>=1.7',
            'pandas>=2.0',
            'pyarrow>=15',
            'pytest>=8.0',
            'pytest-cov>=5.0',
            'pytest-timeout>=2.3',
            'pytest-xdist>=3.5',
            'ruff>=0.8',
            'types-pyyaml',
            'types-protobuf',
            'types-defusedxml',
        ],
        'bench': [
            'h5py>=3.10',
            'koma-python>=1.3',
            'mujoco>=3.2',
            'pyOMA-2>=1.4',
            'scikit-learn>=1.4',
            'strid>=0.4',
            'sdypy-EMA>=0.31',
        ],
        # The pages of docs/ and their pictures: make docs, make reproduce.
        'docs': [
            'furo>=2024.8',
            'matplotlib>=3.8',
            'myst-nb>=1.1',
            'numpydoc>=1.8',
            'pandas>=2.0',
            'sphinx>=7.4',
            'sphinx-copybutton>=0.5',
        ],
    },
    zip_safe=False,
    maintainer='Autonomous Modal Analysis maintainers',
    maintainer_email='maintainers@autonomous-modal-analysis.dev',
    description='A robot identifies its own natural frequencies, damping ratios and mode shapes.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'ama = autonomous_modal_analysis.__main__:main',
            'abb_emulator = autonomous_modal_analysis.executables:abb_emulator',
            'arm_state = autonomous_modal_analysis.executables:arm_state',
            'excitation_planner = autonomous_modal_analysis.executables:excitation_planner',
            'modal_dashboard = autonomous_modal_analysis.executables:modal_dashboard',
            'modal_history = autonomous_modal_analysis.executables:modal_history',
            'modal_map = autonomous_modal_analysis.executables:modal_map',
            'oma_identifier = autonomous_modal_analysis.executables:oma_identifier',
            'robot_bridge = autonomous_modal_analysis.executables:robot_bridge',
            'replay = autonomous_modal_analysis.executables:replay',
        ],
    },
)
