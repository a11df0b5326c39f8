#!/bin/sh
# Name everything that is missing before anything is installed, with the line that installs it.
set -u
python=${1:-python3}
missing=''
need() { missing="$missing $2"; printf 'missing: %s\n' "$1" >&2; }

if ! command -v "$python" >/dev/null 2>&1; then
  need 'Python 3.11, 3.12 or 3.13' 'python3 python3-venv python3-dev'
else
  "$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' || {
    printf 'found: %s; ROS 2 Jazzy is available for Python 3.11 to 3.13\n' \
      "$("$python" --version 2>&1)" >&2
    need 'Python 3.11, 3.12 or 3.13 (name another one with: make PYTHON=python3.12 ...)' 'python3'
  }
  "$python" -c 'import ensurepip, venv' 2>/dev/null ||
    need 'the venv module of Python' 'python3-venv'
  "$python" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' 2>/dev/null ||
    need 'the C headers of Python' 'python3-dev'
fi
command -v c++ >/dev/null 2>&1 || command -v g++ >/dev/null 2>&1 ||
  need 'a C++ compiler' 'g++'

if [ -n "$missing" ]; then
  printf 'Install with:\n  sudo apt install%s\n' "$missing" >&2
  exit 1
fi
