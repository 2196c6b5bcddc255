#!/usr/bin/env bash
# mpirun -n K stratus bake: the bytes of one process on any number of ranks; what a lost rank ends can be resumed.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

cat >small.toml <<'RECIPE'
phase_function = "henyey_greenstein:g=0.5"
second_phase_function = "isotropic"
mixture = { min = 0.0, max = 1.0 }
tolerance = 0.1
optical_depth = { min = 0.5, max = inf }
albedo = { min = 0.8, max = 0.9 }
[discretisation]
mu_samples = 6
RECIPE
cat >stack.toml <<'RECIPE'
tolerance = 0.05
[[layers]]
phase_function = "isotropic"
albedo = 0.9
optical_depth = 0.5
[[layers]]
phase_function = "rayleigh"
albedo = 0.8
optical_depth = 1.0
RECIPE

# without mpirun nothing changes, whether the plugin is there or not
expect_ok bake small.toml --accept -o whole.h5
grep 'of probes' "$err" >choices || fail 'no choices are told'
expect_ok bake stack.toml --accept -o stack.h5 --quiet
# samples go through the disk, but where there is a picture to be made
expect_ok bake small.toml --accept -o in_memory.h5 --exr in_memory.exr --quiet
expect_same in_memory.h5 whole.h5
cp "$stratus" alone
through "exec ./alone \"\$@\"" expect_ok bake small.toml --accept -o alone.h5 --quiet
expect_same alone.h5 whole.h5
through "OMPI_COMM_WORLD_SIZE=2 exec ./alone \"\$@\"" expect_refused 1 \
    'started as one of 2 ranks' 'libstratus_ranks.so is missing' -- bake small.toml -o refused.h5

if ! command -v mpirun >/dev/null || [ ! -e "$(dirname "$stratus")/libstratus_ranks.so" ]; then
    finish
fi
export OMPI_MCA_btl_vader_single_copy_mechanism=none  # which containers refuse
mpirun=(timeout -s KILL 120 mpirun --oversubscribe)
[ "$(id -u)" -ne 0 ] || mpirun+=(--allow-run-as-root)
on_ranks() { # on_ranks COUNT ARGS...: leaves its exit code
    "${mpirun[@]}" -n "$@" >"$out" 2>"$err" </dev/null
    code=$?
}

for count in 1 2 3 5; do
    on_ranks $count "$stratus" bake small.toml --accept -o t.h5 --threads $((count % 2 + 1))
    [ $code -eq 0 ] || fail "exit code $code on $count ranks"
    expect_same t.h5 whole.h5
    grep 'of probes' "$err" | cmp -s - choices || fail "$count ranks choose by other errors than one process"
    [ ! -e t.h5.checkpoint ] || fail 'the checkpoint is left over'
done
on_ranks 2 "$stratus" bake stack.toml --accept -o t.h5 --quiet
expect_same t.h5 stack.h5
expect_ok bake small.toml --accept -o whole.stratus --quiet
on_ranks 3 "$stratus" bake small.toml --accept -o t.stratus --quiet
expect_same t.stratus whole.stratus
on_ranks 2 "$stratus" bake small.toml -o t.h5 --threads 1
[ $code -eq 0 ] || [ $code -eq 1 ] || fail "exit code $code"
expect_says "$err" 'rank 0: ' 'rank 1: '
on_ranks 2 "$stratus" bake missing.toml -o t.h5
[ $code -eq 1 ] || fail "exit code $code of a missing recipe"
expect_says "$err" 'missing.toml'

# a sweep: rows shared among ranks, the tables and the summary of one process
printf 'name,phase_function,tolerance\nrayleigh,rayleigh,\nagain,rayleigh,\nisotropic,isotropic,\ngrey,henyey_greenstein:g=0.2,\nbad,,0.01\n' >sweep.csv
sed '/second_phase/d; /mixture/d' small.toml >plain.toml
expect_ok bake plain.toml --sweep sweep.csv -o one --accept --quiet
without_seconds() { cut -d, -f1-4,6- "$1"; }
for count in 2 3; do
    rm -rf shared
    on_ranks $count "$stratus" bake plain.toml --sweep sweep.csv -o shared --accept --quiet
    [ $code -eq 0 ] || fail "exit code $code of a sweep on $count ranks"
    for row in rayleigh again isotropic grey bad; do expect_same "shared/$row.stratus" "one/$row.stratus"; done
    expect_same <(without_seconds shared/summary.csv) <(without_seconds one/summary.csv)
