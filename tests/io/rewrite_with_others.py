"""Rewrites tables with h5py, h5repack and xarray: they load again, every number and text as it was, and are looked up alike.

Usage: rewrite_with_others.py STRATUS WRITE_SAMPLE_TABLE GOLDEN_FOLDER. Exits 77 (skipped) where a package is missing.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import h5netcdf  # noqa: F401  (xarray's engine)
    import h5py
    import xarray
except ImportError as missing:
    print(missing)
    sys.exit(77)
if not shutil.which("h5repack"):
    print("no h5repack")
    sys.exit(77)

QUERY = "mu_in,mu_out,azimuth_deg,optical_depth,albedo\n0.3,0.8,70,0.9,0.9\n0.9,0.2,160,0.7,0.6\n"
MIXED_QUERY = QUERY.replace("albedo\n", "albedo,mixture\n").replace("0.9\n", "0.9,0.3\n").replace("0.6\n", "0.6,0.8\n")


def copy_with_h5py(source, target):
    with h5py.File(source) as old, h5py.File(target, "w") as new:
        new.attrs.update(old.attrs)
        for name, dataset in old.items():
            new[name] = dataset[...]
            for attribute, value in dataset.attrs.items():
                if attribute not in ("DIMENSION_LIST", "REFERENCE_LIST"):  # refer to objects of the old file
                    new[name].attrs[attribute] = value


def repack(source, target):
    subprocess.run(["h5repack", source, target], check=True)


def repack_latest(source, target):
    subprocess.run(["h5repack", "--latest", source, target], check=True)


def rewrite_with_xarray(source, target):
    with xarray.open_dataset(source, engine="h5netcdf") as table:
        table.to_netcdf(target, engine="h5netcdf")


def stratus(*arguments, code=0, text=None):
    done = subprocess.run([program, *arguments], input=text, capture_output=True, text=True)
    assert done.returncode == code, (arguments, done.returncode, done.stderr)
    return done.stdout if code == 0 else done.stderr


def content(table):
    """All numbers and texts of a table, and what is looked up in it."""
    picture = table.with_suffix(".exr")
    stratus("convert", table, picture)
    return picture.read_bytes(), stratus("eval", table, text=MIXED_QUERY if "mixture" in table.name else QUERY)


def expect_unchanged(source, rewrite):
    target = source.with_name(f"{source.stem}_{rewrite.__name__}.h5")
    rewrite(source, target)
    assert target.read_bytes() != source.read_bytes()
    assert content(target) == content(source), (source, rewrite.__name__)


def expect_sealable(source):
    """A number changed on purpose is refused until it is sealed; a word of one's own is not."""
    with h5py.File(source, "r+") as table:
        table.attrs["owner"] = "me"
    stratus("info", source)
    with h5py.File(source, "r+") as table:
        table["spherical_albedo"][0, 0] = 0.125
    for refused in (stratus("info", source, code=1), stratus("eval", source, code=1, text=QUERY)):
        assert "spherical_albedo was changed or damaged since it was sealed" in refused, refused
        assert f"if on purpose, `stratus seal {source}`" in refused, refused
    stratus("seal", source)
    assert "owner" in stratus("info", source)
    with h5py.File(source) as table:
        assert table["spherical_albedo"][0, 0] == 0.125


program, write_sample_table, recipes = sys.argv[1:]
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    subprocess.run([write_sample_table, folder / "sample.h5"], check=True)
    for recipe in ("plain", "ground", "mixture"):
        stratus("bake", pathlib.Path(recipes) / f"{recipe}.toml", "-o", folder / f"{recipe}.h5", "--accept", "--quiet")
    for table in sorted(folder.glob("*.h5")):
        for rewrite in (copy_with_h5py, repack, repack_latest, rewrite_with_xarray):
            expect_unchanged(table, rewrite)
    expect_sealable(folder / "sample.h5")
