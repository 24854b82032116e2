# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# ./dev deps: what is missing is listed, then installed with apt. The machine's package sources stay as they are: what the release lacks
# is fetched with a private set of apt folders and unpacked under build/deps/root.

lavapipe_minimum=25.0
vma_minimum=3.0

usable_unpacked() { # is a good enough version of $1 installed, so that nothing has to be unpacked?
    local version minimum=0
    version=$(installed_version "$1")
    case $1 in
        mesa-vulkan-drivers) minimum=$lavapipe_minimum ;;
        libvulkan-memory-allocator-dev) minimum=$vma_minimum ;;
    esac
    [[ -n $version ]] && dpkg --compare-versions "$version" ge "$minimum"
}

missing_packages() { # missing_packages RELEASE
    local wanted installed
    wanted=$(list_packages "$1" | sort -u)
    # shellcheck disable=SC2086
    installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' $wanted 2>/dev/null | sed -n 's/ installed$//p' | sort -u) || true
    comm -23 <(printf '%s\n' "$wanted") <(printf '%s\n' "$installed")
}

as_root() {
    if [[ $EUID -eq 0 ]]; then "$@"; else sudo -- "$@"; fi
}

apt_install() { # apt_install PACKAGE...
    local options=(-y -q --no-install-recommends -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0)
    mkdir -p "$build_dir"
    step "Installing $# packages (log: build/apt.log)"
    : >"$build_dir/apt.log"
    # The package lists may be old or absent: the first failure is answered by an update.
    if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}" install "$@" >>"$build_dir/apt.log" 2>&1 </dev/null; then
        as_root apt-get -q -o DPkg::Lock::Timeout=600 update >>"$build_dir/apt.log" 2>&1 || die "apt-get update failed: see build/apt.log"
        if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}" install "$@" >>"$build_dir/apt.log" 2>&1 </dev/null; then
            tail -n 15 "$build_dir/apt.log" >&2
            die "apt-get install failed: see build/apt.log"
        fi
    fi
}

ask() { # ask QUESTION: yes unless the answer begins with n
    local answer
    printf '%s [Y/n] ' "$1" >&2
    read -r answer || return 1
    [[ ! $answer =~ ^[nN] ]]
}

