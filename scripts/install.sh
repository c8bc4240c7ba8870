#!/bin/sh
# Puts the library where PREFIX, LIBDIR and INCLUDEDIR say, below DESTDIR, or takes it away again. Called by
# `make install` and `make uninstall`, which say what is built and which lists go into the files.
set -eu
action=$1
fortran=$PREFIX/share/perion/fortran
cmake=$LIBDIR/cmake/perion

for setting in "PREFIX $PREFIX" "LIBDIR $LIBDIR" "INCLUDEDIR $INCLUDEDIR"; do
    case ${setting#* } in
        /*) ;;
        *) echo "${setting%% *} must be an absolute path, not '${setting#* }'"; exit 1 ;;
    esac
done

if [ "$action" = install ] && ! [ -f "$LIB/libperion.so" -a -f "$LIB/libperion.a" ]; then
    $MAKE library
fi

filled=$(mktemp)
trap 'rm -f "$filled"' EXIT

# place MODE SOURCE TARGET, or away with the target.
place() {
    if [ "$action" = uninstall ]; then
        rm -f "$DESTDIR$3"
    else
        install -d "$DESTDIR${3%/*}"
        install -m "$1" "$2" "$DESTDIR$3"
        echo "$DESTDIR$3"
    fi
}

# place_link NAME TARGET
place_link() {
    if [ "$action" = uninstall ]; then
        rm -f "$DESTDIR$2"
    else
        ln -sf "$1" "$DESTDIR$2"
        echo "$DESTDIR$2"
    fi
}

# below NAME PATH: the path with NAME in place of the prefix, if it lies below it: such files can move.
below() {
    case $2 in
        "$PREFIX"/*) printf '%s/%s' "$1" "${2#"$PREFIX"/}" ;;
        *) printf '%s' "$2" ;;
    esac
}

# for_pkg_config TEXT: pkg-config reads as a shell does.
for_pkg_config() {
    printf '%s' "$1" | sed 's/ /\\ /g'
}

# set_in NAME VALUE: adds to the script that fills @NAME@ in.
script=
set_in() {
    script="$script
s|@$1@|$(printf '%s' "$2" | sed 's/[&|\\]/\\&/g')|g"
}

# place_filled TEMPLATE TARGET
place_filled() {
    sed "$script" "$1" > "$filled"
    place 644 "$filled" "$2"
}

# From the directory of the CMake files up to the prefix, if it is below.
case $cmake in
    "$PREFIX"/*) up=$(printf '%s' "${cmake#"$PREFIX"/}" | sed 's|[^/][^/]*|..|g') ;;
    *) up=$PREFIX ;;
esac
pc_fortran_sources=
for source in $FORTRAN_SOURCES; do
    pc_fortran_sources="$pc_fortran_sources${pc_fortran_sources:+ }\${prefix}/share/perion/fortran/$source"
done

set_in VERSION "$VERSION"
set_in ABI "$ABI"
set_in NATIVE_LIBRARIES "$NATIVE_LIBRARIES"
set_in PREFIX "$(for_pkg_config "$PREFIX")"
set_in PC_LIBDIR "$(for_pkg_config "$(below '${prefix}' "$LIBDIR")")"
set_in PC_INCLUDEDIR "$(for_pkg_config "$(below '${prefix}' "$INCLUDEDIR")")"
set_in PC_FORTRAN_SOURCES "$pc_fortran_sources"
set_in CMAKE_PREFIX "$up"
set_in CMAKE_LIBDIR "$(below '${_perion_prefix}' "$LIBDIR")"
set_in CMAKE_INCLUDEDIR "$(below '${_perion_prefix}' "$INCLUDEDIR")"
set_in CMAKE_FORTRAN_SOURCES "$FORTRAN_SOURCES"

place 755 "$LIB/libperion.so" "$LIBDIR/libperion.so.$VERSION"
place_link "libperion.so.$VERSION" "$LIBDIR/libperion.so.$ABI"
place_link "libperion.so.$ABI" "$LIBDIR/libperion.so"
place 644 "$LIB/libperion.a" "$LIBDIR/libperion.a"
place 644 include/perion.h "$INCLUDEDIR/perion.h"
for source in $FORTRAN_SOURCES; do
    place 644 "bindings/fortran/$source" "$fortran/$source"
done
place_filled bindings/pkgconfig/perion.pc.in "$LIBDIR/pkgconfig/perion.pc"
place_filled bindings/cmake/perionConfig.cmake.in "$cmake/perionConfig.cmake"
place_filled bindings/cmake/perionConfigVersion.cmake.in "$cmake/perionConfigVersion.cmake"
place 644 bindings/cmake/perionFortran.cmake "$cmake/perionFortran.cmake"

if [ "$action" = uninstall ]; then
    for own in "$cmake" "$fortran" "$PREFIX/share/perion"; do
        rmdir "$DESTDIR$own" 2> /dev/null || true
    done
elif [ -z "$DESTDIR" ] && [ "$(id -u)" -eq 0 ] && ldconfig -v -N -X 2> /dev/null | grep -q "^$LIBDIR:"; then
    # The loader looks there, in its own list of what there is.
    ldconfig
fi
if [ "$action" = install ] && [ -z "$DESTDIR" ]; then
    echo "pkg-config: PKG_CONFIG_PATH=$LIBDIR/pkgconfig    CMake: -DCMAKE_PREFIX_PATH=$PREFIX"
fi
