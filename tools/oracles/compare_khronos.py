#!/usr/bin/env python3
"""Holds Khronos' sample models against the pictures that other path tracers made of them (glTF-Render-Fidelity).

    python3 -m venv venv && venv/bin/pip install numpy scipy pillow
    venv/bin/python tools/oracles/compare_khronos.py build/release/parhelion ASSETS OUT [--fit]

ASSETS: a folder with the models of SCENARIOS and goldens_dev/khronos-NAME/ENGINE-golden.thumb.webp (512 pixels, lossy, tone mapped; alpha is
coverage). Cameras are those of that repository's comparison/results/config.json; the tone curve is that of its renderers: light / 0.6, Hill's
ACES fit, then sRGB, or a power of 2.2 for Cycles.

Silhouettes are compared exactly. The light of those pictures, an interior called lightroom_14b.hdr, is not among the assets: with --fit it is
fitted (pictures are linear in it), six by four texels, not negative, so that our picture of FIT comes closest to the goldens of FIT, and
the other models are drawn under it. What colours differ by then is the fit's, which has no small lamps, more than ours.

Prints a row of docs/truth.md a model, and leaves NAME.png in OUT: the goldens from left to right, ours last.
"""
import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.optimize import nnls

from oracle_files import Glb, png_bytes, read_exr, write_exr

# name -> file, width over height, target, orbit's theta and phi in degrees, radius. The files of the first two look along +X, those that
# the goldens show along +Z: their theta is 0 there.
SCENARIOS = {
    "CesiumMan": ("cesium_man/CesiumMan.glb", 1, (0, 0.75, 0), 90, 90, 2),
    "CesiumMilkTruck": ("cesium_milk_truck/CesiumMilkTruck.gltf", 1, (0, 1.3, 0), 90, 90, 7.8),
    "Fox": ("fox/Fox.glb", 1, (-35, 37, 25), -60, 90, 124),
    "InterpolationTest": ("interpolation_test/InterpolationTest.gltf", 1, (0, 2.9, 0), 0, 90, 18.4),
    "ClearCoatTest": ("clearcoat_test/ClearCoatTest.glb", 1, (0, 0, 0), 0, 90, 20),
    "MorphStressTest": ("morph_stress/MorphStressTest.gltf", 768 / 300, (0, 0, 0), 0, 90, 2.5),
    "SheenCloth": ("sheen_cloth/SheenCloth.gltf", 1200 / 768, (0, 0.015, 0), 0, 90, 0.059),
    "FlightHelmet": ("flight_helmet/FlightHelmet.gltf", 1, (0, 0.32, 0), 0, 90, 1),
    "AnisotropyRotationTest": ("anisotropy_rotation_test/AnisotropyRotationTest.glb", 1, (0, 0, 0), 0, 90, 18),
    "TransmissionRoughnessTest": ("transmission_roughness_test/TransmissionRoughnessTest.glb", 768 / 300, (0, -0.09, 0), 0, 90, 1.1),
    "GlassHurricaneCandleHolder": ("glass_hurricane_tutorial/GlassHurricaneCandleHolder.gltf", 1, (0, 0.13, 0), 0, 90, 0.75),
    "DamagedHelmet": ("damaged_helmet/DamagedHelmet.glb", 1, (0, 0, 0), 0, 90, 3),
}
FIT = "CesiumMan"
NO_COLOURS = {FIT, "DamagedHelmet", "ClearCoatTest"}  # another environment than the rest; labels that glow
ENGINES = ("blender-cycles", "vray", "dspbr-pt", "three-gpu-pathtracer")
GREY = 0.35  # behind the models
COLUMNS, ROWS, FIT_WIDTH, WIDTH = 6, 4, 64, 128

ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
ACES_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])


def encoded(display, engine):
    if engine == "blender-cycles":
        return display ** (1 / 2.2)
    return np.where(display <= 0.0031308, 12.92 * display, 1.055 * display ** (1 / 2.4) - 0.055)


def decoded(code, engine):
    if engine == "blender-cycles":
        return code**2.2
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def shown(light, engine):
    v = light / 0.6 @ ACES_IN.T
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return encoded(np.clip(v @ ACES_OUT.T, 0, 1), engine)


def light_of(code, engine):
    """The inverse of shown(), where it is not clipped."""
    w = np.clip(decoded(code, engine) @ np.linalg.inv(ACES_OUT).T, 0, 0.98)
    a, b, c = 1 - 0.983729 * w, 0.0245786 - 0.4329510 * w, -0.000090537 - 0.238081 * w
    return 0.6 * ((-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)) @ np.linalg.inv(ACES_IN).T


