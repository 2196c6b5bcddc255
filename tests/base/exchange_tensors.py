"""Files of tensors from and to a reader and a writer of the safetensors layout of nothing but Python.

Usage: exchange_tensors.py EXCHANGE_TENSORS.
"""

import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

LETTERS = {"F16": "e", "F32": "f", "F64": "d", "I32": "i"}  # of struct


def size_of(dtype):
    return struct.calcsize("<" + LETTERS[dtype])


def read(content):
    """What a file holds, by what the layout demands: nothing overlaps and no byte is left over."""
    (length,) = struct.unpack_from("<Q", content)
    assert content[8:9] == b"{" and (8 + length) % 8 == 0
    header = json.loads(content[8 : 8 + length].decode())
    data = content[8 + length :]
    strings = header.pop("__metadata__", {})
    end, tensors = 0, {}
    for name, tensor in sorted(header.items(), key=lambda item: item[1]["data_offsets"]):
        begin, count = end, math.prod(tensor["shape"])
        end = begin + count * size_of(tensor["dtype"])
        assert tensor["data_offsets"] == [begin, end], (name, tensor)
        assert name.startswith("padding_") or (8 + length + begin) % 64 == 0, (name, tensor)
        numbers = struct.unpack_from(f"<{count}{LETTERS[tensor['dtype']]}", data, begin)
        tensors[name] = (tensor["dtype"], tensor["shape"], list(numbers))
    assert end == len(data), (end, len(data))
    return strings, tensors


def checksum(strings, tensors):
    """As tensor_file.h says."""
    parts = [f"{key}\0{text}\0".encode() for key, text in sorted(strings.items()) if key != "checksum"]
    for name, (dtype, shape, numbers) in sorted(tensors.items()):
        if name.startswith("padding_"):
            continue
        parts.append(f"{name}\0{dtype}\0".encode() + struct.pack(f"<{len(shape)}Q", *shape))
        parts.append(struct.pack(f"<{len(numbers)}{LETTERS[dtype]}", *numbers))
    return f"crc32:{zlib.crc32(b''.join(parts)):08x}"


def write(strings, tensors):
    """A file without padding, the largest numbers first, as the libraries write it."""
    header, data = {"__metadata__": strings}, b""
    for name, (dtype, shape, numbers) in sorted(
        tensors.items(), key=lambda item: (-size_of(item[1][0]), item[0])
    ):
        begin = len(data)
        data += struct.pack(f"<{len(numbers)}{LETTERS[dtype]}", *numbers)
        header[name] = {"dtype": dtype, "shape": shape, "data_offsets": [begin, len(data)]}
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + data


def listed(strings, tensors):
    """What `exchange_tensors list` prints of it."""
    lines = [f"{key} = {text}" for key, text in sorted(strings.items())]
    for name, (dtype, shape, numbers) in sorted(tensors.items()):
        words = [name, dtype, "[", *map(str, shape), "]", *(f"{number:.17g}" for number in numbers)]
        lines.append(" ".join(words))
    return "".join(line + "\n" for line in lines)


STRINGS = {"title": '\u03c4 "8"\\\n\t\U0001f308'}
TENSORS = {
    "floats": ("F32", [2, 3], [-1, -0.5, 0, 0.5, 1, 1.5]),
    "halves": ("F16", [3], [0.25, -1, 65504]),
    "doubles": ("F64", [2, 1], [1 / 3, -1e300]),
    "integers": ("I32", [4], [0, -1, 2147483647, -2147483647]),
    "single": ("F64", [], [7]),
}

program = sys.argv[1]
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "tensors"
    subprocess.run([program, "write", path], check=True)
    strings, tensors = read(path.read_bytes())
    paddings = {name: tensor for name, tensor in tensors.items() if name.startswith("padding_")}
    assert len(paddings) == 4 and not any(any(numbers) for _, _, numbers in paddings.values())
    assert strings.pop("checksum") == checksum(strings, tensors)
    assert strings == STRINGS, strings
    assert {name: tensors[name] for name in tensors.keys() - paddings.keys()} == TENSORS, tensors

    for changes in (
        {},
        {"doubles": ("F64", [3], [math.inf, -math.inf, 5e-324])},
        {"a\u00e9": ("I32", [1, 1], [5])},
    ):
        theirs = {**TENSORS, **changes}
        path.write_bytes(write(STRINGS, theirs))
        done = subprocess.run([program, "list", path], check=True, capture_output=True)
        assert done.stdout.decode() == listed(STRINGS, theirs), done.stdout.decode()
