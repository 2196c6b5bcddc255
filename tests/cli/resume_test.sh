#!/usr/bin/env bash
# stratus bake --resume: killed at random moments, it ends with the bytes of a bake that nothing disturbed.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >attempts.toml <<'RECIPE'
phase_function = "rayleigh"
tolerance = 3e-2
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.5, max = 0.9 }
[discretisation]
mu_samples = 6  # too few: the first attempt misses, the second chooses anew
RECIPE
cat >mixture.toml <<'RECIPE'
phase_function = "rayleigh"
second_phase_function = "isotropic"
mixture = { min = 0.0, max = 1.0 }
tolerance = 0.1
optical_depth = { min = 0.5, max = 1.0 }
albedo = { min = 0.8, max = 0.9 }
[discretisation]
mu_samples = 6
RECIPE

begin() { # begin RECIPE: bakes it undisturbed, as whole.h5 and whole.exr, and takes the time
    recipe=$1
    local started
    started=$(date +%s%N)
    expect_ok bake "$recipe" --accept -o whole.h5 --exr whole.exr --quiet
    nanoseconds=$(($(date +%s%N) - started))
}

kills=0
killed() { # killed MOST ARGS...: bakes, and kills it after a random share of its time, MOST % at most; false if it got through
    local moment code
    moment=$(awk -v r="$RANDOM" -v most="$1" -v whole="$nanoseconds" 'BEGIN { print most / 100 * r / 32768 * whole / 1e9 }')
    shift
    ( # which keeps bash from telling of every kill
        timeout -s KILL --preserve-status "$moment" "$stratus" bake "$recipe" -o t.h5 --exr t.exr --accept --quiet "$@" 2>"$err"
        exit $?
    ) 2>/dev/null
    code=$?
    [ "$code" -eq 0 ] && return 1
    [ "$code" -eq 137 ] || fail "exit code $code"
    kills=$((kills + 1))
}

expect_undisturbed() { # and nothing left over
    expect_same t.h5 whole.h5
    expect_same t.exr whole.exr
    local found
    found=$(find . -type f | sort | tr '\n' ' ')
    [ "$found" = "./attempts.toml ./mixture.toml ./t.exr ./t.h5 ./whole.exr ./whole.h5 " ] || fail "there is $found"
    rm -f t.*
}

RANDOM=1982

# each kill by itself, then to the end on one, two or three threads
for name in attempts mixture; do
    begin $name.toml
    for _ in $(seq 16); do
        until killed 100; do rm t.*; done
        expect_ok bake $name.toml -o t.h5 --exr t.exr --accept --resume --threads $((RANDOM % 3 + 1)) --quiet
        expect_undisturbed
    done
done

# again and again, with a little more time, until one gets through
for name in attempts mixture; do
    begin $name.toml
    for percent in $(seq 400); do
        killed "$percent" --resume --threads $((RANDOM % 3 + 1)) || break
    done
    expect_undisturbed
done
[ "$kills" -ge 50 ] || fail "only $kills of the kills came in time"
finish
