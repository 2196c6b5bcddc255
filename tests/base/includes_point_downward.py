"""Every room includes itself and rooms below it alone, and private headers of none but itself; the five floors of the runtime,
which are one library, include private headers of lower floors too.

    includes_point_downward.py SOURCE_FOLDER
"""
import re
import sys
from pathlib import Path

# Rooms from the ground up; those of one line do not include one another.
STOREYS = """base
phase
layer
table
bsdf
transfer io
bake picture
material scene shader fit
view
c ranks
cli python"""
HEIGHT = {room: height for height, line in enumerate(STOREYS.splitlines()) for room in line.split()}
FLOORS = STOREYS.split()[:5]

# Private headers that another room includes all the same.
KNOWN = {
    ("picture", "src/io/file_bytes.h"),
    ("ranks", "src/bake/backoff.h"),
    ("scene", "src/bake/axes.h"),
    ("scene", "src/bake/forecast.h"),
    ("scene", "src/bake/toml_section.h"),
    ("shader", "src/table/kernels/packed.h"),
    ("shader", "src/table/packed_block.h"),
}


def room_of(path):
    """None for include/stratus/*.h, pages of whole interfaces."""
    if path.parts[0] == "cli":
        return "cli"
    if path.parts[0] == "include":
        return path.parts[2] if len(path.parts) > 3 else None
    return path.parts[1]


def private_header(root, file, name):
    """The file that `#include "NAME"` means in a file; None for one that the build makes."""
    beside = (root / file.parent / name).resolve()
    if beside.exists():
        return beside.relative_to(root)
    return next((path.relative_to(root) for path in sorted((root / "src").rglob(name))), None)


def complaints(root):
    sources = [path for top in ("include", "src", "cli") for path in sorted((root / top).rglob("*.*"))
               if path.suffix in (".h", ".cpp", ".c")]
    read, met = 0, set()
    for source in sources:
        file = source.relative_to(root)
        room = room_of(file)
        if room is None:
            continue
        for name in re.findall(r'^ *# *include (<stratus/[^>]+>|"[^"]+")', source.read_text(), re.M):
            read += 1
            header = (Path("include") / name[1:-1] if name[0] == "<" else private_header(root, file, name[1:-1]))
            other = room_of(header) if header else None
            if other is None or other == room:
                continue
            if room not in HEIGHT or other not in HEIGHT:
                yield f"{file} includes {header}: the storeys lack one of both rooms"
            elif HEIGHT[other] >= HEIGHT[room]:
                yield f"{file} includes {header}, which is not below it"
            elif header.parts[0] != "include" and not (room in FLOORS and other in FLOORS):
                met.add((room, header.as_posix()))
                if (room, header.as_posix()) not in KNOWN:
                    yield f"{file} includes {header}, a private header of another room"
    if read < 1000:
        yield f"only {read} includes were read"
    for room, header in sorted(KNOWN - met):
        yield f"{room} includes {header} no more: take it off the list"


found = list(complaints(Path(sys.argv[1]).resolve()))
print(*found, sep="\n", end="\n" if found else "")
sys.exit(bool(found))
