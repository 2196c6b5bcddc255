"""The documented material of an atlas, rendered by Blender's Cycles on a plane, beside the solver.

    blender --background --python-exit-code 1 --python atlas_in_blender.py -- STRATUS ATLAS_NODES.py
"""
import csv
import importlib.util
import math
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy as np

stratus, example = sys.argv[sys.argv.index("--") + 1:]
specification = importlib.util.spec_from_file_location("atlas_nodes", example)
atlas_nodes = importlib.util.module_from_spec(specification)
specification.loader.exec_module(atlas_nodes)

layer = ["--phase", "henyey_greenstein:g=0.5", "--albedo", "0.9", "--optical-depth", "1"]
size = 64
suns = [(0.3, 0.8, 0.5), (0, 0, 1), (0.6, -0.7, 0.3), (-0.5, 0.5, -0.7)]
tilt, half_angle = math.radians(55), math.radians(40)


def place_camera():
    """A camera above a plane that fills the picture, one ray through the middle of each pixel."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=1e4)
    plane = bpy.context.object
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle, camera.location, camera.rotation_euler = 2 * half_angle, (0, 0, 3), (tilt, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    return scene, plane


def to_eye(column, row):
    x, y = (((k + 0.5) * 2 / size - 1) * math.tan(half_angle) for k in (column, row))
    ray = np.array([x, math.cos(tilt) * y + math.sin(tilt), math.sin(tilt) * y - math.cos(tilt)])
    return -ray / np.linalg.norm(ray)


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    atlas, query = str(folder / "layer.exr"), folder / "query.csv"
    stack = folder / "layer.toml"
    stack.write_text('[[layers]]\nphase_function = "henyey_greenstein:g=0.5"\nalbedo = 0.9\noptical_depth = 1.0\n')
    subprocess.run([stratus, "export", stack, "--format", "exr-atlas", "-o", atlas, "--quiet"], check=True)
    scene, plane = place_camera()
    rows, met = [], []
    for given in suns:
        sun = np.array(given) / np.linalg.norm(given)
        plane.data.materials.clear()
        plane.data.materials.append(atlas_nodes.atlas_material(atlas, sun))
        scene.render.filepath = str(folder / "picture.exr")
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(picture.pixels[:]).reshape(size, size, 4)
        bpy.data.images.remove(picture)
        for row in range(2, size, 6):
            for column in range(2, size, 6):
                eye = to_eye(column, row)
                if eye[2] < 0.05:
                    continue
                azimuth = math.degrees(math.atan2(eye[1], eye[0]) - math.atan2(sun[1], sun[0])) - 180
                rows.append([abs(sun[2]), eye[2], azimuth % 360])
                met.append((sun[2] > 0, pixels[row, column, :3]))
    with open(query, "w", newline="") as file:
        csv.writer(file).writerows([["mu_in", "mu_out", "azimuth_deg"], *rows])
    answer = subprocess.run([stratus, "solve", *layer, "--query", query], check=True, capture_output=True, text=True).stdout

errors = []
for (mu_in, _, _), (lit, pixel), solved in zip(rows, met, csv.DictReader(answer.splitlines())):
    expected = mu_in * float(solved["reflection" if lit else "transmission"])
    errors.extend(abs(pixel / expected - 1))
errors = np.array(errors)
print(f"{len(errors)} values of pixels: median {np.median(errors):.2g}, largest {errors.max():.2g}")
if len(errors) < 500 or np.median(errors) > 3e-4 or errors.max() > 5e-3:
    sys.exit("the material differs from the solver")