install_missing() { # install_missing RELEASE ASSUME_YES
    local release=$1 assume_yes=$2 missing
    mapfile -t missing < <(missing_packages "$release")
    [[ ${#missing[@]} -gt 0 ]] || return 0
    say "These packages are missing:"
    printf '  %s\n' "${missing[*]}" | fold -s -w 118 >&2
    if [[ $EUID -ne 0 ]] && ! have sudo; then
        die "not root, and there is no sudo. As root: apt-get install --no-install-recommends ${missing[*]}"
    fi
    if [[ $assume_yes != true ]]; then
        if [[ -t 0 ]]; then
            ask "Install them with apt?" || die "stopped: these packages are needed"
        elif [[ $EUID -ne 0 ]]; then
            die "not root and no terminal to ask on: ./dev deps --yes installs them with sudo"
        fi
    fi
    apt_install "${missing[@]}"
}

# The address of the Debian archive that this machine uses.
archive_address() {
    apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' "Codename: $1" 2>/dev/null | head -n 1 || true
}

fetch_unpacked() { # fetch_unpacked RELEASE "PACKAGE SUITE"...
    local release=$1 scratch=$deps_dir/apt address entry suites suite options
    shift
    address=$(archive_address "$release")
    if [[ -z $address ]]; then
        # No package lists on this machine yet (a fresh image).
        [[ $EUID -eq 0 ]] || have sudo || die "the package lists are empty: run 'apt-get update' as root, then ./dev deps again"
        quietly "$build_dir/apt.log" as_root apt-get -q -o DPkg::Lock::Timeout=600 update || die "apt-get update failed"
        address=$(archive_address "$release")
    fi
    [[ -n $address ]] || die "apt names no Debian archive for $release (apt-get indextargets): cannot fetch what it lacks"
    rm -rf "$scratch"
    mkdir -p "$scratch/lists/partial" "$scratch/cache/archives/partial" "$scratch/debs"
    suites=$(printf '%s\n' "$@" | awk '{ print $2 }' | sort -u)
    for suite in $suites; do
        printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "$address" "$suite"
    done >"$scratch/sources.list"
    options=(-q -o "Dir::Etc::SourceList=$scratch/sources.list" -o Dir::Etc::SourceParts=/dev/null -o Dir::Etc::Preferences=/dev/null
        -o Dir::Etc::PreferencesParts=/dev/null -o "Dir::State::Lists=$scratch/lists" -o "Dir::Cache=$scratch/cache" -o APT::Sandbox::User=root
        -o Acquire::Languages=none -o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false
        -o Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled=false -o APT::Update::Error-Mode=any)
    step "Fetching what $release lacks: $(printf '%s\n' "$@" | awk '{ printf "%s%s", sep, $1; sep = ", " }')"
    quietly "$scratch/update.log" apt-get "${options[@]}" update || die "cannot read the package lists of ${suites//$'\n'/, }"
    for entry in "$@"; do
        suite=${entry#* }
        (cd "$scratch/debs" && quietly "$scratch/download.log" apt-get "${options[@]}" download "${entry% *}/$suite") ||
            die "cannot download ${entry% *} from $suite"
    done
}

# Unpacks only what is used of each package: Mesa's lavapipe without the other drivers, the allocator's header.
unpack() {
    local deb
    rm -rf "$deps_root.new"
    mkdir -p "$deps_root.new"
    for deb in "$deps_dir"/apt/debs/*.deb; do
        case ${deb##*/} in
            mesa-vulkan-drivers_*)
                dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$deps_root.new" --wildcards \
                    './usr/lib/*/libvulkan_lvp.so' './usr/share/doc/*/copyright'
                ;;
            *) dpkg-deb -x "$deb" "$deps_root.new" ;;
        esac
        dpkg-deb -W --showformat '${Package} ${Version}\n' "$deb"
    done >"$deps_root.new/VERSIONS"
    rm -rf "$deps_root"
    mv "$deps_root.new" "$deps_root"
    rm -rf "$deps_dir/apt"
}

# Absolute paths inside: written anew whenever the tree has moved.
write_env() {
    local driver icd=$deps_dir/lavapipe.json
    mkdir -p "$deps_dir"
    driver=$(find "$deps_root" -name libvulkan_lvp.so 2>/dev/null | head -n 1 || true)
    {
        echo "# Written by ./dev deps. Use: eval \"\$(./dev env)\""
        printf 'export PARHELION_DEPS_ROOT=%q\n' "$deps_root"
        if [[ -n $driver ]]; then
            # Added to the drivers that the loader finds by itself, so that a GPU stays visible.
            printf 'case ":${VK_ADD_DRIVER_FILES:-}:" in *:%q:*) ;; *) export VK_ADD_DRIVER_FILES=%q"${VK_ADD_DRIVER_FILES:+:$VK_ADD_DRIVER_FILES}" ;; esac\n' \
                "$icd" "$icd"
            # An older lavapipe of the system would stand beside it under the same name.
            if [[ -n $(installed_version mesa-vulkan-drivers) ]]; then echo 'export VK_LOADER_DRIVERS_DISABLE="lvp_icd*"'; fi
        fi
    } >"$deps_dir/env.sh.new"
    if [[ -n $driver ]]; then
        printf '{"file_format_version": "1.0.0", "ICD": {"library_path": "%s", "api_version": "1.4.305"}}\n' "$driver" >"$icd.new"
        mv "$icd.new" "$icd"
    fi
    mv "$deps_dir/env.sh.new" "$deps_dir/env.sh"
}

ensure_deps() { # ensure_deps [--yes]
    with_lock "$deps_dir.lock" ensure_deps_locked "$@"
    load_env
}

ensure_deps_locked() {
    local assume_yes=false release wanted entry
    if [[ ${1:-} == --yes || ${1:-} == -y ]]; then assume_yes=true; shift; fi
    [[ $# -eq 0 ]] || usage_error "deps: unknown argument '$1'"
    if ! have apt-get || ! have dpkg-query; then
        die "no apt here. Install what packages.txt lists in your system's way, then use CMake: cmake --preset release"
    fi
    release=$(debian_release)
    if [[ -z $release ]]; then
        warn "this is neither Debian 12 nor 13: Debian 13's package names are tried"
        release=trixie
    fi
    mkdir -p "$deps_dir"
    install_missing "$release" "$assume_yes"
    wanted=()
    while read -r entry; do
        [[ -n $entry ]] || continue
        usable_unpacked "${entry% *}" || wanted+=("$entry")
    done < <(list_unpacked "$release")
    local stamp
    stamp=$(printf '%s\n' "$release" "${wanted[@]}")
    if [[ ${#wanted[@]} -gt 0 && "$(cat "$deps_dir/unpacked.stamp" 2>/dev/null)" != "$stamp" ]]; then
        fetch_unpacked "$release" "${wanted[@]}"
        unpack
        printf '%s\n' "$stamp" >"$deps_dir/unpacked.stamp"
    fi
    write_env
}

cmd_deps() {
    ensure_deps "$@"
    say "All packages are there.$([[ -f $deps_root/VERSIONS ]] && awk '{ printf "%s%s %s", (NR == 1 ? " Unpacked: " : ", "), $1, $2 }' "$deps_root/VERSIONS")"
}
