"""Small writers and readers for the oracle scripts: PNG, EXR, binary glTF. Standard library and numpy only."""
import json
import struct
import zlib

import numpy as np


def png_bytes(texels):
    """Eight-bit RGB or RGBA, [height][width][channels], rows from the top."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, channels = texels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in texels.astype(np.uint8))
    header = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def write_exr(path, planes, attributes=None):
    """planes: {"R": float32 [height][width], ...}; 32-bit channels, ZIPS. attributes: strings for the header."""
    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    def zip_line(data):  # even bytes then odd bytes, differences, deflate; stored plain where that is not smaller
        b = np.frombuffer(data, np.uint8)
        split = np.concatenate([b[0::2], b[1::2]]).astype(np.int32)
        split[1:] = (split[1:] - split[:-1] + 128) & 255
        packed = zlib.compress(split.astype(np.uint8).tobytes(), 9)
        return packed if len(packed) < len(data) else data

    names = sorted(planes)
    height, width = planes[names[0]].shape
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in names) + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0" + attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\x02")
    header += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    header += b"".join(attribute(name, "string", text.encode()) for name, text in sorted((attributes or {}).items())) + b"\0"
    lines = []
    for y in range(height):
        data = zip_line(b"".join(planes[name][y].astype("<f4").tobytes() for name in names))
        lines.append(struct.pack("<ii", y, len(data)) + data)
    at, table = len(header) + 8 * height, b""
    for line in lines:
        table += struct.pack("<Q", at)
        at += len(line)
    path.write_bytes(header + table + b"".join(lines))


def read_exr(path):
    """Scan line files of 32-bit channels, ZIP or ZIPS: {"R": float32 [height][width], ...}."""
    data, at, header = path.read_bytes(), 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        size = struct.unpack_from("<i", rest)[0]
        header[name.decode()] = rest[4 : 4 + size]
        at += len(name) + len(kind) + 6 + size
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    width, height, lines = right - left + 1, bottom - top + 1, {2: 1, 3: 16}[header["compression"][0]]
    names, rest = [], header["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        names, rest = names + [name.decode()], rest[16:]
    planes = {name: np.empty((height, width), np.float32) for name in names}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at + 1):
        y, size = struct.unpack_from("<ii", data, offset)
        block, count = data[offset + 8 : offset + 8 + size], min(lines, height - y + top)
        if size != count * width * 4 * len(names):  # packed: see write_exr
            steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            steps[1:] -= 128
            halves = (np.cumsum(steps) & 255).astype(np.uint8)
            even = (len(halves) + 1) // 2
            whole = np.empty_like(halves)
            whole[0::2], whole[1::2] = halves[:even], halves[even:]
            block = whole.tobytes()
        for i, row in enumerate(np.frombuffer(block, "<f4").reshape(count, len(names), width)):
            for name, values in zip(names, row):
                planes[name][y - top + i] = values
    return planes


class Glb:
    """A binary glTF file: `json` as a dict, and its one buffer."""

    def __init__(self, document=None, buffer=b""):
        self.json, self.buffer = document or {"asset": {"version": "2.0", "generator": "Parhelion tools/oracles"}}, bytearray(buffer)

    @staticmethod
    def read(path):
        data, chunks, at = path.read_bytes(), {}, 12
        while at < len(data):
            size, kind = struct.unpack_from("<II", data, at)
            chunks[kind] = data[at + 8 : at + 8 + size]
            at += 8 + size
        return Glb(json.loads(chunks[0x4E4F534A]), chunks.get(0x004E4942, b""))

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        text, binary = json.dumps(self.json, separators=(",", ":")).encode(), bytes(self.buffer)
        text += b" " * (-len(text) % 4)
        binary += b"\0" * (-len(binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)

    def add(self, collection, value):
        self.json.setdefault(collection, []).append(value)
        return len(self.json[collection]) - 1

    def add_view(self, data):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)})
        self.buffer += data
        return view

    def view(self, index):
        view = self.json["bufferViews"][index]
        at = view.get("byteOffset", 0)
        return bytes(self.buffer[at : at + view["byteLength"]])

    def add_accessor(self, values):
        """A float array [n], [n][2..4] or whole numbers [n]."""
        values = np.asarray(values)
        whole = values.dtype.kind in "iu"
        values = values.astype("<u4" if whole else "<f4")
        kind = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
        accessor = {"bufferView": self.add_view(values.tobytes()), "componentType": 5125 if whole else 5126, "count": len(values), "type": kind}
        if kind == "VEC3":
            accessor |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        return self.add("accessors", accessor)

    def accessor(self, index):
        a = self.json["accessors"][index]
        kind = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[a["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
        view = self.json["bufferViews"][a["bufferView"]]
        item = np.dtype(kind).itemsize
        stride, at = view.get("byteStride", item * width), view.get("byteOffset", 0) + a.get("byteOffset", 0)
        rows = np.lib.stride_tricks.as_strided(np.frombuffer(self.buffer, np.uint8)[at:], (a["count"], item * width), (stride, 1))
        values = np.ascontiguousarray(rows).view(kind).astype(np.float64)
        if a.get("normalized"):
            values /= np.iinfo(np.dtype(kind)).max
        return values if width > 1 else values[:, 0]
