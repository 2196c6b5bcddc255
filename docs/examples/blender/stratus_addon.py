"""A Blender add-on: materials of layers that scatter, by shader nodes alone, for Cycles and Eevee.

Edit > Preferences > Add-ons > Install takes this file, and has the place of the `stratus` program. File > Import > Stratus material
takes a table (.stratus) with an optical depth and an albedo, a stack (.toml), or an atlas of `stratus export ... --format exr-atlas`
(.exr, its .json beside it), and gives the material to the active object. With a depth image, grey and laid out by the object's UV
map, the depth of a table is that of white. Without an interface:

    blender scene.blend --python stratus_addon.py -- rings.exr

adds the material `rings`, which is saved with the scene before any object has it. It shows the light of one sun, whose direction and
irradiance are values of the node group: pi makes a white Lambert surface 1. The sun casts no shadow on it. What is behind shines
through with exp(-tau / mu_out). A stack's first layer is on the side of the face's normal.
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

bl_info = {
    "name": "Stratus materials",
    "description": "Clouds, rings, haze and dust by tables of multiple scattering",
    "blender": (3, 4, 0),
    "version": (0, 1, 0),
    "location": "File > Import > Stratus material",
    "category": "Material",
}


class Nodes:
    """Math nodes of a node tree, written as functions."""

    def __init__(self, tree):
        self.tree = tree

    def add(self, kind, *inputs, **settings):
        node = self.tree.nodes.new(kind)
        for name, setting in settings.items():
            setattr(node, name, setting)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def math(self, operation, *inputs, clamp=False):
        return self.add("ShaderNodeMath", *inputs, operation=operation, use_clamp=clamp).outputs[0]

    def vector(self, operation, *inputs):
        node = self.add("ShaderNodeVectorMath", *inputs, operation=operation)
        return node.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def scaled(self, vector, factor):
        node = self.add("ShaderNodeVectorMath", vector, operation="SCALE")
        self.tree.links.new(factor, node.inputs["Scale"])
        return node.outputs["Vector"]


def add_socket(group, name, kind, side="INPUT"):
    if hasattr(group, "interface"):  # Blender 4
        group.interface.new_socket(name, in_out=side, socket_type=kind)
    else:
        (group.inputs if side == "INPUT" else group.outputs).new(kind, name)


def loaded(picture):
    image = bpy.data.images.load(picture)
    image.colorspace_settings.name = "Non-Color"
    image.use_half_precision = False  # in Eevee
    image.pack()  # kept in the .blend
    return image


def atlas_of(picture):
    """An atlas: its image and its layout."""
    return loaded(picture), json.loads(pathlib.Path(picture).with_suffix(".json").read_text())


PREPARED = 10  # depths, evenly in their cubic roots


def prepared_atlases(source, deepest, albedo, program, folder):
    """Atlases of a table at PREPARED depths, one below the other, as logarithms: of light through layers over the depth."""
    pictures = []
    for number in range(1, PREPARED + 1):
        depth = deepest * (number / PREPARED) ** 3
        atlas, layout = atlas_of(exported_atlas(source, repr(depth), albedo, program, folder))
        width, height = atlas.size
        pixels = np.empty(4 * width * height, np.float32)
        atlas.pixels.foreach_get(pixels)
        bpy.data.images.remove(atlas)
        pictures.append(np.log(np.maximum(pixels, 1e-12) / (depth if "transmission" in layout["rows"] else 1)))
        pictures[-1][3::4] = 1
    image = bpy.data.images.new(pathlib.Path(source).stem, width, PREPARED * height, float_buffer=True, is_data=True)
    image.pixels.foreach_set(np.concatenate(pictures[::-1]))  # rows run upward
    image.use_half_precision = False
    image.pack()
    return image, layout | {"deepest": deepest}


def through_depths(n, blended, root):
    """The cubic through the four prepared atlases around a cubic root of the depth, [0, 1]."""
    place = n.math("MULTIPLY_ADD", root, PREPARED, -1)
    first = n.math("MINIMUM", n.math("MAXIMUM", n.math("SUBTRACT", n.math("FLOOR", place), 1), 0), PREPARED - 4)
    t = n.math("SUBTRACT", place, first)
    total = (0, 0, 0)
    for number in range(4):
        weight = 1.0
        for other in {0, 1, 2, 3} - {number}:
            weight = n.math("MULTIPLY", n.math("DIVIDE", n.math("SUBTRACT", t, other), number - other), weight)
        total = n.vector("ADD", n.scaled(blended(n.math("ADD", first, number)), weight), total)
    logarithms = n.add("ShaderNodeSeparateXYZ", total).outputs
    return n.add("ShaderNodeCombineColor", *(n.math("EXPONENT", channel) for channel in logarithms)).outputs[0]


def atlas_group(image, layout, name):
    """The node group of an atlas: Sun (towards it, world space, of length 1) and Irradiance in, Shader out; of prepared_atlases
    Depth, the share of the deepest, in as well."""
    columns, width, height = layout["columns"], layout["tile_width"], layout["tile_height"]
    rows = len(layout["rows"])
    transmits = "transmission" in layout["rows"]
    deepest = layout.get("deepest")
    atlases = PREPARED if deepest else 1

    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    add_socket(tree, "Sun", "NodeSocketVector")
    add_socket(tree, "Irradiance", "NodeSocketColor")
    if deepest:
        add_socket(tree, "Depth", "NodeSocketFloat")
    add_socket(tree, "Shader", "NodeSocketShader", "OUTPUT")
    n = Nodes(tree)
    given = n.add("NodeGroupInput").outputs
    seen = n.add("ShaderNodeNewGeometry").outputs

    def evened(mu):  # asin(sqrt(mu)) 2 / pi
        return n.math("MULTIPLY", n.math("ARCSINE", n.math("SQRT", mu)), 2 / math.pi)

    # Up is the side that is seen, on which smoothed normals may turn away at the limb. Both directions point away from the layer.
    up = n.scaled(seen["Normal"], n.math("SIGN", n.vector("DOT_PRODUCT", seen["True Normal"], seen["Incoming"])))
    facing = n.vector("DOT_PRODUCT", up, seen["Incoming"])
    cos_in = n.vector("DOT_PRODUCT", given["Sun"], up)
    mu_in = n.math("MINIMUM", n.math("ABSOLUTE", cos_in), 1)
    mu_out = n.math("MINIMUM", n.math("ABSOLUTE", facing), 1)
    along_in = n.vector("SUBTRACT", given["Sun"], n.scaled(up, cos_in))
    along_out = n.vector("SUBTRACT", seen["Incoming"], n.scaled(up, facing))
    lengths = n.math("MULTIPLY", n.vector("LENGTH", along_in), n.vector("LENGTH", along_out))
    cosine = n.math("DIVIDE", n.vector("DOT_PRODUCT", along_in, along_out), lengths)  # 0 where a length is 0
    cosine = n.math("MAXIMUM", n.math("MINIMUM", cosine, 1), -1)
    azimuth = n.math("SUBTRACT", math.pi, n.math("ARCCOSINE", cosine))  # 0 is forward

    lit = n.math("GREATER_THAN", cos_in, 0)
    row = n.math("SUBTRACT", 1, lit) if transmits else 0.0
    tile_in, tile_out = mu_in, mu_out
    if rows == 3:  # a stack: row 2 is seen and lit from below; light from below is transmitted as from above, cosines exchanged
        below = seen["Backfacing"]
        row = n.math("MULTIPLY_ADD", n.math("MULTIPLY", lit, below), 2, row)
        exchanged = n.math("MULTIPLY", n.math("SUBTRACT", 1, lit), n.math("SUBTRACT", 1, below))
        difference = n.math("MULTIPLY", exchanged, n.math("SUBTRACT", mu_out, mu_in))
        tile_in, tile_out = n.math("ADD", mu_in, difference), n.math("SUBTRACT", mu_out, difference)

    def between(place, samples):
        """The first of the two samples, even in [0, 1], around a place, and the share of the second."""
        scaled = n.math("MULTIPLY", place, samples - 1)
        first = n.math("MINIMUM", n.math("FLOOR", scaled), samples - 2)
        return first, n.math("SUBTRACT", scaled, first)

    column, share_in = between(evened(tile_in), columns)
    line, share_out = between(evened(tile_out), height)
    texel, share_azimuth = between(n.math("DIVIDE", azimuth, math.pi), width)
    x, y = n.math("MULTIPLY_ADD", column, width, texel), n.math("MULTIPLY_ADD", row, height, line)

    def mixed(share, pair):
        return n.add("ShaderNodeMixRGB", share, *pair).outputs[0]

    # Texels are read one by one and blended here: Eevee's own filter takes coarser copies of the picture, in which tiles run into
    # each other, where pixels side by side read different tiles.
    across, down = columns * width, atlases * rows * height
    u = [[n.math("MULTIPLY_ADD", x, 1 / across, (tile * width + step + 0.5) / across) for step in (0, 1)] for tile in (0, 1)]

    def blended(atlas):
        """Pi f (mu_in + mu_out) of the eight texels around the directions."""
        place = n.math("MULTIPLY_ADD", atlas, rows * height, y)
        v = [n.math("MULTIPLY_ADD", place, -1 / down, 1 - (step + 0.5) / down) for step in (0, 1)]  # 0 is the lower edge

        def read(u, v):
            place = n.add("ShaderNodeCombineXYZ", u, v).outputs[0]
            return n.add("ShaderNodeTexImage", place, image=image, interpolation="Closest", extension="EXTEND").outputs["Color"]

        return mixed(share_in, [mixed(share_out, [mixed(share_azimuth, [read(place, level) for place in tile]) for level in v]) for tile in u])

    strength = n.math("DIVIDE", mu_in, n.math("MULTIPLY", n.math("ADD", mu_in, mu_out), math.pi))
    if deepest:
        depth = n.math("MULTIPLY", n.math("MINIMUM", n.math("MAXIMUM", given["Depth"], 0), 1), deepest)
        blend = through_depths(n, blended, n.math("POWER", n.math("DIVIDE", depth, deepest), 1 / 3))
        if transmits:
            strength = n.math("MULTIPLY", strength, depth)
    else:
        blend = blended(0.0)
    colour = n.add("ShaderNodeMixRGB", 1.0, blend, given["Irradiance"], blend_type="MULTIPLY").outputs[0]
    if not transmits:
        strength = n.math("MULTIPLY", strength, lit)
    light = n.add("ShaderNodeEmission", colour, strength).outputs[0]
    if transmits:
        if deepest:
            beam = [n.math("EXPONENT", n.math("DIVIDE", n.math("MULTIPLY", depth, -1), mu_out))] * 3
        else:
            depths = [math.inf if tau is None else tau for tau in layout["optical_depth"]]
            beam = [n.math("POWER", math.exp(-tau), n.math("DIVIDE", 1, mu_out)) for tau in depths] * (3 // len(depths))
        behind = n.add("ShaderNodeBsdfTransparent", n.add("ShaderNodeCombineColor", *beam).outputs[0]).outputs[0]
        light = n.add("ShaderNodeAddShader", light, behind).outputs[0]
    n.add("NodeGroupOutput", light)
    return tree


def atlas_material(picture, sun=(0, 0, 1), irradiance=(math.pi, math.pi, math.pi)):
    """A material of the atlas alone."""
    return layer_material(*atlas_of(picture), pathlib.Path(picture).stem, sun, irradiance)


def layer_material(image, layout, name, sun, irradiance, depth_image=None):
    """A material of an atlas, or of prepared atlases and the image that the depth follows."""
    material = bpy.data.materials.new(name)
    material.use_fake_user = True  # or it is not saved until an object has it
    material.use_nodes = True
    material.node_tree.nodes.clear()
    material.blend_method = "BLEND"  # Eevee: what is behind shows,
    material.show_transparent_back = False  # but for farther faces of the same object, which it does not sort
    n = Nodes(material.node_tree)
    group = n.add("ShaderNodeGroup", node_tree=atlas_group(image, layout, name))
    group.inputs["Sun"].default_value = sun
    group.inputs["Irradiance"].default_value = (*irradiance, 1)
    if depth_image:
        grey = n.add("ShaderNodeTexImage", image=depth_image).outputs["Color"]
        material.node_tree.links.new(grey, group.inputs["Depth"])
    n.add("ShaderNodeOutputMaterial", group.outputs[0])
    return material


def exported_atlas(source, optical_depth, albedo, program, folder):
    """Path of the atlas that `stratus export` writes of a table or a stack into a folder; ValueError with what it refuses."""
    atlas = pathlib.Path(folder) / (pathlib.Path(source).stem + ".exr")
    layer = [] if source.endswith(".toml") else ["--optical-depth", optical_depth, "--albedo", albedo]
    done = subprocess.run([program, "export", source, *layer, "--format", "exr-atlas", "-o", str(atlas)],
                          capture_output=True, text=True)
    if done.returncode:
        raise ValueError(done.stderr.strip())
    return str(atlas)


def depth_image_material(source, optical_depth, albedo, program, folder, sun, irradiance, depth_image):
    """A material of a table whose depth is that of an image's white times the image."""
    if not source.endswith(".stratus"):
        raise ValueError(f"A depth image must be given with a table, .stratus, got {source}")
    deepest = float(optical_depth)
    if not 0 < deepest < math.inf:
        raise ValueError(f"Optical depth must be one above 0 and finite with a depth image, got {optical_depth}")
    image = loaded(depth_image)
    return layer_material(*prepared_atlases(source, deepest, albedo, program, folder), pathlib.Path(source).stem, sun, irradiance, image)


class StratusPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__

    program: bpy.props.StringProperty(name="stratus", description="The program, where it is not on the PATH", subtype="FILE_PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


class ImportStratusMaterial(bpy.types.Operator, ImportHelper):
    """Make a material of a table, a stack or an atlas of Stratus"""

    bl_idname = "import_scene.stratus_material"
    bl_label = "Import Stratus material"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: bpy.props.StringProperty(default="*.stratus;*.toml;*.exr", options={"HIDDEN"})
    optical_depth: bpy.props.StringProperty(name="Optical depth", default="1", description="Of a table: one, or three with commas")
    depth_image: bpy.props.StringProperty(name="Depth image", subtype="FILE_PATH", description="Grey: the optical depth is that of white")
    albedo: bpy.props.StringProperty(name="Albedo", default="0.95", description="Of a table: one, or three with commas")
    sun: bpy.props.FloatVectorProperty(name="Sun", default=(0, 0, 1), subtype="XYZ", description="Direction towards it")
    irradiance: bpy.props.FloatVectorProperty(name="Irradiance", default=(math.pi,) * 3, min=0, description="Across the beam")

    def execute(self, context):
        added = context.preferences.addons.get(__name__)
        program = (added and bpy.path.abspath(added.preferences.program)) or shutil.which("stratus") or "stratus"
        try:
            with tempfile.TemporaryDirectory() as folder:
                length = math.hypot(*self.sun)
                if not length > 0:
                    raise ValueError("Sun must be a direction, got (0, 0, 0)")
                light = [x / length for x in self.sun], self.irradiance
                source = self.filepath
                if self.depth_image:
                    material = depth_image_material(source, self.optical_depth, self.albedo, program, folder, *light,
                                                    bpy.path.abspath(self.depth_image))
                elif source.endswith(".exr"):
                    material = atlas_material(source, *light)
                else:
                    material = atlas_material(exported_atlas(source, self.optical_depth, self.albedo, program, folder), *light)
        except (OSError, RuntimeError, ValueError, KeyError) as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        if context.object is not None and hasattr(context.object.data, "materials"):
            context.object.data.materials.append(material)
        return {"FINISHED"}


def menu_entry(menu, _context):
    menu.layout.operator(ImportStratusMaterial.bl_idname, text="Stratus material (.stratus, .toml, .exr)")


def register():
    bpy.utils.register_class(StratusPreferences)
    bpy.utils.register_class(ImportStratusMaterial)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    bpy.utils.unregister_class(ImportStratusMaterial)
    bpy.utils.unregister_class(StratusPreferences)


if __name__ == "__main__":
    try:
        for picture in sys.argv[sys.argv.index("--") + 1:]:
            atlas_material(picture)
    except (OSError, RuntimeError, ValueError, KeyError) as problem:
        sys.exit(f"stratus_addon.py: must be given atlases of `stratus export` after --, each with its .json beside it: {problem}")
