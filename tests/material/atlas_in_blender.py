"""The documented material of an atlas, rendered by Blender on a plane, beside the solver: by Cycles, and by Eevee where it has a display.

    blender --background --python-exit-code 1 --python atlas_in_blender.py -- STRATUS STRATUS_ADDON.py
"""
import csv
import importlib.util
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy as np

stratus, example = sys.argv[sys.argv.index("--") + 1:]
specification = importlib.util.spec_from_file_location("stratus_addon", example)
addon = importlib.util.module_from_spec(specification)
specification.loader.exec_module(addon)

engines = ["CYCLES", "BLENDER_EEVEE"] if os.environ.get("DISPLAY") else ["CYCLES"]
size = 64
suns = [(0.3, 0.8, 0.5), (0, 0, 1), (0.6, -0.7, 0.3), (-0.5, 0.5, -0.7)]
tilt, half_angle = math.radians(55), math.radians(40)


def place_camera(engine):
    """A camera above a plane that fills the picture, one ray through the middle of each pixel."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=1e4)
    plane = bpy.context.object
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle, camera.location, camera.rotation_euler = 2 * half_angle, (0, 0, 3), (tilt, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = engine
    scene.cycles.samples, scene.cycles.use_denoising, scene.eevee.taa_render_samples = 1, False, 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width, scene.render.filter_size = "BOX", 0.01, 0.01
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    return scene, plane


def to_eye(column, row):
    x, y = (((k + 0.5) * 2 / size - 1) * math.tan(half_angle) for k in (column, row))
    ray = np.array([x, math.cos(tilt) * y + math.sin(tilt), math.sin(tilt) * y - math.cos(tilt)])
    return -ray / np.linalg.norm(ray)


def write_stack(path, layers):
    path.write_text("".join(f'[[layers]]\nphase_function = "henyey_greenstein:g={g}"\nalbedo = {albedo}\noptical_depth = {depth}\n'
                            for g, albedo, depth in layers))
    return path


def picture_of(scene, subject, material, folder, sky=0.0):
    subject.data.materials.clear()
    subject.data.materials.append(material)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (sky, sky, sky, 1)
    scene.render.filepath = str(folder / "picture.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(picture.pixels[:]).reshape(size, size, 4)[:, :, :3]
    bpy.data.images.remove(picture)
    return pixels


def pixels_of(scene, plane, material, folder, sky=0.0):
    pixels = picture_of(scene, plane, material, folder, sky)
    return [(eye, pixels[row, column]) for row in range(2, size, 6) for column in range(2, size, 6)
            if (eye := to_eye(column, row))[2] > 0.05]


def write_query(path, sun, met, more=()):
    """A query of pixels, with columns and values of `more` added."""
    with open(path, "w", newline="") as file:
        azimuths = [math.degrees(math.atan2(eye[1], eye[0]) - math.atan2(sun[1], sun[0])) - 180 for eye, _ in met]
        csv.writer(file).writerows([["mu_in", "mu_out", "azimuth_deg", *(name for name, _ in more)],
                                    *([abs(sun[2]), eye[2], azimuth % 360, *(value for _, value in more)]
                                      for (eye, _), azimuth in zip(met, azimuths))])


def errors_of(answer, sun, met):
    """Differences of pixels from R or T of an answer, relative to it."""
    side = "reflection" if sun[2] > 0 else "transmission"
    return [error for (_, pixel), found in zip(met, csv.DictReader(answer.stdout.splitlines()))
            for error in abs(pixel / (abs(sun[2]) * float(found[side])) - 1)]


def check(engine, name, layers, seen_from_below, folder, median, largest):
    """Compares pixels of layers, listed from the top, with the solver's R and T, and what shows through with the beam."""
    above, below = write_stack(folder / "above.toml", layers), write_stack(folder / "below.toml", layers[::-1])
    atlas = str(folder / f"{name}.exr")
    subprocess.run([stratus, "export", above, "--format", "exr-atlas", "-o", atlas, "--quiet"], check=True)
    scene, plane = place_camera(engine)
    plane.rotation_euler = (math.pi * seen_from_below, 0, 0)
    errors = []
    for given in suns:
        sun = np.array(given) / np.linalg.norm(given)
        met = pixels_of(scene, plane, addon.atlas_material(atlas, sun), folder)
        write_query(folder / "query.csv", sun, met)
        lit_side = below if seen_from_below == (sun[2] > 0) else above
        answer = subprocess.run([stratus, "solve", "--layers", lit_side, "--query", folder / "query.csv"], check=True,
                                capture_output=True, text=True)
        errors.extend(errors_of(answer, sun, met))
    dark = addon.atlas_material(atlas, suns[0], (0, 0, 0))
    depth = sum(layer[2] for layer in layers)
    beam = max(max(abs(pixel - math.exp(-depth / eye[2]))) for eye, pixel in pixels_of(scene, plane, dark, folder, sky=1.0))
    print(f"{engine}, {name}: {len(errors)} values of pixels: median {np.median(errors):.2g}, largest {max(errors):.2g}; beam within {beam:.2g}")
    if len(errors) < 500 or np.median(errors) > median or max(errors) > largest or beam > 1e-4:
        sys.exit(f"{engine}, {name}: the material differs from the solver")
    return atlas


