# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# ./dev bundle: the program, and the viewer where it can be built, with their libraries, for another x86-64 Linux that has a Vulkan driver.

# Every Linux has these, and a second copy of them in one process would break its Vulkan driver:
# glibc, the compiler's run-time libraries (a driver may need newer ones than ours) and zlib. Who has a window for the viewer has X11.
part_of_the_system='^(ld-linux.*|lib(c|m|dl|rt|pthread|resolv|stdc\+\+|gcc_s|z|atomic|X11|xcb|Xau|Xdmcp|bsd|md))\.so'
bundle_limit_mib=25  # without the viewer, which has everything compiled in once more:
viewer_limit_mib=15

# The packages whose code is compiled in: their licences are carried too.
compiled_in='libglm-dev nlohmann-json3-dev libvulkan-dev libspdlog-dev libfmt-dev'
compiled_into_the_viewer='libimgui-dev'

bundle_libraries() { # bundle_libraries FOLDER PROGRAM...: copies what the programs load into FOLDER/lib
    local folder=$1 library name
    shift
    linked_libraries "$@" >"$folder/lib.list"
    # The loader is opened at run time, so nothing links it.
    find /usr/lib /lib -name libvulkan.so.1 -path "*$(gcc -print-multiarch)*" 2>/dev/null | head -n 1 >>"$folder/lib.list"
    while read -r library; do
        name=${library##*/}
        [[ ! $name =~ $part_of_the_system ]] || continue
        cp -L "$library" "$folder/lib/$name"
        chmod 644 "$folder/lib/$name"
        # Its own libraries lie beside it.
        patchelf --set-rpath '$ORIGIN' "$folder/lib/$name"
        owner_of "$library" >>"$folder/owners"
    done <"$folder/lib.list"
    rm "$folder/lib.list"
}

# NVIDIA's driver opens libEGL.so.1, the vendor-neutral dispatch library, and offers no Vulkan device without it. A server or a container
# often lacks it, so it is carried; the packages are only unpacked here (to install them would bring all of Mesa's EGL).
bundle_dispatch() { # bundle_dispatch FOLDER
    local folder=$1 scratch=$build_dir/dispatch package name
    mkdir -p "$scratch"
    for package in libegl1 libglvnd0; do
        if ! compgen -G "$scratch/${package}_*.deb" >/dev/null; then
            (cd "$scratch" && quietly "$scratch/download.log" apt-get -q -o APT::Sandbox::User=root download "$package") ||
                die "bundle: cannot download $package"
        fi
        dpkg-deb -x "$scratch/${package}"_*.deb "$scratch/root"
        cp "$scratch/root/usr/share/doc/$package/copyright" "$folder/licenses/$package.txt"
    done
    for name in libEGL.so.1 libGLdispatch.so.0; do
        cp -L "$(find "$scratch/root/usr/lib" -name "$name" | head -n 1)" "$folder/lib/$name"
        patchelf --set-rpath '$ORIGIN' "$folder/lib/$name"
    done
}

bundle_licenses() { # bundle_licenses FOLDER
    local folder=$1 package file
    [[ ! -f $folder/bin/parhelion-view ]] || compiled_in+=" $compiled_into_the_viewer"
    # shellcheck disable=SC2086
    for package in $(cut -d' ' -f1 "$folder/owners" | sort -u) $compiled_in; do
        file=/usr/share/doc/$package/copyright
        [[ -f $file ]] || die "bundle: $package has no licence text in $file"
        cp -L "$file" "$folder/licenses/$package.txt"
    done
    file=$(find "$deps_root/usr/share/doc" /usr/share/doc -path '*/libvulkan-memory-allocator-dev/copyright' 2>/dev/null | head -n 1 || true)
    [[ -n $file ]] || die "bundle: no licence text of libvulkan-memory-allocator-dev"
    cp "$file" "$folder/licenses/libvulkan-memory-allocator-dev.txt"
    # The texts that Debian's copyright files only name.
    for file in GPL-1 GPL-2 GPL-3 LGPL-2 LGPL-2.1 LGPL-3 Apache-2.0; do
        if grep -qF "/usr/share/common-licenses/$file" "$folder"/licenses/*.txt && [[ -f /usr/share/common-licenses/$file ]]; then
            cp -L "/usr/share/common-licenses/$file" "$folder/licenses/common-$file.txt"
        fi
    done
    cp "$root/LICENSE" "$folder/LICENSE"
    cp "$root/THIRD_PARTY.md" "$folder/THIRD_PARTY.md"
    rm "$folder/owners"
}

newest_glibc() { # the newest glibc symbol version that the programs need
    { objdump -T "$@" 2>/dev/null || true; } | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1
}

check_bundle() { # check_bundle FOLDER: nothing comes from this machine but the system's part
    local folder=$1 stray file
    stray=$(env -i ldd "$folder"/bin/* "$folder"/lib/*.so* 2>/dev/null | sed -nE "s/^.*(=> (\/[^ ]+) .*|=> not found)$/\0/p" | grep -v "=> $folder/" |
        awk '{ print $1 }' | sort -u | grep -Ev "$part_of_the_system" || true)
    [[ -z $stray ]] || die "bundle: these libraries are not carried: ${stray//$'\n'/ }"
    for file in "$folder"/bin/*; do
        env -i "$file" --version >/dev/null || die "bundle: ${file##*/} does not start"
    done
    # No path of the build machine may be inside.
    file=$(grep -lF -- "$root" "$folder"/bin/* || true)
    [[ -z $file ]] || warn "bundle: ${file##*/} contains the path of the source tree"
}

