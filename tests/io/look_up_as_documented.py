"""Looks up tables by docs/tables.md, section 2, alone, and compares with `stratus eval`: R and T, by origin, to 1e-5.

Usage: look_up_as_documented.py STRATUS GOLDEN_FOLDER. Exits 77 (skipped) where a package is missing.
"""

import math
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)

SCALES = {
    "square_root_of_complement": lambda w: -np.sqrt(1 - w),
    "fourth_root_of_complement": lambda w: -((1 - w) ** 0.25),
    "logarithmic": np.log2,
    "arcsine_of_fourth_root": lambda mu: np.arcsin(mu**0.25),
    "linear": lambda x: x,
    "square_root": np.sqrt,
    "identity": lambda x: x,
}
PHASE_FUNCTIONS = {
    "isotropic": lambda c: 1.0,
    "rayleigh": lambda c: 0.75 * (1 + c * c),
    "henyey_greenstein": lambda c, g: (1 - g * g) / (1 + g * g - 2 * g * c) ** 1.5,
}


def phase(text, c):
    def term(part):
        weight, _, name = part.rpartition("*")
        name, _, parameter = name.partition(":g=")
        return float(weight or 1) * PHASE_FUNCTIONS[name](c, *([float(parameter)] if parameter else []))

    return sum(map(term, text.split(" + ")))


def share(tau, mu):
    return -np.expm1(-tau / mu)


def fall(tau, k, q):
    if k == 0 or np.isinf(tau):
        return q / (tau + q)
    return np.exp(-k * tau) * np.expm1(-2 * k * q) / np.expm1(-2 * k * (tau + q))


def deficit(tau, k, q):
    if k == 0 or np.isinf(tau):
        return q / (tau + q)
    return np.expm1(2 * k * q) / np.expm1(min(2 * k * (tau + q), 700))


def rise(tau, k, q):
    d = deficit(tau, k, q)
    return 1 / (1 + d + d**2)


def growth(tau):
    return np.log1p(2.51629 / min(tau, 4))


def legendre_sum(coefficients, c):
    return np.polynomial.legendre.legval(c, coefficients)


def meetings(count, s):
    """P(n, s) for n = 0 .. count - 1: at least n particles in a Poisson distribution of mean s."""
    if np.isinf(s):
        return np.ones(count)
    fewer = np.cumsum([np.exp(k * np.log(s) - s - math.lgamma(k + 1)) for k in range(count)])
    return np.concatenate(([1], 1 - fewer[:-1]))


