"""The surfaces of microfacet_model.py as a plugin for Mitsuba 3 ("rough_lobes"), in its LLVM variants. Written from the same papers.

    {"type": "rough_lobes", "kind": "conductor" | "coated" | "glass", "roughness": r, "eta": n, "colour": rgb, "compensated": bool,
     "separable": bool}

eta is the index of the side away from the normal over that on the normal's side. Conductors and coats are black from behind.
What is slow to integrate (directional albedos) is looked up in a table over sqrt(cos) that microfacet_model fills.
"""
import drjit as dr
import mitsuba as mi
import numpy as np

import microfacet_model as model

TABLE = 128             # entries; error of linear interpolation about 1e-4
model.QUADRATURE = 192  # as exact


def smith_lambda(cos_theta, alpha):
    c2 = dr.maximum(dr.square(cos_theta), 1e-12)
    return 0.5 * (dr.sqrt(1 + alpha**2 * (1 - c2) / c2) - 1)


def ggx(h, alpha):
    t = dr.square(h.x) + dr.square(h.y) + dr.square(alpha * h.z)  # sin^2 + alpha^2 cos^2, without cancellation
    return dr.select(h.z > 0, alpha**2 / (dr.pi * dr.square(t)), 0)


def fresnel(cos_o, eta):
    """Reflectance and the cosine behind the boundary."""
    cos2_t = 1 - (1 - dr.square(cos_o)) / dr.square(eta)
    cos_t = dr.safe_sqrt(cos2_t)
    parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t)
    perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t)
    return dr.select(cos2_t <= 0, 1, 0.5 * (dr.square(parallel) + dr.square(perpendicular))), cos_t


def visible_normal(o, alpha, sample):
    view = dr.normalize(mi.Vector3f(alpha * o.x, alpha * o.y, o.z))
    across = dr.square(view.x) + dr.square(view.y)
    t1 = dr.select(across > 1e-12, mi.Vector3f(-view.y, view.x, 0) * dr.rsqrt(dr.maximum(across, 1e-12)), mi.Vector3f(1, 0, 0))
    t2 = dr.cross(view, t1)
    r, phi = dr.sqrt(sample.x), dr.two_pi * sample.y
    p1, s = r * dr.cos(phi), 0.5 * (1 + view.z)
    p2 = (1 - s) * dr.safe_sqrt(1 - dr.square(p1)) + s * r * dr.sin(phi)
    m = p1 * t1 + p2 * t2 + dr.safe_sqrt(1 - dr.square(p1) - dr.square(p2)) * view
    return dr.normalize(mi.Vector3f(alpha * m.x, alpha * m.y, dr.maximum(m.z, 1e-7)))


def visible_normal_density(o, h, alpha):
    return dr.select(dr.dot(o, h) > 0, ggx(h, alpha) * dr.dot(o, h) / (o.z * (1 + smith_lambda(o.z, alpha))), 0)


class Table:
    """A function of the cosine, linear between its values at even steps of sqrt(cos)."""

    def __init__(self, function):
        at = np.maximum(np.linspace(0, 1, TABLE) ** 2, 1e-4)
        self.values = mi.Float(np.array([function(float(mu)) for mu in at], np.float32))

    def __call__(self, cos_theta):
        at = dr.sqrt(dr.clip(cos_theta, 0, 1)) * (TABLE - 1)
        low = dr.minimum(mi.UInt32(at), TABLE - 2)
        a, b = (dr.gather(mi.Float, self.values, low + k) for k in (0, 1))
        return dr.lerp(a, b, at - mi.Float(low))


