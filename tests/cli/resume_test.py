"""stratus bake --resume: killed at random moments, it ends with the bytes of a bake that nothing disturbed."""

import random
import time

from expect import *

write("attempts.toml",
      'phase_function = "rayleigh"',
      "tolerance = 3e-2",
      "optical_depth = { min = 0.5, max = 2.0 }",
      "albedo = { min = 0.5, max = 0.9 }",
      "[discretisation]",
      "mu_samples = 6  # too few: the first attempt misses, the second chooses anew")
write("mixture.toml",
      'phase_function = "rayleigh"',
      'second_phase_function = "isotropic"',
      "mixture = { min = 0.0, max = 1.0 }",
      "tolerance = 0.1",
      "optical_depth = { min = 0.5, max = 1.0 }",
      "albedo = { min = 0.8, max = 0.9 }",
      "[discretisation]",
      "mu_samples = 6")
drawn = random.Random(1982)
kills = 0


def threads():
    return f" --resume --threads {drawn.randint(1, 3)}"


def killed(bake, share):
    """Whether a bake was killed after a random share of the time it takes, this at most, or got through before."""
    global kills
    said = interrupt(bake, share * drawn.random() * seconds, signal.SIGKILL)
    expect(said.code in (0, -signal.SIGKILL), f"exit code {said.code}")
    kills += said.code != 0
    return said.code != 0


def expect_undisturbed():
    """Both tables are those of the undisturbed bake, and nothing is left over."""
    expect_same("t.h5", "whole.h5")
    expect_same("t.exr", "whole.exr")
    found = {str(path) for path in snapshot()}
    expect(found == {"attempts.toml", "mixture.toml", "t.exr", "t.h5", "whole.exr", "whole.h5"}, f"there is {found}")
    remove_tables()


def remove_tables():
    for path in Path().glob("t.*"):
        path.unlink()


for name in "attempts", "mixture":
    began = time.monotonic()
    expect_ok(f"bake {name}.toml --accept -o whole.h5 --exr whole.exr --quiet")
    seconds = time.monotonic() - began
    bake = f"bake {name}.toml -o t.h5 --exr t.exr --accept --quiet"
    # each kill by itself, then to the end on one, two or three threads
    for _ in range(16):
        while not killed(bake, 1):
            remove_tables()
        expect_ok(bake + threads())
        expect_undisturbed()
    # again and again, with a little more time, until one gets through
    for percent in range(1, 401):
        if not killed(bake + threads(), percent / 100):
            break
    expect_undisturbed()
expect(kills >= 50, f"only {kills} of the kills came in time")
finish()
