"""The scenes of the oracle pictures, as binary glTF: flat-faced, closed, so that shading normals and single-sided surfaces, which
renderers treat in their own ways, do not matter. make_mitsuba_oracles.py says how to run it."""
import math

import numpy as np

from oracle_files import Glb, png_bytes

WHITE, RED, GREEN, BLUE, GREY = (0.7, 0.7, 0.7), (0.63, 0.06, 0.05), (0.14, 0.45, 0.09), (0.1, 0.2, 0.6), (0.4, 0.4, 0.4)


def rotation(axis, degrees):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    m = np.eye(4)
    m[:3, :3] = [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
                 [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
                 [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]
    return m


def translation(x, y, z):
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def scaling(x, y, z):
    return np.diag([x, y, z, 1.0])


def looking(eye, at):
    """World matrix of something that looks along its -Z, as cameras and lights do."""
    eye = np.asarray(eye, float)
    back = eye - np.asarray(at, float)
    back /= np.linalg.norm(back)
    up = (0, 1, 0) if abs(back[1]) < 0.999 else (0, 0, -1)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = right, np.cross(back, right), back, eye
    return m


class Faces:
    """Triangles that share no vertex, with texture coordinates and colours where asked for."""

    def __init__(self):
        self.positions, self.uvs, self.colors = [], [], []

    def quad(self, corner, u, v, uv=((0, 1), (1, 1), (1, 0), (0, 0)), colors=None):
        """Counter-clockwise corner, corner + u, corner + u + v, corner + v."""
        corner, u, v = (np.asarray(a, float) for a in (corner, u, v))
        corners = [corner, corner + u, corner + u + v, corner + v]
        for i in (0, 1, 2, 0, 2, 3):
            self.positions.append(corners[i])
            self.uvs.append(uv[i])
            self.colors.append(colors[i] if colors else (1, 1, 1))
        return self

    def box(self, low, high):
        low, high = np.asarray(low, float), np.asarray(high, float)
        x, y, z = np.diag(high - low)
        self.quad(low + z, x, y).quad(high - y, -z, y).quad(low + x, -x, y).quad(low, z, y)
        return self.quad(low + y + z, x, -z).quad(low, x, z)

    def inside_out(self):
        order = np.arange(len(self.positions)).reshape(-1, 3)[:, ::-1].ravel()
        self.positions, self.uvs, self.colors = ([values[i] for i in order] for values in (self.positions, self.uvs, self.colors))
        return self

    def icosphere(self, radius, levels):
        """Triangles on a sphere, from an octahedron halved `levels` times."""
        faces = [[(0, 1, 0), (0, 0, 1), (1, 0, 0)], [(0, 1, 0), (1, 0, 0), (0, 0, -1)], [(0, 1, 0), (0, 0, -1), (-1, 0, 0)], [(0, 1, 0), (-1, 0, 0), (0, 0, 1)]]
        faces += [[(c[0], -c[1], c[2]) for c in reversed(face)] for face in faces]
        faces = np.asarray(faces, float)
        for _ in range(levels):
            a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
            ab, bc, ca = ((m / np.linalg.norm(m, axis=1)[:, None]) for m in (a + b, b + c, c + a))
            faces = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        self.positions += list(radius * faces.reshape(-1, 3))
        self.uvs += [(0, 0)] * (3 * len(faces))
        self.colors += [(1, 1, 1)] * (3 * len(faces))
        return self


class SceneWriter(Glb):
    def __init__(self):
        super().__init__()
        self.json |= {"scene": 0, "scenes": [{"nodes": []}], "extensionsUsed": ["KHR_materials_specular"]}

    def use(self, extension):
        if extension not in self.json["extensionsUsed"]:
            self.json["extensionsUsed"].append(extension)

    def lambert(self, color=WHITE, emission=None, strength=None, texture=None, emissive_texture=None, **more):
        """A purely diffuse material; textures are references (texture_ref)."""
        pbr = {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        if texture:
            pbr["baseColorTexture"] = texture
        material = {"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}} | more
        if emission:
            material["emissiveFactor"] = list(emission)
        if strength:
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
            self.use("KHR_materials_emissive_strength")
        if emissive_texture:
            material["emissiveTexture"] = emissive_texture
        return self.add("materials", material)

    def mirror(self):
        """White: a coloured metal's Fresnel term is Schlick's here and the complex one there."""
        return self.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 1.0, "roughnessFactor": 0.0}})

    def glass(self, ior):
        """Smooth, clear and solid."""
        for extension in ("transmission", "volume", "ior"):
            self.use("KHR_materials_" + extension)
        extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": {"thicknessFactor": 1.0}, "KHR_materials_ior": {"ior": ior}}
        return self.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0.0, "roughnessFactor": 0.0}, "extensions": extensions})

    def texture(self, texels, nearest=False, wrap=10497):
        filter = 9728 if nearest else 9729
        image = self.add("images", {"bufferView": self.add_view(png_bytes(texels)), "mimeType": "image/png"})
        return self.add("textures", {"source": image, "sampler": self.add("samplers", {"magFilter": filter, "minFilter": filter, "wrapS": wrap, "wrapT": wrap})})

    def texture_ref(self, texture, offset=(0, 0), turn=0.0, scale=(1, 1)):
        self.use("KHR_texture_transform")
        return {"index": texture, "extensions": {"KHR_texture_transform": {"offset": list(offset), "rotation": turn, "scale": list(scale)}}}

    def mesh(self, faces, material, with_uv=False, with_colors=False):
        attributes = {"POSITION": self.add_accessor(np.asarray(faces.positions, float))}
        if with_uv:
            attributes["TEXCOORD_0"] = self.add_accessor(np.asarray(faces.uvs, float))
        if with_colors:
            attributes["COLOR_0"] = self.add_accessor(np.asarray(faces.colors, float))
        return self.add("meshes", {"primitives": [{"attributes": attributes, "material": material}]})

    def node(self, value, matrix=None, parent=None):
        if matrix is not None:
            value = value | {"matrix": np.asarray(matrix).T.ravel().tolist()}
        index = self.add("nodes", value)
        if parent is None:
            self.json["scenes"][0]["nodes"].append(index)
        else:
            self.json["nodes"][parent].setdefault("children", []).append(index)
        return index

    def object(self, faces, material, matrix=None, **with_what):
        return self.node({"mesh": self.mesh(faces, material, **with_what)}, matrix)

    def camera(self, eye, at, degrees):
        camera = self.add("cameras", {"type": "perspective", "perspective": {"yfov": math.radians(degrees), "znear": 0.01}})
        self.node({"camera": camera}, looking(eye, at))

    def light(self, light, matrix):
        self.use("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        self.node({"extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}}, matrix)

    def room(self, materials, half=1.0, height=2.0, lamp=None, with_uv=False, lamp_half=0.3):
        """Floor, back, left, right, ceiling and front wall, seen from inside; `lamp` is let into the ceiling."""
        f, h, floor, back, left, right, ceiling = half, height, *(materials if isinstance(materials, (list, tuple)) else [materials] * 5)
        x, y, z = (2 * f, 0, 0), (0, h, 0), np.array((0, 0, 2 * f))
        self.object(Faces().quad((-f, 0, f), x, -z), floor, with_uv=with_uv)
        self.object(Faces().quad((-f, 0, -f), x, y), back, with_uv=with_uv)
        self.object(Faces().quad((-f, 0, f), -z, y), left, with_uv=with_uv)
        self.object(Faces().quad((f, 0, -f), z, y), right, with_uv=with_uv)
        self.object(Faces().quad((f, 0, f), (-2 * f, 0, 0), y), ceiling)
        top = Faces()
        edges = [-f, -lamp_half, lamp_half, f]
        for i in range(3):
            for k in range(3):
                if (i, k) != (1, 1) or lamp is None:
                    top.quad((edges[i], h, edges[k]), (edges[i + 1] - edges[i], 0, 0), (0, 0, edges[k + 1] - edges[k]))
        self.object(top, ceiling)
        if lamp is not None:
            self.object(Faces().quad((-lamp_half, h, -lamp_half), (2 * lamp_half, 0, 0), (0, 0, 2 * lamp_half)), lamp, with_uv=with_uv)