def check_depth_image(engine, table, folder):
    """Compares pixels of a layer whose depth is that of a grey image with the table, and what shows through with the beam."""
    scene, plane = place_camera(engine)
    prepared = addon.prepared_atlases(table, 1.8, "0.9", stratus, folder)
    errors, beams = [], []
    for grey in (10, 100, 255):
        image = bpy.data.images.new("grey", 1, 1)
        image.pixels = [grey / 255] * 3 + [1]
        image.filepath_raw, image.file_format = str(folder / f"grey_{grey}.png"), "PNG"
        image.save()
        depth = 1.8 * grey / 255
        for given in suns:
            sun = np.array(given) / np.linalg.norm(given)
            material = addon.layer_material(*prepared, "rings", sun, (math.pi,) * 3, addon.loaded(image.filepath_raw))
            met = pixels_of(scene, plane, material, folder)
            write_query(folder / "query.csv", sun, met, [("albedo", 0.9), ("optical_depth", depth)])
            answer = subprocess.run([stratus, "eval", table, "--query", folder / "query.csv"], check=True, capture_output=True, text=True)
            errors.extend(errors_of(answer, sun, met))
        material.node_tree.nodes["Group"].inputs["Irradiance"].default_value = (0, 0, 0, 1)
        beams.extend(max(abs(pixel - math.exp(-depth / eye[2]))) for eye, pixel in pixels_of(scene, plane, material, folder, sky=1.0))
    print(f"{engine}, depth image: {len(errors)} values of pixels: median {np.median(errors):.2g}, 99 % {np.quantile(errors, 0.99):.2g}, "
          f"largest {max(errors):.2g}; beam within {max(beams):.2g}")
    if np.median(errors) > 1e-3 or max(errors) > 2e-2 or max(beams) > 1e-4:
        sys.exit("a depth image: the material differs from the table")


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    two = [(0.6, 0.9, 0.3), (0.1, 0.6, 0.5)]
    for engine in engines:
        check(engine, "layer", [(0.5, 0.9, 1.0)], False, folder, 3e-4, 5e-3)
        check(engine, "narrow", [(0.85, 1.0, 0.1)], False, folder, 2e-3, 3e-2)
        check(engine, "stack", two, False, folder, 3e-4, 5e-3)
        atlas = check(engine, "stack_from_below", two, True, folder, 3e-4, 5e-3)

    # A smooth ball over ground lit from the right: its left half is dark up to the limb, where normals turn away from the eye.
    ground = write_stack(folder / "ground.toml", two)
    ground.write_text(ground.read_text() + "[below]\nlambert_albedo = 0.3\n")
    subprocess.run([stratus, "export", ground, "--format", "exr-atlas", "-o", folder / "ground.exr", "--quiet"], check=True)
    scene, plane = place_camera("CYCLES")
    bpy.data.objects.remove(plane)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, location=(0, 4 * math.sin(tilt), 3 - 4 * math.cos(tilt)))
    bpy.ops.object.shade_smooth()
    scene.camera.data.angle, scene.cycles.samples = math.radians(32), 16
    material = addon.atlas_material(str(folder / "ground.exr"), (1, 0, 0))
    pixels = picture_of(scene, bpy.context.object, material, folder)
    if pixels[:, :size // 2 - 4].max() > 0 or pixels[size // 2, size * 3 // 4].min() < 0.1:
        sys.exit("a ball must be lit on the side of the sun alone")
    inside = np.hypot(*np.mgrid[:size, :size] - (size - 1) / 2) < 24
    lit = inside[:, :, None] & (pixels > 0.1)
    for scene.render.engine in engines[1:]:  # pixels side by side read different tiles
        apart = abs(picture_of(scene, bpy.context.object, material, folder)[lit] / pixels[lit] - 1)
        print(f"a ball in Eevee: median {np.median(apart):.2g} from Cycles, largest {max(apart):.2g}")
        if max(apart) > 1e-2:
            sys.exit("a ball must look as in Cycles")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon.atlas_material(atlas)
    saved = str(folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=saved)
    bpy.ops.wm.open_mainfile(filepath=saved)
    if "stack_from_below" not in bpy.data.materials:
        sys.exit("a material that no object has is not saved")

    # The menu entry, on a stack and on a table, with the program from the PATH.
    os.environ["PATH"] = str(pathlib.Path(stratus).parent) + os.pathsep + os.environ["PATH"]
    (folder / "rings.toml").write_text('phase_function = "isotropic"\ntolerance = 0.02\n'
                                       'optical_depth = { min = 0.1, max = 2 }\nalbedo = { min = 0.5, max = 1 }\n')
    subprocess.run([stratus, "bake", folder / "rings.toml", "-o", folder / "rings.stratus", "--quiet"], check=True)
    for engine in engines:
        check_depth_image(engine, str(folder / "rings.stratus"), folder)
    addon.register()
    for name, chosen in (("ground.toml", {}), ("rings.stratus", {"optical_depth": "0.5,1,2"}),
                         ("rings.stratus", {"depth_image": str(folder / "grey_100.png")})):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.mesh.primitive_plane_add()
        done = bpy.ops.import_scene.stratus_material(filepath=str(folder / name), albedo="0.9", sun=(0, 2, 0), **chosen)
        material = bpy.context.object.data.materials[-1]
        if done != {"FINISHED"} or material.name != name.split(".")[0]:
            sys.exit(f"{name} was not imported")
        if not all(image.packed_file for image in bpy.data.images if image.users):
            sys.exit("the pictures of materials must be kept in the scene")
    for refused in ({"albedo": "2"}, {"sun": (0, 0, 0)}, {"optical_depth": "inf", "depth_image": str(folder / "grey_100.png")}):
        try:
            bpy.ops.import_scene.stratus_material(filepath=str(folder / "rings.stratus"), **refused)
            sys.exit(f"{refused} must be refused")
        except RuntimeError as told:
            if "must be" not in str(told):
                raise
    addon.unregister()
