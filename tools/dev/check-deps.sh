# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# ./dev check-deps: the package list resolves from nothing, and what was built includes and links nothing outside of it.

# Prints the names that `apt-get install` of the list would install on a machine with no package at all.
closure() { # closure RELEASE APT-OPTIONS...
    local release=$1 packages
    shift
    mapfile -t packages < <(list_packages "$release" | sort -u)
    apt-get --simulate --no-install-recommends -o Dir::State::status=/dev/null "$@" install "${packages[@]}" | sed -n 's/^Inst \([^ ]*\).*/\1/p'
}

owner_of() { # owner_of FILE...: "PACKAGE FILE" for each; a file without a package is "- FILE"
    local file found
    for file in "$@"; do
        found=$(dpkg-query -S "$file" 2>/dev/null | grep -v '^diversion ' | head -n 1 | sed 's/[:,].*//') || true
        # With a merged /usr the package may know the file under either name.
        if [[ -z $found ]]; then
            case $file in
                /usr/lib/*) found=$(dpkg-query -S "${file#/usr}" 2>/dev/null | head -n 1 | sed 's/[:,].*//') || true ;;
                /lib/*) found=$(dpkg-query -S "/usr$file" 2>/dev/null | head -n 1 | sed 's/[:,].*//') || true ;;
            esac
        fi
        printf '%s %s\n' "${found:--}" "$file"
    done
}

built_programs() { # the ELF programs of a build folder, CMake's own left out
    find "$1" -type d -name CMakeFiles -prune -o -type f \( -perm -u+x -o -name '*.so*' \) -print | while read -r file; do
        if [[ $(head -c 4 "$file" | tr -d '\0') == $'\x7fELF' ]]; then printf '%s\n' "$file"; fi
    done
}

linked_libraries() { # linked_libraries PROGRAM...: every shared library that the programs load, by absolute path
    ldd "$@" 2>/dev/null | sed -nE 's/^.* => (\/[^ ]+) .*$/\1/p' | sort -u
}

check_simulation() { # check_simulation RELEASE APT-OPTIONS...: the closure goes to $scratch/closure
    local release=$1
    closure "$@" | sort -u >"$scratch/closure" || die "check-deps: the package list does not resolve on an empty $release"
    [[ -s $scratch/closure ]] || die "check-deps: the package list does not resolve on an empty $release"
    say "$release: $(list_packages "$release" | sort -u | wc -l) packages listed; with what they need, $(wc -l <"$scratch/closure") on an empty machine"
}

check_release() { # check_release RELEASE: another release than this machine's, with its lists fetched into a scratch folder
    local release=$1 address here options
    here=$(debian_release)
    address=$(archive_address "${here:-bookworm}")
    [[ -n $address ]] || die "check-deps: apt names no Debian archive here"
    mkdir -p "$scratch/lists/partial" "$scratch/cache/archives/partial"
    printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "$address" "$release" >"$scratch/sources.list"
    options=(-q -o "Dir::Etc::SourceList=$scratch/sources.list" -o Dir::Etc::SourceParts=/dev/null -o Dir::Etc::PreferencesParts=/dev/null
        -o "Dir::State::Lists=$scratch/lists" -o "Dir::Cache=$scratch/cache" -o APT::Sandbox::User=root -o Acquire::Languages=none
        -o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false)
    quietly "$scratch/update.log" apt-get "${options[@]}" update || die "check-deps: cannot read the package lists of $release"
    check_simulation "$release" "${options[@]}"
}

report_outside() { # report_outside WHAT: reads "PACKAGE FILE" lines; the count of those outside the closure goes to $outside
    local package file
    outside=0
    while read -r package file; do
        case $file in "$root"/*) continue ;; esac
        grep -qxF -- "$package" "$scratch/closure" && continue
        say "  outside the list: $1 $file (package $package)"
        outside=$((outside + 1))
    done
}

cmd_check_deps() {
    local release status=0 folder=$build_dir/release headers libraries programs package used
    release=$(debian_release)
    scratch=$build_dir/check-deps
    rm -rf "$scratch"
    mkdir -p "$scratch"
    if [[ ${1:-} == --release ]]; then
        [[ $# -eq 2 ]] || usage_error "check-deps --release needs bookworm or trixie"
        case $2 in bookworm | trixie) ;; *) usage_error "check-deps: no release '$2': bookworm or trixie" ;; esac
        check_release "$2"
        rm -rf "$scratch"
        return
    fi
    [[ $# -eq 0 ]] || usage_error "check-deps: unknown argument '$1'"
    [[ -n $release ]] || die "check-deps needs Debian 12 or 13"
    check_simulation "$release"
    [[ -f $folder/build.ninja ]] || die "check-deps: nothing is built yet: ./dev build, then again"

    mapfile -t programs < <(built_programs "$folder")
    mapfile -t -O "${#programs[@]}" programs < <(find "$deps_root" -name '*.so' 2>/dev/null)
    mapfile -t libraries < <(linked_libraries "${programs[@]}")
    if ldd "${programs[@]}" 2>/dev/null | grep 'not found' >&2; then die "check-deps: a library is missing on this machine"; fi
    owner_of "${libraries[@]}" >"$scratch/libraries"
    report_outside library <"$scratch/libraries"
    [[ $outside -eq 0 ]] || status=1
    say "${#programs[@]} programs load ${#libraries[@]} shared libraries: $outside outside the list"

    mapfile -t headers < <(ninja -C "$folder" -t deps 2>/dev/null | sed -nE 's|^    (/usr/.*)$|\1|p' | xargs -r realpath -ms | sort -u)
    # One query for all headers: thousands of them.
    printf '%s\n' "${headers[@]}" | xargs -r dpkg-query -S 2>/dev/null | grep -v '^diversion ' | sed -E 's/^([^:,]+)[^/]*: (.*)$/\1 \2/' | sort -u >"$scratch/owned"
    comm -23 <(printf '%s\n' "${headers[@]}" | sort -u) <(cut -d' ' -f2- "$scratch/owned" | sort -u) | sed '/^$/d; s/^/- /' >"$scratch/unowned"
    cat "$scratch/owned" "$scratch/unowned" >"$scratch/headers"
    report_outside header <"$scratch/headers"
    [[ $outside -eq 0 ]] || status=1
    say "${#headers[@]} system headers: $outside outside the list"

    # The other way round: a library's headers that nothing includes are a listed package too many.
    used=$(cut -d' ' -f1 "$scratch/headers" | sort -u)
    for package in $(list_packages "$release" | grep -e '-dev$' | sort -u); do
        # A package without headers of its own (libjpeg-dev) stands for those that it depends on.
        # clang itself links libFuzzer and the sanitizers.
        if [[ $package == libclang-rt-* ]] || grep -qxF "$package" <<<"$used"; then continue; fi
        if dpkg-query -W -f '${Depends}\n' "$package" | sed 's/[,|] */\n/g' | awk '{ print $1 }' | grep -e '-dev$' | grep -qxFf - <(printf '%s\n' "$used"); then
            [[ $(dpkg-query -L "$package" | grep -c '/include/') -gt 0 ]] || continue
        fi
        warn "check-deps: nothing includes a header of $package"
    done
    rm -rf "$scratch"
    [[ $status -eq 0 ]] || die "check-deps: add the packages above to packages.txt, or stop using them"
    say "The package list is complete."
}
