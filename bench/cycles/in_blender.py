"""Renders a scene by Cycles: `blender -b -t 1 --python in_blender.py -- JOB.json`.

A job names the scene file, width and height, the greatest number of segments of a path, and runs:
samples a pixel, seed, and the file for the picture (.pfm). The processor seconds of every run are
added to it, in a file beside it (.done.json).
"""

import array
import json
import math
import pathlib
import sys
import time

import bpy
from mathutils import Matrix

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import description as d  # noqa: E402

DIVISIONS_OF_LAMPS = 4  # 5120 triangles
STOPS = 32  # of a table of reflectances over the cosine


# --- Materials ------------------------------------------------------------------------------------


def closure(material, tree):
    """The output of the nodes that scatter as a material does."""
    def node(kind, **values):
        made = tree.nodes.new(kind)
        for name, value in values.items():
            made.inputs[name].default_value = value
        return made

    kind = material["type"]
    if kind == "mix":
        mixed = node("ShaderNodeMixShader", Fac=material["amount"][0])
        for k, part in enumerate(material["parts"]):
            tree.links.new(closure(part, tree), mixed.inputs[1 + k])
        return mixed.outputs[0]
    if kind == "diffuse":
        return node("ShaderNodeBsdfDiffuse", Color=[*material["reflectance"], 1]).outputs[0]
    if kind == "dielectric":
        glass = node("ShaderNodeBsdfGlass", Color=[1, 1, 1, 1], Roughness=0, IOR=material["eta"][0])
        glass.distribution = "SHARP"
        return glass.outputs[0]
    alpha = d.alpha_of(material) if kind == "conductor" else 0
    glossy = node("ShaderNodeBsdfGlossy", Roughness=math.sqrt(alpha))
    glossy.distribution = "GGX" if alpha else "SHARP"
    colour = material.get("reflectance", [0])
    if kind == "mirror" or min(colour) >= 1:
        glossy.inputs["Color"].default_value = [*colour, 1]
        return glossy.outputs[0]
    # Fresnel's formula at the normal's cosine, as a table.
    facing, ramp = node("ShaderNodeLayerWeight", Blend=0.5), node("ShaderNodeValToRGB")
    elements = ramp.color_ramp.elements
    while len(elements) < STOPS:
        elements.new(0.5)
    etas, ks = d.metal(material)
    for k in range(STOPS):
        elements[k].position = k / (STOPS - 1)
    for k in range(STOPS):
        elements[k].color = [*(d.fresnel(1 - k / (STOPS - 1), eta, k_) for eta, k_ in zip(etas, ks)), 1]
    tree.links.new(facing.outputs["Facing"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], glossy.inputs["Color"])
    return glossy.outputs[0]


def new_material(scatters=None, emits=None):
    made = bpy.data.materials.new("material")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if emits:
        emission = tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = [x / max(emits) for x in emits] + [1]
        emission.inputs["Strength"].default_value = max(emits)
        tree.links.new(emission.outputs[0], output.inputs[0])
    else:
        tree.links.new(closure(scatters, tree), output.inputs[0])
    return made


# --- Shapes, lamps, camera ------------------------------------------------------------------------


def add(name, data, matrix=None):
    made = bpy.data.objects.new(name, data)
    if matrix:
        made.matrix_world = Matrix(matrix)
    made.visible_camera = True
    bpy.context.scene.collection.objects.link(made)


def add_mesh(points, triangles, material, smooth=False):
    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(points))
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    mesh.vertices.foreach_set("co", array.array("f", (x for p in points for x in p)))
    mesh.loops.foreach_set("vertex_index", array.array("i", (i for t in triangles for i in t)))
    mesh.polygons.foreach_set("loop_start", array.array("i", range(0, 3 * len(triangles), 3)))
    mesh.polygons.foreach_set("loop_total", array.array("i", [3]) * len(triangles))
    mesh.polygons.foreach_set("use_smooth", array.array("b", [smooth]) * len(triangles))
    mesh.materials.append(material)
    mesh.update(calc_edges=True)
    add("mesh", mesh)


def add_sphere(shape, material, divisions):
    points, triangles = d.sphere_mesh(divisions)
    radius = shape.radius
    if shape.emission:  # the area of the sphere, not of the polyhedron
        area = sum(math.sqrt(d.dot(n, n)) for n in (d.cross(d.minus(points[b], points[a]), d.minus(points[c], points[a])) for a, b, c in triangles)) / 2
        radius *= math.sqrt(4 * math.pi / area)
    add_mesh([[radius * x + c for x, c in zip(p, shape.points[0])] for p in points], triangles, material, smooth=True)


