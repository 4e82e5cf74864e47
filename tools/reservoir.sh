#!/bin/sh
# Makes .reservoir, the environment of the reservoir simulator open-DARTS, beside .venv.
# Run by make reservoir. PYTHON=/path/to/python is tried first. Quick when nothing has changed.
set -eu
cd "$(dirname "$0")/.."
here=$(pwd -P)
unset PYTHONPATH PYTHONHOME PIP_USER PIP_TARGET PIP_PREFIX PIP_ROOT
export PYTHONNOUSERSITE=1

refuse() {
    echo "reservoir: $1" >&2
    exit 2
}

exists() { command -v "$1" >/dev/null 2>&1; }

# Where a Python may be: as in tools/setup.sh. That of .venv may be 3.14, for which there is no
# wheel, so each version is looked for by its name.
candidates() {
    for name in ${PYTHON:+"$PYTHON"} python3.13 python3.12 python3.11 python3 python; do
        command -v "$name" || true
    done
    ls -d "${PYENV_ROOT:-${HOME:-}/.pyenv}"/versions/*/bin/python 2>/dev/null || true
    ! exists uv || uv python find --system '>=3.11,<3.14' 2>/dev/null || true
}

# Prints the interpreter below a virtual environment, if the pinned wheels exist for it.
probe='
import importlib.util, sys, sysconfig
fits = (
    sys.implementation.name == "cpython"
    and (3, 11) <= sys.version_info < (3, 14)
    and not sysconfig.get_config_var("Py_GIL_DISABLED")
    and importlib.util.find_spec("ensurepip") is not None
)
if not fits:
    sys.exit(1)
print(sys._base_executable)
'
find_python() {
    candidates | while IFS= read -r candidate; do
        "$candidate" -I -c "$probe" 2>/dev/null </dev/null && break
    done || true
}

fetch_python() {
    exists uv || return 0
    echo "reservoir: no Python 3.11, 3.12 or 3.13 found; fetching 3.13 with uv" >&2
    uv python install 3.13 >&2 && uv python find --system 3.13 || true
}

check_platform() {
    [ "$(uname -s)-$(uname -m)" = Linux-x86_64 ] || refuse "the binary wheel of open-DARTS is for\
 Linux x86-64 and this is $(uname -s) $(uname -m): name another machine's results with\
 simulator = \"fields\", or take simulator = \"single\"."
}

check_python() {
    python=$(find_python)
    [ -n "$python" ] || python=$(fetch_python)
    [ -n "$python" ] || refuse "no Python 3.11, 3.12 or 3.13 that can make an environment found\
 (open-DARTS has no wheel for another one; tried \$PYTHON, then python3.11 to python3.13, python3\
 and python on PATH, pyenv's versions, and uv): install one ('apt install python3.13-venv', 'pyenv\
 install 3.13', 'uv python install 3.13'), or name one with PYTHON=/path/to/python."
}

check_folder() {
    [ ! -e .reservoir ] || [ -e .reservoir/.staffa ] || rmdir .reservoir 2>/dev/null ||
        refuse "$here/.reservoir was not made by this script, which would overwrite it: delete it\
 or move it away, and run make reservoir again."
}

# The stamp says that the last install ended, and in which folder.
fresh() {
    [ "$(cat .reservoir/.ready 2>/dev/null)" = "$here" ] &&
        .reservoir/bin/python -I -c '' 2>/dev/null &&
        [ -z "$(find constraints-reservoir.txt tools/reservoir.sh -newer .reservoir/.ready)" ]
}

create() {
    rm -rf .reservoir
    mkdir .reservoir
    touch .reservoir/.staffa
    "$python" -I -m venv .reservoir
}

# The constraints name every package that open-DARTS needs, so nothing else is looked for.
install() {
    .reservoir/bin/python -m pip --disable-pip-version-check install \
        --only-binary :all: --no-deps --requirement constraints-reservoir.txt
}

exec 8<.
flock 8 2>/dev/null || true # two makes at once take turns
! fresh || exit 0
check_platform
check_python
check_folder
echo "reservoir: making .reservoir with $python"
create
echo "reservoir: installing open-DARTS, 1.1 GB, which takes some minutes"
if ! install >.reservoir/setup.log 2>&1; then
    tail -n 5 .reservoir/setup.log >&2
    refuse "the installation failed; the whole of it is in .reservoir/setup.log. Check the network,\
 and run make reservoir again."
fi
echo "$here" >.reservoir/.ready
