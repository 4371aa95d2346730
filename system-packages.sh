#!/bin/sh
# Install what Weft needs from Debian: a software OpenGL for machines without a GPU, a virtual display for the tests of
# the window, and Python's venv. As root this installs; otherwise it says the one line to run.
set -eu

missing=""
need() { # need PACKAGE COMMAND...: PACKAGE is missing unless COMMAND succeeds
    package=$1
    shift
    "$@" >/dev/null 2>&1 || missing="$missing $package"
}
library() { "$PYTHON" -c "import ctypes; ctypes.CDLL('$1')"; }
driver() { ls /usr/lib/*/dri/swrast_dri.so /usr/lib/*/libgallium*.so 2>/dev/null | grep -q .; }

need xvfb command -v Xvfb
need libegl1 library libEGL.so.1
need libgl1 library libGL.so.1
need libglx-mesa0 library libGLX_mesa.so.0
need libegl-mesa0 library libEGL_mesa.so.0
need libgl1-mesa-dri driver
need "python3-venv" "$PYTHON" -c "import venv, ensurepip"

[ -n "$missing" ] || exit 0
if ! command -v apt-get >/dev/null 2>&1; then
    echo "weft: install the equivalents of these Debian packages:$missing" >&2
elif [ "$(id -u)" = 0 ]; then
    apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
else
    echo "weft: system packages are missing; run:  sudo apt-get install --no-install-recommends$missing" >&2
    case $missing in *venv*) exit 1 ;; esac
fi
