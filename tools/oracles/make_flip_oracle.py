#!/usr/bin/env python3
"""Makes tests/unit/data/flip: small image pairs and what the official FLIP evaluator says about them.

    python3 -m venv venv && venv/bin/pip install flip-evaluator==1.7 numpy
    venv/bin/python tools/oracles/make_flip_oracle.py tests/unit/data/flip

Pairs are drawn from a fixed seed. Pictures are written by the few lines below (PNG; EXR with half channels and ZIPS), so the
files are also inputs that our own writers did not make. expected.tsv has one line a pair: name, range, mean FLIP, the map's
5 %, 50 % and 95 % points and maximum, and for HDR the start and stop exposure and their number.
"""
import struct
import sys
import zlib
from pathlib import Path

import flip_evaluator
import numpy as np

WIDTH, HEIGHT = 96, 64


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_png(path, rgb8):
    height, width, _ = rgb8.shape
    rows = b"".join(b"\0" + row.tobytes() for row in rgb8)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + png_chunk(b"IDAT", zlib.compress(rows, 9)) + png_chunk(b"IEND", b""))


def exr_attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def zip_line(data):
    """OpenEXR's ZIP: even bytes then odd bytes, differences, deflate; stored plain where that is not smaller."""
    b = np.frombuffer(data, np.uint8)
    split = np.concatenate([b[0::2], b[1::2]]).astype(np.int32)
    split[1:] = (split[1:] - split[:-1] + 128) & 255
    packed = zlib.compress(split.astype(np.uint8).tobytes(), 9)
    return packed if len(packed) < len(data) else data


def write_exr(path, rgb):
    """Half channels B, G, R, one compressed scanline a chunk."""
    height, width, _ = rgb.shape
    channels = b"".join(c + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0"
    header += exr_attribute("channels", "chlist", channels) + exr_attribute("compression", "compression", b"\x02")
    header += exr_attribute("dataWindow", "box2i", box) + exr_attribute("displayWindow", "box2i", box)
    header += exr_attribute("lineOrder", "lineOrder", b"\0") + exr_attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += exr_attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    header += exr_attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    lines = []
    for y in range(height):
        data = zip_line(rgb[y, :, ::-1].T.astype("<f2").tobytes())
        lines.append(struct.pack("<ii", y, len(data)) + data)
    offset, table = len(header) + 8 * height, b""
    for line in lines:
        table += struct.pack("<Q", offset)
        offset += len(line)
    path.write_bytes(header + table + b"".join(lines))


def grid():
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    return x / (WIDTH - 1), y / (HEIGHT - 1)


def scene(rng):
    """A smooth picture with an edge, a disk and a checker, in linear light around 0.2."""
    x, y = grid()
    rgb = np.stack([0.05 + 0.5 * x, 0.1 + 0.3 * y, 0.3 - 0.2 * x * y], -1)
    rgb[y > 0.7] = [0.6, 0.2, 0.1]
    rgb[(x - 0.3) ** 2 + (0.7 * y - 0.25) ** 2 < 0.02] = [0.1, 0.4, 0.8]
    checker = ((x * 24).astype(int) + (y * 16).astype(int)) % 2 == 1
    rgb[checker & (x > 0.7) & (y < 0.5)] = 0.9
    return rgb * (1 + 0.02 * rng.standard_normal(rgb.shape))


def to_8_bit(linear):
    linear = np.clip(linear, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(encoded * 255).astype(np.uint8)


def ldr_pairs(rng):
    base = scene(rng)
    yield "ldr_noise", base, base * (1 + 0.25 * rng.standard_normal(base.shape))
    shifted = np.roll(base, 2, axis=1)
    shifted[:, :, 2] *= 1.3
    yield "ldr_shift", base, shifted


def hdr_pairs(rng):
    base = scene(rng) * 3
    base[20:24, 30:34] = 400.0
    fireflies = base * rng.gamma(16, 1 / 16, base.shape)
    for _ in range(12):
        fireflies[rng.integers(HEIGHT), rng.integers(WIDTH)] *= 200
    yield "hdr_fireflies", base, fireflies
    x, _ = grid()
    stops = np.repeat((2.0 ** (18 * x - 9))[:, :, None], 3, axis=2)
    yield "hdr_gradient", stops, stops * (1 + 0.2 * np.sin(40 * x))[:, :, None]
    night = scene(rng) * 0.02
    night[:, : WIDTH // 3] = 0
    yield "hdr_third_black", night, night + np.where(rng.random(night.shape) < 0.05, 0.02, 0)
    # More than half black: the evaluator's exposures mean nothing here; only the lit half's exposures are right.
    half = scene(rng)
    half[:, : WIDTH * 3 // 5] = 0
    yield "hdr_half_black", half, half * (1 + 0.3 * rng.standard_normal(half.shape)).clip(0)


def write_pair(folder, name, is_hdr, reference, test, out):
    pair = []
    for role, rgb in (("reference", reference), ("test", test)):
        if is_hdr:
            rgb = np.clip(rgb, 0, 60000).astype(np.float16).astype(np.float32)
            write_exr(folder / f"{name}.{role}.exr", rgb)
        else:
            encoded = to_8_bit(rgb)
            write_png(folder / f"{name}.{role}.png", encoded)
            rgb = encoded.astype(np.float32) / 255
        pair.append(np.ascontiguousarray(rgb))
    parameters = {}
    if name == "hdr_half_black":
        # The exposures of the lit pixels alone: what the evaluator finds for the picture without its black part.
        lit = [np.ascontiguousarray(image[:, WIDTH * 3 // 5:]) for image in pair]
        _, _, found = flip_evaluator.evaluate(lit[0], lit[1], "HDR", applyMagma=False)
        parameters = {key: found[key] for key in ("startExposure", "stopExposure", "numExposures")}
        _, unguided, _ = flip_evaluator.evaluate(pair[0], pair[1], "HDR", applyMagma=False)
        print(f"{name}: the evaluator's own exposures give {unguided}")
    flip_map, mean, used = flip_evaluator.evaluate(pair[0], pair[1], "HDR" if is_hdr else "LDR", applyMagma=False, parameters=parameters)
    percentiles = np.percentile(flip_map, [5, 50, 95, 100])
    row = [name, "HDR" if is_hdr else "LDR", f"{mean:.7f}"] + [f"{v:.6f}" for v in percentiles]
    row += [f"{used['startExposure']:.6f}", f"{used['stopExposure']:.6f}", str(used["numExposures"])] if is_hdr else ["0", "0", "0"]
    out.append("\t".join(row))
    print(out[-1])


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(2021)
    out = ["name\trange\tmean\tp5\tp50\tp95\tmax\tstart\tstop\texposures"]
    for pair in ldr_pairs(rng):
        write_pair(folder, pair[0], False, pair[1], pair[2], out)
    for pair in hdr_pairs(rng):
        write_pair(folder, pair[0], True, pair[1], pair[2], out)
    (folder / "expected.tsv").write_text("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
