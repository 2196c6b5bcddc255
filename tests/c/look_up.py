"""Stratus from Python, with nothing but ctypes: the same answers as those of the C++ program.

Usage: look_up.py LIBSTRATUS TABLE.h5 ANSWER.csv
"""

import csv
import ctypes as c
import math
import sys

library = c.CDLL(sys.argv[1])
library.stratus_last_error.restype = c.c_char_p
library.stratus_table_text.restype = c.c_char_p


class Point(c.Structure):
    _fields_ = [(name, c.c_double) for name in
                ("optical_depth", "albedo", "mu_in", "mu_out", "azimuth")]


class Scattered(c.Structure):
    _fields_ = [("single", c.c_double), ("multiple", c.c_double)]


class Effects(c.Structure):
    _fields_ = ([("size", c.c_size_t)] +
                [(name, c.c_int) for name in ("single", "multiple", "reflection", "transmission")] +
                [("density", c.c_double), ("opposition", c.c_int),
                 ("opposition_width", c.c_double), ("opposition_amplitude", c.c_double)])


def call(name, *arguments):
    status = getattr(library, name)(*arguments)
    assert status == 0, (name, status, library.stratus_last_error())


table = c.c_void_p()
call("stratus_table_open", sys.argv[2].encode(), c.byref(table))
assert library.stratus_table_text(table, b"title") == b"Golden, plain"
assert library.stratus_table_text(table, b"no such text") is None

with open(sys.argv[3], newline="") as file:
    rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
points = (Point * len(rows))(*(
    Point(row["optical_depth"], row["albedo"], row["mu_in"], row["mu_out"],
          math.radians(row["azimuth_deg"])) for row in rows))
for side in "reflection", "transmission":
    values = (Scattered * len(rows))()
    call("stratus_table_" + side, table, c.c_size_t(len(rows)), points, values)
    for row, value in zip(rows, values):
        assert math.isclose(value.single, row[side + "_single"], rel_tol=1e-14)
        assert math.isclose(value.multiple, row[side + "_multiple"], rel_tol=1e-14)

# A layer half as deep whose particles fill half of the volume is the same layer.
effects = Effects(size=c.sizeof(Effects))
call("stratus_effects_default", c.byref(effects))
assert (effects.single, effects.multiple, effects.density) == (1, 1, 0)
effects.density = 0.5
row = rows[1]
piece, value = c.c_void_p(), c.c_float()
call("stratus_slice_bind", table, 1, c.byref(c.c_double(row["optical_depth"] / 2)), c.byref(c.c_double(row["albedo"])),
     c.byref(effects), c.byref(piece))
library.stratus_table_close(table)
call("stratus_slice_reflection", piece, c.c_float(row["mu_in"]), c.c_float(row["mu_out"]),
     c.c_float(math.radians(row["azimuth_deg"])), c.byref(value))
assert math.isclose(value.value, row["reflection"], rel_tol=1e-2), (value, row)  # the table's tolerance

assert library.stratus_table_open(b"absent.h5", c.byref(table)) != 0
assert b"absent.h5" in library.stratus_last_error(), library.stratus_last_error()
library.stratus_slice_free(piece)
