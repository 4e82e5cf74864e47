#!/bin/sh
# Makes .venv with the pinned finite-element stack; says what is missing before it creates anything.
# Run by make. PYTHON=/path/to/python is tried first; CC names the C compiler.
set -eu
cd "$(dirname "$0")/.."
here=$(pwd -P)
unset PYTHONPATH PYTHONHOME PIP_USER PIP_TARGET PIP_PREFIX PIP_ROOT
export PYTHONNOUSERSITE=1

refuse() {
    echo "setup: $1" >&2
    exit 2
}

exists() { command -v "$1" >/dev/null 2>&1; }

# Where a Python may be. A pyenv shim can be on PATH and still refuse to run (no installed
# version matches .python-version), so pyenv's versions are listed one by one as well.
candidates() {
    for name in ${PYTHON:+"$PYTHON"} python3 python python3.14 python3.13 python3.12; do
        command -v "$name" || true
    done
    ls -d "${PYENV_ROOT:-${HOME:-}/.pyenv}"/versions/*/bin/python 2>/dev/null || true
    ! exists uv || uv python find --system '>=3.12,<3.15' 2>/dev/null || true
}

# Prints the interpreter if the pinned wheels exist for it (CPython 3.12 to 3.14, with the GIL)
# and, asked for a "complete" one, if it has its C headers and can make an environment.
# The interpreter below a virtual environment is named, since it outlives the environment.
probe='
import importlib.util, os, sys, sysconfig
fits = (
    sys.implementation.name == "cpython"
    and (3, 12) <= sys.version_info < (3, 15)
    and not sysconfig.get_config_var("Py_GIL_DISABLED")
)
if fits and sys.argv[1] == "complete":
    header = os.path.join(sysconfig.get_path("include"), "Python.h")
    fits = os.path.exists(header) and importlib.util.find_spec("ensurepip") is not None
if not fits:
    sys.exit(1)
print(sys._base_executable)
'
find_python() {
    candidates | while IFS= read -r candidate; do
        "$candidate" -I -c "$probe" "$1" 2>/dev/null </dev/null && break
    done || true
}

fetch_python() {
    exists uv || return 0
    echo "setup: no Python 3.12, 3.13 or 3.14 found; fetching 3.13 with uv" >&2
    uv python install 3.13 >&2 && uv python find --system 3.13 || true
}

ask() { "$python" -I -c "import importlib.util, os, sys, sysconfig; print($1)"; }

has_ensurepip() { [ "$(ask 'importlib.util.find_spec("ensurepip") is not None')" = True ]; }

check_platform() {
    [ "$(uname -s)-$(uname -m)" = Linux-x86_64 ] || refuse "the binary wheel of DOLFINx and PETSc\
 is for Linux x86-64 and this is $(uname -s) $(uname -m): install DOLFINx from conda-forge\
 instead, as README.md says."
}

check_python() {
    python=$(find_python complete)
    [ -n "$python" ] || python=$(find_python any)
    [ -n "$python" ] || python=$(fetch_python)
    [ -n "$python" ] || refuse "no Python 3.12, 3.13 or 3.14 found (tried \$PYTHON, then python3,\
 python and python3.12 to python3.14 on PATH, pyenv's versions, and uv): install one\
 ('apt install python3.13-dev python3.13-venv', 'dnf install python3.13-devel', 'pyenv install\
 3.13', 'uv python install 3.13'), or name one with PYTHON=/path/to/python."
    version=$(ask '"%d.%d" % sys.version_info[:2]')
}

check_libc() {
    libc=$(ask 'os.confstr("CS_GNU_LIBC_VERSION")' 2>/dev/null) || libc="another C library"
    case $libc in
        "glibc 2.3"[4-9]* | "glibc 2."[4-9][0-9]*) ;;
        *) refuse "the binary wheel of DOLFINx and PETSc needs glibc 2.34 or newer and this is\
 $libc: install DOLFINx from conda-forge instead, as README.md says." ;;
    esac
}

# FFCx compiles with $CC, or else with the compiler that this Python was built with.
check_compiler() {
    compiler=${CC:-$(ask 'sysconfig.get_config_var("CC") or "cc"')}
    exists "${compiler%% *}" || refuse "no C compiler '${compiler%% *}' on PATH, and staffa needs it\
 because the finite-element forms are compiled at first use: install it ('apt install\
 build-essential', 'dnf install gcc', 'brew install gcc'), or name another one that you have, with\
 'export CC=clang' for instance."
    include=$(ask 'sysconfig.get_path("include")')
    [ -f "$include/Python.h" ] || refuse "Python $version at $python has no C headers\
 ($include/Python.h is missing), and the finite-element forms are compiled against them: install\
 them ('apt install python$version-dev', 'dnf install python$version-devel'), or name another\
 Python with PYTHON=/path/to/python."
    # shellcheck disable=SC2086 # $CC may carry options, or be 'ccache gcc'
    error=$(echo '#include <Python.h>' | $compiler -x c -fsyntax-only -I"$include" - 2>&1) ||
        refuse "the C compiler '$compiler' cannot compile a program that includes Python.h: install\
 the C library's headers ('apt install libc6-dev', 'dnf install glibc-devel'); it says: $error"
}

check_venv() {
    has_ensurepip || exists uv || refuse "Python $version at $python cannot make a virtual\
 environment (it has no module ensurepip): install it ('apt install python$version-venv'), or\
 install uv."
    [ ! -e .venv ] || [ -e .venv/.staffa ] || rmdir .venv 2>/dev/null || refuse "$here/.venv was\
 not made by this script, which would overwrite it: delete it or move it away, and run make again."
}

# The stamp says that the last install ended, and in which folder. Without it, or after the
# folder or the interpreter has moved, the environment is made again.
trusted() {
    [ "$(cat .venv/.ready 2>/dev/null)" = "$here" ] && .venv/bin/python -c '' 2>/dev/null
}

fresh() {
    trusted && [ -z "$(find pyproject.toml constraints.txt tools/setup.sh -newer .venv/.ready)" ]
}

create() {
    rm -rf .venv
    mkdir .venv
    touch .venv/.staffa
    if has_ensurepip; then
        "$python" -I -m venv .venv
    else
        uv venv --quiet --allow-existing --seed --python "$python" .venv
    fi
}

# The build backend is installed first and used in place, so that it is a pinned one too.
install() {
    set -- .venv/bin/python -m pip --disable-pip-version-check install --constraint constraints.txt
    "$@" pip setuptools && "$@" --no-build-isolation --editable '.[wheel,mesh,docs,dev]'
}

exec 9<.
flock 9 2>/dev/null || true # two makes at once take turns
! fresh || exit 0
if trusted; then
    echo "setup: bringing .venv up to date"
    rm .venv/.ready # until the update has ended
else
    check_platform
    check_python
    check_libc
    check_compiler
    check_venv
    echo "setup: making .venv with Python $version ($python)"
    create
    echo "setup: installing the pinned packages into .venv, which takes about a minute"
fi
if ! install >.venv/setup.log 2>&1; then
    tail -n 5 .venv/setup.log >&2
    refuse "the installation failed; the whole of it is in .venv/setup.log. Check the network, and\
 run make again."
fi
echo "$here" >.venv/.ready
