"""--keys prints what the pages show, and what is refused names file and line."""

import re

from expect import *


def expect_page(page, said):
    """The page's table of keys has the columns of the answer."""
    rows = [line.strip("| ").replace("`", "").split(" | ") for line in read(source / "docs" / page).splitlines()]
    shown = [row for row in rows if len(row) == 6 and not row[0].startswith("---")]
    told = [re.split("   *", line) for line in said.out.splitlines()]
    expect(told == shown, f"docs/{page} must show the keys that the program prints: {[row for row in told if row not in shown]}")


expect_page("scenes.md", expect_ok("render --keys", err="", out=
                                   "camera.field_of_view_deg | degrees | [1e-3, 170] | layer.opposition.law"))
expect_page("recipes.md", expect_ok("bake --keys", out="discretisation.mu_samples | [4, 512] | optical_depth.max | or inf"))

write("rings.csv", "radius,optical_depth,w1,w2", "1.2,1,0.6,0.2", "1.1,1,0.6,0.2")
write("rings.toml",
      "[camera]",
      "distance = 10.0",
      "field_of_view_deg = 20.0",
      "[sun]",
      "elevation_deg = 20.0",
      "[layer]",
      'components = ["isotropic", "rayleigh"]',
      "[rings]",
      'profile = "rings.csv"',
      'surface = { image = "absent.png" }')
render = "render rings.toml -o a.png => rings.toml, "
expect_refused(render + "line 9: rings.profile: rings.csv, line 3: radius must be above | got 1.1")
edit("rings.csv", "rings.csv", ("1.1,", "1.3,"))
expect_refused(render + "line 10: rings.surface.image:  | absent.png", code=1)
edit("rings.toml", "rings.toml", ('{ image = "absent.png" }', "0.5\n[[panels]]\nrings.inner = 1.9"))
expect_refused(render + "line 12: rings.inner must be within the profile | got 1.9")
finish()
