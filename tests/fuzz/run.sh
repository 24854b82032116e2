#!/usr/bin/env bash
# Runs fuzz targets: tests/fuzz/run.sh FUZZ_BUILD SECONDS [--grow] [--share I/N] [TARGET...]
#   FUZZ_BUILD     the build folder of the preset "fuzz"
#   SECONDS        for all targets together, one after the other
#   --grow         keep what is found in FUZZ_BUILD/corpus, and start from it
#   --share I/N    every Nth target, beginning with the Ith (from 0)
# An input that breaks a target is left in FUZZ_BUILD/crashes. 77: the targets are not built.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
[[ $# -ge 2 ]] || { sed -n '2,7s/^# //p' "${BASH_SOURCE[0]}" >&2; exit 2; }
build=$1 seconds=$2 grow=false share=0 shares=1
shift 2
targets=()
while [[ $# -gt 0 ]]; do
    case $1 in
        --grow) grow=true ;;
        --share) share=${2%/*} shares=${2#*/}; shift ;;
        *) targets+=("$1") ;;
    esac
    shift
done
if [[ ${#targets[@]} -eq 0 ]]; then mapfile -t targets < <(find "$here/corpus" -mindepth 1 -maxdepth 1 -type d -printf '%f\n' | sort); fi

mine=()
for ((i = share; i < ${#targets[@]}; i += shares)); do mine+=("${targets[i]}"); done
[[ ${#mine[@]} -gt 0 ]] || exit 0
each=$((seconds / ${#mine[@]} > 0 ? seconds / ${#mine[@]} : 1))
export ASAN_OPTIONS=quarantine_size_mb=32:detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1
mkdir -p "$build/crashes" "$build/logs"
failed=0
for target in "${mine[@]}"; do
    program=$build/tests/fuzz/$target
    [[ -x $program ]] || { echo "fuzz: $program is not built: ./dev build fuzz"; exit 77; }
    found=$(mktemp -d)
    if $grow; then
        rmdir "$found"
        found=$build/corpus/$target
        mkdir -p "$found"
    fi
    options=(-seed=1 "-max_total_time=$each" -timeout=10 -rss_limit_mb=768 -max_len=65536 -verbosity=0 -print_final_stats=1
        "-artifact_prefix=$build/crashes/$target-")
    dictionary=$here/$target.dict
    [[ $target != glb ]] || dictionary=$here/gltf.dict
    if [[ -f $dictionary ]]; then options+=("-dict=$dictionary"); fi
    log=$build/logs/$target.log
    if "$program" "${options[@]}" "$found" "$here/corpus/$target" >"$log" 2>&1; then
        awk -v target="$target" -v each="$each" '/^stat::number_of_executed_units/ { n = $2 } /^stat::peak_rss_mb/ { m = $2 }
            END { printf "%-8s %9d inputs in %d s, at most %d MB\n", target, n, each, m }' "$log"
    else
        failed=1
        grep -E -m 12 'ERROR|SUMMARY|runtime error|^ +#[0-6] ' "$log" | cut -c1-300 || true
        input=$(sed -nE 's/^artifact_prefix=.*Test unit written to (.*)$/\1/p' "$log" | tail -n 1)
        echo "fuzz: $target broke (log: $log). Again: $program ${input:-(see the log)}"
    fi
    $grow || rm -rf "$found"
done
exit $failed
