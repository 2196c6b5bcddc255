#!/usr/bin/env bash
# README and docs/*.md: every file that they link to or name as `src/...`, `tests/...` and the like must exist, and every test that
# they run.
#
#     docs_name_what_exists.sh SOURCE_FOLDER BUILD_FOLDER
set -euo pipefail
cd "$1"
missing=0
tick=$'\x60'

require_file() { # require_file DOCUMENT FILE
    [ -e "$2" ] || { echo "$1 names $2, which does not exist"; missing=1; }
}

for document in README.md docs/*.md; do
    while read -r path; do
        require_file "$document" "$path"
    done < <(grep -oE '(src|include|tests|tables|cli|bench)/[A-Za-z0-9_./-]*[A-Za-z0-9_/]' "$document" |
        grep -E '\.[a-z0-9]+$|/$' || true)
    while read -r link; do
        require_file "$document" "$(dirname "$document")/$link"
    done < <(grep -oE '\]\([^)#:]+' "$document" | cut -c 3-)
    while read -r header; do
        [ -n "$(find include src tests -name "$header")" ] || { echo "$document names $header, which does not exist"; missing=1; }
    done < <(grep -oE "${tick}[a-z_0-9]+\.(h|cpp|py)$tick" "$document" | tr -d "$tick")
    while read -r tests; do
        [ "$(ctest --test-dir "$2" -N -R "$tests" | grep -c 'Test *#')" -gt 0 ] || { echo "$document runs tests $tests, of which there are none"; missing=1; }
    done < <(grep -oE 'ctest --test-dir build -R [A-Za-z0-9_.]+' "$document" | cut -d ' ' -f 5)
done
exit $missing
