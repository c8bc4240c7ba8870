#!/bin/sh
# The examples of README.md from C, Fortran and Rust: runs, hashes, pictures. Called by `make demo`.
set -eu
. scripts/need.sh

points=${POINTS:-200}
lib=$TARGET/release

# Compiles with what follows, against the library as cargo has built it.
linked() {
    "$@" -L"$lib" -lperion -lm -Wl,-rpath,"$lib"
}

# An example begins: what an earlier run has left of it goes.
begin() {
    example=$1
    out=$OUT/$example
    languages=
    mkdir -p "$out"
    rm -f "$out"/*.vtu "$out"/*.pvd "$out"/*.csv "$out"/*.txt
}

# Runs a program, and keeps what it prints.
run() {
    echo
    echo "== $example in $1 =="
    language=$2
    languages="$languages $language"
    shift 2
    "$@" | tee "$out/$language.txt"
}

in_c() {
    linked $CC -std=c11 $CFLAGS -Iinclude "examples/$example/main.c" -o "$out/${example}_c"
    run C c "$out/${example}_c" "$@"
}

in_fortran() {
    need "$FC" gfortran gcc-gfortran "the Fortran part of the demo" || return 0
    sources=
    for source in $FORTRAN_SOURCES; do sources="$sources bindings/fortran/$source"; done
    linked $FC -std=f2018 $FFLAGS -J "$out" $sources "examples/$example/main.f90" \
        -o "$out/${example}_fortran"
    run Fortran fortran "$out/${example}_fortran" "$@"
}

in_rust() {
    run Rust rust "$lib/examples/$example" "$@"
}

# The languages have the same results, to the last bit.
same_hashes() {
    echo
    for language in $languages; do
        printf '%-8s %s\n' "$language" "$(sed -n 's/^hash *//p' "$out/$language.txt")"
    done | tee "$out/hashes.txt"
    if grep -q ' $' "$out/hashes.txt"; then
        echo "a program has not come to its end"
        exit 1
    elif [ "$(awk '{ print $2 }' "$out/hashes.txt" | sort -u | wc -l)" -ne 1 ]; then
        echo "the hashes differ"
        exit 1
    fi
}

# Draws a file as a picture beside it.
picture() {
    drawn=$out/$2.png
    from=$1
    shift 2
    "$lib/examples/picture" "$from" "$drawn" "$@"
    echo "picture:   $drawn"
}

last() {
    ls "$out"/c_*.vtu | tail -n 1
}

branching() {
    begin branching
    in_c "$points" "$out/c.pvd"
    in_fortran "$points" "$out/fortran.pvd"
    in_rust "$points" "$out/rust.pvd"
    same_hashes
    picture "$(last)" damage --range 0 0.5
    echo "ParaView:  $out/c.pvd"
}

specimen() {
    begin specimen
    mesh=examples/specimen/specimen.msh
    in_c $mesh "$out/c.csv" "$out/c.pvd"
    in_fortran $mesh "$out/fortran.csv" "$out/fortran.pvd"
    in_rust $mesh "$out/rust.csv" "$out/rust.pvd"
    same_hashes
    picture "$(last)" damage --range 0 0.5 --scale-displacement 10
    picture "$out/c.csv" curve --curve --width 1200 --title "force on the grip"
    echo "ParaView:  $out/c.pvd"
}

$CARGO build --release --target-dir "$TARGET" --quiet \
    --example branching --example specimen --example picture
specimen
branching
