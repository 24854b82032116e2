# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# ./dev build, render, run, view, bench, fuzz.

presets=(release dev asan fuzz)

check_preset() {
    local preset
    for preset in "${presets[@]}"; do [[ $1 == "$preset" ]] && return 0; done
    usage_error "no preset '$1': it is one of ${presets[*]}"
}

configure_and_build() { # configure_and_build PRESET [TARGET...]
    with_lock "$build_dir/$1.lock" configure_and_build_locked "$@"
}

configure_and_build_locked() {
    local preset=$1 folder=$build_dir/$1 warnings=OFF cache jobs
    shift
    cache=$folder/CMakeCache.txt
    # CMake refuses a build folder that has moved with its tree.
    if [[ -f $cache ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then rm -rf "$folder"; fi
    # Warnings are errors with the compiler that CI has, and in the developer builds; a newer compiler's new warnings stop nobody.
    if [[ $preset == dev || $preset == asan || $(debian_release) == bookworm ]]; then warnings=ON; fi
    local arguments=("-DPARHELION_DEPS_ROOT=$deps_root" "-DPARHELION_WARNINGS_AS_ERRORS=$warnings")
    if [[ ! -f $folder/build.ninja || "$(cat "$folder/arguments.stamp" 2>/dev/null)" != "${arguments[*]}" ]]; then
        step "Configuring build/$preset"
        (cd "$root" && cmake --preset "$preset" "${arguments[@]}") >&2 || die "cannot configure build/$preset"
        printf '%s\n' "${arguments[*]}" >"$folder/arguments.stamp"
    fi
    jobs=$(nproc)
    step "Building build/$preset with $jobs jobs"
    cmake --build "$folder" --parallel "$jobs" ${1:+--target "$@"} >&2 || die "the build failed"
}

program_path() { # program_path NAME PRESET
    printf '%s' "$build_dir/$2/$1"
}

need_program() { # the built program in $program; it is built if it is not there
    program=$(program_path parhelion release)
    if [[ -x $program ]]; then load_env; else
        ensure_deps
        configure_and_build release parhelion
    fi
}

cmd_build() {
    local preset=${1:-release}
    [[ $# -le 1 ]] || usage_error "build takes one preset: ${presets[*]}"
    check_preset "$preset"
    ensure_deps
    configure_and_build "$preset"
}

cmd_render() {
    ensure_deps
    configure_and_build release parhelion
    program=$(program_path parhelion release)
    if [[ $# -gt 0 ]]; then
        "$program" render "$@"
        return
    fi
    mkdir -p "$root/out"
    step "Rendering the built-in Cornell box"
    "$program" render builtin:cornell --size 400x400 --spp 32 --out "$root/out/cornell.exr" --out "$root/out/cornell.png"
    say "The picture: out/cornell.png (tone-mapped) and out/cornell.exr (linear light)."
}

cmd_run() {
    [[ $# -gt 0 ]] || usage_error "run what? For example: ./dev run devices"
    need_program
    exec "$program" "$@"
}

cmd_bench() {
    ensure_deps
    configure_and_build release parhelion
    exec "$(program_path parhelion release)" bench "$@"
}

cmd_view() {
    compgen -G "$root/src/app/view/*.cpp" >/dev/null || die "this tree has no viewer yet (src/app/view)"
    ensure_deps
    configure_and_build release parhelion-view
    # The key F6 builds the shaders anew; the viewer then takes them.
    export PARHELION_SHADER_DIR="$build_dir/release/shaders/shaders"
    export PARHELION_SHADER_BUILD="cmake --build '$build_dir/release' --target shaders/shaders/shaders.pack"
    exec "$(program_path parhelion-view release)" "$@"
}
