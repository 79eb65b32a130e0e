// SPDX-License-Identifier: MIT
#include <cstring>

#include "raster/cpu/fast/survivors.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/project.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

/// log2_portable() of kernel/project.h.
HWY_INLINE V log2_portable(D d, V x) {
  const V one = hn::Set(d, 1.0f);
  V e = hn::Zero(d);
  for (int i = 0; i < 32; ++i) {
    const M small = hn::Lt(x, hn::Set(d, 0.70710678f));
    if (hn::AllFalse(d, small)) break;
    x = hn::IfThenElse(small, hn::Mul(x, hn::Set(d, 2.0f)), x);
    e = hn::IfThenElse(small, hn::Sub(e, one), e);
  }
  const V t = hn::Div(hn::Sub(x, one), hn::Add(x, one));
  const V tt = hn::Mul(t, t);
  V series = hn::Add(hn::Set(d, 1.0f / 5), hn::Mul(tt, hn::Set(d, 1.0f / 7)));
  series = hn::Add(hn::Set(d, 1.0f / 3), hn::Mul(tt, series));
  series = hn::Add(one, hn::Mul(tt, series));
  return hn::Add(e, hn::Mul(hn::Mul(hn::Set(d, 2.0f * static_cast<float>(kLog2E)), t), series));
}

/// Sum of three products, in source order.
HWY_INLINE V dot(V ax, V ay, V az, V bx, V by, V bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

HWY_INLINE V clamp(D d, V value, float limit) {
  const V low = hn::Set(d, -limit), high = hn::Set(d, limit);
  return hn::IfThenElse(hn::Lt(value, low), low, hn::IfThenElse(hn::Gt(value, high), high, value));
}

/// A point in view axes, per lane: depth_of(), and projected_point() with its slopes x/z and y/z.
struct PointLanes {
  V depth, z, slope_x, slope_y;
};

/// Covariance on the image, per lane.
struct CovarianceLanes {
  V xx, xy, yy;

  HWY_INLINE V determinant() const { return hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy)); }
};

/// Footprint, per lane.
struct FootprintLanes {
  V mean_x, mean_y;
  CovarianceLanes covariance;
  V a, b, c;  // conic
  V determinant, gamma;
};

struct Packer {
  D d;
  M keep;
  std::size_t at;

  /// Compresses in a register, because compressing stores are slow on some CPUs.
  HWY_INLINE void operator()(V values, float* plane) const {
    hn::StoreU(hn::Compress(values, keep), d, plane + at);
  }
};

/// Upper bound of the reach of all modes in pixels. The boxes by opacity reach k sqrt(gamma s) (see
/// Extents), the square of `3dgs` reaches 3 sqrt(largest eigenvalue).
HWY_INLINE V farthest_reach(D d, const FootprintLanes& f) {
  const auto& [xx, xy, yy] = f.covariance;
  const V f2 = hn::Div(f.determinant, hn::Mul(xx, yy));
  const V k = hn::Add(hn::Set(d, kReachK), hn::Div(hn::Set(d, kReachKPerF2), f2));
  const V level = hn::Max(f.gamma, hn::Set(d, kSigmas * kSigmas));
  return hn::Add(hn::Mul(k, hn::Sqrt(hn::Mul(level, hn::Add(xx, yy)))),
                 hn::Set(d, 2.0f * kTileSize));
}

/// True where mean +- reach is outside of [0, size].
HWY_INLINE M outside(D d, V mean, V reach, int tiles) {
  const V size = hn::Set(d, static_cast<float>(tiles * kTileSize));
  return hn::Or(hn::Lt(hn::Add(mean, reach), hn::Zero(d)), hn::Gt(hn::Sub(mean, reach), size));
}

/// The steps of project(), for the lanes of a block from `i` on. A step clears the lanes of `keep`
/// that it drops.
struct Projector {
  D d;
  View<float> view;  // a copy: stores cannot change it
  FootprintRules rules;

  /// to_view(), depth_of(), projected_point()
  HWY_INLINE PointLanes point(const Block& block, std::size_t i, M& keep) const {
    const auto& m = view.view_from_world;
    const V wx = hn::Load(d, block.x + i), wy = hn::Load(d, block.y + i),
            wz = hn::Load(d, block.z + i);
    const auto row = [&](int r) HWY_ATTR {
      return hn::Add(dot(hn::Set(d, m[0][r]), hn::Set(d, m[1][r]), hn::Set(d, m[2][r]), wx, wy, wz),
                     hn::Set(d, m[3][r]));
    };
    const V x = row(0), y = row(1), ahead = row(2);
    const V z = view.projection == Projection::orthographic ? hn::Set(d, 1.0f) : ahead;
    V depth = ahead;
    if (view.projection == Projection::face)
      depth = hn::IfThenElse(hn::Gt(ahead, hn::Zero(d)), hn::Sqrt(dot(x, y, ahead, x, y, ahead)),
                             ahead);
    keep = hn::Gt(depth, hn::Set(d, view.near_depth));
    return {depth, z, hn::Div(x, z), hn::Div(y, z)};
  }

