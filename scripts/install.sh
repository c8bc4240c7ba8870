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

# Other letters mean something to shells, make, pkg-config or CMake.
case $PREFIX$LIBDIR$INCLUDEDIR in
    *[!A-Za-z0-9\ _./+,@%=:~-]*)
        echo "PREFIX, LIBDIR and INCLUDEDIR may have letters, digits, blanks and _ . / + , @ % = : ~ -, not more"
        exit 1 ;;
esac

# older: whether what is built lacks, or is older than what it is built from.
older() {
    [ -f "$LIB/libperion.so" ] && [ -f "$LIB/libperion.a" ] || return 0
    [ -n "$(find src build.rs Cargo.toml Cargo.lock -newer "$LIB/libperion.so" -type f 2> /dev/null | head -n 1)" ]
}

if [ "$action" = install ] && older; then
    if [ -f "$LIB/libperion.so" ] && ! command -v "${CARGO%% *}" > /dev/null 2>&1; then
        echo "the library that is built is older than its sources: run make first, where cargo is"
        exit 1
    fi
    $MAKE library
    # Where nothing was to be done but dates differ, they need not be looked at again.
    touch -c "$LIB/libperion.so" "$LIB/libperion.a" 2> /dev/null || true
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

# An older version with the same interface, to which no link will lead any more.
old=$(readlink "$DESTDIR$LIBDIR/libperion.so.$ABI" || true)
case $old in
    "libperion.so.$VERSION" | "") ;;
    libperion.so.*) rm -f "$DESTDIR$LIBDIR/$old" ;;
esac
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
    # Directories that nobody else has put anything into.
    for own in "$cmake" "$LIBDIR/cmake" "$LIBDIR/pkgconfig" "$fortran" "$PREFIX/share/perion" "$INCLUDEDIR"; do
        rmdir "$DESTDIR$own" 2> /dev/null || true
    done
elif [ -z "$DESTDIR" ] && [ "$(id -u)" -eq 0 ] && ldconfig -v -N -X 2> /dev/null | grep -q "^$LIBDIR:"; then
    # The loader looks there, in its own list of what there is.
    ldconfig
fi
if [ "$action" = install ] && [ -z "$DESTDIR" ]; then
    case $LIBDIR in
        "$PREFIX/lib") for_cmake=-DCMAKE_PREFIX_PATH=$PREFIX ;;
        *) for_cmake=-Dperion_DIR=$cmake ;;
    esac
    echo "pkg-config: PKG_CONFIG_PATH=$LIBDIR/pkgconfig    CMake: $for_cmake"
fi