def low_camera(scene):
    """Inside a room two metres wide, below its lamp, which is not in the picture."""
    scene.camera((0.05, 1.0, 0.95), (-0.02, 0.42, -1.0), 57)


def random_texels(seed, width, height, low=40, high=230):
    return np.random.default_rng(seed).integers(low, high, (height, width, 3)).astype(np.uint8)


def textured(writer):
    s = writer
    plain = s.texture(random_texels(1, 8, 8))
    floor = s.lambert((0.9, 0.8, 0.7), texture=s.texture_ref(plain, (0.13, 0.29), 0.4, (2.3, 1.7)))
    back = s.lambert((1, 1, 1), texture=s.texture_ref(s.texture(random_texels(2, 7, 5), nearest=True), (0.5, -0.2), -1.1, (1.4, 1.9)))
    left = s.lambert((1, 1, 1), texture=s.texture_ref(s.texture(random_texels(3, 6, 6), wrap=33648), (-0.4, -0.7), 0.2, (2.6, 2.1)))
    right = s.lambert((1, 0.9, 1), texture=s.texture_ref(s.texture(random_texels(4, 5, 9), wrap=33071), (-0.3, -0.4), 0.0, (1.8, 1.5)))
    s.room([floor, back, left, right, s.lambert()], lamp=s.lambert(WHITE, (1, 0.9, 0.7), 9.0), with_uv=True)
    rng = np.random.default_rng(5)
    block = Faces().box((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3))
    block.colors = list(rng.uniform(0.1, 1.0, (len(block.positions), 3)))
    s.object(block, s.lambert((0.9, 0.9, 0.9)), translation(0.25, 0.5, -0.2) @ rotation((1, 2, 0.5), 40), with_colors=True)
    low_camera(s)


