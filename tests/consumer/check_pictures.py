"""Compares the path tracer's pictures with what `stratus eval` says of its table.

    check_pictures.py STRATUS TABLE SUNLIT.ppm SUN FURNACE.ppm SKY

SUNLIT has no sky, and light that bounced once; FURNACE has no sun. Prints nothing if they agree.
"""

import subprocess
import sys
from math import acos, degrees, pi, sqrt
from pathlib import Path

stratus, table, *pictures = sys.argv[1:]
ALBEDOS = 1.0, 0.97, 0.9  # as in the path tracer, like the width
HALF_WIDTH = 1.6
ROOT_HALF, ROOT_THIRD = sqrt(1 / 2), sqrt(1 / 3)
all_right = True


class Picture:
    """Pixels by their coordinates to the right and up, in [-HALF_WIDTH, HALF_WIDTH]."""

    def __init__(self, path):
        kind, width, height, white, *values = Path(path).read_text().split()
        assert kind == "P3" and width == height, path
        self.size = int(width)
        self.values = [float(value) / float(white) for value in values]

    def place(self, coordinate):
        return int((coordinate / HALF_WIDTH + 1) / 2 * self.size)

    def middle(self, coordinate):
        """The middle of the pixel that a coordinate lies in."""
        return ((self.place(coordinate) + 0.5) / self.size * 2 - 1) * HALF_WIDTH

    def at(self, right, up, channel):
        """The mean of nine pixels around a point."""
        first = self.place(-up) * self.size + self.place(right)
        near = -1, 0, 1
        return sum(self.values[3 * (first + row * self.size + column) + channel] for row in near for column in near) / 9


def expect_within(what, met, low, high):
    global all_right
    if not low <= met <= high:
        all_right = False
        print(f"{what}: {met} is not in [{low}, {high}]")


def reflections(albedo, geometries):
    """R of the dust, which has no end, for each mu_in, mu_out and azimuth."""
    rows = "".join(f"{mu_in},{mu_out},{degrees(azimuth)},{albedo},inf\n" for mu_in, mu_out, azimuth in geometries)
    said = subprocess.run([stratus, "eval", table, "--effects", "single,multiple,reflection"], text=True, check=True,
                          capture_output=True, input="mu_in,mu_out,azimuth_deg,albedo,optical_depth\n" + rows)
    return [float(line.split(",")[5]) for line in said.stdout.splitlines()[1:]]


def sunlit(albedo, sun, x, y, z):
    """Radiance towards the camera of a facet of this normal that faces the sun and sees nothing else."""
    mu_in, mu_out = (x - y + z) * ROOT_THIRD, (z - y) * ROOT_HALF
    # Light travels along (-1, 1, -1), then along (0, -1, 1): the product of their parts along the facet.
    along = -2 * ROOT_THIRD * ROOT_HALF + mu_in * mu_out
    sines = sqrt((1 - mu_in**2) * (1 - mu_out**2))
    azimuth = acos(max(-1, min(along / sines, 1)) if sines > 0 else 1)
    return sun * mu_in * reflections(albedo, [(mu_in, mu_out, azimuth)])[0] / pi


def normal_at(right, up):
    """The sphere's normal at a point to the right and up of the picture's centre."""
    towards = sqrt(1 - right**2 - up**2)
    return right, (up - towards) * ROOT_HALF, (up + towards) * ROOT_HALF


def check_sunlit(picture, sun):
    # 0.5 %: binding adds a quarter of the table's 0.1 %, and pixels are as wide as 2 degrees.
    for c, albedo in enumerate(ALBEDOS):
        for name, right, up in ("top", 0, ROOT_HALF), ("centre", 0, 0), ("sunny side", 0.6, 0.1), ("ground", 1.3, -1):
            normal = (0, 0, 1) if name == "ground" else normal_at(picture.middle(right), picture.middle(up))
            expected = sunlit(albedo, sun, *normal)
            expect_within(f"{name} in channel {c}", picture.at(right, up, c), 0.995 * expected, 1.005 * expected)
        expect_within("night", picture.at(-0.8, 0.5, c), 0, 0)
        expect_within("shadow", picture.at(-1.3, 0, c), 0, 0)


def check_furnace(picture, sky):
    white = picture.values[::3]
    for value in white:  # without absorption as bright as the sky, but for the noise of 32 paths
        expect_within("pixel in the furnace", value, 0.8 * sky, 1.2 * sky)
    expect_within("mean of the furnace", sum(white) / len(white), 0.997 * sky, 1.003 * sky)
    # The share of a white sky that the top sends to the camera: midpoints, exact to 1e-3.
    middles = [((i + 0.5) / 100, ROOT_HALF, (k + 0.5) * pi / 20) for i in range(100) for k in range(20)]
    for c in 1, 2:
        found = zip(middles, reflections(ALBEDOS[c], middles))
        expected = sky * sum(2 * mu_in * reflection for (mu_in, _, _), reflection in found) / len(middles)
        expect_within("top in the furnace", picture.at(0, ROOT_HALF, c), 0.98 * expected, 1.02 * expected)


check_sunlit(Picture(pictures[0]), float(pictures[1]))
check_furnace(Picture(pictures[2]), float(pictures[3]))
sys.exit(not all_right)