  /// project_covariance()
  HWY_INLINE CovarianceLanes covariance(const Block& block, std::size_t i,
                                        const PointLanes& point) const {
    const auto& m = view.view_from_world;
    const V fx = hn::Set(d, view.focal_px.x), fy = hn::Set(d, view.focal_px.y), z = point.z;
    const V tx = hn::Mul(clamp(d, point.slope_x, view.slope_limit.x), z);
    const V ty = hn::Mul(clamp(d, point.slope_y, view.slope_limit.y), z);
    const V zz = hn::Mul(z, z);
    const V j00 = hn::Div(fx, z), j02 = hn::Div(hn::Neg(hn::Mul(fx, tx)), zz);
    const V j11 = hn::Div(fy, z), j12 = hn::Div(hn::Neg(hn::Mul(fy, ty)), zz);
    // The rows of J W.
    const auto along = [&](V j, V j2, int column, int r) HWY_ATTR {
      return hn::Add(hn::Mul(j, hn::Set(d, m[column][r])), hn::Mul(j2, hn::Set(d, m[column][2])));
    };
    const V ux = along(j00, j02, 0, 0), uy = along(j00, j02, 1, 0), uz = along(j00, j02, 2, 0);
    const V vx = along(j11, j12, 0, 1), vy = along(j11, j12, 1, 1), vz = along(j11, j12, 2, 1);
    const V sxx = hn::Load(d, block.xx + i), sxy = hn::Load(d, block.xy + i),
            sxz = hn::Load(d, block.xz + i), syy = hn::Load(d, block.yy + i),
            syz = hn::Load(d, block.yz + i), szz = hn::Load(d, block.zz + i);
    const V sux = dot(sxx, sxy, sxz, ux, uy, uz), suy = dot(sxy, syy, syz, ux, uy, uz),
            suz = dot(sxz, syz, szz, ux, uy, uz);
    const V svx = dot(sxx, sxy, sxz, vx, vy, vz), svy = dot(sxy, syy, syz, vx, vy, vz),
            svz = dot(sxz, syz, szz, vx, vy, vz);
    const V scale2 = hn::Set(d, rules.splat_scale * rules.splat_scale);
    return {hn::Mul(dot(ux, uy, uz, sux, suy, suz), scale2),
            hn::Mul(dot(vx, vy, vz, sux, suy, suz), scale2),
            hn::Mul(dot(vx, vy, vz, svx, svy, svz), scale2)};
  }

  /// dilate()
  HWY_INLINE CovarianceLanes with_dilation(const PointLanes& point,
                                           const CovarianceLanes& c) const {
    const V dilation = hn::Set(d, rules.dilation);
    if (view.projection != Projection::face)
      return {hn::Add(c.xx, dilation), c.xy, hn::Add(c.yy, dilation)};
    const V one = hn::Set(d, 1.0f);
    const V x = clamp(d, point.slope_x, view.slope_limit.x);
    const V y = clamp(d, point.slope_y, view.slope_limit.y);
    const V xx = hn::Mul(x, x), yy = hn::Mul(y, y);
    const V along = hn::Mul(dilation, hn::Add(hn::Add(one, xx), yy));
    return {hn::Add(c.xx, hn::Mul(along, hn::Add(one, xx))),
            hn::Add(c.xy, hn::Mul(along, hn::Mul(x, y))),
            hn::Add(c.yy, hn::Mul(along, hn::Add(one, yy)))};
  }