class Table:
    def __init__(self, path):
        with h5py.File(path) as file:
            self.attribute = {n: v.decode() if isinstance(v, bytes) else v for n, v in file.attrs.items()}
            self.data = {name: values[...] for name, values in file.items()}
            self.scale = {n: SCALES[v.attrs["scale"].decode()] for n, v in file.items() if "scale" in v.attrs}
        self.finite = {name: self.data[name][np.isfinite(self.data[name])] for name in self.scale}
        self.boundary = self.attribute.get("below")
        if "path_law" in self.attribute:
            chi = np.array(self.attribute["moments"])
            first, last = self.attribute["path_law"]
            u = np.clip((np.arange(len(chi)) - first) / (last - first), 0, 1)
            self.path_moments = chi, chi * (1 - u * u * (3 - 2 * u))

    def stencil(self, name, value):
        """Samples and their weights."""
        values, scale = self.finite[name], self.scale[name]
        n = len(values)
        if n < 2:
            return np.arange(n), np.ones(n)
        first, last = scale(values[0]), scale(values[-1])
        p = (scale(np.clip(value, values[0], values[-1])) - first) * (n - 1) / (last - first)
        cell, used = min(int(p), n - 2), 4 if name == "azimuth" else min(n, 4)
        before = name == "azimuth" and values[0] == 0  # an image of the samples lies there
        beyond = name == "azimuth" and values[-1] >= np.pi - 1e-9
        start = np.clip(cell - 1, -1 if before else 0, n - used + (1 if beyond else 0))
        at = np.arange(start, start + used)
        weights = np.array([np.prod([(p - j) / (i - j) for j in at if j != i]) for i in at])
        return np.array([abs(i) if i < n else 2 * (n - 1) - i for i in at]), weights

    def path_law(self, side, row):
        """Orders n >= 2 of the path law."""
        w, tau, mu0, mu = (row[n] for n in ("albedo", "optical_depth", "mu_in", "mu_out"))
        c = np.sqrt((1 - mu0**2) * (1 - mu**2)) * np.cos(row["azimuth"])
        c += mu * mu0 if side == "transmission" else -mu * mu0
        chi, smooth = self.path_moments
        count = 400
        if side == "reflection":
            share_of = meetings(count, tau / mu + tau / mu0) / (4 * (mu + mu0))
        else:
            share_of = (meetings(count, tau / mu0) - meetings(count, tau / mu)) / (4 * (mu - mu0))
        of_l = sum(w**n * share_of[n] / n * (chi**n - smooth**n) for n in range(2, count))
        return legendre_sum((2 * np.arange(len(chi)) + 1) * of_l, c)

    def multiple(self, side, row):
        """Orders n >= 2."""
        along_path = self.path_law(side, row) if "path_law" in self.attribute else 0
        return max(0, along_path + self.tabulated(side, row))

    def tabulated(self, side, row):
        q1 = self.attribute["extrapolation_length"]
        if "mixture" not in self.data:
            return self.of_mixture(side, row, (), q1)[0]
        total, (samples, weights) = 0, self.stencil("mixture", row["mixture"])
        lengths = self.attribute["extrapolation_lengths"][samples]
        found = [self.of_mixture(side, row, (m,), q) for m, q in zip(samples, lengths)]
        mixed = sum(c * k for c, (_, k, _) in zip(weights, found))
        for c, (value, k, tau) in zip(weights, found):
            total += c * value * (fall(tau, mixed, q1) / fall(tau, k, q1) if side == "transmission" else 1)
        return total

    def of_mixture(self, side, row, m, q):
        albedos, depths, finite = self.data["albedo"], self.data["optical_depth"], self.finite["optical_depth"]
        exponents = self.data["diffusion_exponent"][m]
        mu = [np.clip(row[name], self.data[name][0], self.data[name][-1]) for name in ("mu_in", "mu_out")]
        tau = row["optical_depth"] if np.isinf(depths[-1]) else min(row["optical_depth"], finite[-1])
        a_samples, a_weights = self.stencil("albedo", row["albedo"])
        k, plain = max(0, a_weights @ exponents[a_samples]), self.boundary is not None

        def law(t, exponent):
            return fall(t, exponent, q) if side == "transmission" else 1 if plain else rise(t, exponent, q)

        def divisor(a, t):
            return 1 if plain else (albedos[a] or 1) * law(depths[t], exponents[a])

        def value(a, t):  # V(a, t)
            (i, ci), (j, cj), (l, cl) = (self.stencil(name, at) for name, at in
                                         (("mu_in", mu[0]), ("mu_out", mu[1]), ("azimuth", row["azimuth"])))
            if not plain:
                ci = ci / share(depths[t], self.data["mu_in"][i])
                cj = cj / share(depths[t], self.data["mu_out"][j])
            samples = self.data[side + "_multiple"][m][a, t][np.ix_(i, j, l)].astype(float)
            return np.einsum("ijl,i,j,l", samples, ci, cj, cl) / divisor(a, t)

        total = carried = 0
        last = len(finite) - 1
        if side == "reflection" and (last < 0 or tau > finite[last]):
            for a, c in zip(a_samples, a_weights):
                limit, of_last = value(a, len(depths) - 1), deficit(finite[last], exponents[a], q) if last >= 0 else 0
                carried, total = carried + c, total + c * limit
                if of_last >= 1e-5:
                    near = law(finite[last], exponents[a]) * value(a, last)
                    total, carried = total + carried * deficit(tau, k, q) / of_last * (near - limit), 0
        elif last >= 0:
            first, deeper = finite[0], min(2 * finite[0], finite[:3][-1])
            x = 0.8 * (tau - first) / (deeper - first) if tau < first < deeper and not plain else 0
            for depth, share_of_depth in ((first, 1 - x), (deeper, x * growth(first) / growth(deeper))) if x else ((tau, 1),):
                in_depth = self.stencil("optical_depth", depth) if depth <= finite[last] else ([last], [1])
                carried = 0
                for t, depth_weight in reversed(list(zip(*in_depth))):
                    weight, left, carried = share_of_depth * depth_weight + carried, 0, 0
                    for a, c in zip(a_samples, a_weights):
                        left += weight * c
                        if divisor(a, t) >= 1e-35:
                            total, left = total + left * value(a, t), 0
                    carried = weight if left else 0
            total *= law(tau, k) * (growth(tau) / growth(first) if tau < first and not plain else 1)
        factor = 1 if plain else np.clip(row["albedo"], albedos[0], albedos[-1]) * share(tau, mu[0]) * share(tau, mu[1])
        if self.boundary == "lambert surface" and last >= 0 and tau < finite[0]:
            factor = sum(share(tau, m) for m in mu) / sum(share(finite[0], m) for m in mu)
        return factor * total, k, tau

    def single(self, side, row):
        w, tau, mu0, mu, f = (row.get(n, 1) for n in ("albedo", "optical_depth", "mu_in", "mu_out", "mixture"))
        c = np.sqrt((1 - mu0**2) * (1 - mu**2)) * np.cos(row["azimuth"])
        c += mu * mu0 if side == "transmission" else -mu * mu0
        phi = f * phase(self.attribute["phase_function"], c)
        if f < 1:
            phi += (1 - f) * phase(self.attribute["second_phase_function"], c)
        if side == "transmission":
            return w / 4 * phi * (np.exp(-tau / mu0) - np.exp(-tau / mu)) / (mu0 - mu)
        below = 0
        if self.boundary:
            below = self.attribute["below_albedo"]
        if self.boundary == "semi-infinite layer":
            below *= phase(self.attribute["below_phase_function"], c) / 4 / (mu + mu0)
        return w / 4 * phi * share(tau, 1 / (1 / mu + 1 / mu0)) / (mu + mu0) + np.exp(-tau / mu0 - tau / mu) * below


