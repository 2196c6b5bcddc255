#!/usr/bin/env bash
# `./run install` builds every program and library that `cmake --install` then copies.
#
#     run_builds_what_is_installed.sh RUN BUILD NINJA
set -euo pipefail
run=$1 build=$2 ninja=$3

# The target's name, from the one line of ./run that builds it.
target=$(sed -n '/^run_install()/,/^}/s/^ *build install build \([a-z_]*\)$/\1/p' "$run")
[ -n "$target" ] || { echo "./run install names no target"; exit 1; }
commands=$("$ninja" -C "$build" -t commands "$target")

# Programs and libraries in the installation scripts that CMake has written: the first, and what it includes.
scripts() {
    cat "$1"
    sed -n 's/^ *include("\(.*\/cmake_install.cmake\)")$/\1/p' "$1" |
        while read -r script; do case $script in */tests/*) ;; *) scripts "$script" ;; esac; done
}
mapfile -t installed < <(scripts "$build/cmake_install.cmake" |
    tr '\n' ' ' | grep -oE 'TYPE (STATIC_LIBRARY|SHARED_LIBRARY|EXECUTABLE) FILES( +"[^"]+")+' |
    grep -oE '"[^"]+"' | tr -d '"' | xargs -n 1 realpath --relative-to="$build" | sort -u)
[ "${#installed[@]}" -ge 2 ] || { echo "nothing is installed"; exit 1; }

missing=0
for file in "${installed[@]}"; do
    grep -qwF -- "$file" <<<"$commands" || { echo "target $target does not build $file"; missing=1; }
done
exit $missing
