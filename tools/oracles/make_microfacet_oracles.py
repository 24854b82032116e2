#!/usr/bin/env python3
"""Makes tests/golden/oracles/rough_*: scenes of rough metals, coats and glass, and what mitsuba_microfacet.py's surfaces look like in Mitsuba 3.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy scipy
    venv/bin/python tools/oracles/make_microfacet_oracles.py tests/golden/oracles [PICTURE...]

Dr.Jit needs LLVM 16 or newer (DRJIT_LIBLLVM_PATH names its library). Files are as make_mitsuba_oracles.py makes them; a picture whose
name ends in _compensated shows the same .glb as the one without, with the light put back that scatters more than once. The header's
"environment" says whether environment_map.exr lights it. How many bounces a picture has, its header says.
"""
import argparse
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")  # before the plugin's class is made

import make_mitsuba_oracles as base
import mitsuba_microfacet
from oracle_files import Glb, write_exr
from oracle_scenes import BLUE, GREEN, GREY, RED, WHITE, Faces, SceneWriter, environment_picture, low_camera, rotation, translation

GOLD, COPPER = (1.0, 0.78, 0.34), (0.95, 0.5, 0.35)
RUNS = 16


def rough(scene, colour, roughness, metallic=0.0, transmission=0.0, ior=1.5):
    extensions = {}
    if ior != 1.5:
        extensions["KHR_materials_ior"] = {"ior": ior}
    if transmission:
        extensions |= {"KHR_materials_transmission": {"transmissionFactor": transmission}, "KHR_materials_volume": {"thicknessFactor": 1.0}}
    for name in extensions:
        scene.use(name)
    pbr = {"baseColorFactor": [*colour, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
    return scene.add("materials", {"pbrMetallicRoughness": pbr, "extensions": extensions})


def rough_room(s):
    """Metals and coats in a room whose floor and back wall are coated too."""
    floor, back = rough(s, GREY, 0.4), rough(s, BLUE, 0.7)
    s.room([floor, back, s.lambert(RED), s.lambert(GREEN), s.lambert(WHITE)], lamp=s.lambert(WHITE, (1, 0.9, 0.75), 7.0), lamp_half=0.5)
    for x, z, size, turn, material in ((-0.62, -0.55, 0.24, 20, rough(s, WHITE, 1.0, 1.0)), (-0.1, -0.6, 0.26, -25, rough(s, (1, 1, 1), 0.7, 1.0)),
                                       (0.5, -0.5, 0.25, 40, rough(s, GOLD, 0.4, 1.0)), (0.02, 0.15, 0.16, 65, rough(s, (0.8, 0.7, 0.2), 0.4))):
        s.object(Faces().box((-size, 0, -size), (size, 2.4 * size, size)), material, translation(x, 0, z) @ rotation((0, 1, 0), turn))
    low_camera(s)


def rough_sky(s):
    """Spheres of flat faces under an environment."""
    s.object(Faces().quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), rough(s, GREY, 0.7))
    for x, z, radius, material in ((-0.85, -0.3, 0.42, rough(s, (1, 1, 1), 1.0, 1.0)), (0.0, -0.5, 0.42, rough(s, COPPER, 0.4, 1.0)),
                                   (0.85, -0.3, 0.42, rough(s, RED, 0.4)), (0.35, 0.4, 0.28, rough(s, (1, 1, 1), 1.0, ior=1.8))):
        s.object(Faces().icosphere(radius, 2), material, translation(x, radius, z))
    s.camera((0.4, 1.3, 2.9), (0, 0.4, 0), 42)


def rough_glass(s):
    """Blocks and spheres of glass on a coloured floor, under an environment."""
    for k, colour in enumerate((RED, WHITE, BLUE, (0.7, 0.6, 0.1))):
        s.object(Faces().quad((-2 + k, 0, 2), (1, 0, 0), (0, 0, -4)), s.lambert(colour))
    s.object(Faces().box((-0.35, 0.05, -0.2), (0.35, 0.85, 0.2)), rough(s, (1, 1, 1), 0.4, transmission=1.0), translation(-0.6, 0, -0.3) @ rotation((0, 1, 0), 25))
    s.object(Faces().icosphere(0.4, 2), rough(s, (1, 1, 1), 0.7, transmission=1.0), translation(0.3, 0.45, -0.4))
    s.object(Faces().icosphere(0.25, 2), rough(s, (1, 1, 1), 0.25, transmission=1.0, ior=1.33), translation(0.55, 0.3, 0.35))
    s.object(Faces().box((-0.2, 0.02, -0.2), (0.2, 0.3, 0.2)), rough(s, (1, 1, 1), 1.0, transmission=1.0), translation(-0.2, 0, 0.5) @ rotation((0, 1, 0), -15))
    s.camera((0.4, 1.3, 2.9), (0, 0.4, 0), 38)


def rough_slab(s):
    """Slabs of ground glass before a lamp and coloured walls: light from a room's end."""
    lamp = s.lambert((0.3, 0.3, 0.3), (1, 0.85, 0.6), 2.5)
    s.room([s.lambert(WHITE), s.lambert(GREY), s.lambert(RED), s.lambert(GREEN), s.lambert(WHITE)])
    s.object(Faces().box((-0.8, 0.15, -0.85), (0.8, 0.95, -0.8)), lamp)
    for x, roughness in ((-0.62, 0.25), (0.0, 0.5), (0.62, 0.9)):
        s.object(Faces().box((x - 0.29, 0.05, -0.4), (x + 0.29, 0.8, -0.3)), rough(s, (1, 1, 1), roughness, transmission=1.0))
    low_camera(s)


# picture -> (scene, bounces, environment)
PICTURES = {
    "rough_room": (rough_room, 4, False),
    "rough_room_compensated": (rough_room, 4, False),
    "rough_sky": (rough_sky, 4, True),
    "rough_sky_compensated": (rough_sky, 4, True),
    "rough_glass": (rough_glass, 10, True),
    "rough_slab": (rough_slab, 8, False),
}


class Translation(base.Translation):
    def __init__(self, glb, folder, compensated):
        self.compensated = compensated
        super().__init__(glb, folder)

    def bsdf(self, material, has_colors):
        pbr, extensions = material["pbrMetallicRoughness"], material.get("extensions", {})
        if extensions.get("KHR_materials_specular", {}).get("specularFactor", 1) == 0:
            return super().bsdf(material, has_colors)
        kind = "conductor" if pbr["metallicFactor"] == 1 else "coated"
        if "KHR_materials_transmission" in extensions:
            kind = "glass"
        return {"type": "rough_lobes", "kind": kind, "roughness": pbr["roughnessFactor"], "eta": extensions.get("KHR_materials_ior", {}).get("ior", 1.5),
                "colour": mi.ScalarColor3f(pbr["baseColorFactor"][:3]), "compensated": self.compensated}


def render(name, path, samples):
    _, bounces, environment = PICTURES[name]
    with tempfile.TemporaryDirectory() as folder:
        scene = Translation(Glb.read(path), folder, name.endswith("_compensated")).scene
    if environment:
        scene["environment"] = base.environment_emitter(environment_picture())
    scene["integrator"] = {"type": "path", "max_depth": bounces + 1, "rr_depth": 1 << 20}
    scene = mi.load_dict(scene)
    runs = np.stack([np.array(mi.render(scene, spp=samples // RUNS, seed=3000 + run), dtype=np.float64)[..., :3] for run in range(RUNS)])
    mean, variance = runs.mean(0), runs.var(0, ddof=1) / RUNS
    header = {"bounces": str(bounces), "environment": str(int(environment)), "runs": str(RUNS), "renderer": f"Mitsuba {mi.__version__} llvm_ad_rgb path", "samples": str(samples)}
    planes = dict(zip("RGB", np.moveaxis(mean, 2, 0))) | dict(zip(("variance.R", "variance.G", "variance.B"), np.moveaxis(variance, 2, 0)))
    write_exr(path.with_name(name + ".exr"), planes, header)
    return mean, variance


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("pictures", nargs="*")
    arguments.add_argument("--samples", type=int, default=16384)
    options = arguments.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    if unknown := set(options.pictures) - set(PICTURES):
        sys.exit(f"no picture {', '.join(unknown)}; there are {', '.join(PICTURES)}")
    mitsuba_microfacet.register()
    for name in options.pictures or PICTURES:
        path, started = options.folder / (name.removesuffix("_compensated") + ".glb"), time.time()
        writer = SceneWriter()
        PICTURES[name][0](writer)
        writer.write(path)
        mean, variance = render(name, path, options.samples)
        print(f"{name}: mean {mean.mean():.5f}, standard error of a pixel {np.sqrt(variance.mean(2)).mean() / mean.mean():.4f} of it, {time.time() - started:.0f} s", flush=True)


if __name__ == "__main__":
    main()