done
rm shared/grey.stratus
on_ranks 2 "$stratus" bake plain.toml --sweep sweep.csv -o shared --quiet --resume
[ $code -eq 1 ] || fail "exit code $code of a table that misses"
expect_says "$err" '1 of 5 tables miss their tolerance'
[ "$(grep -c 'was there' shared/summary.csv)" -eq 3 ] || fail 'found tables must be left alone'
expect_same shared/grey.stratus one/grey.stratus
on_ranks 2 "$stratus" bake plain.toml --sweep missing.csv -o shared
[ $code -eq 1 ] || fail "exit code $code of missing rows"
expect_says "$err" 'missing.csv'
# a rank that is killed once a table is there
rm -rf shared
cat >rank.sh <<'RANK'
if [ "$OMPI_COMM_WORLD_RANK" = 1 ]; then
    (
        until [ -e shared/rayleigh.stratus ]; do sleep 0.01; done
        kill -KILL $$
    ) &
fi
exec "$@"
RANK
printf 'name,phase_function,tolerance\nrayleigh,rayleigh,\nlong,henyey_greenstein:g=0.9,1e-5\nlonger,henyey_greenstein:g=0.92,1e-5\n' >long.csv
on_ranks 2 bash rank.sh "$stratus" bake plain.toml --sweep long.csv -o shared --accept --quiet --threads 1
[ $code -ne 0 ] || fail 'exit code 0 in spite of a lost rank'
expect_says "$err" 'stratus: rank 1 (' 'was killed or has crashed; finished work is kept in shared: repeat the command with --resume'

# A rank is killed, stopped, or denied any more memory as soon as some work is kept: the run says which, and is resumed.
lose() { # lose COMMAND ARGS...: the command and the process of rank $of_rank, or 1
    export lose=$1 lost=${of_rank:-1}
    shift
    rm -f t.h5*
    cat >rank.sh <<'RANK'
if [ "$OMPI_COMM_WORLD_RANK" = "$lost" ]; then
    (
        until [ "$(stat -c %s t.h5.checkpoint 2>/dev/null || echo 0)" -gt 100000 ]; do sleep 0.01; done
        eval "$lose $$"
    ) &
fi
exec "$@"
RANK
    on_ranks 2 bash rank.sh "$stratus" bake long.toml --accept -o t.h5 --threads 1 "$@"
    [ $code -ne 0 ] || fail 'exit code 0 in spite of a lost rank'
}
cat >long.toml <<'RECIPE'
phase_function = "henyey_greenstein:g=0.5"
tolerance = 1e-3
optical_depth = { min = 0.01, max = 8.0 }
albedo = { min = 0.0, max = 1.0 }
[discretisation]
nodes = 16
modes = 9
mu_samples = 20
azimuth_samples = 9
optical_depth_samples_per_octave = 4
albedo_samples = 41
RECIPE
expect_ok bake long.toml --accept -o whole.h5 --quiet
lose 'kill -KILL'
expect_says "$err" 'stratus: rank 1 (' 'was killed or has crashed; finished work is kept in t.h5.checkpoint'
on_ranks 3 "$stratus" bake long.toml --accept -o t.h5 --threads 1 --resume
expect_says "$err" 'resuming from t.h5.checkpoint'
expect_same t.h5 whole.h5
# rank 0 tells what it keeps with every sign of life, four in a second
of_rank=0 lose 'sleep 0.4; kill -KILL' --rank-timeout 1
expect_says "$err" 'stratus: rank 0 (' 'was killed or has crashed; finished work is kept in t.h5.checkpoint'
expect_ok bake long.toml --accept -o t.h5 --resume --quiet
expect_same t.h5 whole.h5
lose 'kill -STOP' --rank-timeout 1
expect_says "$err" 'stratus: rank 1 (' 'has given no sign of life for 1 s; finished work is kept in'
expect_ok bake long.toml --accept -o t.h5 --resume --quiet
expect_same t.h5 whole.h5
lose 'prlimit --as=1 --pid'
end='out of memory'
if grep -aq __asan_init "$stratus"; then end='was killed or has crashed'; fi  # by AddressSanitizer
expect_says "$err" 'stratus: rank 1 (' "$end; finished work is kept in"
on_ranks 2 "$stratus" bake long.toml --accept -o t.h5 --threads 1 --resume
expect_same t.h5 whole.h5
finish
