#!/bin/sh
# Usage: sh tools/bootstrap.sh STAMP [EXTRAS]
# Makes .venv, installs longwave with the named extras (default: dev) into it, touches STAMP. The
# versions are the tested ones of tools/constraints.txt; the package itself allows ranges.
# PYTHON names the interpreter to use; LONGWAVE_NO_APT=1 keeps apt untouched.
set -eu

stamp=${1:?usage: sh tools/bootstrap.sh STAMP [EXTRAS]}
extras=${2:-dev}
venv=.venv

fail() {
    echo "bootstrap: $*" >&2
    exit 1
}

find_python() {
    for candidate in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$candidate"
            return 0
        fi
    done
    return 1
}

has_ensurepip() {
    "$1" -c 'import ensurepip, venv' 2>/dev/null
}

need_ensurepip() {
    has_ensurepip "$1" && return 0
    echo "bootstrap: $1 lacks ensurepip, so it cannot make a virtual environment." >&2
    sh tools/apt.sh "'$1' -c 'import ensurepip, venv'" python3-venv ||
        fail "or name another interpreter with PYTHON=..., then repeat the command"
}

python=$(find_python) || fail "Python 3.11 or newer is missing: install it, or name it with PYTHON=..."
if ! "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
    need_ensurepip "$python"
    echo "bootstrap: making $venv with $("$python" --version)"
    "$python" -m venv --clear "$venv"
fi
echo "bootstrap: installing longwave[$extras] into $venv"
"$venv/bin/python" -m pip install --quiet --no-input --disable-pip-version-check \
    -c tools/constraints.txt -e ".[$extras]"
touch "$stamp"
