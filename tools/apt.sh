#!/bin/sh
# Usage: sh tools/apt.sh TEST PACKAGE...
# Installs the packages with apt-get unless the shell's command TEST succeeds. Root needs nothing,
# others sudo without a password. LONGWAVE_NO_APT=1 forbids it. Status 1, and a line that says what to
# install, if it does not succeed in the end.
set -u

wanted=${1:?usage: sh tools/apt.sh TEST PACKAGE...}
shift

is_there() {
    (eval "$wanted") >/dev/null 2>&1
}

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

# Another apt-get, of the machine's own updates say, is waited for.
apt_get() {
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -oDPkg::Lock::Timeout=300 "$@" \
        >/dev/null 2>&1
}

is_there && exit 0
if [ -z "${LONGWAVE_NO_APT:-}" ] && command -v apt-get >/dev/null && as_root true 2>/dev/null; then
    echo "installing $* with apt-get (LONGWAVE_NO_APT=1 forbids this)" >&2
    apt_get update
    apt_get install -y --no-install-recommends "$@"
fi
is_there && exit 0
echo "not there: install $*" >&2
exit 1