def many_emitters(writer):
    s = writer
    s.room([s.lambert(GREY), s.lambert(BLUE), s.lambert(RED), s.lambert(GREEN), s.lambert(GREY)])
    rng = np.random.default_rng(7)
    for _ in range(60):
        color = rng.uniform(0.05, 1.0, 3)
        size = rng.uniform(0.012, 0.03, 3)
        lamp = s.lambert((0.5, 0.5, 0.5), color.tolist(), float(np.exp(rng.uniform(0, 3.4))))
        place = translation(*rng.uniform((-0.85, 1.45, -0.7), (0.85, 1.9, 0.6))) @ rotation(rng.normal(size=3), float(rng.uniform(0, 360)))
        s.object(Faces().box(-size, size), lamp, place)
    for _ in range(14):
        place = translation(*rng.uniform((-0.8, 0.05, -0.9), (0.8, 0.7, 0.2))) @ rotation(rng.normal(size=3), float(rng.uniform(0, 360)))
        s.object(Faces().box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)), s.lambert(rng.uniform(0.1, 0.8, 3).tolist()), place)
    low_camera(s)


def textured_emitters(writer):
    s = writer
    picture = np.clip(random_texels(11, 6, 6, 0, 256).astype(int) * (np.random.default_rng(12).random((6, 6, 1)) < 0.5), 0, 255).astype(np.uint8)
    lamp = s.lambert((0.2, 0.2, 0.2), (1, 0.8, 0.6), 14.0, emissive_texture=s.texture_ref(s.texture(picture), (0.1, 0.25), 0.3, (0.7, 0.6)))
    panel = s.lambert((0.3, 0.3, 0.3), (0.7, 0.9, 1), 2.0, emissive_texture=s.texture_ref(s.texture(random_texels(13, 5, 7, 0, 256), nearest=True), (0, 0), 0.0, (1, 1)))
    s.room([s.lambert(WHITE), panel, s.lambert(GREEN), s.lambert(RED), s.lambert(WHITE)], lamp=lamp, with_uv=True, lamp_half=0.5)
    s.object(Faces().box((-0.25, 0, -0.25), (0.25, 0.7, 0.25)), s.lambert(WHITE), translation(-0.3, 0, -0.3) @ rotation((0, 1, 0), 25))
    s.object(Faces().box((-0.2, 0, -0.2), (0.2, 0.35, 0.2)), s.lambert(BLUE), translation(0.4, 0, 0.0) @ rotation((0, 1, 0), -20))
    low_camera(s)


def some_solids(s):
    s.object(Faces().icosphere(0.5, 2), s.lambert(WHITE), translation(-0.65, 0.5, -0.2))
    s.object(Faces().box((-0.3, 0, -0.3), (0.3, 0.9, 0.3)), s.lambert(RED), translation(0.5, 0, -0.5) @ rotation((0, 1, 0), 35))
    s.object(Faces().box((-0.2, -0.2, -0.2), (0.2, 0.2, 0.2)), s.lambert(BLUE), translation(0.35, 0.36, 0.5) @ rotation((1, 1, 0), 50))


