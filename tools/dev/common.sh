# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# What every ./dev command uses. Sourced by ./dev, which sets $root (the source tree) and its options -e, -u and pipefail.

build_dir=$root/build
deps_dir=$build_dir/deps
deps_root=$deps_dir/root
# CI is set by most CI services; "false" and "0" mean no.
case ${CI:-} in '' | false | 0) in_ci=false ;; *) in_ci=true ;; esac

say() { printf '%s\n' "$*" >&2; }
step() { if [[ -t 2 && -z ${NO_COLOR:-} ]]; then printf '\033[1m-- %s\033[0m\n' "$*" >&2; else printf -- '-- %s\n' "$*" >&2; fi; }
warn() { say "dev: warning: $*"; }
die() { say "dev: $*"; exit 1; }
usage_error() { say "dev: $*"; say "See ./dev help."; exit 2; }
have() { command -v "$1" >/dev/null 2>&1; }
quietly() { # quietly LOG COMMAND...: the output goes to LOG and is shown only if the command fails.
    local log=$1; shift
    if ! "$@" >"$log" 2>&1; then
        cat "$log" >&2
        return 1
    fi
}

# bookworm, trixie, or "" on a system that packages.txt says nothing about.
debian_release() {
    local id='' codename='' version=''
    if [[ -r /etc/os-release ]]; then
        id=$(. /etc/os-release && printf '%s' "${ID:-}")
        codename=$(. /etc/os-release && printf '%s' "${VERSION_CODENAME:-}")
        version=$(. /etc/os-release && printf '%s' "${VERSION_ID:-}")
    fi
    [[ $id == debian ]] || return 0
    case $codename:$version in
        bookworm:* | *:12) echo bookworm ;;
        trixie:* | *:13) echo trixie ;;
    esac
}

# list_packages RELEASE: the names to install.  list_unpacked RELEASE: "NAME SUITE" of those to unpack.
list_packages() {
    sed -E '/^[[:space:]]*(#|$)/d' "$root/packages.txt" | awk -v release="$1" '
        { tag = ""; if (match($0, /\[[^]]*\]/)) tag = substr($0, RSTART + 1, RLENGTH - 2) }
        tag == "" || tag == release { print $1 }'
}
list_unpacked() {
    sed -E '/^[[:space:]]*(#|$)/d' "$root/packages.txt" | awk -v release="$1" '
        match($0, /\[[^]]* from [^]]*\]/) { split(substr($0, RSTART + 1, RLENGTH - 2), part, " "); if (part[1] == release) print $1, part[3] }'
}

installed_version() { # installed_version PACKAGE: its version, "" if it is not installed
    local status
    status=$(dpkg-query -W -f '${db:Status-Status} ${Version}\n' "$1" 2>/dev/null | sed -n 's/^installed //p' | head -n 1) || true
    printf '%s' "$status"
}

# The environment of everything that runs here. build/deps/env.sh is written by `./dev deps`.
load_env() {
    if [[ -f $deps_dir/env.sh ]]; then
        # shellcheck source=/dev/null
        . "$deps_dir/env.sh"
    fi
}

# One ./dev at a time works on a folder: with_lock FILE COMMAND... (in a subshell)
with_lock() {
    local lock=$1
    shift
    mkdir -p "${lock%/*}"
    (
        if ! flock -n 9; then
            say "dev: another ./dev is at work on ${lock%.lock}: waiting for it"
            flock 9
        fi
        # What is started inside does not keep the lock.
        "$@" 9>&-
    ) 9>"$lock"
}