cmd_bundle() {
    local with_tests=false version name folder program programs tests archive mib viewer_mib=0
    case ${1:-} in '') ;; --with-tests) with_tests=true ;; *) usage_error "bundle: unknown argument '$1'" ;; esac
    [[ $# -le 1 ]] || usage_error "bundle: unknown argument '$2'"
    [[ $(uname -m) == x86_64 ]] || die "bundle: this machine is $(uname -m), bundles are for x86_64"
    ensure_deps
    have patchelf || apt_install patchelf
    if $with_tests; then configure_and_build release; else configure_and_build release parhelion; fi
    programs=("$(program_path parhelion release)")
    if grep -q '^build parhelion-view:' "$build_dir/release/build.ninja"; then
        configure_and_build release parhelion-view
        programs+=("$(program_path parhelion-view release)")
    fi
    version=$(sed -nE 's/^CMAKE_PROJECT_VERSION:STATIC=(.*)$/\1/p' "$build_dir/release/CMakeCache.txt")
    name=parhelion-$version-linux-x86_64
    folder=$build_dir/bundle/$name
    step "Bundling $name"
    rm -rf "$folder"
    mkdir -p "$folder/bin" "$folder/lib" "$folder/licenses"
    tests=()
    if $with_tests; then mapfile -t tests < <(built_programs "$build_dir/release/tests"); fi
    for program in "${programs[@]}"; do
        strip -o "$folder/bin/${program##*/}" "$program"
        chmod 755 "$folder/bin/${program##*/}"
        # DT_RPATH, not DT_RUNPATH: it holds for what the driver opens, too (bundle_dispatch).
        patchelf --force-rpath --set-rpath '$ORIGIN/../lib' "$folder/bin/${program##*/}"
    done
    bundle_libraries "$folder" "${programs[@]}" "${tests[@]}"
    bundle_licenses "$folder"
    bundle_dispatch "$folder"
    if $with_tests; then bundle_tests "$folder" "${tests[@]}"; fi
    cat >"$folder/README.txt" <<TEXT
Parhelion $version, for Linux on x86-64.

  bin/parhelion devices
  bin/parhelion render builtin:cornell --out cornell.png
  bin/parhelion help$([[ ${#programs[@]} -lt 2 ]] || printf '\n  bin/parhelion-view builtin:diorama       a window (X11)')

Needs a Vulkan 1.3 driver (your GPU's, or Mesa's lavapipe 25.0 or newer for the CPU) and glibc $(newest_glibc "$folder"/bin/* "$folder"/lib/*.so* | tr -d A-Z_) or newer.
lib/ holds the libraries it uses, licenses/ their terms.
TEXT
    check_bundle "$folder"
    mib=$((($(du -sk --apparent-size --exclude=tests "$folder" | cut -f1) + 1023) / 1024))
    [[ ! -f $folder/bin/parhelion-view ]] || viewer_mib=$((($(stat -c %s "$folder/bin/parhelion-view") + 1048575) / 1048576))
    [[ $viewer_mib -le $viewer_limit_mib ]] || die "bundle: the viewer has $viewer_mib MiB, more than the $viewer_limit_mib allowed"
    [[ $((mib - viewer_mib)) -le $bundle_limit_mib ]] || die "bundle: $((mib - viewer_mib)) MiB without the viewer, more than the $bundle_limit_mib allowed"
    archive=$folder.tar.gz
    # gzip, because every system unpacks it; sorted, without owners and dates, so that the same tree gives the same file.
    tar -C "$build_dir/bundle" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@"${SOURCE_DATE_EPOCH:-0}" -cf - "$name" | gzip -9n >"$archive"
    say "The bundle: ${folder#"$root"/} ($mib MiB without tests) and ${archive#"$root"/} ($(($(stat -c %s "$archive") / 1048576 + 1)) MiB)"
}

bundle_tests() { # bundle_tests FOLDER PROGRAM...: tests/ with the programs, their data and a script that runs them
    local folder=$1 program
    shift
    mkdir -p "$folder/tests"
    for program in "$@"; do
        strip -o "$folder/tests/${program##*/}" "$program"
        chmod 755 "$folder/tests/${program##*/}"
        patchelf --force-rpath --set-rpath '$ORIGIN/../lib' "$folder/tests/${program##*/}"
    done
    # What the tests read from the tree: shaders, sources (the include table) and golden files.
    mkdir -p "$folder/tests/tree"
    git -C "$root" ls-files -co --exclude-standard -z | tar -C "$root" --null --no-recursion -T - -cf - | tar -C "$folder/tests/tree" -xf -
    cat >"$folder/tests/run" <<'TEXT'
#!/bin/sh
# Runs every test program, or those named, on this machine's Vulkan devices.
here=$(cd "$(dirname "$0")" && pwd)
[ $# -gt 0 ] || set -- $(find "$here" -maxdepth 1 -type f -perm -u+x ! -name run | sort)
PATH=$here/../bin:$PATH
status=0
for program in "$@"; do
    case $program in /*) ;; *) program=$here/$program ;; esac
    echo "== ${program##*/}"
    (cd "$here/tree" && PARHELION_TREE=$here/tree "$program") || status=1
done
exit $status
TEXT
    chmod 755 "$folder/tests/run"
}
