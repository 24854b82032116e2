#!/usr/bin/env python3
"""Draws glTF scenes with Cycles (Debian's blender) and with Parhelion, and compares: a row of docs/truth.md a scene.

    apt-get install blender python3-numpy
    python3 tools/oracles/compare_cycles.py build/release/parhelion OUT [NAME...]

NAME: a scene of tests/golden/oracles (all of SCENES by default). OUT gets NAME.cycles.exr, NAME.parhelion.exr and NAME.png, Cycles on the left.
The file runs twice: by Python, and inside Blender, which imports the glTF.

What Blender's importer makes of a file that is not what glTF says, and what is done about it here:
  diffuse      a Principled shader, whose diffuse part is Disney's, not Lambert's, with its own specular part:
               KHR_materials_specular is only kept for the way back. Materials without specular part become Diffuse shaders
               here, others stay (`--as-imported` leaves all)
  environment  none in glTF: the picture is hung up, turned so that its middle lies where Parhelion has it
  textures     eight-bit ones are filtered before they are made linear, glTF filters after: scenes with linear filtering differ
  display      linear radiance is written; no view transform, no exposure
  sampling     box filter of one pixel, no clamping, no light threshold, caustics on, equal number of bounces
"""
import json
import math
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# name -> (bounces, environment's turn in degrees)
SCENES = {"cornell": (5, 0), "many_emitters": (4, 0), "environment": (4, 73), "directional": (4, 0)}
ORACLES = ROOT / "tests/golden/oracles"


def diffuse_only(material):
    """The importer's Principled shader as the Diffuse one that the file means: base colour and emission are kept."""
    tree = material.node_tree
    principled = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    kept = [node.inputs["Specular"].default_value for node in tree.nodes if node.type == "GROUP" and "Specular" in node.inputs]
    if principled.inputs["Metallic"].default_value != 0 or kept != [0.0]:
        return
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    emission = tree.nodes.new("ShaderNodeEmission")
    add = tree.nodes.new("ShaderNodeAddShader")
    for new, old in ((diffuse.inputs["Color"], "Base Color"), (emission.inputs["Color"], "Emission"), (emission.inputs["Strength"], "Emission Strength")):
        source = principled.inputs[old]
        if source.is_linked:
            node = source.links[0].from_node  # a Mix node has a result of every type, of which one is in use
            tree.links.new(next(o for o in node.outputs if o.enabled and o.type == "RGBA"), new)
        else:
            new.default_value = source.default_value
    tree.links.new(diffuse.outputs[0], add.inputs[0])
    tree.links.new(emission.outputs[0], add.inputs[1])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(add.outputs[0], output.inputs["Surface"])


