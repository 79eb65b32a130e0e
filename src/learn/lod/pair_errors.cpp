// SPDX-License-Identifier: MIT
#include "learn/lod/pair_errors.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "raster/kernel/constants.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "learn/lod/pair_errors.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::pair_lanes {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<D>;
using M = hn::Mask<D>;
using V = hn::Vec<D>;

/// A float per lane. drawn() and ellipsoid_area() repeat the formulas of merging.cpp.
struct F {
  V v;
  F() = default;
  HWY_INLINE F(V values) : v(values) {}
  HWY_INLINE F(float value) : v(hn::Set(D(), value)) {}
  friend HWY_INLINE F operator+(F a, F b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE F operator-(F a, F b) { return hn::Sub(a.v, b.v); }
  friend HWY_INLINE F operator*(F a, F b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE F operator/(F a, F b) { return hn::Div(a.v, b.v); }
};
HWY_INLINE F larger(F a, F b) { return hn::Max(a.v, b.v); }
HWY_INLINE F smaller(F a, F b) { return hn::Min(a.v, b.v); }
HWY_INLINE M above(F a, F b) { return hn::Gt(a.v, b.v); }
HWY_INLINE F choose(M mask, F yes, F no) { return hn::IfThenElse(mask, yes.v, no.v); }

/// 1 / sqrt(a) for normal a > 0, with the same bits on all instruction sets and much faster than
/// the instructions of division and root: from the exponent by three of Newton's steps.
HWY_INLINE F inverse_root(F a) {
  const I i;
  const auto guess = hn::Sub(hn::Set(i, 0x5f375a86), hn::ShiftRight<1>(hn::BitCast(i, a.v)));
  F y = hn::BitCast(D(), guess);
  const F half = F(0.5f) * a;
  for (int step = 0; step < 3; ++step) y = y * (F(1.5f) - half * y * y);
  return y;
}
HWY_INLINE F root(F a) { return a * inverse_root(a); }

/// 2^y for y <= 0.
HWY_INLINE F exp2(F y) {
  const D d;
  y = larger(y, F(-126.0f));
  const F shifted = y + F(kRoundToInteger);
  const F whole = shifted - F(kRoundToInteger), f = y - whole;
  const F power =
      F(1) +
      f * (F(kExp2C1) + f * (F(kExp2C2) + f * (F(kExp2C3) + f * (F(kExp2C4) + f * F(kExp2C5)))));
  const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(I(), whole.v), hn::Set(I(), 127)));
  return power * F(hn::BitCast(d, exponent));
}

/// ln x for normal x > 0.
HWY_INLINE F logarithm(F x) {
  const D d;
  const I i;
  // The fraction is within sqrt(1/2) to sqrt(2).
  const auto bits = hn::BitCast(i, x.v), base = hn::Set(i, 0x3f3504f3);
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, base));
  const F fraction = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const F t = (fraction - F(1)) / (fraction + F(1)), tt = t * t;
  const F series = F(1) + tt * (F(1.0f / 3) + tt * (F(1.0f / 5) + tt * F(1.0f / 7)));
  return F(hn::ConvertTo(d, exponent)) * F(static_cast<float>(kLn2)) + F(2) * t * series;
}

struct Cov {
  F xx, xy, xz, yy, yz, zz;
};

HWY_INLINE F ellipsoid_area(const Cov& c) {
  const F trace = c.xx + c.yy + c.zz, s = F(1) / larger(trace, F(1e-36f));
  const F xx = c.xx * s, xy = c.xy * s, xz = c.xz * s, yy = c.yy * s, yz = c.yz * s, zz = c.zz * s;
  const F kx = yy * zz - yz * yz, ky = xx * zz - xz * xz, kz = xx * yy - xy * xy;
  const F first = larger(kx + ky + kz, F(1e-12f));
  const F second = xx * kx - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const F evenness = smaller(larger(F(3) * second / (first * first), F(0)), F(1));
  return F(4 * std::numbers::pi_v<float>) * trace * root(first * F(1.0f / 3)) *
         (F(0.866f) + F(0.134f) * evenness);
}

struct Node {
  F x, y, z, mass, opacities, leaf;
  Cov covariance;
};

/// As it is drawn with a filter.
struct Shown {
  F opacity;
  Cov covariance;
};

