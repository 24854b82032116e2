#!/usr/bin/env python3
"""Makes tests/golden/oracles/microfacet_values.tsv and microfacet_albedos.tsv from tools/oracles/microfacet_model.py.

    python3 -m venv venv && venv/bin/pip install numpy scipy
    venv/bin/python tools/oracles/make_microfacet_values.py tests/golden/oracles

Values: one line a point, f(o, i) without the cosine as that module says. kind is
    conductor         Schlick from the colour to white
    coated            a dielectric of index eta over a diffuse base of that colour; f90 = 1, f0 = ((eta - 1) / (eta + 1))^2
    glass             a rough boundary; height-correlated masking in both lobes
    glass_separable   the same with the product of both one-sided maskings in both lobes
compensation says whether light that scatters more than once is put back (Kulla and Conty 2017; none for glass). Half of the
directions are spread over the sphere, half lie in the lobe. Directions are floats, written exactly.

Albedos: what a surface sends back of a white surrounding, seen under the cosine mu; mean is over 2 mu d mu. one: f0 = 1, f90 = 1
(E of Kulla and Conty). glossy: f0 = 0.04, f90 = 1. Both single scattering. glass_*: energy that a boundary of eta = 1.5 (or
1 / 1.5, seen from within) reflects and transmits.
"""
import sys
from pathlib import Path

import numpy as np

import microfacet_model as model

POINTS = {"conductor": 60, "coated": 60, "glass": 80}
ROUGHNESS = [0.2, 0.23, 0.31, 0.4, 0.45, 0.52, 0.6, 0.67, 0.75, 0.83, 0.91, 1.0]
ETA = [1.5, 1 / 1.5, 1.33, 1 / 1.33, 2.0, 1.5, 1 / 1.5]


def sphere_point(random, lowest=0.05):
    z, phi = random.uniform(lowest, 1), random.uniform(0, 2 * np.pi)
    s = np.sqrt(1 - z * z)
    return np.array([s * np.cos(phi), s * np.sin(phi), z])


def lobe_point(random, o, alpha, eta):
    """A direction in the reflected (eta None) or refracted lobe of o."""
    while True:
        t = alpha * np.sqrt(random.uniform(0, 0.9))
        phi = random.uniform(0, 2 * np.pi)
        h = model.normalize(np.array([t * np.cos(phi), t * np.sin(phi), 1]))
        oh = o @ h
        if eta is None:
            i = 2 * oh * h - o
            good = oh > 0 and i[2] > 0.05
        else:
            cos2_t = 1 - (1 - oh * oh) / eta**2
            i = (oh / eta - np.sqrt(max(cos2_t, 0))) * h - o / eta
            good = oh > 0 and cos2_t > 0 and i[2] < -0.05
        if good:
            return i


def as_float(v):
    return np.asarray(v, np.float32).astype(np.float64)


def text(values):
    return "\t".join(f"{v:.9g}" for v in np.atleast_1d(values))


def values():
    random = np.random.default_rng(1)
    yield "\t".join(["kind", "compensation", "roughness", "eta", *("colour_" + c for c in "rgb"), *("o_" + c for c in "xyz"), *("i_" + c for c in "xyz"),
                     *("f_" + c for c in "rgb")])
    for kind, count in POINTS.items():
        for n in range(count):
            roughness = ROUGHNESS[n % len(ROUGHNESS)]
            alpha = roughness**2
            o = sphere_point(random)
            through = kind == "glass" and n % 4 >= 1  # a quarter reflects
            eta = float(as_float(ETA[n // 4 % len(ETA)])) if kind == "glass" else [1.5, 1.5, 1.33, 1.8][n // 12 % 4]
            if n % 2 == 0:
                i = sphere_point(random) * [1, 1, -1 if through else 1]
            else:
                if through and eta < 1:  # else all is reflected
                    o = sphere_point(random, np.sqrt(max(0.05, 1.2 - eta**2)))
                i = lobe_point(random, o, alpha, eta if through else None)
            o, i = as_float(o), as_float(i)
            colour = as_float(random.uniform(0, 1, 3)) if n % 3 else np.ones(3)
            start = [text([roughness, eta]), text(colour), text(o), text(i)]
            if kind == "glass":
                for name, separable in (("glass", False), ("glass_separable", True)):
                    yield "\t".join([name, "0", start[0], text(np.ones(3)), *start[2:], text(np.full(3, model.glass(o, i, alpha, eta, separable)))])
                continue
            for compensated in (False, True):
                if kind == "conductor":
                    f = model.conductor(o, i, alpha, colour, compensated)
                else:
                    f = model.coated_diffuse(o, i, alpha, ((eta - 1) / (eta + 1)) ** 2, colour, compensated)
                yield "\t".join([kind, str(int(compensated)), *start, text(f)])


def albedos():
    yield "\t".join(["roughness", "mu", "one", "glossy", "one_mean", "glossy_mean", "glass_reflected", "glass_transmitted", "inside_reflected", "inside_transmitted"])
    for roughness in (0.2, 0.3, 0.4, 0.55, 0.7, 0.85, 1.0):
        alpha = roughness**2
        for mu in (0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 0.999):
            glass = *model.glass_albedo(mu, alpha, 1.5), *model.glass_albedo(mu, alpha, 1 / 1.5)
            row = [model.albedo(mu, alpha), model.specular_albedo(mu, alpha, 0.04, False), model.mean_albedo(alpha), model.mean_specular_albedo(alpha, 0.04, False)]
            yield "\t".join([f"{roughness}", f"{mu}", *(f"{v:.5f}" for v in (*row, *glass))])


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, lines in (("values", values()), ("albedos", albedos())):
        (folder / f"microfacet_{name}.tsv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
