#!/bin/sh
# Everything that is tested; prints a closing line that counts. Called by `make test`.
set -eu
. scripts/need.sh
. scripts/tools.sh
need gfortran gfortran gcc-gfortran "the Fortran tests" || true
need valgrind valgrind valgrind "the memory tests" || true
tools "$TARGET/tools" || true

log=$(mktemp)
trap 'rm -f "$log"' EXIT
failures=0

step() {
    echo "== $1 =="
    shift
    if "$@" 2>&1; then return 0; fi
    failures=$((failures + 1))
    echo "failed: $*"
}

if $CARGO fmt --version > /dev/null 2>&1; then
    step "rustfmt" $CARGO fmt --check
else
    echo "not looked at, since rustfmt is not installed: the form of the sources"
fi
if $CARGO clippy --version > /dev/null 2>&1; then
    step "clippy" $CARGO clippy --release --target-dir "$TARGET" --quiet --all-targets -- -D warnings
else
    echo "not looked at, since clippy is not installed: lints"
fi
step "documentation" env RUSTDOCFLAGS="-D warnings" \
    $CARGO doc --no-deps --quiet --target-dir "$TARGET"
echo "== tests =="
if $CARGO test --release --target-dir "$TARGET" --no-fail-fast > "$log" 2>&1; then :; else failures=$((failures + 1)); fi
cat "$log"

count() {
    awk -v what="$1" '/^test result:/ { for (k = 1; k < NF; ++k) if ($(k + 1) ~ what) sum += $k } END { print sum + 0 }' "$log"
}
passed=$(count passed)
failed=$(count failed)
[ "$failures" -eq 0 ] || [ "$failed" -gt 0 ] || failed=$failures
# Tests that find a program missing say so past the test runner, which counts them as passed.
skipped=$(grep -c '^skipped:' "$log" || true)
echo "$((passed - skipped)) passed, $failed failed, $skipped skipped"
[ "$failures" -eq 0 ]