def lamp(kind, radiance, factor):
    made = bpy.data.lights.new("lamp", kind)
    made.color = [x / max(radiance) for x in radiance]
    made.energy = max(radiance) * factor
    return made


def add_area_lamp(shape):
    """An area lamp, which shines along its -z, and a black surface behind it."""
    centre, x, y, normal = d.rectangle(shape)
    sizes = [math.sqrt(d.dot(edge, edge)) for edge in (x, y)]
    made = lamp("AREA", shape.emission, 4 * sizes[0] * sizes[1])
    made.shape, made.size, made.size_y = "RECTANGLE", *sizes
    back = [-n for n in normal]
    add("lamp", made, d.from_axes(d.unit(x), d.cross(back, d.unit(x)), back, centre))
    behind = [[p + 1e-4 * b for p, b in zip(point, back)] for point in shape.points]
    add_mesh(behind, shape.triangles, new_material({"type": "diffuse", "reflectance": [0, 0, 0]}))


def add_camera(scene, description):
    """Whether the picture comes out mirrored: Blender's cameras are right-handed."""
    right, up, forward, origin = ([row[j] for row in description.camera[:3]] for j in range(4))
    back = [-x for x in forward]
    mirrored = d.dot(d.cross(up, back), right) < 0
    if mirrored:
        right = [-x for x in right]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(description.fov)
    data.clip_start, data.clip_end = 1e-3, 1e4
    add("camera", data, d.from_axes(right, up, back, origin))
    scene.camera = bpy.data.objects["camera"]
    return mirrored


def build(scene, description):
    made = {}
    for shape in description.shapes:
        key = json.dumps(shape.material)
        if not shape.emission:
            material = made[key] = made.get(key) or new_material(shape.material)
            if shape.radius:
                add_sphere(shape, material, d.DIVISIONS)
            else:
                add_mesh(shape.points, shape.triangles, material)
        elif shape.radius:
            # Radiance shrinks by the square of the index on its way out of glass; Cycles leaves
            # that out.
            scale = d.around(shape, description) ** -2
            add_sphere(shape, new_material(emits=[scale * x for x in shape.emission]), DIVISIONS_OF_LAMPS)
        else:
            add_area_lamp(shape)
    for direction, irradiance in description.distant:
        sun = lamp("SUN", irradiance, 1)
        sun.angle = 0
        back = [-x for x in direction]
        x = d.unit(d.cross([0.3, 0.5, 0.7], back))
        add("sun", sun, d.from_axes(x, d.cross(back, x), back, [0, 0, 0]))
    return add_camera(scene, description)


# --- Rendering ------------------------------------------------------------------------------------


def settings(scene, job):
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "NONE"
    scene.render.use_persistent_data = True
    scene.render.dither_intensity = 0
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("black")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = [0, 0, 0, 1]
    scene.world = world
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
    # Bounces are the vertices between camera and light beyond the first.
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, name, job["segments"] - 2)


def picture(file, size, mirrored):
    """The picture of an .exr as a .pfm holds it, rows from the bottom."""
    image = bpy.data.images.load(str(file))
    width, height = size
    rgba = array.array("f", [0.0]) * (4 * width * height)
    image.pixels.foreach_get(rgba)
    bpy.data.images.remove(image)
    values = array.array("f")
    for y in range(height):
        for x in reversed(range(width)) if mirrored else range(width):
            k = 4 * (y * width + x)
            values.extend(rgba[k:k + 3])
    return b"PF\n%d %d\n-1.0\n" % (width, height) + values.tobytes()


def main(job_file):
    job = json.loads(job_file.read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    settings(scene, job)
    mirrored = build(scene, d.read(pathlib.Path(job["scene"])))
    for run in job["runs"]:
        scene.cycles.samples, scene.cycles.seed = run["samples"], run["seed"]
        exr = job_file.with_suffix(".exr").absolute()
        scene.render.filepath = str(exr)
        start = time.process_time()
        bpy.ops.render.render(write_still=True)
        run["seconds"] = time.process_time() - start
        if run.get("out"):
            pathlib.Path(run["out"]).write_bytes(picture(exr, job["size"], mirrored))
    job_file.with_suffix(".done.json").write_text(json.dumps(job))


main(pathlib.Path(sys.argv[sys.argv.index("--") + 1]))
