# need PROGRAM PACKAGE: true when the program is there, if need be after installing the package. Says
# in one line what to install when it cannot.
need() {
    command -v "$1" > /dev/null 2>&1 && return 0
    as_root=
    [ "$(id -u)" -eq 0 ] || as_root="sudo -n"
    log=$(mktemp)
    if [ -z "$as_root" ] || sudo -n true 2> /dev/null; then
        echo "installing $2 ..."
        if command -v apt-get > /dev/null 2>&1; then
            { $as_root apt-get update && $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y "$2"; } > "$log" 2>&1
        elif command -v dnf > /dev/null 2>&1; then
            $as_root dnf install -y "$3" > "$log" 2>&1
        elif command -v apk > /dev/null 2>&1; then
            $as_root apk add "$2" > "$log" 2>&1
        fi
    fi
    rm -f "$log"
    command -v "$1" > /dev/null 2>&1 && return 0
    echo "$1 is missing: install the package $2 (Debian, Ubuntu) or $3 (Fedora) to have $4"
    return 1
}