def hang_environment(scene, path, degrees):
    """Cycles looks at the map's middle along its +X, which is glTF's +X too; Parhelion along glTF's -Z, Blender's +Y."""
    import bpy

    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    tree = world.node_tree
    picture, mapping, where = (tree.nodes.new(kind) for kind in ("ShaderNodeTexEnvironment", "ShaderNodeMapping", "ShaderNodeTexCoord"))
    picture.image = bpy.data.images.load(str(path))
    picture.image.colorspace_settings.name = "Linear"
    mapping.inputs["Rotation"].default_value = (0, 0, -math.radians(90 + degrees))
    tree.links.new(where.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    tree.links.new(picture.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def inside_blender(task):
    import bpy
    import numpy

    numpy.bool = bool  # Debian 12's importer is older than its numpy, which has no such name any more
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=task["scene"])
    scene = bpy.context.scene
    if not task["as_imported"]:
        for material in bpy.data.materials:
            if material.use_nodes:
                diffuse_only(material)
    if task["environment"]:
        hang_environment(scene, task["environment"], task["turn"])
    scene.camera = next(o for o in scene.objects if o.type == "CAMERA")
    scene.camera.data.sensor_fit = "VERTICAL"
    scene.camera.data.angle = task["yfov"]
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", task["samples"], 1, False, False
    cycles.pixel_filter_type, cycles.light_sampling_threshold, cycles.blur_glossy = "BOX", 0.0, 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    # Cycles counts bounces after the first surface: direct light is 0.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = task["bounces"] - 1
    cycles.transparent_max_bounces = 64
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = *task["size"], 100
    render.use_persistent_data, render.threads_mode, render.threads = False, "FIXED", os.cpu_count()
    render.image_settings.file_format, render.image_settings.color_depth, render.image_settings.color_mode = "OPEN_EXR", "32", "RGB"
    render.filepath = task["out"]
    bpy.ops.render.render(write_still=True)


def side_by_side(left, right, out):
    """Both pictures as sRGB, white at the 98th percentile of the left one. Inside Blender, which reads EXR and has numpy."""
    import bpy
    import numpy

    sys.path.insert(0, str(Path(__file__).parent))
    from oracle_files import png_bytes

    pictures = []
    for path in (left, right):
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = "Linear"
        width, height = image.size
        pictures.append(numpy.array(image.pixels[:]).reshape(height, width, 4)[::-1, :, :3])
    both = numpy.concatenate(pictures, 1) / numpy.percentile(pictures[0], 98)
    both = numpy.clip(both, 0, 1)
    encoded = numpy.where(both <= 0.0031308, 12.92 * both, 1.055 * both ** (1 / 2.4) - 0.055)
    Path(out).write_bytes(png_bytes(numpy.rint(255 * encoded)))


def run_blender(task, log):
    # Debian's Blender finds its Python by PATH: it must meet Debian's first.
    system = os.environ | {"PATH": "/usr/bin:/bin:" + os.environ["PATH"]}
    command = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--", json.dumps(task)]
    subprocess.run(command, stdout=log, stderr=log, env=system, check=True)


def read_glb_json(path):
    data = Path(path).read_bytes()
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


def compare(program, out, name, samples, size, as_imported):
    bounces, turn = SCENES.get(name, (8, 0))
    scene = ORACLES / f"{name}.glb"
    environment = ORACLES / "environment_map.exr" if name == "environment" else None
    theirs, ours = out / f"{name}.cycles.exr", out / f"{name}.parhelion.exr"
    task = {"scene": str(scene), "environment": environment and str(environment), "turn": turn, "bounces": bounces, "samples": samples, "size": size,
            "yfov": read_glb_json(scene)["cameras"][0]["perspective"]["yfov"], "out": str(theirs), "as_imported": as_imported}
    with open(out / f"{name}.log", "w") as log:
        run_blender(task, log)
        render = [program, "render", scene, "--size", f"{size[0]}x{size[1]}", "--spp", str(samples), "--max-bounces", str(bounces), "--exr-type", "float", "--out", ours]
        render += ["--env", environment, "--env-rotation", str(turn)] if environment else []
        render += ["--set", "reference.roulette_start=65535"]
        subprocess.run(render, stdout=log, stderr=log, check=True)
        run_blender({"left": str(theirs), "right": str(ours), "png": str(out / f"{name}.png")}, log)
    told = json.loads(subprocess.run([program, "compare", ours, theirs, "--json"], check=True, capture_output=True, text=True).stdout)
    print(f"| {name} | {told['mean_ratio']:.4f} | {told['relmse']:.2e} | {told['flip']:.4f} |", flush=True)


def main():
    if "--" in sys.argv and "blender" in Path(sys.argv[0]).name:
        task = json.loads(sys.argv[sys.argv.index("--") + 1])
        return side_by_side(task["left"], task["right"], task["png"]) if "png" in task else inside_blender(task)
    import argparse

    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("program")
    arguments.add_argument("out", type=Path)
    arguments.add_argument("scenes", nargs="*")
    arguments.add_argument("--samples", type=int, default=4096)
    arguments.add_argument("--size", default="96x72")
    arguments.add_argument("--as-imported", action="store_true", help="leave the materials as Blender's importer makes them")
    options = arguments.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print("| scene | mean, Parhelion over Cycles | relMSE | FLIP |\n|---|---|---|---|")
    for name in options.scenes or SCENES:
        compare(options.program, options.out, name, options.samples, [int(n) for n in options.size.split("x")], options.as_imported)


main()