class RoughLobes(mi.BSDF):
    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.kind, self.eta = props["kind"], props.get("eta", 1.5)
        self.alpha, self.separable = props["roughness"] ** 2, props.get("separable", False)
        self.compensated = props.get("compensated", False)
        colour = props.get("colour", mi.ScalarColor3f(1.0))
        self.colour = [float(colour[c]) for c in range(3)]
        front, back = mi.BSDFFlags.FrontSide, mi.BSDFFlags.BackSide
        if self.kind == "glass":
            self.m_components = [mi.BSDFFlags.GlossyReflection | front | back, mi.BSDFFlags.GlossyTransmission | mi.BSDFFlags.NonSymmetric | front | back]
        else:
            self.m_components = [mi.BSDFFlags.GlossyReflection | front]
            self.prepare()
        self.m_flags = self.m_components[0] | self.m_components[-1]

    def prepare(self):
        alpha = self.alpha
        self.f0 = self.colour if self.kind == "conductor" else [((self.eta - 1) / (self.eta + 1)) ** 2] * 3
        self.lost = Table(lambda mu: 1 - model.albedo(mu, alpha)) if self.compensated else None
        self.again = [float(model.multiple_fresnel(f, alpha) / (np.pi * (1 - model.mean_albedo(alpha)))) for f in self.f0]
        if self.kind == "coated":
            self.passed = Table(lambda mu: 1 - model.specular_albedo(mu, alpha, self.f0[0], self.compensated))
            self.base = [float(c / (np.pi * (1 - model.mean_specular_albedo(alpha, self.f0[0], self.compensated)))) for c in self.colour]
        # A cosine-spread share of the samples for all that is not single scattering; only the noise depends on it.
        self.wide = 0.6 if self.kind == "coated" else (0.25 if self.compensated else 0.02)

    def masking(self, o, i, same_side):
        lo, li = smith_lambda(o.z, self.alpha), smith_lambda(i.z, self.alpha)
        if self.separable:
            return 1 / ((1 + lo) * (1 + li))
        if same_side:
            return 1 / (1 + lo + li)
        return dr.exp(dr.lgamma(1 + lo) + dr.lgamma(1 + li) - dr.lgamma(2 + lo + li))

    def opaque(self, o, i):
        """f cos, pdf; both directions on the normal's side."""
        h = dr.normalize(o + i)
        oh = dr.dot(o, h)
        valid = (o.z > 0) & (i.z > 0) & (oh > 0)
        single = ggx(h, self.alpha) * self.masking(o, i, True) / (4 * o.z * i.z)
        grazing = (1 - dr.minimum(oh, 1)) ** 5
        value = mi.Color3f(*(single * (f + (1 - f) * grazing) for f in self.f0))
        if self.compensated:
            value += mi.Color3f(*self.again) * self.lost(o.z) * self.lost(i.z)
        if self.kind == "coated":
            value += mi.Color3f(*self.base) * self.passed(o.z) * self.passed(i.z)
        pdf = self.wide * i.z * dr.inv_pi + (1 - self.wide) * visible_normal_density(o, h, self.alpha) / (4 * oh)
        return dr.select(valid, value * i.z, 0), dr.select(valid, pdf, 0)

    def glass(self, o, i):
        """f cos, pdf; o may come from either side, and is turned to the front."""
        eta, side = dr.select(o.z > 0, self.eta, 1 / self.eta), dr.sign(o.z)
        o, i = mi.Vector3f(o.x, o.y, o.z * side), mi.Vector3f(i.x, i.y, i.z * side)
        reflects = i.z > 0
        h = dr.normalize(o + i * dr.select(reflects, 1, eta))
        h *= dr.sign(h.z)
        oh, ih = dr.dot(o, h), dr.dot(i, h)
        valid = (o.z > 0) & (i.z != 0) & (oh > 0) & dr.select(reflects, ih > 0, ih < 0)
        f, _ = fresnel(oh, eta)
        d = ggx(h, self.alpha)
        back = f * d * self.masking(o, i, True) / (4 * o.z)
        denominator = dr.square(oh + eta * ih)
        through = (1 - f) * d * self.masking(o, i, False) * dr.abs(oh * ih) / (o.z * denominator)
        density = visible_normal_density(o, h, self.alpha)
        pdf = density * dr.select(reflects, f / (4 * oh), (1 - f) * dr.square(eta) * dr.abs(ih) / denominator)
        return dr.select(valid, mi.Color3f(dr.select(reflects, back, through)), 0), dr.select(valid, pdf, 0)

    def both(self, o, i):
        return self.glass(o, i) if self.kind == "glass" else self.opaque(o, i)

    def sample(self, ctx, si, sample1, sample2, active=True):
        side = dr.sign(si.wi.z) if self.kind == "glass" else mi.Float(1)
        o = mi.Vector3f(si.wi.x, si.wi.y, si.wi.z * side)
        h = visible_normal(o, self.alpha, sample2)
        oh = dr.dot(o, h)
        i = 2 * oh * h - o
        bs = mi.BSDFSample3f()
        bs.eta, through = mi.Float(1), mi.Mask(False)
        if self.kind == "glass":
            eta = dr.select(si.wi.z > 0, self.eta, 1 / self.eta)
            f, cos_t = fresnel(oh, eta)
            through = sample1 >= f
            i = dr.select(through, (oh / eta - cos_t) * h - o / eta, i)
            active &= dr.select(through, i.z < 0, i.z > 0)
            bs.eta = dr.select(through, eta, 1)
        else:
            i = dr.select(sample1 < self.wide, mi.warp.square_to_cosine_hemisphere(sample2), i)
            active &= (o.z > 0) & (i.z > 0)
        bs.wo = mi.Vector3f(i.x, i.y, i.z * side)
        value, bs.pdf = self.both(si.wi, bs.wo)
        bs.sampled_component = dr.select(through, mi.UInt32(1), mi.UInt32(0))
        bs.sampled_type = dr.select(through, mi.UInt32(+mi.BSDFFlags.GlossyTransmission), mi.UInt32(+mi.BSDFFlags.GlossyReflection))
        active &= bs.pdf > 0
        bs.pdf = dr.select(active, bs.pdf, 0)
        return bs, dr.select(active, value / bs.pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        return dr.select(active, self.both(si.wi, wo)[0], 0)

    def pdf(self, ctx, si, wo, active=True):
        return dr.select(active, self.both(si.wi, wo)[1], 0)

    def eval_pdf(self, ctx, si, wo, active=True):
        value, pdf = self.both(si.wi, wo)
        return dr.select(active, value, 0), dr.select(active, pdf, 0)

    def to_string(self):
        return f"RoughLobes[{self.kind}, alpha {self.alpha}]"


def register():
    mi.register_bsdf("rough_lobes", RoughLobes)