  /// The footprint of a covariance before the dilation; multiplies the opacity by compensation(),
  /// or makes it a solid's.
  HWY_INLINE FootprintLanes footprint(const PointLanes& point, const CovarianceLanes& undilated,
                                      V& log2_255_opacity, M& keep) const {
    const CovarianceLanes dilated = with_dilation(point, undilated);
    const V det = dilated.determinant();
    keep = hn::And(keep, hn::And(hn::Gt(det, hn::Zero(d)), hn::Lt(det, hn::Set(d, INFINITY))));
    if (rules.antialiased) {
      const V ratio = hn::Div(undilated.determinant(), det);
      const V floor = hn::Set(d, float(kCompensationFloor));
      const V factor = hn::Sqrt(hn::IfThenElse(hn::Gt(ratio, floor), ratio, floor));
      log2_255_opacity = hn::Add(log2_255_opacity, log2_portable(d, factor));
    }
    if (rules.is_solid) {
      keep = hn::And(keep, hn::Gt(log2_255_opacity, hn::Set(d, rules.solid_above)));
      log2_255_opacity = hn::Set(d, kSolidLog2 + kLog2Of255);
    }
    const V gamma = hn::Mul(hn::Set(d, 2.0f * static_cast<float>(kLn2)), log2_255_opacity);
    if (!rules.keep_faint) keep = hn::And(keep, hn::Gt(gamma, hn::Zero(d)));
    const V fx = hn::Set(d, view.focal_px.x), fy = hn::Set(d, view.focal_px.y);
    const V mean_x = hn::Add(hn::Mul(fx, point.slope_x), hn::Set(d, view.center_px.x));
    const V mean_y = hn::Add(hn::Mul(fy, point.slope_y), hn::Set(d, view.center_px.y));
    const V a = hn::Div(dilated.yy, det), b = hn::Div(hn::Neg(dilated.xy), det),
            c = hn::Div(dilated.xx, det);
    // Drops values that are not finite.
    const V sum = hn::Add(hn::Add(hn::Add(hn::Add(mean_x, mean_y), a), b), c);
    keep = hn::And(keep, hn::Eq(hn::Sub(sum, sum), hn::Zero(d)));
    return {mean_x, mean_y, dilated, a, b, c, det, gamma};
  }

  /// Drops footprints that have no tile in any mode.
  HWY_INLINE void drop_outside(const FootprintLanes& footprint, TileGrid grid, M& keep) const {
    const V reach = farthest_reach(d, footprint);
    keep = hn::AndNot(outside(d, footprint.mean_x, reach, grid.columns), keep);
    keep = hn::AndNot(outside(d, footprint.mean_y, reach, grid.rows), keep);
  }
};

HWY_INLINE void pack_footprint(const Packer& pack, const FootprintLanes& f, Survivors& out) {
  pack(f.mean_x, out.mean_x);
  pack(f.mean_y, out.mean_y);
  pack(f.covariance.xx, out.xx);
  pack(f.covariance.xy, out.xy);
  pack(f.covariance.yy, out.yy);
  pack(f.a, out.conic_a);
  pack(f.b, out.conic_b);
  pack(f.c, out.conic_c);
  pack(f.determinant, out.determinant);
  pack(f.gamma, out.gamma);
}

void project_block(const View<float>& view, const FootprintRules& rules, TileGrid grid,
                   const Block& block, const std::uint64_t* drawn, Survivors& out) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  const Projector projector{d, view, rules};
  std::size_t count = 0;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    M keep;
    const PointLanes point = projector.point(block, i, keep);
    if (drawn != nullptr) {
      const std::uint64_t word = drawn[i / 64] >> i % 64;
      std::uint8_t bits[sizeof word];
      std::memcpy(bits, &word, sizeof word);
      keep = hn::And(keep, hn::LoadMaskBits(d, bits));
    }
    if (hn::AllFalse(d, keep)) continue;
    const CovarianceLanes covariance = projector.covariance(block, i, point);
    V log2_255_opacity = hn::Load(d, block.log2_255_opacity + i);
    const FootprintLanes footprint = projector.footprint(point, covariance, log2_255_opacity, keep);
    projector.drop_outside(footprint, grid, keep);
    if (hn::AllFalse(d, keep)) continue;

    const Packer pack{d, keep, count};
    pack_footprint(pack, footprint, out);
    pack(point.depth, out.depth);
    pack(hn::Sub(log2_255_opacity, hn::Set(d, kLog2Of255)), out.log2_opacity);
    const auto lanes = hn::Iota(du, static_cast<std::uint32_t>(i));
    hn::StoreU(hn::Compress(lanes, hn::RebindMask(du, keep)), du, out.lane + count);
    count += hn::CountTrue(d, keep);
  }
  out.count = count;
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(project_block);

void project(const View<float>& view, const FootprintRules& rules, TileGrid grid,
             const Block& block, const std::uint64_t* drawn, Survivors& out) {
  HWY_DYNAMIC_DISPATCH(project_block)(view, rules, grid, block, drawn, out);
}

}  // namespace qs::cpu::fast
#endif
