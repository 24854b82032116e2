# shellcheck shell=bash disable=SC1091,SC2016,SC2034,SC2154
# ./dev test, truth, soak, fuzz: CTest runs the GoogleTest programs, two at a time; every test case is counted from their output.

# list_results JUNIT LOG: reads what CTest writes (only the JUnit file knows which programs were skipped as a whole).
# Prints "pass|fail|skip SECONDS NAME" for each test case, and for each program that is no GoogleTest.
list_results() {
    awk '
        function cut(text, mark) { text = substr(text, index(text, mark) + length(mark)); sub(/ \([0-9]+ ms\).*$/, "", text); return text }
        function milliseconds(text) { return match(text, /\([0-9]+ ms\)/) ? substr(text, RSTART + 1, RLENGTH - 5) : 0 }
        function result(kind, text, mark) {
            if (running != "" && index(cut(text, mark), running) == 1) {
                printf "%s %.3f %s\n", kind, milliseconds(text) / 1000, running
                if (kind == "fail") ++failures
                running = ""
            }
        }
        FNR == NR { if (match($0, /<testcase name="[^"]*"/)) name = substr($0, RSTART + 16, RLENGTH - 17); if (/<skipped/) skipped[name] = 1; next }
        /^[0-9]+\/[0-9]+ Testing: / { program = substr($0, index($0, "Testing: ") + 9); running = ""; cases = 0; failures = 0; is_gtest = 0; seconds = 0; absent = 0 }
        /^Command: ""$/ { absent = 1 }
        /\[==========\]/ { is_gtest = 1 }
        { sub(/\r$/, "") }
        index($0, "[ RUN      ] ") { running = substr($0, index($0, "[ RUN      ] ") + 13); ++cases }
        index($0, "[       OK ] ") { result("pass", $0, "[       OK ] ") }
        index($0, "[  FAILED  ] ") { result("fail", $0, "[  FAILED  ] ") }
        index($0, "[  SKIPPED ] ") { result("skip", $0, "[  SKIPPED ] ") }
        /^Test time = / { seconds = $4 }
        /^Test (Passed|Failed)\.$/ {
            passed = ($0 == "Test Passed." && !absent)
            if (running != "") { printf "fail %.3f %s (did not finish)\n", seconds, running; ++failures; running = "" }
            if (!is_gtest || (passed && cases == 0 && program in skipped))
                printf "%s %.3f %s\n", passed ? (program in skipped ? "skip" : "pass") : "fail", seconds, program
            else if (!passed && failures == 0) printf "fail %.3f %s (the program as a whole)\n", seconds, program
        }' "$1" "$2"
}

run_tests() { # run_tests PRESET FILTER CTEST-ARGUMENTS...: prints the summary; 1 if anything failed
    local preset=$1 filter=$2 folder=$build_dir/$1 status=0 results passed failed skipped
    shift 2
    results=$folder/test-results.txt
    # In the submitting thread and one program a core: the fastest way to run many small dispatches on lavapipe.
    export LP_NUM_THREADS=${LP_NUM_THREADS:-0} GTEST_COLOR=no
    if [[ -n $filter ]]; then
        [[ $filter == *[*?:]* ]] || filter="*$filter*"
        export GTEST_FILTER=$filter
        # Tests that are no GoogleTest programs have no cases to choose from; the masked ones have a filter of their own.
        if [[ "$*" != '-L ^truth$' ]]; then set -- "$@" -LE '^(truth|soak|script|embed|fuzz|masked)$'; fi
    fi
    if [[ $preset == asan ]]; then
        export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_stack_use_after_return=1} UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
        export LSAN_OPTIONS=${LSAN_OPTIONS:-suppressions=$root/tools/dev/lsan.supp:print_suppressions=0}
    fi
    rm -f "$folder/Testing/Temporary/LastTest.log" "$folder/test-results.xml"
    ctest --test-dir "$folder" -j2 --output-on-failure --output-junit "$folder/test-results.xml" --no-tests=error "$@" || status=$?
    [[ -f $folder/Testing/Temporary/LastTest.log && -f $folder/test-results.xml ]] || die "no test ran"
    list_results "$folder/test-results.xml" "$folder/Testing/Temporary/LastTest.log" >"$results"
    passed=$(grep -c '^pass ' "$results" || true)
    failed=$(grep -c '^fail ' "$results" || true)
    skipped=$(grep -c '^skip ' "$results" || true)
    # A failure that left no line in the log is still one.
    if [[ $status -ne 0 && $failed -eq 0 ]]; then failed=1; fi
    printf '\nThe ten slowest tests:\n'
    sort -k2,2 -rn "$results" | awk 'NR <= 10 { seconds = $2; $1 = $2 = ""; printf "  %8.2f s %s\n", seconds, $0 }'
    if [[ $skipped -gt 0 ]]; then
        printf '\nSkipped%s:\n' "$($require_all && echo ', which fails here')"
        awk '$1 == "skip" { $1 = $2 = ""; print " " $0 }' "$results"
    fi
    if [[ $failed -gt 0 ]]; then
        printf '\nFailed:\n'
        awk '$1 == "fail" { $1 = $2 = ""; print " " $0 }' "$results"
    fi
    printf '\nSeconds: packages %d, build %d, tests %d\n' "$packages_seconds" "$build_seconds" $((SECONDS - packages_seconds - build_seconds))
    if [[ $((passed + failed + skipped)) -eq 0 ]]; then say "dev: no test matched"; status=1; fi
    printf '%d passed, %d failed, %d skipped\n' "$passed" "$failed" "$skipped"
    if [[ $status -ne 0 || $failed -gt 0 ]]; then return 1; fi
    if $require_all && [[ $skipped -gt 0 ]]; then return 1; fi
}

cmd_test() {
    local preset=release filter='' build=true label='' selection=(-LE '^(truth|soak)$')
    require_all=$in_ci
    while [[ $# -gt 0 ]]; do
        case $1 in
            -L) [[ $# -ge 2 ]] || usage_error "-L needs a label"; label=$2 selection=(-L "^$2\$"); shift ;;
            --require) require_all=true ;;
            --preset) [[ $# -ge 2 ]] || usage_error "--preset needs a name"; preset=$2; shift ;;
            --no-build) build=false ;;
            -*) usage_error "test: unknown option '$1'" ;;
            *) [[ -z $filter ]] || usage_error "test takes one filter"; filter=$1 ;;
        esac
        shift
    done
    check_preset "$preset"
    prepare_tests "$preset" "$build" "$([[ -z $filter && (-z $label || $label == fuzz) ]] && echo fuzz)"
    run_tests "$preset" "$filter" "${selection[@]}"
}

prepare_tests() { # prepare_tests PRESET BUILD [MORE-PRESETS]: packages and build, with the time that each took
    local more
    SECONDS=0
    ensure_deps
    packages_seconds=$SECONDS
    if $2; then for more in "$1" ${3:-}; do configure_and_build "$more"; done; fi
    build_seconds=$((SECONDS - packages_seconds))
    if $require_all; then export PARHELION_REQUIRE=${PARHELION_REQUIRE:-device,query,pipeline,compute,validation}; fi
}

long_tests() { # long_tests LABEL [FILTER]
    local label=$1 filter=${2:-} count
    [[ $# -le 2 ]] || usage_error "$label takes one filter"
    require_all=false
    prepare_tests release true
    count=$(ctest --test-dir "$build_dir/release" -N -L "^$label\$" | sed -n 's/^Total Tests: //p')
    [[ ${count:-0} -gt 0 ]] || die "this tree has no test with the label '$label' yet"
    run_tests release "$filter" -L "^$label\$"
}

# One line for each thing that was compared, also where it failed: build/release/truth.tsv, and on stdout.
cmd_truth() {
    local status=0
    export PARHELION_TRUTH_TABLE=$build_dir/release/truth.tsv
    rm -f "$PARHELION_TRUTH_TABLE"
    long_tests truth "$@" || status=$?
    if [[ -s $PARHELION_TRUTH_TABLE ]]; then
        printf '\n'
        column -t -s "$(printf '\t')" "$PARHELION_TRUTH_TABLE" 2>/dev/null || cat "$PARHELION_TRUTH_TABLE"
        say "The table: ${PARHELION_TRUTH_TABLE#"$root"/}"
    fi
    return $status
}
cmd_soak() { long_tests soak "$@"; }

# For SECONDS, a share of the targets on each core; what they find stays in build/fuzz/corpus and is where the next run begins.
cmd_fuzz() { # cmd_fuzz [SECONDS] [TARGET...]
    local seconds=600 shares share status=0 jobs=()
    if [[ ${1:-} =~ ^[0-9]+$ ]]; then seconds=$1; shift; fi
    ensure_deps
    configure_and_build fuzz
    shares=$(nproc)
    for ((share = 0; share < shares; ++share)); do
        "$root/tests/fuzz/run.sh" "$build_dir/fuzz" "$seconds" --grow --share "$share/$shares" "$@" &
        jobs+=($!)
    done
    for share in "${jobs[@]}"; do wait "$share" || status=1; done
    return $status
}
