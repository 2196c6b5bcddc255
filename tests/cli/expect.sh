# What every test of the command line stands on; a test begins with `source .../expect.sh "$@"`.
#
# The program under test is "$stratus", the fixture's maker "$make_fixture". Each test runs in an empty folder of its
# own, which is removed at its end. A test prints nothing when it passes and its last line is `finish`.
# shellcheck shell=bash
set -u
export LC_ALL=C

if [ $# -ne 2 ]; then
    echo "usage: $0 STRATUS MAKE_FIXTURE_TABLE" >&2
    exit 2
fi
stratus=$(realpath "$1")
# shellcheck disable=SC2034  # the tests use it
make_fixture=$(realpath "$2")

for program in "$stratus" "$make_fixture"; do
    [ -x "$program" ] || { echo "$0: there is no program $program" >&2; exit 2; }
done

folder=$(mktemp -d) || exit 1
logs=$(mktemp -d) || exit 1
trap 'rm -rf "$folder" "$logs"' EXIT
cd "$folder" || exit 1
export STRATUS_CACHE=$logs/cache  # nobody's own

# Fontconfig, which draws the pictures' words, keeps its cache to the end; HDF5 loses memory on damaged files: no leaks of
# ours.
printf 'leak:libfontconfig\nleak:libhdf5\n' >"$logs/not_ours"
export LSAN_OPTIONS="${LSAN_OPTIONS:+$LSAN_OPTIONS:}suppressions=$logs/not_ours:print_suppressions=0"

out=$logs/out  # what the last command said
err=$logs/err
failures=0

fail() { # fail SENTENCE: notes a failure and shows what the last command said
    failures=$((failures + 1))
    echo "FAILED, line ${BASH_LINENO[-2]}: $1" >&2
    head -n 20 "$out" | sed 's/^/    stdout: /' >&2
    head -n 20 "$err" | sed 's/^/    stderr: /' >&2
}

finish() {
    [ "$failures" -eq 0 ] || echo "$failures failed" >&2
    exit $((failures > 0))
}

# Every file of the folder with its checksum.
snapshot() { find . -type f -exec cksum {} + | sort; }

# expect_ok ARGS...: exit 0. Standard input is the test's: expect_ok eval t.h5 < q.csv
expect_ok() {
    "$stratus" "$@" >"$out" 2>"$err"
    local code=$?
    [ "$code" -eq 0 ] || fail "stratus $*: exit code $code, expected 0"
}

# expect_refused CODE FRAGMENT... -- ARGS...: that exit code, nothing on stdout, one line on stderr that holds every
# fragment, and no file of the folder made, changed or removed.
expect_refused() {
    local expected=$1 fragments=()
    shift
    while [ "$1" != -- ]; do
        fragments+=("$1")
        shift
    done
    shift
    local before after code
    before=$(snapshot)
    "$stratus" "$@" >"$out" 2>"$err"
    code=$?
    after=$(snapshot)
    [ "$code" -eq "$expected" ] || fail "stratus $*: exit code $code, expected $expected"
    [ ! -s "$out" ] || fail "stratus $*: an answer in spite of the refusal"
    [ "$(wc -l <"$err")" -eq 1 ] || fail "stratus $*: not one line on stderr"
    grep -q '^stratus: ' "$err" || fail "stratus $*: the line must begin with 'stratus: '"
    local fragment
    for fragment in "${fragments[@]}"; do
        grep -qF -- "$fragment" "$err" || fail "stratus $*: the refusal does not say '$fragment'"
    done
    [ "$before" = "$after" ] || fail "stratus $*: files differ after the refusal"
}

# expect_says FILE TEXT...: each text stands in the file ("$out" and "$err" are the last command's).
expect_says() {
    local file=$1 text
    shift
    for text in "$@"; do
        grep -qF -- "$text" "$file" || fail "$(basename "$file") does not say '$text'"
    done
}

# expect_silent FILE: the file is empty.
expect_silent() { [ ! -s "$1" ] || fail "$(basename "$1") must be empty"; }

# expect_same FILE FILE: same bytes.
expect_same() { cmp -s "$1" "$2" || fail "$1 and $2 must be the same"; }

# expect_header LINE: first line of the last answer.
expect_header() { [ "$(head -n 1 "$out")" = "$1" ] || fail "the first line must be $1"; }

# expect_rows COUNT CONDITION: so many rows follow the header of the last answer, and for each the awk condition holds,
# in which f["column"] is a field.
expect_rows() {
    awk -F, -v count="$1" '
        NR == 1 { for (i = 1; i <= NF; ++i) name[i] = $i; next }
        { for (i = 1; i <= NF; ++i) f[name[i]] = $i; ++rows; if (!('"$2"')) bad = 1 }
        END { exit bad || rows + 0 != count }' "$out" || fail "not $1 rows with $2"
}

# expect_near TEXT EXPECTED TOLERANCE: a number, so near.
expect_near() {
    awk -v met="$1" -v expected="$2" -v most="$3" 'BEGIN {
        off = met - expected
        exit met == "" || !(off <= most && -off <= most) }' || fail "'$1' must be $2 within $3"
}

# through WRAPPER EXPECTATION...: the expectation, the program started by a shell script in which it is "$stratus".
# For instance: through 'exec nice "$stratus" "$@"' expect_ok info table.h5
through() {
    printf '#!/usr/bin/env bash\nstratus=%q\n%s\n' "$stratus" "$1" >"$logs/wrapper"
    chmod +x "$logs/wrapper"
    shift
    local stratus=$logs/wrapper
    "$@"
}

# Wrappers in which writing fails: by a limit on the size of a file; on a disk of 16 KiB that only this program sees,
# mounted on the folder `disk`, where a file `older.*` must come to no harm; and as a user whom the folder `shut` refuses.
# The last two are empty where the machine permits no such thing.
# shellcheck disable=SC2034,SC2016  # the tests use them; expanded in the wrapper
{
    size_limited='trap "" XFSZ; ulimit -f 4; exec "$stratus" "$@"'
    small_disk=
    user_refused=
    own_mounts='unshare --mount'
    [ "$(id -u)" -eq 0 ] || own_mounts='unshare --map-root-user --mount'
    on_disk='mount -t tmpfs -o size=16k none disk'
    mkdir disk shut
    # shellcheck disable=SC2086  # words of a command
    if $own_mounts sh -c "$on_disk" 2>"$err"; then
        small_disk="exec $own_mounts bash -c '$on_disk; echo older >disk/older.h5; cp disk/older.h5 disk/older.csv
            \"\$@\"; code=\$?
            for file in disk/older.*; do [ \"\$(cat \$file)\" = older ] || echo \"\$file is harmed\" >&2; done
            find disk -type f ! -name \"older.*\" >&2; exit \$code' bash \"\$stratus\" \"\$@\""
    fi
    if [ "$(id -u)" -ne 0 ]; then
        chmod a-w shut
        user_refused='exec "$stratus" "$@"'
    else
        chmod a+rx .
        as_nobody='setpriv --reuid=65534 --regid=65534 --clear-groups'
        $as_nobody "$stratus" --version >"$out" 2>"$err" && user_refused="exec $as_nobody \"\$stratus\" \"\$@\""
    fi
}
