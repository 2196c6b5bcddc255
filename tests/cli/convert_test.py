"""stratus convert: both ways and back without loss; its refusals."""

from expect import *

write("back.h5", "older")
for kind in "full", "endless":
    fixtures(kind)
    expect_ok(f"convert {kind}.h5 {kind}.exr", out="", err="")
    expect_ok(f"convert {kind}.exr back.h5")
    expect_ok("convert back.h5 back.exr")
    expect_same(kind + ".h5", "back.h5")
    expect_same(kind + ".exr", "back.exr")

os.symlink("full.h5", "link.h5")
expect_refused(
    "full.h5 table.txt => OUT | .h5 | .exr | table.txt",
    "table full.exr => IN | .h5 | .exr | table",
    "full.h5 ./full.h5 => full.h5 | another",
    "full.h5 link.h5 => link.h5 | another", prefix="convert ")
Path("folder.exr").mkdir()
Path("short.h5").write_bytes(Path("full.h5").read_bytes()[:1000])
expect_refused(
    "absent.h5 new.exr => absent.h5",
    "full.h5 absent/new.exr => absent/new.exr",
    "full.h5 folder.exr => folder.exr",
    "short.h5 full.exr => short.h5",  # an older table survives
    prefix="convert ", code=1)
finish()
