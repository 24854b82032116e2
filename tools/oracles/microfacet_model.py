"""Rough surfaces in plain numpy, written from the papers alone: what the renderer's BSDF is held against.

Local frame, normal +Z. `o` points to the viewer (o.z > 0), `i` to where light comes from; i.z < 0 is transmission. Values are
f(o, i) without the cosine, for radiance: what is seen through a boundary is scaled by 1 / eta^2, eta = index on the far side of
the surface over the index on the viewer's side. alpha = roughness^2. Arrays broadcast; vectors have their last axis of size 3.

    GGX, its Jacobians, rough glass     Walter, Marschner, Li, Torrance 2007, Microfacet models for refraction through rough surfaces
    Smith's Lambda, height correlation  Heitz 2014, Understanding the masking-shadowing function; for opposite sides (Beta function)
                                        Heitz, Hanika, d'Eon, Dachsbacher 2016, Multiple-scattering microfacet BSDFs with the Smith model
    visible normals                     Heitz 2018, Sampling the GGX distribution of visible normals
    Fresnel of metals                   Schlick 1994
    energy compensation                 Kulla and Conty 2017, Revisiting physically based shading at Imageworks
    diffuse under a specular layer      Ashikhmin and Shirley 2000, with directional albedos as Kelemen and Szirmay-Kalos 2001
"""
from functools import lru_cache

import numpy as np
from scipy.special import beta

QUADRATURE = 256  # points each way in directional albedos: errors about 1e-5
MEANS = 48        # cosines in their means


def normalize(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def ggx(cos_h, alpha):
    """Density of microfacet normals per solid angle."""
    c2 = cos_h * cos_h
    return np.where(cos_h > 0, alpha**2 / (np.pi * (c2 * alpha**2 + (1 - c2)) ** 2), 0.0)


def smith_lambda(cos_theta, alpha):
    c2 = np.maximum(cos_theta * cos_theta, 1e-300)
    return 0.5 * (np.sqrt(1 + alpha**2 * (1 - c2) / c2) - 1)


def masking(o, i, alpha, separable=False):
    """Both visible: G2. Directions on one side of the surface share heights, directions on opposite sides exclude them."""
    lo, li = smith_lambda(o[..., 2], alpha), smith_lambda(i[..., 2], alpha)
    if separable:
        return 1 / ((1 + lo) * (1 + li))
    with np.errstate(over="ignore", under="ignore"):
        return np.where(i[..., 2] > 0, 1 / (1 + lo + li), beta(1 + lo, 1 + li))


def schlick(f0, cos_h, f90=1.0):
    return f0 + (f90 - f0) * (1 - cos_h) ** 5


def dielectric_fresnel(cos_o, eta):
    """Unpolarised reflectance; cos_o > 0 on the viewer's side, eta = far index over near index. 1 at total reflection."""
    sin2_t = (1 - cos_o**2) / eta**2
    cos_t = np.sqrt(np.maximum(1 - sin2_t, 0))
    parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t)
    perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t)
    return np.where(sin2_t >= 1, 1.0, 0.5 * (parallel**2 + perpendicular**2))


def specular(o, i, alpha, fresnel, separable=False):
    """Single scattering by mirrors; `fresnel` maps the cosine between i and the half vector to a reflectance."""
    h = normalize(o + i)
    value = ggx(h[..., 2], alpha) * masking(o, i, alpha, separable) / (4 * np.abs(o[..., 2] * i[..., 2]))
    return np.where(i[..., 2] > 0, value * fresnel(np.sum(h * i, -1)), 0.0)