def random_row(table, random):
    row = {name: random.uniform(values[0], values[-1]) for name, values in table.finite.items() if len(values)}
    low, high = table.finite["optical_depth"][[0, -1]]
    row["optical_depth"] = np.exp(random.uniform(np.log(low), np.log(high)))
    if random.uniform() < 0.2 and table.boundary != "semi-infinite layer" and low <= 2:
        row["optical_depth"] = low * random.uniform(0.01, 1)
    if np.isinf(table.data["optical_depth"][-1]):
        row["optical_depth"] = random.choice([row["optical_depth"], high * random.uniform(1, 4), np.inf])
    return row


def check(stratus, path, tolerance=1e-5):
    table, random = Table(path), np.random.default_rng(1982)
    rows = [random_row(table, random) for _ in range(100)]
    lines = [",".join(rows[0]).replace("azimuth", "azimuth_deg")]
    lines += [",".join(repr(float(v if n != "azimuth" else np.degrees(v))) for n, v in row.items()) for row in rows]
    answer = subprocess.run([stratus, "eval", path], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
    names, *found = [line.split(",") for line in answer.stdout.splitlines()]
    for row, numbers in zip(rows, found, strict=True):
        told = dict(zip(names, map(float, numbers)))
        for side in ("reflection", "transmission"):
            for origin in (table.single, table.multiple) if side in told else ():
                # the path law may take away most of what is scattered once
                scale = abs(told[side]) + (abs(table.single(side, row)) if tolerance > 1e-5 else 0)
                mine, theirs = origin(side, row), told[f"{side}_{origin.__name__}"]
                assert abs(mine - theirs) <= tolerance * scale + 1e-37, (path, side, origin, row, mine, theirs)


# Deep enough to lose samples to float's range; and over a semi-infinite layer, with a sample at infinity.
DEEP = """
phase_function = "isotropic"
tolerance = 0.1
optical_depth = { min = 64.0, max = inf }
albedo = { min = 0.2, max = 1.0 }
[discretisation]
nodes = 4
modes = 1
mu_samples = 4
optical_depth_samples_per_octave = 1
deepest_optical_depth = 512.0
albedo_samples = 6
"""
OVER_LAYER = DEEP.replace("64", "1").replace("512", "4") + '[below]\nphase_function = "rayleigh"\nalbedo = 0.8\n'

# Forward-peaked, azimuths and albedos on their other scales.
PEAKED = """
phase_function = "henyey_greenstein:g=0.7"
tolerance = 0.1
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.9, max = 1.0 }
[discretisation]
nodes = 8
modes = 12
mu_samples = 6
azimuth_samples = 9
azimuth_scale = "square_root"
optical_depth_samples_per_octave = 2
albedo_samples = 3
albedo_scale = "fourth_root_of_complement"
"""

# Some directions alone.
ONE_SUN = PEAKED.replace("[disc", "mu_in = 0.4\nazimuth_deg = { min = 0.0, max = 30.0 }\n[disc").replace("azimuth_samples = 9", "azimuth_samples = 29")
ONE_AZIMUTH = PEAKED.replace("[disc", "mu_out = { min = 0.2, max = 0.7 }\nazimuth_deg = 75\n[disc")
BETWEEN = PEAKED.replace("[disc", "azimuth_deg = { min = 60.0, max = 150.0 }\n[disc").replace("square_root\"\no", "linear\"\no")

# With the path law, which the program interpolates.
NARROW = PEAKED.replace("g=0.7", "g=0.9")

program, recipes = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
SMALL = [(recipes / f"{name}.toml").read_text() for name in ("plain", "ground", "mixture")]
with tempfile.TemporaryDirectory() as folder:
    recipe, baked = pathlib.Path(folder) / "recipe.toml", pathlib.Path(folder) / "table.h5"
    for text in (*SMALL, DEEP, OVER_LAYER, PEAKED, ONE_SUN, ONE_AZIMUTH, BETWEEN):
        recipe.write_text(text)
        subprocess.run([program, "bake", recipe, "-o", baked, "--quiet"], check=False)  # 1 where its tolerance is missed
        check(program, baked)
    recipe.write_text(NARROW)
    subprocess.run([program, "bake", recipe, "-o", baked, "--quiet"], check=False)
    check(program, baked, 4e-4)