def environment(writer):
    s = writer
    s.object(Faces().quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), s.lambert(GREY))
    some_solids(s)
    s.camera((0.4, 1.3, 2.9), (0, 0.45, 0), 42)


def environment_picture():
    """24 x 12 texels: a dim sky, a darker ground, a bright and coloured patch, noise."""
    rng = np.random.default_rng(21)
    texels = rng.uniform(0.2, 0.6, (12, 24, 3)) * np.linspace(1.5, 0.3, 12)[:, None, None]
    texels[2:4, 15:17] = (40, 30, 18)
    texels[4, 5] = (2, 8, 20)
    return texels.astype(np.float32)


def instances(writer):
    s = writer
    s.room([s.lambert(WHITE), s.lambert(GREY), s.lambert(RED), s.lambert(GREEN), s.lambert(WHITE)], lamp=s.lambert(WHITE, (1, 0.95, 0.85), 10.0))
    wedge = Faces().box((-0.2, -0.2, -0.2), (0.2, 0.2, 0.2))  # a box whose top is pulled to one side: it has no mirror image in itself
    wedge.positions = [p + np.array((0.16, 0, 0.1)) * (p[1] > 0) for p in wedge.positions]
    mesh = s.mesh(wedge, s.lambert((0.75, 0.6, 0.3)))
    lamp = s.mesh(Faces().box((-0.05, -0.05, -0.05), (0.05, 0.05, 0.05)), s.lambert(GREY, (0.3, 0.6, 1.0), 20.0))
    s.node({"mesh": mesh}, translation(-0.6, 0.25, -0.5) @ rotation((0, 1, 0), 20))
    s.node({"mesh": mesh}, translation(0.0, 0.45, -0.6) @ scaling(0.6, 2.2, 1.1) @ rotation((0, 1, 0), 60))                   # stretched
    s.node({"mesh": mesh}, translation(0.6, 0.25, -0.4) @ rotation((0, 1, 0), 20) @ scaling(-1, 1, 1))                        # mirrored
    s.node({"mesh": mesh}, translation(-0.25, 0.3, 0.0) @ scaling(1.7, 0.6, 0.7) @ rotation((1, 1, 1), 50) @ scaling(1, -1.3, 0.6))  # sheared, mirrored
    parent = s.node({}, translation(0.4, 0.35, 0.05) @ scaling(1.0, 0.5, 1.6))
    turned = s.node({}, rotation((0.3, 1, 0.2), 37), parent)
    s.node({"mesh": mesh}, scaling(0.7, 1.4, 0.9), turned)  # sheared by its parents
    s.node({"mesh": lamp}, translation(-0.45, 1.45, -0.3) @ scaling(3, 0.5, 1) @ rotation((0, 1, 1), 30))  # stretched emitters: flux by area
    s.node({"mesh": lamp}, translation(0.5, 1.4, -0.5) @ scaling(1, -2.5, 1.5) @ rotation((1, 0, 1), 70))
    low_camera(s)


