"""Looks up a packed table with NumPy alone: docs/packed.md describes the file, docs/conventions.md the terms.

Of one layer with no lower boundary, mixture or path law, where mu_in and mu_out are sampled alike, at finite depths.
"""
import json
import numpy as np

DTYPES = {"F16": "<f2", "F32": "<f4", "F64": "<f8", "I32": "<i4"}
SCALES = {"square_root_of_complement": lambda w: -np.sqrt(1 - w), "fourth_root_of_complement": lambda w: -((1 - w) ** 0.25),
          "arcsine_of_fourth_root": lambda mu: np.arcsin(mu**0.25), "logarithmic": np.log2,
          "linear": lambda azimuth: azimuth, "square_root": np.sqrt}

class PackedTable:
    def __init__(self, path):
        data = np.memmap(path, np.uint8, "r")
        length = int(data[:8].view("<u8")[0])
        header, numbers = json.loads(bytes(data[8 : 8 + length])), data[8 + length :]
        self.text = header.pop("__metadata__")
        self.array = {name: np.frombuffer(numbers[slice(*of["data_offsets"])], DTYPES[of["dtype"]]).reshape(of["shape"])
                      for name, of in header.items()}

    def stencil(self, name, value, least=4):
        """The sample before a value, and the samples of its cubic with their weights; on `least` samples or more."""
        scale, samples = SCALES[self.text[name + "_scale"]], self.array[name][np.isfinite(self.array[name])]
        first, last = scale(samples[0]), scale(samples[-1])
        count, mirrored = max(least, len(samples)), name == "azimuth" and len(samples) > 1
        p = (count - 1) * (scale(np.clip(value, samples[0], samples[-1])) - first) / (last - first) if first < last else 0.0
        before = max(0, min(int(p - 1e-9), count - 2))  # a sample belongs to the cell below it
        at = (before - 1 if mirrored else max(0, min(before - 1, count - 4))) + np.arange(4 if mirrored else min(4, count))
        return before, at, np.array([np.prod([(p - j) / (i - j) for j in at if j != i]) for i in at])

    def multiple(self, side, albedo, tau, mu_in, mu_out, azimuth):
        """R or T of the orders n >= 2; side is "reflection" or "transmission"."""
        (a, albedos, ca), (t, depths, ct) = self.stencil("albedo", albedo), self.stencil("optical_depth", tau)
        thinnest, deeper = self.array["optical_depth"][0], self.array["optical_depth"][: 3][-1]
        deeper, growth = min(2 * thinnest, deeper), lambda depth: np.log1p(2.51629 / min(depth, 4))
        if tau < thinnest < deeper:
            x = 0.8 * (tau - thinnest) / (deeper - thinnest)
            ct = (1 - x) / growth(thinnest) * ct + x / growth(deeper) * self.stencil("optical_depth", deeper)[2]
        elif tau < thinnest:
            ct = ct / growth(thinnest)
        block = self.array[side + "/block_of_cell"][a, t]
        first_albedo, _, first_depth, depth_count, _, first_row = self.array[side + "/blocks"][block]
        rows = first_row + (albedos[:, None] - first_albedo) * depth_count + depths - first_depth
        coefficients = np.einsum("a,t,atf", ca, ct, self.array[side + "/coefficients"][rows])
        both = [self.stencil("mu_in", mu_in)[1:], self.stencil("mu_out", mu_out)[1:]]
        (i, ci), (j, cj) = sorted(both, key=lambda cubic: -cubic[0][0])  # mu, whose samples are the higher, and mu'
        _, k, ck = self.stencil("azimuth", azimuth, least=1)
        width = len(self.array["azimuth"]) + 2 if len(k) > 1 else 1
        places = ((i * (i + 7) // 2)[:, None] + j)[:, :, None] * width + k + (width > 1)  # i + 4 of mu' for each i
        functions = self.array[side + "/functions"][block, places].astype(float)
        _, at, weights = self.stencil("albedo", albedo, least=1)
        k, q = max(0, weights @ self.array["diffusion_exponent"][0, at]), float(self.text["extrapolation_length"])
        fall = np.sinh(k * q) / np.sinh(k * (tau + q)) if k else q / (tau + q)
        d = np.expm1(2 * k * q) / np.expm1(2 * k * (tau + q)) if k else fall
        scale = fall if side == "transmission" else 1 / (1 + d + d**2)
        scale *= growth(tau) if tau < thinnest else 1
        return albedo * scale * np.expm1(-tau / mu_in) * np.expm1(-tau / mu_out) * np.einsum(
            "f,i,j,k,ijkf", coefficients, ci, cj, ck, functions)
