#!/usr/bin/env bash
# Seeded bugs: applies each row of bugs.tsv to a copy of the shaders, compiles those that read the file into a pack of its own
# (PARHELION_SHADER_DIR) and expects the named tests to fail; or to a copy of a .cpp file, which is linked before the library that has
# the right one. Prints the killing test; a crash kills too. A missing barrier is seeded by the tests
# themselves (each_barrier_left_out_draws_a_complaint), a wrong merge by a wrong film (merged_parts_are_the_whole_bit_for_bit).
#     tests/seeded/run.sh BUILD_FOLDER [NAME...]       the build must be up to date; JOBS bugs run side by side (all cores),
#                                                  LIMIT seconds each (600; more where others use the machine)
set -u
limit=${LIMIT:-600}
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:?usage: run.sh BUILD_FOLDER [NAME...]}" && pwd)
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Makes $1/$2.pack: the build's, but what depends on file $3 is compiled from the tree in $1.
compile_pack() {
    local tree=$1 pack=$2 file=$3 name variant stage spv source flags rest define changed=0
    : >"$tree/manifest.tsv"
    # A tab as separator would swallow the empty variant.
    while IFS='|' read -r name variant stage spv; do
        [ -n "$name" ] || continue
        case $variant in *'~') continue ;; esac  # what GPUs get: made of the others, which serve every device
        if grep -qF "$root/$file" "$spv.d"; then
            changed=1
            case $name in
                scene_gpu/*) source=$tree/src/$name.comp ;;
                scene/*) source=$tree/shaders/$name.$stage ;;
                device/*) source=$(compgen -G "$tree/tests/device/shaders/${name#device/}.*" | grep -E "\.(comp|trace|$stage)\$") ;;
                *) source=$(compgen -G "$tree/src/passes/$name.*" | grep -E "\.(comp|trace|$stage)\$") ;;
            esac
            flags=() rest=$variant
            case $variant in query*) flags+=(-DTRACE_QUERY) ;; compute*) flags+=(-DTRACE_COMPUTE) ;; pipeline*) flags+=(-DTRACE_PIPELINE) ;; esac
            case $stage in rchit | rahit | rmiss) flags+=(-DTRACE_PIPELINE) ;; esac
            while [ "$rest" != "${rest#*+}" ]; do rest=${rest#*+} define=${rest%%+*}; flags+=("-D$define"); done
            spv=$tree/$(basename "$spv")
            glslc --target-env=vulkan1.3 "-fshader-stage=$stage" "${flags[@]}" -I "$tree/shaders" -I "$tree/src/passes" -o "$spv" "$source" || return 1
        fi
        printf '%s\t%s\t%s\t%s\n' "$name" "$variant" "$stage" "$spv" >>"$tree/manifest.tsv"
    done < <(tr '\t' '|' <"$build/shaders/$pack/manifest.tsv")
    if [ "$changed" -eq 0 ]; then ln -s "$build/shaders/$pack/$pack.pack" "$tree/$pack.pack"; else "$build/shader_pack" "$tree/manifest.tsv" "$tree/$pack.pack"; fi
}

# Makes $1/program: the test program $2 with $1/$3 in the place of the library's. The build's own commands, each on a line.
link_program() {
    local tree=$1 program=$2 file=$3 compile link joined source seeded
    source=$root/$file seeded=$tree/$file
    if joined=$(grep -slF "\"$source\"" "$build"/CMakeFiles/*/Unity/*.cxx); then  # a unity build: the file's whole object, with the others that it is joined with
        seeded=$tree/joined.cxx
        sed "s#\"$source\"#\"$tree/$file\"#" "$joined" >"$seeded"
        source=$joined
    fi
    compile=$(ninja -C "$build" -t commands "tests/$program" | grep -F -e " -c $source") && link=$(ninja -C "$build" -t commands "tests/$program" | tail -n 1) || return 1
    compile=${compile/ -c "$source"/ -c "$seeded"} link=${link/ -o "tests/$program" / "$tree/bug.o" -o "$tree/program" }
    compile=$(sed -E "s# -MF [^ ]+# -MF $tree/bug.d#; s# -o [^ ]+# -o $tree/bug.o#" <<<"$compile")
    (cd "$build" && eval "$compile" && eval "$link")
}

# A program that cannot start without bugs says nothing of them.
while read -r program; do
    "$build/tests/$program" --gtest_list_tests >"$work/start.log" 2>&1 || { echo "$build/tests/$program does not start: $(tail -n 1 "$work/start.log")"; exit 2; }
done < <(grep -v '^#' "$root/tests/seeded/bugs.tsv" | cut -f5 | sort -u)

# What ended a program early: "signal 11", "exit status 3".
cause_of() { if [ "$1" -gt 128 ]; then echo "signal $(($1 - 128))"; else echo "exit status $1"; fi; }

# A test that fails anyway kills nothing.
passes_without_bugs() { LP_NUM_THREADS=0 timeout "$limit" "$build/tests/$1" --gtest_filter="$2" >"$work/control.$BASHPID" 2>&1; }

# One row of the table.
try_bug() {
    local name=$1 file=$2 from=$3 to=$4 program=$5 filter=$6 tree=$work/$1 out killer status how=
    local binary=$build/tests/$program pack=()
    mkdir -p "$tree/src" "$tree/tests/device"
    cp -r "$root/tests/device/shaders" "$tree/tests/device/shaders"
    cp -r "$root/shaders" "$tree/shaders"
    cp -r "$root/src/passes" "$tree/src/passes"
    mkdir "$tree/src/scene_gpu" && cp "$root"/src/scene_gpu/*.comp "$tree/src/scene_gpu"
    case $file in *.cpp) mkdir -p "$tree/$(dirname "$file")" && cp "$root/$file" "$tree/$file" ;; esac
    FROM=$from TO=$to perl -0pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/ or die "the text is not there\n"' "$tree/$file" || { echo "$name: does not apply to $file"; return; }
    case $file in
        *.cpp) link_program "$tree" "$program" "$file" && binary=$tree/program ;;
        *) compile_pack "$tree" shaders "$file" && compile_pack "$tree" test_shaders "$file" && pack=(PARHELION_SHADER_DIR="$tree") ;;
    esac || { echo "$name: does not compile"; return; }
    out=$(env "${pack[@]}" LP_NUM_THREADS=0 timeout "$limit" "$binary" --gtest_filter="$filter" --gtest_fail_fast 2>&1)
    status=$?
    killer=$(grep -m1 -E '^\[  FAILED  \]' <<<"$out" | sed 's/^\[  FAILED  \] //; s/ (.*//; s/,.*//')
    # Ended before a test could say that it failed: by the test that ran, or by a signal before any did.
    if [ -z "$killer" ] && [ "$status" -ne 0 ] && [ "$status" -ne 124 ]; then
        killer=$(grep -E '^\[ RUN      \]' <<<"$out" | tail -n 1 | sed 's/^\[ RUN      \] //') how=" (a crash: $(cause_of "$status"))"
        [ -n "$killer" ] || [ "$status" -le 128 ] || killer=$filter
    fi
    if [ -n "$killer" ] && ! passes_without_bugs "$program" "$killer"; then echo "$name: NOT TRIED, $killer fails without it"
    elif [ -n "$killer" ]; then echo "$name: killed by $killer$how"
    elif [ "$status" -eq 124 ]; then echo "$name: NOT FINISHED in $limit s"
    elif [ "$status" -ne 0 ]; then echo "$name: NOT STARTED ($(tail -n 1 <<<"$out"))"
    else echo "$name: SURVIVED ($(tail -n 1 <<<"$out"))"; fi
    rm -rf "$tree"
}

jobs=${JOBS:-$(nproc)} running=0
while IFS=$'\t' read -r name file from to program filter; do
    case $name in '' | '#'*) continue ;; esac
    if [ $# -gt 0 ] && ! printf '%s\n' "$@" | grep -qxF -e "$name"; then continue; fi
    if [ "$running" -ge "$jobs" ]; then wait -n; running=$((running - 1)); fi
    try_bug "$name" "$file" "$from" "$to" "$program" "$filter" </dev/null 2>&1 | tee "$work/$name.verdict" &
    running=$((running + 1))
done <"$root/tests/seeded/bugs.tsv"
wait
killed=$(cat "$work"/*.verdict | grep -c ': killed by ') alive=$(cat "$work"/*.verdict | grep -vc ': killed by ')
echo "$killed killed, $alive survived"
[ "$killed" -gt 0 ] && [ "$alive" -eq 0 ]
