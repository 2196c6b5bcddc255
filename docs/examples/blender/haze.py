"""A planet of sandy ground under haze in the light of a sun: R cos(sun) in every pixel. From the root of the repository:

    build/cli/stratus export tables/stacks/haze_over_ground.toml --format exr-atlas -o docs/examples/blender/haze.exr
    blender --background --python docs/examples/blender/haze.py

renders haze.png beside it, and saves haze.blend.
"""
import pathlib
import sys

import bpy
from mathutils import Vector

folder = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(folder))
from stratus_addon import atlas_material

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)
bpy.ops.object.shade_smooth()
bpy.context.object.data.materials.append(atlas_material(str(folder / "haze.exr"), sun=Vector((2, -2, 1)).normalized()))
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = (0, -4, 1)
camera.rotation_euler = (-camera.location).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.engine = "CYCLES"
scene.cycles.samples, scene.cycles.use_denoising = 16, False
scene.render.resolution_x = scene.render.resolution_y = 400
scene.view_settings.view_transform = "Standard"
scene.render.filepath = str(folder / "haze.png")
bpy.ops.render.render(write_still=True)
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "haze.blend"))
