"""mpirun -n K stratus bake: the bytes of one process on any number of ranks; what a lost rank ends can be resumed."""

from expect import *

mixture = ['phase_function = "henyey_greenstein:g=0.5"',
           'second_phase_function = "isotropic"', "mixture = { min = 0.0, max = 1.0 }"]
others = ["tolerance = 0.1", "optical_depth = { min = 0.5, max = inf }", "albedo = { min = 0.8, max = 0.9 }",
          "[discretisation]", "mu_samples = 6"]
write("small.toml", *mixture, *others)
write("plain.toml", mixture[0], *others)
write("stack.toml", "tolerance = 0.05",
      "[[layers]]", 'phase_function = "isotropic"', "albedo = 0.9", "optical_depth = 0.5",
      "[[layers]]", 'phase_function = "rayleigh"', "albedo = 0.8", "optical_depth = 1.0")


def choices(said):
    return [line for line in said.err.splitlines() if "of probes" in line]


# without mpirun nothing changes, whether the plugin is there or not
small = expect_ok("bake small.toml --accept -o whole.h5")
expect(choices(small), "no choices are told")
expect_ok("bake stack.toml --accept -o stack.h5 --quiet")
# samples go through the disk, but where there is a picture to be made
expect_ok("bake small.toml --accept -o in_memory.h5 --exr in_memory.exr --quiet")
shutil.copy(stratus, "alone")
expect_ok("bake small.toml --accept -o alone.h5 --quiet", program="./alone")
expect_same("whole.h5", "in_memory.h5", "alone.h5")
expect_refused("bake small.toml -o refused.h5 => started as one of 2 ranks | libstratus_ranks.so is missing", code=1,
               program="./alone", env=os.environ | {"OMPI_COMM_WORLD_SIZE": "2"})
if not shutil.which("mpirun") or not Path(stratus).with_name("libstratus_ranks.so").exists():
    finish()

os.environ["OMPI_MCA_btl_vader_single_copy_mechanism"] = "none"  # which containers refuse
mpirun = ["timeout", "-s", "KILL", "120", "mpirun", "--oversubscribe", *(["--allow-run-as-root"] if os.getuid() == 0 else [])]


def on_ranks(count, command, code=0, through=(), **how):
    return expect_ok(command, code, through=[*mpirun, "-n", str(count), *through], **how)


for count in 1, 2, 3, 5:
    said = on_ranks(count, f"bake small.toml --accept -o t.h5 --threads {count % 2 + 1}")
    expect_same("t.h5", "whole.h5")
    expect(choices(said) == choices(small), f"{count} ranks choose by other errors than one process")
    expect(not Path("t.h5.checkpoint").exists(), "the checkpoint is left over")
on_ranks(2, "bake stack.toml --accept -o t.h5 --quiet")
expect_same("t.h5", "stack.h5")
expect_ok("bake small.toml --accept -o whole.stratus --quiet")
on_ranks(3, "bake small.toml --accept -o t.stratus --quiet")
expect_same("t.stratus", "whole.stratus")
on_ranks(2, "bake small.toml --accept -o t.h5 --threads 1", err="rank 0:  | rank 1: ")
on_ranks(2, "bake missing.toml -o t.h5", 1, err="missing.toml")


# a sweep: rows shared among ranks, the tables and the summary of one process
def summary(folder):
    rows = [vars(row) for row in Answer(out=read(folder + "/summary.csv")).rows]
    return [row | {"seconds": None} for row in rows]


names = "rayleigh", "again", "isotropic", "grey", "bad"
write("sweep.csv", "name,phase_function,tolerance", "rayleigh,rayleigh,", "again,rayleigh,", "isotropic,isotropic,",
      "grey,henyey_greenstein:g=0.2,", "bad,,0.01")
