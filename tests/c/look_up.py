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
library.stratus_slice_bytes.restype = c.c_size_t

INVALID_ARGUMENT, FAILED = 1, 2


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


def refused(status, text, name, *arguments):
    assert getattr(library, name)(*arguments) == status, name
    assert text in library.stratus_last_error(), library.stratus_last_error()


def floats(*values):
    return (c.c_float * len(values))(*values)


def doubles(*values):
    return (c.c_double * len(values))(*values)


table = c.c_void_p()
call("stratus_table_open", sys.argv[2].encode(), c.byref(table))
assert library.stratus_table_text(table, b"title") == b"Called from elsewhere"
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
piece = c.c_void_p()
call("stratus_slice_bind", table, 1, doubles(row["optical_depth"] / 2), doubles(row["albedo"]),
     c.byref(effects), c.byref(piece))
library.stratus_table_close(table)
assert library.stratus_slice_channels(piece) == 1 and library.stratus_slice_bytes(piece) > 1000
count = 20
value = (c.c_float * count)()
call("stratus_slice_reflection_many", piece, c.c_size_t(count), floats(*count * [row["mu_in"]]),
     floats(*count * [row["mu_out"]]), floats(*count * [math.radians(row["azimuth_deg"])]), value)
for met in value:  # 1e-2: the table's tolerance
    assert math.isclose(met, row["reflection"], rel_tol=1e-2), (met, row)

refused(FAILED, b"absent.h5", "stratus_table_open", b"absent.h5", c.byref(table))
refused(INVALID_ARGUMENT, b".h5", "stratus_table_open", b"table.txt", c.byref(table))
refused(INVALID_ARGUMENT, b"null", "stratus_slice_eval", None, None, None, None)
refused(INVALID_ARGUMENT, b"albedo must be in [0, 1], got 1.5", "stratus_slice_bind_single",
        b"rayleigh", 1, doubles(1), doubles(1.5), None, c.byref(table))
effects.size -= 8
refused(INVALID_ARGUMENT, b"effects.size", "stratus_slice_bind_single", b"rayleigh", 1,
        doubles(1), doubles(1), c.byref(effects), c.byref(table))
library.stratus_slice_free(piece)
