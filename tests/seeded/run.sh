#!/usr/bin/env bash
# Seeded bugs: applies each row of bugs.tsv to a copy of the shaders, compiles them into a pack of its own (PARHELION_SHADER_DIR)
# and expects the named tests to fail. Prints the killing test. A missing barrier is seeded by the tests themselves
# (each_barrier_left_out_draws_a_complaint), a wrong merge by a wrong film (merged_parts_are_the_whole_bit_for_bit).
#     tests/seeded/run.sh BUILD_FOLDER [NAME...]
set -u
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:?usage: run.sh BUILD_FOLDER [NAME...]}" && pwd)
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
alive=0 killed=0

# Compiles every shader of pack $2 from the tree in $1 as the build's manifest lists them, into $1/$2.pack.
compile_pack() {
    local tree=$1 pack=$2 name variant stage spv source flags rest define
    : >"$tree/manifest.tsv"
    # A tab as separator would swallow the empty variant.
    while IFS='|' read -r name variant stage spv; do
        [ -n "$name" ] || continue
        case $name in
            scene/*) source=$tree/shaders/$name.$stage ;;
            device/*) source=$(compgen -G "$tree/tests/device/shaders/${name#device/}.*" | grep -E "\.(comp|trace|$stage)\$") ;;
            *) source=$(compgen -G "$tree/src/passes/$name.*" | grep -E '\.(comp|trace)$') ;;
        esac
        flags=() rest=$variant
        case $variant in query*) flags+=(-DTRACE_QUERY) ;; compute*) flags+=(-DTRACE_COMPUTE) ;; pipeline*) flags+=(-DTRACE_PIPELINE) ;; esac
        case $stage in rchit | rahit | rmiss) flags+=(-DTRACE_PIPELINE) ;; esac
        while [ "$rest" != "${rest#*+}" ]; do rest=${rest#*+} define=${rest%%+*}; flags+=("-D$define"); done
        glslc --target-env=vulkan1.3 "-fshader-stage=$stage" "${flags[@]}" -I "$tree/shaders" -I "$tree/src/passes" -o "$tree/$(basename "$spv")" "$source" || return 1
        printf '%s\t%s\t%s\t%s\n' "$name" "$variant" "$stage" "$tree/$(basename "$spv")" >>"$tree/manifest.tsv"
    done < <(tr '\t' '|' <"$build/shaders/$pack/manifest.tsv")
    "$build/shader_pack" "$tree/manifest.tsv" "$tree/$pack.pack"
}

while IFS=$'\t' read -r name file from to program filter; do
    case $name in '' | '#'*) continue ;; esac
    if [ $# -gt 0 ] && ! printf '%s\n' "$@" | grep -qx "$name"; then continue; fi
    tree=$work/$name
    mkdir -p "$tree/src" "$tree/tests/device"
    cp -r "$root/tests/device/shaders" "$tree/tests/device/shaders"
    cp -r "$root/shaders" "$tree/shaders"
    cp -r "$root/src/passes" "$tree/src/passes"
    FROM=$from TO=$to perl -0pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/ or die "the text is not there\n"' "$tree/$file" || { echo "$name: does not apply to $file"; alive=$((alive + 1)); continue; }
    compile_pack "$tree" shaders && compile_pack "$tree" test_shaders || { echo "$name: does not compile"; alive=$((alive + 1)); continue; }
    out=$(PARHELION_SHADER_DIR=$tree LP_NUM_THREADS=0 timeout 600 "$build/tests/$program" --gtest_filter="$filter" --gtest_fail_fast 2>&1)
    killer=$(grep -m1 -E '^\[  FAILED  \]' <<<"$out" | sed 's/^\[  FAILED  \] //; s/ (.*//; s/,.*//')
    if [ -n "$killer" ]; then killed=$((killed + 1)); echo "$name: killed by $killer"; else alive=$((alive + 1)); echo "$name: SURVIVED"; fi
    rm -rf "$tree"
done <"$root/tests/seeded/bugs.tsv"
echo "$killed killed, $alive survived"
[ "$alive" -eq 0 ]