def glass(o, i, alpha, eta, separable=False):
    """Both lobes of a rough boundary between two clear media; the side of i chooses."""
    reflected = specular(o, i, alpha, lambda c: dielectric_fresnel(c, eta), separable)
    h = normalize(o + eta * i)
    h = h * np.sign(h[..., 2:3])
    oh, ih = np.sum(o * h, -1), np.sum(i * h, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.abs(oh * ih) / np.abs(o[..., 2] * i[..., 2]) / (oh + eta * ih) ** 2  # viewer's index squared: radiance
        value = scale * (1 - dielectric_fresnel(np.abs(oh), eta)) * ggx(h[..., 2], alpha) * masking(o, i, alpha, separable)
    transmitted = np.where((oh > 0) & (ih < 0), value, 0.0)  # else one of the two sees the facet from its wrong side
    return np.where(i[..., 2] > 0, reflected, transmitted)


def visible_normals(mu, alpha, n):
    """Half vectors as seen from (sin, 0, mu) and their weights (sum 1): Gauss's points over the disc of visible normals.

    The disc's radius is sqrt(1 - v^3): dense at the rim, where small roughness keeps its few steep facets.
    """
    x, w = np.polynomial.legendre.leggauss(n)
    v, phi = np.meshgrid(0.5 * (x + 1), (np.arange(n) + 0.5) / n * np.pi, indexing="ij")  # half of the disc: the rest mirrors it
    weights = np.broadcast_to((0.5 * w * 3)[:, None], v.shape) * v**2 / n
    view = normalize(np.array([alpha * np.sqrt(1 - mu * mu), 0, mu]))
    t1 = np.array([0.0, 1.0, 0.0])
    t2 = np.cross(view, t1)
    r, s = np.sqrt(1 - v**3), 0.5 * (1 + view[2])
    p1 = r * np.sin(phi)
    p2 = (1 - s) * np.sqrt(1 - p1 * p1) + s * r * np.cos(phi)
    p3 = np.sqrt(np.maximum(0, 1 - p1 * p1 - p2 * p2))
    m = p1[..., None] * t1 + p2[..., None] * t2 + p3[..., None] * view
    return normalize(np.stack([alpha * m[..., 0], alpha * m[..., 1], np.maximum(m[..., 2], 1e-300)], -1)), weights


@lru_cache(maxsize=None)
def albedo_parts(mu, alpha, n):
    """Directional albedo of single scattering with Schlick's Fresnel is (first) f0 + (second) f90."""
    o = np.array([np.sqrt(1 - mu * mu), 0, mu])
    h, weights = visible_normals(mu, alpha, n)
    oh = np.sum(o * h, -1)
    i_z = 2 * oh * h[..., 2] - mu
    lo, li = smith_lambda(np.float64(mu), alpha), smith_lambda(i_z, alpha)
    weight = np.where(i_z > 0, (1 + lo) / (1 + lo + li), 0.0)  # G2 / G1, height-correlated
    grazing = (1 - oh) ** 5
    return float(np.sum(weights * weight * (1 - grazing))), float(np.sum(weights * weight * grazing))


def _mean(function):
    """2 * integral over mu in [0, 1] of function(mu) mu: what a diffuse light on all sides sees."""
    x, w = np.polynomial.legendre.leggauss(MEANS)
    mu = 0.5 * (x + 1)
    return sum(wk * mk * function(float(mk)) for mk, wk in zip(mu, w))


@lru_cache(maxsize=None)
def albedo(mu, alpha):
    """E: directional albedo of mirrors that lose nothing; what is missing to 1 scattered more than once."""
    return sum(albedo_parts(mu, alpha, QUADRATURE))


@lru_cache(maxsize=None)
def mean_albedo_parts(alpha):
    return tuple(_mean(lambda mu, k=k: albedo_parts(mu, alpha, QUADRATURE // 2)[k]) for k in (0, 1))


def mean_albedo(alpha):
    return sum(mean_albedo_parts(alpha))


def multiple_fresnel(f0, alpha, f90=1.0):
    """Colour of all light that scattered more than once (Kulla and Conty 2017, slide 16, with the mean Fresnel squared)."""
    mean = f0 + (f90 - f0) / 21
    e = mean_albedo(alpha)
    return mean**2 * e / (1 - mean * (1 - e))


def multiple_scattering(mu_o, mu_i, alpha, f0):
    return multiple_fresnel(f0, alpha) * (1 - albedo(mu_o, alpha)) * (1 - albedo(mu_i, alpha)) / (np.pi * (1 - mean_albedo(alpha)))


def specular_albedo(mu, alpha, f0, compensated):
    a, b = albedo_parts(mu, alpha, QUADRATURE)
    single = f0 * a + b
    return single + (multiple_fresnel(f0, alpha) * (1 - albedo(mu, alpha)) if compensated else 0)


def mean_specular_albedo(alpha, f0, compensated):
    a, b = mean_albedo_parts(alpha)
    single = f0 * a + b
    return single + (multiple_fresnel(f0, alpha) * (1 - mean_albedo(alpha)) if compensated else 0)


def conductor(o, i, alpha, colour, compensated):
    """One pair of directions, o and i of shape (3,); colour is the reflectance straight on."""
    if i[2] <= 0:
        return np.zeros(3)
    value = np.array([float(specular(o, i, alpha, lambda c, f0=f0: schlick(f0, c))) for f0 in colour])
    return value + multiple_scattering(float(o[2]), float(i[2]), alpha, np.asarray(colour)) if compensated else value


def coated_diffuse(o, i, alpha, f0, colour, compensated):
    """Diffuse light that a dielectric's specular lobe lets in and out; the lobe is the conductor's with the scalar f0."""
    if i[2] <= 0:
        return np.zeros(3)
    lobe = conductor(o, i, alpha, np.full(3, f0), compensated)
    through_o = 1 - specular_albedo(float(o[2]), alpha, f0, compensated)
    through_i = 1 - specular_albedo(float(i[2]), alpha, f0, compensated)
    return lobe + np.asarray(colour) / np.pi * through_o * through_i / (1 - mean_specular_albedo(alpha, f0, compensated))


def glass_albedo(mu, alpha, eta, separable=False, n=256):
    """(reflected, transmitted) share of energy, eta^2 undone: their sum is 1 less what scattered more than once."""
    o = np.array([np.sqrt(1 - mu * mu), 0, mu])
    h, weights = visible_normals(mu, alpha, n)
    oh = np.sum(o * h, -1)
    f = dielectric_fresnel(oh, eta)
    lo = smith_lambda(np.float64(mu), alpha)

    def mean(i, share, side):
        g = masking(np.broadcast_to(o, i.shape), i, alpha, separable) * (1 + lo)
        return float(np.sum(weights * np.where(side * i[..., 2] > 0, share * g, 0.0)))

    cos_t = np.sqrt(np.maximum(0, 1 - (1 - oh**2) / eta**2))
    refracted = (oh / eta - cos_t)[..., None] * h - o / eta
    return mean(2 * oh[..., None] * h - o, f, 1), mean(refracted, 1 - f, -1)
