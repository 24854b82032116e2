#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets into tests/fuzz/corpus: tiny files, each the smallest that uses a part of its format.

Python's standard library only; run it again after a change and commit what it writes. corpus/exr/*-*.exr (one for each of OpenEXR's other
compressions and layouts) were written by OpenEXR itself and are kept.
"""
import base64
import json
import pathlib
import struct
import zlib

from encoded import DRACO, MESHOPT, WEBP

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
FLOAT, USHORT, BYTE, UBYTE, SHORT, UINT = 5126, 5123, 5120, 5121, 5122, 5125


def put(target, name, data):
    folder = CORPUS / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data)


# ---- images ----

def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, depth, colour, rows, interlace=0, extra=b""):
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlace)
    return (b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + extra + png_chunk(b"IDAT", zlib.compress(rows, 9)) + png_chunk(b"IEND", b""))


def rows(width_bytes, height):
    return b"".join(bytes([y % 5]) + bytes((31 * x + 17 * y) % 256 for x in range(width_bytes)) for y in range(height))


PNG_RGB = png(3, 3, 8, 2, rows(9, 3))


def write_png():
    put("png", "rgb8.png", PNG_RGB)
    put("png", "rgba8.png", png(2, 3, 8, 6, rows(8, 3)))
    put("png", "grey1.png", png(9, 2, 1, 0, rows(2, 2)))
    put("png", "grey16.png", png(2, 2, 16, 0, rows(4, 2), extra=png_chunk(b"tRNS", b"\x00\x11")))
    put("png", "grey_alpha8.png", png(2, 2, 8, 4, rows(4, 2)))
    put("png", "rgb16.png", png(2, 2, 16, 2, rows(12, 2), extra=png_chunk(b"gAMA", struct.pack(">I", 45455))))
    palette = png_chunk(b"PLTE", bytes(range(12))) + png_chunk(b"tRNS", b"\x00\x80")
    put("png", "palette2.png", png(5, 2, 2, 3, b"\x00\x1b\x40\x00\x1b\x40", extra=palette))
    adam7 = b"\x00\x01\x00\x02\x00\x03\x04"  # 2x2 grey: the passes 1, 6 and 7
    put("png", "adam7.png", png(2, 2, 8, 0, adam7, interlace=1))


def jpeg_segment(marker, data):
    return bytes([0xFF, marker]) + struct.pack(">H", len(data) + 2) + data


def jpeg(components, progressive=False, restart=0):
    quant = jpeg_segment(0xDB, b"\x00" + bytes([1] * 64))
    ids = range(1, components + 1)
    sampling = {1: 0x22 if components == 3 else 0x11}
    frame = struct.pack(">BHHB", 8, 16, 16, components) + b"".join(bytes([i, sampling.get(i, 0x11), 0]) for i in ids)
    # DC: categories 0 and 3 in two codes of two bits; AC: end of block and one run.
    dc = jpeg_segment(0xC4, bytes([0x00, 0, 2] + [0] * 14 + [0, 3]))
    ac = jpeg_segment(0xC4, bytes([0x10, 0, 2] + [0] * 14 + [0x00, 0x11]))
    interval = jpeg_segment(0xDD, struct.pack(">H", restart)) if restart else b""

    def scan(first, last, approximation, names, data):
        head = bytes([len(names)]) + b"".join(bytes([i, 0]) for i in names) + bytes([first, last, approximation])
        return jpeg_segment(0xDA, head) + data

    start = b"\xff\xd8" + jpeg_segment(0xE0, b"JFIF\x00\x01\x01\x00\x00\x01\x00\x01\x00\x00")
    head = start + quant + jpeg_segment(0xC2 if progressive else 0xC0, frame) + dc + ac + interval
    zeros = b"\x00" * 16
    if not progressive:
        body = b"\x4e\x1c\x08" + zeros if not restart else b"\x4f\xff\xd0\x0f" + zeros
        return head + scan(0, 63, 0, list(ids), body) + b"\xff\xd9"
    body = scan(0, 0, 0x01, list(ids), zeros) + scan(1, 63, 0, [1], zeros) + scan(0, 0, 0x10, list(ids), zeros)
    return head + body + b"\xff\xd9"


def write_jpeg():
    put("jpeg", "grey.jpg", jpeg(1))
    put("jpeg", "colour.jpg", jpeg(3))
    put("jpeg", "restart.jpg", jpeg(3, restart=1))
    put("jpeg", "progressive.jpg", jpeg(3, progressive=True))


def write_hdr():
    def hdr(resolution, body, lines=b"FORMAT=32-bit_rle_rgbe\n"):
        return b"#?RADIANCE\n" + lines + b"\n" + resolution + b"\n" + body
    put("hdr", "flat.hdr", hdr(b"-Y 2 +X 3", bytes(range(100, 124))))
    put("hdr", "turned.hdr", hdr(b"+X 2 -Y 3", bytes(range(100, 124)), b"EXPOSURE=2.5\n"))
    put("hdr", "old.hdr", hdr(b"-Y 1 +X 9", b"\x40\x50\x60\x80\x01\x01\x01\x08"))
    line = b"\x02\x02\x00\x09" + b"\x89\x40" + b"\x04\x01\x02\x03\x04\x85\x07" + b"\x89\x10" + b"\x89\x80"
    put("hdr", "new.hdr", hdr(b"-Y 2 +X 9", line * 2))


def exr_attribute(name, kind, data):
    return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data


def exr(width, height, channels, pixel_type, compression=0, tiled=False):
    names = b"".join(c + b"\0" + struct.pack("<IBxxxII", pixel_type, 0, 1, 1) for c in channels) + b"\0"
    box = struct.pack("<IIII", 0, 0, width - 1, height - 1)
    head = (exr_attribute(b"channels", b"chlist", names) + exr_attribute(b"compression", b"compression", bytes([compression])) +
            exr_attribute(b"dataWindow", b"box2i", box) + exr_attribute(b"displayWindow", b"box2i", box) +
            exr_attribute(b"lineOrder", b"lineOrder", b"\0") + exr_attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) +
            exr_attribute(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)) +
            exr_attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + exr_attribute(b"comments", b"string", b"x"))
    if tiled:
        head += exr_attribute(b"tiles", b"tiledesc", struct.pack("<IIB", 2, 2, 0))
    head = struct.pack("<II", 20000630, 2 | (0x200 if tiled else 0)) + head + b"\0"
    size = 2 if pixel_type == 1 else 4
    blocks = []
    if tiled:
        for y in range(0, height, 2):
            for x in range(0, width, 2):
                data = bytes((i * 5 + x) % 60 for i in range(4 * size * len(channels)))
                blocks.append(struct.pack("<IIIII", x // 2, y // 2, 0, 0, len(data)) + data)
    else:
        for y in range(height):
            data = bytes((i * 7 + y) % 60 for i in range(width * size * len(channels)))
            blocks.append(struct.pack("<II", y, len(data)) + data)
    offset, table = len(head) + 8 * len(blocks), b""
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    return head + table + b"".join(blocks)


def write_exr():
    put("exr", "half.exr", exr(3, 2, [b"B", b"G", b"R"], 1))
    put("exr", "float.exr", exr(2, 2, [b"Y"], 2))
    put("exr", "uint.exr", exr(2, 2, [b"id"], 0))
    put("exr", "tiled.exr", exr(4, 4, [b"A", b"B", b"G", b"R"], 1, tiled=True))


def write_webp():
    for name, data in WEBP.items():
        put("webp", name + ".webp", data)


def ktx2(code, model, width, height, levels, keys=b"", zstd=False):
    """`levels`: their bytes, finest first; Zstandard holds them in one raw block each (RFC 8878, 3.1.1)."""
    def pack(data):
        return struct.pack("<IBI", 0xFD2FB528, 0xA0, len(data)) + struct.pack("<I", len(data) << 3 | 1)[:3] + data if zstd else data
    descriptor = struct.pack("<IIHHBBBBII8x", 44, 0, 2, 40, model, 1, 1, 0, 0, 0) + bytes(44 - 32)
    stored = [pack(data) for data in levels]
    at = 80 + 24 * len(levels) + len(descriptor) + len(keys)
    index, body = [None] * len(levels), b""
    for i in reversed(range(len(levels))):
        index[i] = struct.pack("<QQQ", at + len(body), len(stored[i]), len(levels[i]))
        body += stored[i]
    key_at = 80 + 24 * len(levels) + len(descriptor) if keys else 0
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", code, 1, width, height, 0, 0, 1, len(levels), 2 if zstd else 0)
    head += struct.pack("<IIIIQQ", 80 + 24 * len(levels), len(descriptor), key_at, len(keys), 0, 0)
    return head + b"".join(index) + descriptor + keys + body


def noise(size):
    return bytes((i * 73 + 41) % 256 for i in range(size))


def ktx2_key(key, value):
    data = key + b"\0" + value + b"\0"
    return struct.pack("<I", len(data)) + data + bytes(-len(data) % 4)


KTX2_BC7 = ktx2(145, 134, 5, 4, [noise(32), noise(16)])


def write_ktx2():
    put("ktx2", "rgb8.ktx2", ktx2(29, 1, 3, 2, [noise(18), noise(3)]))
    put("ktx2", "bgra8_zstd.ktx2", ktx2(44, 1, 3, 3, [noise(36), noise(4)], zstd=True))
    put("ktx2", "keys.ktx2", ktx2(9, 1, 4, 1, [noise(4)], ktx2_key(b"KTXorientation", b"rd") + ktx2_key(b"KTXswizzle", b"r001")))
    put("ktx2", "bc1.ktx2", ktx2(132, 128, 8, 8, [noise(32), noise(8), noise(8), noise(8)]))
    put("ktx2", "bc3_zstd.ktx2", ktx2(138, 130, 4, 4, [noise(16)], zstd=True))
    put("ktx2", "bc4.ktx2", ktx2(139, 131, 4, 4, [noise(8)]))
    put("ktx2", "bc5.ktx2", ktx2(141, 132, 4, 4, [noise(16)]))
    put("ktx2", "bc7.ktx2", KTX2_BC7)


# ---- glTF ----

class Maker:
    def __init__(self):
        self.buffer = b""
        self.doc = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "bufferViews": [], "accessors": [],
                    "meshes": []}

    def push(self, table, value):
        self.doc.setdefault(table, []).append(value)
        return len(self.doc[table]) - 1

    def view(self, data, **more):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        at = len(self.buffer)
        self.buffer += data
        return self.push("bufferViews", {"buffer": 0, "byteOffset": at, "byteLength": len(data), **more})

    def accessor(self, code, kind, values, **more):
        letters = {FLOAT: "f", USHORT: "H", UBYTE: "B", SHORT: "h", UINT: "I"}
        count = len(values) // {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        view = self.view(struct.pack("<%d%s" % (len(values), letters[code]), *values))
        return self.push("accessors", {"bufferView": view, "componentType": code, "type": kind, "count": count, **more})

    def node(self, **value):
        self.doc["scenes"][0]["nodes"].append(self.push("nodes", value))

    def mesh(self, **primitive):
        self.node(mesh=self.push("meshes", {"primitives": [primitive]}))

    def write(self, name):
        self.doc = {k: v for k, v in self.doc.items() if v != []}
        if self.buffer:
            self.doc["buffers"] = [{"byteLength": len(self.buffer)}]
            if any(view["buffer"] == 1 for view in self.doc["bufferViews"]):  # the fallback of meshopt, which is not there
                self.doc["buffers"].append({"byteLength": 4096})
        text = json.dumps(self.doc, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = self.buffer + b"\0" * (-len(self.buffer) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        put("glb", name + ".glb", struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)
        if self.buffer:
            self.doc["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(self.buffer).decode()
        put("gltf", name + ".gltf", json.dumps(self.doc, separators=(",", ":")).encode())


TRIANGLE = [0, 0, 0, 1, 0, 0, 0, 1, 0]
QUAD = TRIANGLE + [1, 1, 0]


def write_gltf():
    m = Maker()
    m.mesh(attributes={"POSITION": m.accessor(FLOAT, "VEC3", TRIANGLE)})
    m.write("triangle")

    m = Maker()
    texture = m.push("textures", {"source": m.push("images", {"bufferView": m.view(PNG_RGB), "mimeType": "image/png"}),
                                  "sampler": m.push("samplers", {"magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648})})
    info = {"index": texture, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1, "scale": [2, 2]}}}
    material = m.push("materials", {
        "pbrMetallicRoughness": {"baseColorFactor": [1, .5, .2, 1], "metallicFactor": 0, "roughnessFactor": .5, "baseColorTexture": info,
                                 "metallicRoughnessTexture": {"index": texture}},
        "normalTexture": {"index": texture, "scale": .5}, "occlusionTexture": {"index": texture, "strength": .5},
        "emissiveTexture": {"index": texture}, "emissiveFactor": [0, 0, 1], "alphaMode": "MASK", "alphaCutoff": .3, "doubleSided": True,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5}, "KHR_materials_ior": {"ior": 1.4},
                       "KHR_materials_specular": {"specularFactor": .5, "specularColorFactor": [1, .5, 1]},
                       "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_unlit": {},
                       "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0, 1]},
                       "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": texture}},
                       "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0], "sheenRoughnessFactor": .5},
                       "KHR_materials_anisotropy": {"anisotropyStrength": .5, "anisotropyRotation": 1},
                       "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.3},
                       "KHR_materials_dispersion": {"dispersion": 1}}})
    m.mesh(material=material, mode=5, indices=m.accessor(USHORT, "SCALAR", [0, 1, 2, 3]),
           attributes={"POSITION": m.accessor(FLOAT, "VEC3", QUAD), "NORMAL": m.accessor(FLOAT, "VEC3", [0, 0, 1] * 4),
                       "TEXCOORD_0": m.accessor(USHORT, "VEC2", [0, 0, 65535, 0, 0, 65535, 65535, 65535], normalized=True),
                       "TEXCOORD_1": m.accessor(FLOAT, "VEC2", [0, 0, 1, 0, 0, 1, 1, 1]),
                       "COLOR_0": m.accessor(UBYTE, "VEC4", [255] * 16, normalized=True)})
    m.doc["meshes"][0]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 0, "variants": [0]}]}}
    m.doc["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "a"}]}}
    m.doc["extensionsUsed"] = ["KHR_texture_transform", "KHR_materials_ior", "KHR_materials_variants"]
    m.doc["extensionsRequired"] = ["KHR_texture_transform"]
    m.write("material")

    m = Maker()
    sparse = m.accessor(FLOAT, "VEC3", QUAD)
    m.doc["accessors"][sparse]["sparse"] = {"count": 2, "indices": {"bufferView": m.view(struct.pack("<BB", 1, 3)), "componentType": UBYTE},
                                            "values": {"bufferView": m.view(struct.pack("<6f", 2, 0, 0, 2, 2, 0))}}
    m.mesh(mode=6, attributes={"POSITION": sparse}, indices=m.accessor(UINT, "SCALAR", [0, 1, 2, 3]))
    view = m.view(struct.pack("<12h", 0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0), byteStride=8)
    m.mesh(attributes={"POSITION": m.push("accessors", {"bufferView": view, "componentType": SHORT, "type": "VEC3", "count": 3})})
    m.doc["extensionsUsed"] = ["KHR_mesh_quantization"]
    m.write("accessors")

    m = Maker()
    mesh = m.push("meshes", {"primitives": [{"attributes": {"POSITION": m.accessor(FLOAT, "VEC3", TRIANGLE)}}]})
    leaf = m.push("nodes", {"mesh": mesh, "matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]})
    m.node(name="root", children=[leaf], translation=[1, 2, 3], rotation=[0, 0, 0, 1], scale=[1, -1, 2])
    m.node(camera=m.push("cameras", {"type": "perspective", "perspective": {"yfov": 1, "znear": .1, "zfar": 9, "aspectRatio": 1}}))
    m.node(camera=m.push("cameras", {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}))
    m.doc["extensions"] = {"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 5, "range": 3}, {"type": "directional", "color": [1, 0, 1]},
        {"type": "spot", "spot": {"innerConeAngle": .1, "outerConeAngle": .5}}]}}
    for light in range(3):
        m.node(extensions={"KHR_lights_punctual": {"light": light}})
    instances = {"TRANSLATION": m.accessor(FLOAT, "VEC3", [0] * 6), "SCALE": m.accessor(FLOAT, "VEC3", [1] * 6),
                 "ROTATION": m.accessor(FLOAT, "VEC4", [0, 0, 0, 1] * 2)}
    m.node(mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": instances}})
    m.doc["extensionsUsed"] = ["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]
    m.write("nodes")

    m = Maker()
    joints = m.accessor(UBYTE, "VEC4", [0, 1, 0, 0] * 3)
    weights = m.accessor(FLOAT, "VEC4", [.5, .5, 0, 0] * 3)
    bones = [m.push("nodes", {"translation": [0, 0, 0]}), m.push("nodes", {"translation": [0, 1, 0]})]
    m.doc["nodes"][0]["children"] = [1]
    m.doc["scenes"][0]["nodes"].append(0)
    identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    skin = m.push("skins", {"joints": bones, "skeleton": 0, "inverseBindMatrices": m.accessor(FLOAT, "MAT4", identity * 2)})
    morphed = m.push("meshes", {"weights": [.5], "primitives": [{
        "attributes": {"POSITION": m.accessor(FLOAT, "VEC3", TRIANGLE), "NORMAL": m.accessor(FLOAT, "VEC3", [0, 0, 1] * 3),
                       "JOINTS_0": joints, "WEIGHTS_0": weights},
        "targets": [{"POSITION": m.accessor(FLOAT, "VEC3", [0, 0, 1] * 3)}]}]})
    m.node(mesh=morphed, skin=skin)
    times = m.accessor(FLOAT, "SCALAR", [0, 1], min=[0], max=[1])
    turn = m.accessor(FLOAT, "VEC4", [0, 0, 0, 1, 0, 1, 0, 0])
    cubic = m.accessor(FLOAT, "VEC3", [0, 1, 0] * 6)
    fade = m.accessor(FLOAT, "SCALAR", [0, 1])
    m.push("animations", {"samplers": [{"input": times, "output": turn}, {"input": times, "output": cubic, "interpolation": "CUBICSPLINE"},
                                       {"input": times, "output": fade, "interpolation": "STEP"}],
                          "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}},
                                       {"sampler": 1, "target": {"node": 1, "path": "translation"}},
                                       {"sampler": 2, "target": {"node": 2, "path": "weights"}}]})
    m.write("moving")


def write_compressed():
    for name, data in DRACO.items():
        m = Maker()
        # Accessors without a view: what the compressed data give them.
        kinds = [("POSITION", FLOAT, "VEC3"), ("NORMAL", FLOAT, "VEC3"), ("TEXCOORD_0", FLOAT, "VEC2"), ("COLOR_0", UBYTE, "VEC4"),
                 ("JOINTS_0", UBYTE, "VEC4"), ("WEIGHTS_0", FLOAT, "VEC4")]
        kinds = kinds[:1] if name.startswith("plain") else kinds
        accessors = {key: m.push("accessors", {"componentType": code, "type": kind, "count": 16, "normalized": key == "COLOR_0"})
                     for key, code, kind in kinds}
        extension = {"bufferView": m.view(data), "attributes": {kinds[i][0]: i for i in range(len(kinds))}}
        m.mesh(attributes=accessors, indices=m.push("accessors", {"componentType": USHORT, "type": "SCALAR", "count": 54}),
               extensions={"KHR_draco_mesh_compression": extension})
        m.doc["extensionsUsed"] = m.doc["extensionsRequired"] = ["KHR_draco_mesh_compression"]
        m.write("draco_" + name)

    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"]:
        m = Maker()

        def compressed(key, code, kind, stride, mode="ATTRIBUTES", count=8, **more):
            at = m.push("bufferViews", {"buffer": 1, "byteLength": count * stride})
            data = MESHOPT[key]
            view = m.doc["bufferViews"][at]
            if mode == "ATTRIBUTES":
                view["byteStride"] = stride
            filters = {"filter": more.pop("filter")} if "filter" in more else {}
            m.buffer += bytes(-len(m.buffer) % 4)
            view["extensions"] = {extension: {"buffer": 0, "byteOffset": len(m.buffer), "byteLength": len(data), "byteStride": stride, "mode": mode,
                                              "count": count, **filters}}
            m.buffer += data
            return m.push("accessors", {"bufferView": at, "componentType": code, "type": kind, "count": count, **more})
        short = {"normalized": True}
        color = {"COLOR_0": compressed("color", UBYTE, "VEC4", 4, filter="COLOR", **short)} if extension.startswith("KHR") else {}
        m.mesh(attributes={"POSITION": compressed("positions", FLOAT, "VEC3", 12), "NORMAL": compressed("oct8", BYTE, "VEC3", 4, filter="OCTAHEDRAL", **short),
                           **color}, indices=compressed("triangles", UINT, "SCALAR", 4, "TRIANGLES", 12))
        if color:
            color = {"COLOR_0": compressed("color16", USHORT, "VEC4", 8, filter="COLOR", **short)}
        m.mesh(attributes={"POSITION": compressed("exp", FLOAT, "VEC3", 12, filter="EXPONENTIAL"),
                           "NORMAL": compressed("oct16", SHORT, "VEC3", 8, filter="OCTAHEDRAL", **short), **color},
               indices=compressed("indices", USHORT, "SCALAR", 2, "INDICES", 12))
        places = {"ROTATION": compressed("quat", SHORT, "VEC4", 8, filter="QUATERNION", **short),
                  "TRANSLATION": compressed("positions", FLOAT, "VEC3", 12)}
        m.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": places}})
        m.doc["extensionsUsed"] = m.doc["extensionsRequired"] = [extension, "KHR_mesh_quantization", "EXT_mesh_gpu_instancing"]
        m.write(extension[:11].lower())


def write_textures():
    m = Maker()
    sources = [(PNG_RGB, "image/png"), (WEBP["lossless"], "image/webp"), (KTX2_BC7, "image/ktx2"), (ktx2(0, 166, 4, 4, [noise(16)]), "image/ktx2")]
    images = [m.push("images", {"bufferView": m.view(data), "mimeType": kind}) for data, kind in sources]
    webp = m.push("textures", {"source": images[0], "extensions": {"EXT_texture_webp": {"source": images[1]}}})
    bc7 = m.push("textures", {"extensions": {"KHR_texture_basisu": {"source": images[2]}}})
    basis = m.push("textures", {"source": images[0], "extensions": {"KHR_texture_basisu": {"source": images[3]}}})

    def info(index):
        return {"index": index, "extensions": {"KHR_texture_transform": {"rotation": 1, "texCoord": 1}}}
    extensions = {
        "KHR_materials_specular": {"specularTexture": info(webp), "specularColorTexture": info(bc7)},
        "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": info(webp)},
        "KHR_materials_volume": {"thicknessFactor": 1, "thicknessTexture": info(bc7)},
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": .5, "clearcoatRoughnessTexture": info(bc7),
                                    "clearcoatNormalTexture": {"index": webp, "scale": 2}},
        "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0], "sheenColorTexture": info(webp), "sheenRoughnessTexture": info(basis)},
        "KHR_materials_anisotropy": {"anisotropyStrength": .5, "anisotropyTexture": info(webp)},
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceTexture": info(webp), "iridescenceThicknessTexture": info(bc7),
                                      "iridescenceThicknessMinimum": 10, "iridescenceThicknessMaximum": 20}}
    first = m.push("materials", {"name": "all", "pbrMetallicRoughness": {"baseColorTexture": info(webp)}, "normalTexture": {"index": bc7},
                                 "alphaMode": "BLEND", "extensions": extensions})
    old = {"diffuseFactor": [1, 0, 0, 1], "diffuseTexture": info(webp), "specularFactor": [1, 1, 1], "glossinessFactor": .5,
           "specularGlossinessTexture": info(bc7)}
    second = m.push("materials", {"extensions": {"KHR_materials_pbrSpecularGlossiness": old}})
    m.mesh(material=first, attributes={"POSITION": m.accessor(FLOAT, "VEC3", TRIANGLE), "TEXCOORD_0": m.accessor(FLOAT, "VEC2", [0, 0, 1, 0, 0, 1]),
                                       "TEXCOORD_1": m.accessor(FLOAT, "VEC2", [0, 0, 1, 0, 0, 1])},
           extensions={"KHR_materials_variants": {"mappings": [{"material": second, "variants": [0]}, {"material": first, "variants": [1]}]}})
    m.doc["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "old"}, {"name": "new"}]}}
    m.write("textures")


def write_uri():
    seeds = ["a.bin", "sub/back", "../out.bin", "link", "up/out.bin", "%2e%2e/out.bin", "no/../link", "sub/..\\..\\out.bin", "data:,a%20b",
             "data:;base64,aGVsbG8=", "file:///etc/passwd", "//host/a", "./sub/../a.bin", "c:a.bin"]
    for number, seed in enumerate(seeds):
        put("uri", "%02d" % number, seed.encode())


if __name__ == "__main__":
    write_png()
    write_jpeg()
    write_hdr()
    write_exr()
    write_webp()
    write_ktx2()
    write_gltf()
    write_compressed()
    write_textures()
    write_uri()