HWY_INLINE Shown drawn(const Node& node, F v) {
  const Cov& c = node.covariance;
  const F area = ellipsoid_area({c.xx + v, c.xy, c.xz, c.yy + v, c.yz, c.zz + v});
  const F mass = node.mass + F(4 * std::numbers::pi_v<float>) * v * node.opacities;
  const F m = choose(above(area, F(0)), mass / larger(area, F(1e-36f)), F(0));
  const M is_leaf = above(node.leaf, F(0));
  const F x = larger(m, F(1)) + F(0.5f);
  const F harmonic = logarithm(x) + F(std::numbers::egamma_v<float>) + F(1) / (F(24) * x * x);
  const F growth = choose(hn::Or(is_leaf, hn::Not(above(m, F(1)))), F(1), harmonic);
  const F more = (growth - F(1)) * v;
  return {choose(is_leaf, node.opacities, smaller(m, F(1))),
          {c.xx * growth + more, c.xy * growth, c.xz * growth, c.yy * growth + more, c.yz * growth,
           c.zz * growth + more}};
}

struct Flat {
  F xx, xy, yy;
  HWY_INLINE F determinant() const { return larger(xx * yy - xy * xy, F(1e-36f)); }
};

/// The integral of the product of two Gaussians / 2 pi / the roots of both determinants.
HWY_INLINE F overlap(const Flat& a, const Flat& b, F dx, F dy) {
  const Flat sum{a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
  const F r = inverse_root(sum.determinant());
  const F q = (sum.yy * dx * dx - F(2) * sum.xy * dx * dy + sum.xx * dy * dy) * (r * r);
  return r * exp2(F(-0.5f * static_cast<float>(kLog2E)) * q);
}

HWY_INLINE Node load(const float* const* planes, std::size_t i) {
  const D d;
  const auto at = [&](std::size_t k) { return F(hn::LoadU(d, planes[k] + i)); };
  return {at(0), at(1), at(2), at(9), at(10), at(11), {at(3), at(4), at(5), at(6), at(7), at(8)}};
}

void errors(const float* const* first, const float* const* second, std::size_t count,
            const PairFilter& filter, float* out) {
  const D d;
  constexpr float kPi = std::numbers::pi_v<float>;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Node a = load(first, i), b = load(second, i);
    // Weight of the opacity among the colours, the mean square over grey backgrounds: black
    // Gaussians hide other ones too.
    F aa(0.25f), bb(0.25f), ab(0.25f);
    for (std::size_t k = 12; k < LodPlanes::kPlanes; ++k) {
      const F ca = hn::LoadU(d, first[k] + i), cb = hn::LoadU(d, second[k] + i);
      aa = aa + ca * ca;
      bb = bb + cb * cb;
      ab = ab + ca * cb;
    }
    const F p = (a.mass + F(kLeastLodMass)) / (a.mass + b.mass + F(2 * kLeastLodMass)),
            q = F(1) - p;
    const F dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z, pq = p * q;
    const Cov &ca = a.covariance, &cb = b.covariance;
    const Node node{b.x + p * dx,
                    b.y + p * dy,
                    b.z + p * dz,
                    a.mass + b.mass,
                    a.opacities + b.opacities,
                    F(0),
                    {p * ca.xx + q * cb.xx + pq * dx * dx, p * ca.xy + q * cb.xy + pq * dx * dy,
                     p * ca.xz + q * cb.xz + pq * dx * dz, p * ca.yy + q * cb.yy + pq * dy * dy,
                     p * ca.yz + q * cb.yz + pq * dy * dz, p * ca.zz + q * cb.zz + pq * dz * dz}};
    F v(filter.v);
    if (filter.of_size > 0)
      v = v + F(filter.of_size / (4 * kPi)) * ellipsoid_area(node.covariance) + F(1e-30f);
    const F an = p * aa + q * ab, bn = p * ab + q * bb, nn = p * an + q * bn;
    const F fitted = filter.antialiased ? F(0) : v;
    const Shown shown[3] = {drawn(a, fitted), drawn(b, fitted), drawn(node, fitted)};
    const F place[3][3] = {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {node.x, node.y, node.z}};
    // One of the pair hides a part of its partner. The light that is hidden is the product of
    // both, a fourth Gaussian, in the mean of their colours, because either may be in front.
    const F am = F(0.5f) * (aa + ab), bm = F(0.5f) * (ab + bb), mm = F(0.5f) * (am + bm),
            mn = F(0.5f) * (an + bn);
    F sum(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
      const int x = axis == 0 ? 1 : 0, y = axis == 2 ? 1 : 2;
      Flat flat[4];
      F roots[4], light[4], px[4], py[4];
      for (int k = 0; k < 3; ++k) {
        const Cov& c = shown[k].covariance;
        const Flat sharp = axis == 0   ? Flat{c.yy, c.yz, c.zz}
                           : axis == 1 ? Flat{c.xx, c.xz, c.zz}
                                       : Flat{c.xx, c.xy, c.yy};
        flat[k] = {sharp.xx + v, sharp.xy, sharp.yy + v};
        roots[k] = root(flat[k].determinant());
        light[k] = shown[k].opacity;
        if (filter.antialiased) light[k] = light[k] * root(sharp.determinant()) / roots[k];
        px[k] = place[k][x];
        py[k] = place[k][y];
      }
      // The product: u = both^-1 (a - b), w = both^-1 times the second covariance.
      const Flat both{flat[0].xx + flat[1].xx, flat[0].xy + flat[1].xy, flat[0].yy + flat[1].yy};
      const F r = inverse_root(both.determinant()), inverse = r * r;
      const F ex = px[0] - px[1], ey = py[0] - py[1];
      const F ux = inverse * (both.yy * ex - both.xy * ey),
              uy = inverse * (both.xx * ey - both.xy * ex);
      const F wxx = inverse * (both.yy * flat[1].xx - both.xy * flat[1].xy),
              wxy = inverse * (both.yy * flat[1].xy - both.xy * flat[1].yy),
              wyx = inverse * (both.xx * flat[1].xy - both.xy * flat[1].xx),
              wyy = inverse * (both.xx * flat[1].yy - both.xy * flat[1].xy);
      flat[3] = {flat[0].xx * wxx + flat[0].xy * wyx, flat[0].xx * wxy + flat[0].xy * wyy,
                 flat[0].xy * wxy + flat[0].yy * wyy};
      px[3] = px[1] + flat[1].xx * ux + flat[1].xy * uy;
      py[3] = py[1] + flat[1].xy * ux + flat[1].yy * uy;
      roots[3] = root(flat[3].determinant());
      const F distance = exp2(F(-0.5f * static_cast<float>(kLog2E)) * (ex * ux + ey * uy));
      light[3] = light[0] * light[1] * distance;
      F weight[4];  // 2 pi weight: the integral of a Gaussian
      for (int k = 0; k < 4; ++k) weight[k] = light[k] * roots[k];
      const auto term = [&](int j, int k) {
        return weight[j] * weight[k] * overlap(flat[j], flat[k], px[k] - px[j], py[k] - py[j]);
      };
      // The integrals / pi.
      sum = sum + light[0] * weight[0] * aa + light[1] * weight[1] * bb +
            light[2] * weight[2] * nn + light[3] * weight[3] * mm +
            F(4) * (ab * weight[0] * weight[1] * r * distance - an * term(0, 2) - bn * term(1, 2) -
                    am * term(0, 3) - bm * term(1, 3) + mn * term(2, 3));
    }
    constexpr float kMost = std::numeric_limits<float>::max() / 1024;
    const F error = sum * F(kPi / 3);
    const F bounded = choose(hn::Lt(error.v, hn::Set(d, kMost)), larger(error, F(0.0f)), F(kMost));
    if (i + hn::Lanes(d) <= count) {
      hn::StoreU(bounded.v, d, out + i);
    } else {
      HWY_ALIGN float rest[16];
      hn::Store(bounded.v, d, rest);
      std::copy_n(rest, count - i, out + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::pair_lanes
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs {
namespace pair_lanes {
HWY_EXPORT(errors);
}  // namespace pair_lanes

void LodPlanes::resize(std::size_t count) {
  stride_ = count + 16;
  values_.assign(kPlanes * stride_, 0);
}

void LodPlanes::set(std::size_t i, const LodGaussian& g) {
  float* at = values_.data() + i;
  const auto put = [&](float value) {
    *at = value;
    at += stride_;
  };
  for (int axis = 0; axis < 3; ++axis) put(g.mean[axis]);
  for (const float value : g.covariance) put(value);
  put(g.mass);
  put(g.opacities);
  put(g.is_leaf ? 1 : 0);
  for (const float value : g.color) put(value);
}

void pair_errors(const LodPlanes& first, std::size_t a, const LodPlanes& second, std::size_t b,
                 std::size_t count, const PairFilter& filter, float* errors) {
  const float *from[LodPlanes::kPlanes], *to[LodPlanes::kPlanes];
  for (std::size_t k = 0; k < LodPlanes::kPlanes; ++k) {
    from[k] = first.plane(k) + a;
    to[k] = second.plane(k) + b;
  }
  HWY_DYNAMIC_DISPATCH(pair_lanes::errors)(from, to, count, filter, errors);
}

}  // namespace qs
#endif
