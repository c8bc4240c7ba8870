# tools DIRECTORY: a Python environment there with what tests/requirements.txt names, made when it is not there
# or the list has changed. Exports PERION_TOOLS, where its programs are; says in a line what is missing when it
# cannot be made, and the tests that need it say so too.
tools() {
    PERION_TOOLS=$1/bin
    export PERION_TOOLS
    cmp -s tests/requirements.txt "$1/requirements.txt" && return 0
    echo "installing cmake, fpm and what reads results into $1 ..."
    if { python3 -m venv "$1" && "$1/bin/python" -m pip install --quiet --disable-pip-version-check --retries 1 \
        --only-binary :all: -r tests/requirements.txt; } > "$1.log" 2>&1; then
        cp tests/requirements.txt "$1/requirements.txt"
        rm -f "$1.log"
        return 0
    fi
    echo "not installed ($(tail -n 1 "$1.log")): install python3-venv, or cmake and fpm by hand, to have all tests"
    return 1
}
