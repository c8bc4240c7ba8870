#!/bin/sh
# Examples from C, Fortran and Rust: runs, hashes, pictures. Called with their names by `make demo` and
# `make examples`.
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

checkerboard() {
    begin checkerboard
    in_c 16 "$out/c.csv" "$out/c"
    in_fortran 16 "$out/fortran.csv" "$out/fortran"
    in_rust 16 "$out/rust.csv" "$out/rust"
    same_hashes
    for form in correspondence_constant bond_associated_quadrature_constant; do
        picture "$out/c_$form.vtu" $form --field strain_energy_density --slice 0 --width 900
    done
}

twist() {
    begin twist
    in_c 6 "$out/c.csv" "$out/c.pvd"
    in_fortran 6 "$out/fortran.csv" "$out/fortran.pvd"
    in_rust 6 "$out/rust.csv" "$out/rust.pvd"
    same_hashes
    picture "$out/c_000010.vtu" bar --field reference_position.x --view 30 25 --right z
    picture "$out/c.csv" curve --curve --width 1200 --title "angle of the free end"
    echo "ParaView:  $out/c.pvd"
}

bend() {
    begin bend
    in_c 4 0.03 "$out/c.csv" "$out/c.pvd"
    in_fortran 4 0.03 "$out/fortran.csv" "$out/fortran.pvd"
    in_rust 4 0.03 "$out/rust.csv" "$out/rust.pvd"
    same_hashes
    picture "$(last)" bar --field von_mises_stress --view 20 30 --width 900
    picture "$out/c.csv" curve --curve --width 1200 --title "height of the middle"
    echo "ParaView:  $out/c.pvd"
}

wave() {
    begin wave
    in_c 200 "$out/c.csv"
    in_fortran 200 "$out/fortran.csv"
    in_rust 200 "$out/rust.csv"
    same_hashes
    picture "$out/c.csv" map --map --range 0 2
}

own_material() {
    begin own_material
    in_c 20 "$out/c.csv"
    in_fortran 20 "$out/fortran.csv"
    in_rust 20 "$out/rust.csv"
    same_hashes
    picture "$out/c.csv" curve --curve --width 1200 --title "force of the held bar"
}

traction_bar() {
    begin traction_bar
    in_c 5 2 7 all body_force "$out/c.csv"
    in_fortran 5 2 7 all body_force "$out/fortran.csv"
    in_rust 5 2 7 all body_force "$out/rust.csv"
    same_hashes
    picture "$out/c.csv" errors --curves --logarithmic --width 1200 --title "size of the error of the length change"
}

hyperelastic_bar() {
    begin hyperelastic_bar
    in_c 14 5 4 "$out/c.csv" "$out/c"
    in_fortran 14 5 4 "$out/fortran.csv" "$out/fortran"
    in_rust 14 5 4 "$out/rust.csv" "$out/rust"
    same_hashes
    picture "$out/c.csv" curves --curves --width 1200 --title "displacement of the top"
    picture "$out/c_updated_lagrangian.vtu" bar --field displacement.z --view 30 25 --right x --width 900
}

patch() {
    begin patch
    cloud=examples/patch/points.txt
    in_c $cloud 388 "$out/c.csv" "$out/c"
    in_fortran $cloud 388 "$out/fortran.csv" "$out/fortran"
    in_rust $cloud 388 "$out/rust.csv" "$out/rust"
    same_hashes
    picture "$out/c.csv" disorder --curves --width 1200 --title "disorder"
    for form in correspondence bond_associated_quadrature; do
        picture "$out/c_$form.vtu" $form --field von_mises_stress --width 900
    done
}

beam() {
    begin beam
    in_c 8 9 10 saint_venant_kirchhoff "$out/c.csv" "$out/c"
    in_fortran 8 9 10 saint_venant_kirchhoff "$out/fortran.csv" "$out/fortran"
    in_rust 8 9 10 saint_venant_kirchhoff "$out/rust.csv" "$out/rust"
    same_hashes
    picture "$out/c.csv" out_of_line --curves --logarithmic --width 1200 --title "points out of line, in spacings"
    for form in correspondence bond_associated_quadrature; do
        picture "$out/c_${form}_08.vtu" $form --field strain.0 --range -0.25 0.25 --width 900
    done
}

for name in "$@"; do
    case $name in
        beam | bend | branching | checkerboard | hyperelastic_bar | own_material | patch | specimen | traction_bar | twist | wave) ;;
        *)
            echo "there is no example $name"
            exit 1
            ;;
    esac
done
$CARGO build --release --target-dir "$TARGET" --quiet --examples
for name in "$@"; do
    "$name"
done
