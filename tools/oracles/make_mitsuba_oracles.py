#!/usr/bin/env python3
"""Makes tests/golden/oracles: small scenes, and what Mitsuba 3 (Jakob et al.) says they look like.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python tools/oracles/make_mitsuba_oracles.py build/release/parhelion tests/golden/oracles [SCENE...]

NAME.glb is the scene; NAME.exr its mean (R, G, B) and the variance of that mean (variance.R, ...), from independent runs with fixed
seeds. environment_map.exr lights NAME = environment, turned by its ENVIRONMENT_DEGREES. The glTF files are read here by the few lines
below, with no code of Parhelion's; what Mitsuba models in another way is refused, not approximated.

Where the two programs say the same thing differently:
  depth       Mitsuba counts edges of a path, Parhelion scatterings: max_depth = bounces + 1
  camera      Mitsuba's looks along +Z with +X to the left
  environment Mitsuba's texel rows lie on the poles, Parhelion's half a row from them: rows are doubled, which keeps the bilinear
              picture exactly; Mitsuba's map begins where Parhelion's has its middle
  alpha masks Mitsuba's null passage counts as an edge: that scene is deep enough that it does not matter
"""
import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

from oracle_files import Glb, write_exr
from oracle_scenes import SCENES, SceneWriter, environment_picture, looking

WIDTH, HEIGHT, RUNS = 48, 36, 16
ENVIRONMENT_DEGREES = 73.0


def linear_from_srgb(encoded):
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def refuse(what):
    raise SystemExit(f"{what}: Mitsuba has no equal of it")


