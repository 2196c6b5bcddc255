"""stratus seal: a table changed on purpose is refused until it is sealed; what is no table is not sealed."""

import re

from expect import *

fixtures("full")
expect_ok("convert full.h5 full.exr")
title = re.search("^title *(.*)", expect_ok("info full.exr").out, re.M)[1]
changed = "#" + title[1:]
for ending in "h5", "exr":
    # a table as it was written stays as it is
    expect_ok(f"seal full.{ending} -o sealed.{ending}", out="", err="")
    expect_same("full." + ending, "sealed." + ending)
    # another title, as long; not through HDF5, whose headers have checksums of their own
    table = Path("full." + ending).read_bytes()
    Path("changed." + ending).write_bytes(table.replace(title.encode(), changed.encode()))
expect_refused(
    "info changed.h5 => changed.h5 | checksum",
    "seal changed.h5 => changed.h5 | checksum",
    "info changed.exr => changed.exr: the metadata was changed or damaged since it was sealed | "
    "if on purpose, `stratus seal changed.exr`",
    code=1)
expect_ok("seal changed.exr")
expect_ok("info changed.exr", out=changed)

expect_refused(
    "table.txt => TABLE | .h5 | .exr | table.txt",
    "full.stratus => TABLE | .h5 | .exr | full.stratus",
    "full.h5 -o '' => --output | the name of a file, got nothing",
    "full.h5 -o new.txt => --output | .h5 | .exr | new.txt", prefix="seal ")
Path("short.h5").write_bytes(Path("full.h5").read_bytes()[:1000])
Path("other.exr").write_bytes(table.replace(b"stratus-table", b"stratus-chair"))
expect_refused(
    "absent.h5 => absent.h5",
    "full.h5 -o absent/new.h5 => absent/new.h5",
    "short.h5 => short.h5",
    "other.exr => other.exr | is not a stratus-table file", prefix="seal ", code=1)
finish()
