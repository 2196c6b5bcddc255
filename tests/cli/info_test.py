"""stratus info: its output, its picture, its refusals."""

from expect import *

fixtures("full", "endless", "mixed")
expect_ok("info full.h5", err="", out=(
    "title | Saturn's rings | phase function | henyey_greenstein | asymmetry g | -0.096 | 8 samples | 0.01 to inf | finite to 8 | "
    "logarithmic | 0 to 180 degrees | reflection, transmission | tolerance | 0.001 | 0.00081 | in memory | MB as float | "
    "MB as half | 0.0.0-synthetic | made up for tests"))
expect_ok("info endless.h5", out="isotropic | 1 sample at 0.9 | 1 sample at inf")
expect_ok("info mixed.h5", out=
          "second phase function isotropic | 2 samples at 0 to 1, identity, the share of the first phase function")

write("full.png", "older")
for table in "full", "endless", "mixed":
    expect_ok(f"info {table}.h5 --picture {table}.png", out=table + ".png")
    expect(Path(table + ".png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n"), f"{table}.png is not a PNG file")

# every command that reads a table honours a limit on memory, before it looks at what it would read
large = Path("full.h5").read_bytes()
Path("large.h5").write_bytes(large + bytes(2 ** 21 - len(large)))
write("query.csv", "mu_in,mu_out,azimuth_deg,optical_depth,albedo")
expect_refused(*(f"{command} --max-memory 1 => large.h5 | needs 2 MiB | limit of 1 MiB" for command in (
    "info large.h5", "verify large.h5", "eval large.h5 --query query.csv", "convert large.h5 new.exr")), code=1)
expect_ok("info --max-memory 1 full.h5")

write("foreign.h5", "not a table")
expect_refused(
    "table.txt => table.txt | .h5 | .exr",
    "full.h5 --picture full.gif => info | --picture | .png | got full.gif",
    "full.h5 --picture full.h5 => full.h5 | another",
    "full.h5 --picture '' => --picture | the name of a file, got nothing",
    "full.h5 --max-memory 0 => --max-memory | 0",
    "full.h5 --max-memory 1.5 => --max-memory | 1.5", prefix="info ")
expect_refused("absent.h5 => absent.h5", "foreign.h5 => foreign.h5", "full.h5 --picture absent/full.png => absent/full.png",
               prefix="info ", code=1)
finish()