class Translation:
    """A glTF scene as a Mitsuba one."""

    def __init__(self, glb, folder):
        self.glb, self.folder, self.scene = glb, Path(folder), {"type": "scene"}
        for root in glb.json["scenes"][glb.json.get("scene", 0)]["nodes"]:
            self.visit(root, np.eye(4))

    def visit(self, index, parent):
        node = self.glb.json["nodes"][index]
        world = parent @ self.local(node)
        if "mesh" in node:
            for primitive in self.glb.json["meshes"][node["mesh"]]["primitives"]:
                self.scene[f"shape{len(self.scene)}"] = self.shape(primitive, world)
        if "camera" in node and "sensor" not in self.scene:
            self.scene["sensor"] = self.sensor(self.glb.json["cameras"][node["camera"]], world)
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light:
            self.scene[f"light{len(self.scene)}"] = self.light(self.glb.json["extensions"]["KHR_lights_punctual"]["lights"][light["light"]], world)
        for child in node.get("children", []):
            self.visit(child, world)

    @staticmethod
    def local(node):
        if "matrix" in node:
            return np.asarray(node["matrix"], float).reshape(4, 4).T
        x, y, z, w = node.get("rotation", (0, 0, 0, 1))
        m = np.eye(4)
        m[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        m[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)))
        m[:3, 3] = node.get("translation", (0, 0, 0))
        return m

    @staticmethod
    def sensor(camera, world):
        to_world = world @ np.diag([-1.0, 1, -1, 1])
        return {"type": "perspective", "fov_axis": "y", "fov": float(np.degrees(camera["perspective"]["yfov"])), "near_clip": 0.001, "far_clip": 1000.0,
                "to_world": mi.ScalarTransform4f(to_world), "sampler": {"type": "independent"},
                "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}}

    @staticmethod
    def light(light, world):
        intensity = {"type": "rgb", "value": [light.get("intensity", 1.0) * c for c in light.get("color", (1, 1, 1))]}
        position, forward = world[:3, 3], -world[:3, 2]
        if light["type"] == "point":
            return {"type": "point", "position": position.tolist(), "intensity": intensity}
        if light["type"] == "directional":
            return {"type": "directional", "direction": forward.tolist(), "irradiance": intensity}
        cone = light["spot"]  # equal inside the inner cone only
        return {"type": "spot", "to_world": mi.ScalarTransform4f(world @ np.diag([-1.0, 1, -1, 1])), "intensity": intensity,
                "cutoff_angle": float(np.degrees(cone["outerConeAngle"])), "beam_width": float(np.degrees(cone["innerConeAngle"]))}

    def texels(self, texture, srgb):
        image = self.glb.json["images"][texture["source"]]
        path = self.folder / "texels.png"
        path.write_bytes(self.glb.view(image["bufferView"]))
        values = np.array(mi.Bitmap(str(path)), dtype=np.float64) / 255
        if srgb:
            values[..., :3] = linear_from_srgb(values[..., :3])
        return values

    def bitmap(self, texture, values):
        sampler = self.glb.json["samplers"][texture["sampler"]] if "sampler" in texture else {}
        wrap = {10497: "repeat", 33648: "mirror", 33071: "clamp"}[sampler.get("wrapS", 10497)]
        if sampler.get("wrapT", 10497) != sampler.get("wrapS", 10497):
            refuse("a texture that wraps differently in its two directions")
        filter = {9728: "nearest", 9729: "bilinear"}[sampler.get("magFilter", 9729)]
        return {"type": "bitmap", "bitmap": mi.Bitmap(values.astype(np.float32)), "raw": True, "filter_type": filter, "wrap_mode": wrap}

    def colour(self, reference, factor):
        """factor x texture, linear."""
        if not reference:
            return {"type": "rgb", "value": [float(c) for c in factor]}
        texture = self.glb.json["textures"][reference["index"]]
        return self.bitmap(texture, self.texels(texture, True)[..., :3] * np.asarray(factor))

    def bsdf(self, material, has_colors):
        pbr, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
        smooth_white = pbr.get("roughnessFactor", 1) == 0 and pbr.get("baseColorFactor", [1, 1, 1, 1]) == [1, 1, 1, 1] and "baseColorTexture" not in pbr
        if smooth_white and pbr.get("metallicFactor", 1) == 1:
            return {"type": "conductor", "material": "none"}
        if smooth_white and extensions.get("KHR_materials_transmission") == {"transmissionFactor": 1.0} and extensions.get("KHR_materials_volume") == {"thicknessFactor": 1.0}:
            return {"type": "dielectric", "int_ior": extensions["KHR_materials_ior"]["ior"], "ext_ior": 1.0}
        if pbr.get("metallicFactor", 1) != 0 or extensions.get("KHR_materials_specular", {}).get("specularFactor", 1) != 0 or "normalTexture" in material:
            refuse("a material that is neither purely diffuse nor a white mirror nor clear glass")
        factor, reference = np.asarray(pbr.get("baseColorFactor", (1, 1, 1, 1)), float), pbr.get("baseColorTexture")
        if has_colors and reference:
            refuse("vertex colours times a texture")
        reflectance = {"type": "mesh_attribute", "name": "vertex_color"} if has_colors else self.colour(reference, factor[:3])
        bsdf = {"type": "diffuse", "reflectance": reflectance}
        if material.get("doubleSided"):
            bsdf = {"type": "twosided", "bsdf": bsdf}
        mode = material.get("alphaMode", "OPAQUE")
        if mode == "OPAQUE":
            return bsdf
        texture = self.glb.json["textures"][reference["index"]]
        opacity = self.texels(texture, True)[..., 3:] * factor[3]
        if mode == "MASK":
            opacity = (opacity >= material.get("alphaCutoff", 0.5)).astype(np.float64)
        picture = self.bitmap(texture, opacity)
        if mode == "MASK" and picture["filter_type"] != "nearest":
            refuse("a cutoff after filtering")
        return {"type": "mask", "bsdf": bsdf, "opacity": picture}

    @staticmethod
    def transformed(uv, reference):
        moved = reference.get("extensions", {}).get("KHR_texture_transform")
        if not moved:
            return uv
        angle, scale = moved.get("rotation", 0.0), np.asarray(moved.get("scale", (1, 1)), float)
        c, s = np.cos(angle), np.sin(angle)
        return (uv * scale) @ np.array([[c, s], [-s, c]]).T + np.asarray(moved.get("offset", (0, 0)), float)

    def shape(self, primitive, world):
        material = self.glb.json["materials"][primitive["material"]]
        attributes = {name: self.glb.accessor(index) for name, index in primitive["attributes"].items()}
        faces = self.glb.accessor(primitive["indices"]).astype(np.int64).reshape(-1, 3) if "indices" in primitive else np.arange(len(attributes["POSITION"])).reshape(-1, 3)
        if np.linalg.det(world[:3, :3]) < 0:  # a mirror does not turn an object inside out
            faces = faces[:, ::-1]
        references = [r for r in (material.get("pbrMetallicRoughness", {}).get("baseColorTexture"), material.get("emissiveTexture")) if r]
        if len(references) > 1:
            refuse("two textures, each with a transform of its own")
        emission = np.asarray(material.get("emissiveFactor", (0, 0, 0)), float)
        emission = emission * material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(self.bsdf(material, "COLOR_0" in attributes))
        if emission.any():
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": self.colour(material.get("emissiveTexture"), emission)})
        positions = attributes["POSITION"] @ world[:3, :3].T + world[:3, 3]
        mesh = mi.Mesh("mesh", len(positions), len(faces), has_vertex_normals=False, has_vertex_texcoords=bool(references), props=properties)
        if "COLOR_0" in attributes:
            factor = np.asarray(material.get("pbrMetallicRoughness", {}).get("baseColorFactor", (1, 1, 1, 1)), float)
            mesh.add_attribute("vertex_color", 3, (attributes["COLOR_0"][:, :3] * factor[:3]).ravel().astype(np.float32))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = positions.ravel().astype(np.float32)
        parameters["faces"] = faces.ravel().astype(np.uint32)
        if references:
            parameters["vertex_texcoords"] = self.transformed(attributes["TEXCOORD_0"], references[0]).ravel().astype(np.float32)
        parameters.update()
        if emission.any() and references and not 0 <= np.array(parameters["vertex_texcoords"]).min() <= np.array(parameters["vertex_texcoords"]).max() <= 1:
            refuse("an emissive texture beyond its edge, of which Mitsuba samples only the inside,")
        return mesh


def environment_emitter(texels):
    """Parhelion's picture has its rows at (j + 1/2) / n of the way from pole to pole, Mitsuba's at k / (m - 1): with m = 2 n + 1 every
    knot of the one is a knot of the other."""
    rows = len(texels)
    at = np.clip(np.arange(2 * rows + 1) / 2 - 0.5, 0, rows - 1)
    low = np.floor(at).astype(int)
    high, share = np.minimum(low + 1, rows - 1), (at - low)[:, None, None]
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], ENVIRONMENT_DEGREES + 180.0)
    return {"type": "envmap", "bitmap": mi.Bitmap((texels[low] * (1 - share) + texels[high] * share).astype(np.float32)), "to_world": turned}


