"""Run `ama`; also as ``python -m autonomous_modal_analysis``."""

import sys

from autonomous_modal_analysis.missing import EXIT_MISSING, explain
from modal_core.work.quiet_loading import quiet_loading


def main() -> None:
    """Run the command line; a package that is missing is one line and exit status 2."""
    try:
        with quiet_loading():
            from autonomous_modal_analysis.cli import main as run

        run()
    except ImportError as error:
        missing = explain(error)
        if missing is None:
            raise
        sys.stderr.write(f'error: {missing}\n')
        sys.exit(EXIT_MISSING)


if __name__ == '__main__':
    main()
