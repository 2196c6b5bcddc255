"""R and T of a layer from `stratus export ... --format slice`, with numpy alone.

    stratus export TABLE.h5 --optical-depth 1 --albedo 0.9 --format slice -o layer.safetensors
    python3 look_up_slice.py layer.safetensors 0.8 0.5 60
"""

import json
import sys

import numpy as np


def read_arrays(path):
    """All arrays of a file of the safetensors layout, by name."""
    data = open(path, "rb").read()
    start = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:start])
    header.pop("__metadata__")
    dtypes = {"F16": "<f2", "F32": "<f4", "F64": "<f8"}  # F16: padding alone
    return {name: np.frombuffer(data[start:], dtypes[of["dtype"]], int(np.prod(of["shape"])),
                                of["data_offsets"][0]).reshape(of["shape"])
            for name, of in header.items()}


def look_up(samples, mu_in, mu_out, azimuth):
    """R or T at arrays of cosines and azimuths in radians, over (colour, ...)."""
    places = [np.arcsin(np.sqrt(mu)) * 2 / np.pi for mu in (mu_in, mu_out)]
    places.append(np.arccos(np.cos(azimuth)) / np.pi)
    sum_of_corners = 0
    low = [np.minimum((place * (n - 1)).astype(int), n - 2)
           for place, n in zip(places, samples.shape[1:])]
    share = [place * (n - 1) - i for place, n, i in zip(places, samples.shape[1:], low)]
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod([s if c else 1 - s for s, c in zip(share, corner)], axis=0)
        i, o, a = (i + c for i, c in zip(low, corner))
        sum_of_corners = sum_of_corners + weight * samples[:, i, o, a]
    return sum_of_corners / (mu_in + mu_out)


if __name__ == "__main__":
    arrays = read_arrays(sys.argv[1])
    mu_in, mu_out, degrees = (np.array([float(text)]) for text in sys.argv[2:5])
    for side in "reflection", "transmission":
        if side in arrays:
            print(side, *look_up(arrays[side], mu_in, mu_out, np.radians(degrees))[:, 0])
