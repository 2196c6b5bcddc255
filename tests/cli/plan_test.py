"""stratus plan, bake, render --table: the recipes that a plan writes make the tables that its scene is rendered with, for every
picture of the gallery that needs one. A coarse tolerance and one ray a pixel of few keep plans, bakes and pictures quick."""

import re

from expect import *

shutil.copytree(source / "tables", "tables")
chains = 0
for scene in sorted(Path("tables/scenes").glob("*.toml")):
    text = scene.read_text()
    scene.write_text(re.sub("^samples = .*", "samples = 1", text, flags=re.M))
    if re.search(r"^\[(lobes|lambert)\]", text, re.M):
        continue
    name = scene.stem
    expect_ok(f"plan {scene} --width 64 --quiet --tolerance 0.05 --write {name}.toml", out="render takes about | tolerance 0.05")
    recipes = [recipe for recipe in Path().glob("*.toml") if re.fullmatch(name + "(_.*)?", recipe.stem)]
    for recipe in recipes:
        expect_ok(f"bake {recipe} -o {recipe.stem}.h5 --quiet --accept")
    expect(recipes, f"{name} must have a recipe")
    tables = "".join(f" --table {recipe.stem}.h5" for recipe in recipes)
    expect_ok(f"render {scene} -o {name}.png --width 32 --quiet {tables}")
    chains += 1
expect(chains >= 7, "the gallery has seven pictures at least")

# a table without what the scene looks up is refused
expect_refused("render tables/scenes/fogbow.toml -o a.png --table fogbow_red.h5 => table.phase_function | wavelength=0.55")
finish()
