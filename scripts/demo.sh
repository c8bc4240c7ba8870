#!/bin/sh
# The branching plate from C, Fortran and Rust: runs, hashes, pictures. Called by `make demo`.
set -eu
. scripts/need.sh

points=${POINTS:-200}
lib=$TARGET/release

# Compiles with what follows, against the library as cargo has built it.
linked() {
    "$@" -L"$lib" -lperion -lm -Wl,-rpath,"$lib"
}

mkdir -p "$OUT"
rm -f "$OUT"/*.vtu "$OUT"/*.pvd

run() {
    echo
    echo "== $1 =="
    language=$2
    shift 2
    "$@" "$points" "$OUT/$language.pvd" | tee "$OUT/$language.txt"
}

linked $CC -std=c11 $CFLAGS -Iinclude examples/branching/main.c -o "$OUT/branching_c"
run "C" c "$OUT/branching_c"

languages="c rust"
if need "$FC" gfortran gcc-gfortran "the Fortran part of the demo"; then
    linked $FC -std=f2018 $FFLAGS -J "$OUT" bindings/fortran/perion_c.f90 \
        examples/branching/main.f90 -o "$OUT/branching_fortran"
    run "Fortran" fortran "$OUT/branching_fortran"
    languages="c fortran rust"
fi

$CARGO build --release --target-dir "$TARGET" --quiet --example branching --example picture
run "Rust" rust "$lib/examples/branching"

echo
hashes=
for language in $languages; do
    hash=$(sed -n 's/^hash *//p' "$OUT/$language.txt")
    printf '%-8s %s\n' "$language" "$hash"
    hashes="$hashes$hash
"
done
if [ -z "$hash" ] || [ "$(printf '%s' "$hashes" | sort -u | wc -l)" -ne 1 ]; then
    echo "the hashes differ"
    exit 1
fi

last=$(ls "$OUT"/c_*.vtu | tail -n 1)
"$lib/examples/picture" "$last" "$OUT/damage.png" --field damage --range 0 0.5
echo "picture:   $OUT/damage.png"
echo "ParaView:  $OUT/c.pvd"