class Khronos:
    def __init__(self, program, assets, out):
        self.program, self.assets, self.out = program, assets, out

    def size(self, name, width):
        return width, round(width / SCENARIOS[name][1])

    def still(self, name):
        """The model without its animations: a time of 0 is on them, the goldens stand as the nodes do."""
        file = Path(SCENARIOS[name][0])
        path = self.out / "models" / file
        if not path.exists():
            shutil.copytree(self.assets / file.parent, path.parent, copy_function=shutil.copyfile)
            glb = Glb.read(path) if file.suffix == ".glb" else None
            document = glb.json if glb else json.loads(path.read_text())
            document.pop("animations", None)
            glb.write(path) if glb else path.write_text(json.dumps(document))
        return path

    def draw(self, name, environment, width, samples, bounces=16):
        """Light of the model alone, and what is seen past it."""
        _, _, target, theta, phi, radius = SCENARIOS[name]
        t, p = np.radians((theta, phi))
        eye = np.array(target) + radius * np.array((np.sin(p) * np.sin(t), np.cos(p), np.sin(p) * np.cos(t)))
        path, picture = self.out / "environment.exr", self.out / "picture.exr"
        write_exr(path, dict(zip("RGB", np.moveaxis(environment.astype(np.float32), 2, 0))))
        width, height = self.size(name, width)
        command = [self.program, "render", self.still(name), "--size", f"{width}x{height}", "--spp", str(samples), "--env", path, "--exr-type", "float",
                   "--aov", "path.emission", "--exposure", "0", "--max-bounces", str(bounces), "--out", picture, "--fov", "45"]
        command += [f"--look-from={','.join(map(str, eye))}", f"--look-at={','.join(map(str, target))}"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(done.stderr)
        planes = read_exr(picture)
        both, past = (np.stack([planes[prefix + c] for c in "RGB"], 2).astype(float) for prefix in ("", "path.emission."))
        return both - past, past

    def goldens(self, name, width):
        out = {}
        for engine in ENGINES:
            path = self.assets / f"goldens_dev/khronos-{name}/{engine}-golden.thumb.webp"
            if path.exists():
                picture = Image.open(path).convert("RGBa")  # premultiplied
                out[engine] = np.array(picture.resize(self.size(name, width), Image.Resampling.BOX), float) / 255
        return out

    def basis(self, name):
        """The model under each texel alone, and what the goldens show of it: rows are pixels. Kept in OUT."""
        kept = self.out / f"{name}.npz"
        if not kept.exists():
            pictures = []
            for texel in range(COLUMNS * ROWS):
                environment = np.zeros((COLUMNS * ROWS, 3))
                environment[texel] = 1
                pictures.append(self.draw(name, environment.reshape(ROWS, COLUMNS, 3), FIT_WIDTH, 16)[0])
            np.savez_compressed(kept, pictures=np.stack(pictures))
        pictures = np.load(kept)["pictures"]
        goldens = self.goldens(name, FIT_WIDTH)
        usable = np.all([(g[..., 3] > 0.999) & (g[..., :3].max(2) < 0.95) for g in goldens.values()], 0)
        light = np.mean([light_of(g[..., :3], engine) for engine, g in goldens.items()], 0)
        return pictures[:, usable], light[usable]

    def fitted(self):
        pictures, light = self.basis(FIT)
        environment = np.zeros((COLUMNS * ROWS, 3))
        for c in range(3):
            weight = 1 / (light[:, c] + 0.02)  # to equal ratios of light
            environment[:, c] = nnls(pictures[:, :, c].T * weight[:, None], light[:, c] * weight)[0]
        return environment.reshape(ROWS, COLUMNS, 3)

    def flip(self, test, reference):
        for path, picture in ((self.out / "test.png", test), (self.out / "reference.png", reference)):
            path.write_bytes(png_bytes(np.rint(255 * np.clip(picture, 0, 1))))
        told = subprocess.run([self.program, "compare", self.out / "test.png", self.out / "reference.png", "--json"], capture_output=True, text=True, check=True)
        return json.loads(told.stdout)["flip"]

    def compare(self, name, fit):
        goldens = self.goldens(name, WIDTH)
        kept = self.out / f"{name}.cover.npy"
        if not kept.exists():
            bright = 1e4  # against which no surface glows
            np.save(kept, 1 - np.clip(self.draw(name, np.full((ROWS, COLUMNS, 3), bright), WIDTH, 32, 1)[1].mean(2) / bright, 0, 1))
        cover, engines = np.load(kept), list(goldens)
        shared = lambda a, b: np.minimum(a, b).sum() / np.maximum(a, b).sum()
        pairs = [(a, b) for i, a in enumerate(engines) for b in engines[i + 1 :]]
        on_grey = {e: g[..., :3] + GREY * (1 - g[..., 3:]) for e, g in goldens.items()}
        row = [", ".join(f"{shared(goldens[e][..., 3], cover):.3f}" for e in engines), ", ".join(f"{shared(goldens[a][..., 3], goldens[b][..., 3]):.3f}" for a, b in pairs) or "-"]
        tiles = list(on_grey.values())
        if fit and name not in NO_COLOURS:
            light = np.maximum(self.draw(name, self.fitted(), WIDTH, 64)[0], 0) / np.maximum(cover, 1e-3)[..., None]
            ours = {e: shown(light, e) * cover[..., None] + GREY * (1 - cover[..., None]) for e in engines}
            row += [", ".join(f"{self.flip(ours[e], on_grey[e]):.3f}" for e in engines), ", ".join(f"{self.flip(on_grey[a], on_grey[b]):.3f}" for a, b in pairs) or "-"]
            tiles.append(ours[engines[-1]])
        (self.out / f"{name}.png").write_bytes(png_bytes(np.rint(255 * np.clip(np.concatenate(tiles, 1), 0, 1))))
        print(f"| {name} | " + " | ".join(row) + " | " + ", ".join(engines) + " |", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("program", type=Path)
    arguments.add_argument("assets", type=Path)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("names", nargs="*")
    arguments.add_argument("--fit", action="store_true", help="compare colours too, under a fitted light")
    options = arguments.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    khronos = Khronos(options.program, options.assets, options.out)
    print("| model | silhouettes shared with ours | among them | FLIP of ours | among them | renderers |\n|---|---|---|---|---|---|")
    for name in options.names or SCENARIOS:
        khronos.compare(name, options.fit)


if __name__ == "__main__":
    main()