expect_ok("bake plain.toml --sweep sweep.csv -o one --accept --quiet")
for count in 2, 3:
    shutil.rmtree("shared", ignore_errors=True)
    on_ranks(count, "bake plain.toml --sweep sweep.csv -o shared --accept --quiet")
    for name in names:
        expect_same(f"one/{name}.stratus", f"shared/{name}.stratus")
    expect(summary("shared") == summary("one"), "ranks must tell the same summary")
Path("shared/grey.stratus").unlink()
on_ranks(2, "bake plain.toml --sweep sweep.csv -o shared --quiet --resume", 1, err="1 of 5 tables miss their tolerance")
expect(read("shared/summary.csv").count("was there") == 3, "found tables must be left alone")
expect_same("shared/grey.stratus", "one/grey.stratus")
on_ranks(2, "bake plain.toml --sweep missing.csv -o shared", 1, err="missing.csv")

write("rank.sh", 'if [ "$OMPI_COMM_WORLD_RANK" = "$lost" ]; then',
      '    (until eval "$ready"; do sleep 0.01; done; eval "$lose $$") &',
      "fi",
      'exec "$@"')


def lose(how, command, said, rank=1, ready='[ "$(stat -c %s t.h5.checkpoint 2>/dev/null || echo 0)" -gt 100000 ]'):
    """Does this to a rank of two, with its process as the argument, as soon as it is ready: the run says which is lost, and
    what is kept."""
    for old in Path().glob("t.h5*"):
        old.unlink()
    lost = dict(lost=str(rank), lose=how, ready=ready)
    met = run(command, through=[*mpirun, "-n", "2", "bash", "rank.sh"], env=os.environ | lost)
    expect(met.code != 0, "exit code 0 in spite of a lost rank")
    expect_says(met.err, f"stratus: rank {rank} ( | {said}; finished work is kept in ")
    return met


crashed = "was killed or has crashed"
shutil.rmtree("shared")
write("long.csv", "name,phase_function,tolerance", "rayleigh,rayleigh,", "long,henyey_greenstein:g=0.9,1e-5",
      "longer,henyey_greenstein:g=0.92,1e-5")
met = lose("kill -KILL", "bake plain.toml --sweep long.csv -o shared --accept --quiet --threads 1", crashed,
           ready="[ -e shared/rayleigh.stratus ]")
expect_says(met.err, "kept in shared: repeat the command with --resume")

# a rank is killed, stopped, or denied any more memory as soon as some work is kept: the run is resumed
write("long.toml",
      'phase_function = "henyey_greenstein:g=0.5"',
      "tolerance = 1e-3",
      "optical_depth = { min = 0.01, max = 8.0 }",
      "albedo = { min = 0.0, max = 1.0 }",
      "[discretisation]",
      "nodes = 64",
      "modes = 9",
      "mu_samples = 20",
      "azimuth_samples = 9",
      "optical_depth_samples_per_octave = 4",
      "albedo_samples = 41")
bake = "bake long.toml --accept -o t.h5 "
expect_ok("bake long.toml --accept -o whole.h5 --quiet")
one_thread = "--threads 1"
memory = crashed if sanitized else "out of memory"
for how, rank, flags, said, ranks in [
        ("kill -KILL", 1, one_thread, crashed, 3),
        # rank 0 tells what it keeps with every sign of life, four in a second
        ("sleep 0.4; kill -KILL", 0, one_thread + " --rank-timeout 1", crashed, 1),
        ("kill -STOP", 1, one_thread + " --rank-timeout 1", "has given no sign of life for 1 s", 1),
        ("prlimit --as=1 --pid", 1, one_thread, memory, 2)]:
    met = lose(how, bake + flags, said, rank)
    expect_says(met.err, "kept in t.h5.checkpoint")
    if ranks > 1:
        on_ranks(ranks, f"{bake} --resume {one_thread}", err="resuming from t.h5.checkpoint")
    else:
        expect_ok(bake + "--resume --quiet")
    expect_same("t.h5", "whole.h5")
finish()