def punctual(writer):
    s = writer
    s.room([s.lambert(WHITE), s.lambert(GREY), s.lambert(RED), s.lambert(GREEN), s.lambert(WHITE)])
    s.object(Faces().box((-0.25, 0, -0.25), (0.25, 0.7, 0.25)), s.lambert(WHITE), translation(-0.3, 0, -0.4) @ rotation((0, 1, 0), 25))
    s.light({"type": "point", "color": [1, 0.8, 0.5], "intensity": 2.5}, translation(0.6, 1.3, 0.3))
    s.light({"type": "point", "color": [0.2, 0.4, 1], "intensity": 1.2}, translation(-0.7, 0.9, 0.2))
    # Renderers fade spots in their own ways: a black plate with a hole lets only the even inner cone through.
    black, hole, rim, y = s.lambert((0, 0, 0)), 0.08, 0.45, 1.6
    for low, high in (((-rim, y, -rim), (rim, y + 0.02, -hole)), ((-rim, y, hole), (rim, y + 0.02, rim)), ((-rim, y, -hole), (-hole, y + 0.02, hole)), ((hole, y, -hole), (rim, y + 0.02, hole))):
        s.object(Faces().box(low, high), black, translation(0.3, 0, -0.2))
    s.light({"type": "spot", "color": [1, 1, 0.9], "intensity": 9.0, "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.75}}, looking((0.3, 1.9, -0.2), (0.3, 0, -0.2)))
    low_camera(s)


def directional(writer):
    s = writer
    s.object(Faces().quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), s.lambert(GREY))
    some_solids(s)
    s.light({"type": "directional", "color": [1, 0.9, 0.7], "intensity": 3.0}, looking((2, 3, 1.5), (0, 0, 0)))
    s.light({"type": "directional", "color": [0.3, 0.5, 1], "intensity": 1.0}, looking((-3, 1.2, 1), (0, 0, 0)))
    s.camera((0.4, 1.3, 2.9), (0, 0.45, 0), 42)


def alpha(writer):
    s = writer
    grey = s.lambert((0.35, 0.35, 0.35))
    s.room([grey, s.lambert((0.1, 0.2, 0.35)), s.lambert((0.35, 0.1, 0.1)), s.lambert((0.1, 0.35, 0.1)), grey], lamp=s.lambert((0.35, 0.35, 0.35), (1, 0.9, 0.8), 6.0), lamp_half=0.6)
    leaf = np.concatenate([random_texels(31, 8, 8), np.random.default_rng(32).integers(0, 256, (8, 8, 1))], 2).astype(np.uint8)
    nearest = s.texture(leaf, nearest=True)
    mask = s.lambert((0.6, 0.6, 0.6), texture=s.texture_ref(nearest), alphaMode="MASK", alphaCutoff=0.4, doubleSided=True)
    blend = s.lambert((0.5, 0.6, 0.6), texture=s.texture_ref(nearest, (0.2, 0.1)), alphaMode="BLEND", doubleSided=True)
    s.object(Faces().quad((-0.75, 0.1, 0), (0.7, 0, 0), (0, 0.8, 0)), mask, translation(0, 0, -0.2) @ rotation((0, 1, 0), 15), with_uv=True)
    s.object(Faces().quad((0.05, 0.1, 0), (0.7, 0, 0), (0, 0.8, 0)), blend, translation(0, 0, -0.3) @ rotation((0, 1, 0), -20), with_uv=True)
    s.object(Faces().quad((-0.5, 1.2, 0), (1, 0, 0), (0, 0, -0.8)), mask, with_uv=True)
    low_camera(s)


def mirrors(writer):
    s = writer
    s.room([s.lambert(WHITE), s.mirror(), s.lambert(RED), s.lambert(GREEN), s.lambert(WHITE)], lamp=s.lambert(WHITE, (1, 0.9, 0.75), 5.0), lamp_half=0.6)
    s.object(Faces().box((-0.25, 0, -0.25), (0.25, 0.8, 0.25)), s.mirror(), translation(-0.4, 0, -0.35) @ rotation((0, 1, 0), 25))
    s.object(Faces().icosphere(0.28, 1), s.mirror(), translation(0.45, 0.3, -0.3))
    s.object(Faces().box((-0.15, 0, -0.15), (0.15, 0.3, 0.15)), s.lambert(BLUE), translation(0.1, 0, 0.1) @ rotation((0, 1, 0), 40))
    low_camera(s)


def glass(writer):
    s = writer
    s.room([s.lambert(GREY), s.lambert(BLUE), s.lambert(RED), s.lambert(GREEN), s.lambert(GREY)], lamp=s.lambert(WHITE, (1, 0.9, 0.75), 5.0), lamp_half=0.7)
    s.object(Faces().icosphere(0.35, 3), s.glass(1.5), translation(-0.4, 0.45, -0.3))
    s.object(Faces().box((-0.2, -0.25, -0.2), (0.2, 0.25, 0.2)), s.glass(1.33), translation(0.4, 0.4, -0.1) @ rotation((0.4, 1, 0.2), 35))
    s.object(Faces().box((-0.12, 0, -0.12), (0.12, 0.9, 0.12)), s.lambert(WHITE), translation(0.15, 0, -0.7) @ rotation((0, 1, 0), 30))
    low_camera(s)


# name -> (builder, bounces): what is compared; bounces as --max-bounces counts them.
SCENES = {
    "textured": (textured, 4),
    "many_emitters": (many_emitters, 4),
    "textured_emitters": (textured_emitters, 4),
    "environment": (environment, 4),
    "instances": (instances, 4),
    "punctual": (punctual, 4),
    "directional": (directional, 4),
    "alpha": (alpha, 12),
    "mirrors": (mirrors, 6),
    "glass": (glass, 8),
}
