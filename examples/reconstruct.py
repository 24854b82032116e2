#!/usr/bin/env python3
"""A reconstruction of one's own, from files: reads a frame as docs/reconstruction.md ("From files") has it, and writes its picture.

    pip install numpy OpenEXR
    parhelion render builtin:diorama --renderer realtime --denoise builtin --frames 8 --size 480x270 --dataset set --reference-spp 256
    python examples/reconstruct.py set/frame.0007.exr mine.exr
    parhelion compare mine.exr set/reference.0007.exr

What stands in `body` is the mean of the neighbours that show the same surface: put yours there.
"""
import json
import sys

import numpy as np
import OpenEXR


def read(path):
    file = OpenEXR.File(path, separate_channels=True)
    planes = {name.removeprefix("reconstruction."): channel.pixels for name, channel in file.channels().items()}

    def layer(name, suffixes="RGB"):
        return np.stack([planes[f"{name}.{s}"].astype(np.float32) for s in suffixes], axis=-1)

    frame = {name: layer(name) for name in ("diffuse", "specular", "emission", "albedo", "specular_albedo")}
    frame["normal"] = layer("normal", "XYZ")
    frame["depth"] = planes["depth"]
    frame["surface"] = planes["surface"]
    return frame, json.loads(file.header()["reconstruction"])


def body(frame, radius=3):
    """Diffuse and specular light, demodulated and pre-exposed, without noise."""
    height, width = frame["depth"].shape
    sums = {"diffuse": 0.0, "specular": 0.0}
    weights = 0.0
    depth = np.where(np.isinf(frame["depth"]), 1e6, frame["depth"])
    rows, columns = np.mgrid[0:height, 0:width]
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            there = np.clip(rows + dy, 0, height - 1), np.clip(columns + dx, 0, width - 1)
            same = frame["surface"][there] == frame["surface"]
            same &= np.sum(frame["normal"][there] * frame["normal"], axis=-1) > 0.9
            same &= np.abs(depth[there] - depth) < 0.05 * depth
            same |= (dx == 0) & (dy == 0)
            weights = weights + same
            for signal in sums:
                sums[signal] = sums[signal] + np.where(same[..., None], frame[signal][there], 0.0)
    return {signal: total / weights[..., None] for signal, total in sums.items()}


def main(source, target):
    frame, words = read(source)
    clean = body(frame)
    light = clean["diffuse"] * frame["albedo"] + clean["specular"] * frame["specular_albedo"] + frame["emission"]
    nits = np.ascontiguousarray(light / words["exposure"], dtype=np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": OpenEXR.Channel("RGB", nits)}).write(target)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: reconstruct.py FRAME.exr PICTURE.exr")
    main(*sys.argv[1:])