def exported_cornell(program, path):
    """builtin:cornell as the program writes it, with a camera that has the lamp out of its picture."""
    subprocess.run([program, "export", "builtin:cornell", "--out", path], check=True)
    glb = Glb.read(path)
    for node in glb.json["nodes"]:
        if "camera" in node:
            for place in ("translation", "rotation", "scale", "matrix"):
                node.pop(place, None)
            node["matrix"] = looking((0.0, 1.0, 3.6), (0.0, 0.75, 0.0)).T.ravel().tolist()
            glb.json["cameras"][node["camera"]]["perspective"]["yfov"] = 0.46
    glb.write(path)


def render(name, path, bounces, samples):
    with tempfile.TemporaryDirectory() as folder:
        scene = Translation(Glb.read(path), folder).scene
    if name == "environment":
        scene["environment"] = environment_emitter(environment_picture())
    scene["integrator"] = {"type": "path", "max_depth": bounces + 1, "rr_depth": 1 << 20}
    scene = mi.load_dict(scene)
    runs = np.stack([np.array(mi.render(scene, spp=samples // RUNS, seed=1000 + run), dtype=np.float64)[..., :3] for run in range(RUNS)])
    return runs.mean(0), runs.var(0, ddof=1) / RUNS


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("program")
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("scenes", nargs="*")
    arguments.add_argument("--samples", type=int, default=8192)
    arguments.add_argument("--variant", default="scalar_rgb")
    options = arguments.parse_args()
    mi.set_variant(options.variant)
    options.folder.mkdir(parents=True, exist_ok=True)
    scenes = {"cornell": (None, 5)} | SCENES
    if unknown := set(options.scenes) - set(scenes):
        sys.exit(f"no scene {', '.join(unknown)}; there are {', '.join(scenes)}")
    for name in options.scenes or scenes:
        builder, bounces = scenes[name]
        path, started = options.folder / f"{name}.glb", time.time()
        if builder:
            writer = SceneWriter()
            builder(writer)
            writer.write(path)
        else:
            exported_cornell(options.program, path)
        if name == "environment":
            write_exr(options.folder / "environment_map.exr", dict(zip("RGB", np.moveaxis(environment_picture(), 2, 0))))
        mean, variance = render(name, path, bounces, options.samples)
        planes = dict(zip("RGB", np.moveaxis(mean, 2, 0))) | dict(zip(("variance.R", "variance.G", "variance.B"), np.moveaxis(variance, 2, 0)))
        write_exr(options.folder / f"{name}.exr", planes, {"bounces": str(bounces), "runs": str(RUNS), "renderer": f"Mitsuba {mi.__version__} {options.variant} path", "samples": str(options.samples)})
        print(f"{name}: mean {mean.mean():.5f}, standard error of a pixel {np.sqrt(variance.mean(2)).mean() / mean.mean():.4f} of it, {time.time() - started:.0f} s", flush=True)


if __name__ == "__main__":
    main()
