// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/project.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/project.cpp"
#include "raster/cpu/fast/simd.h"

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

HWY_INLINE V determinant(V xx, V xy, V yy) { return hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy)); }

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
HWY_INLINE V farthest_reach(D d, V xx, V yy, V det, V gamma) {
  const V f2 = hn::Div(det, hn::Mul(xx, yy));
  const V k = hn::Add(hn::Set(d, kReachK), hn::Div(hn::Set(d, kReachKPerF2), f2));
  const V level = hn::Max(gamma, hn::Set(d, kSigmas * kSigmas));
  return hn::Add(hn::Mul(k, hn::Sqrt(hn::Mul(level, hn::Add(xx, yy)))),
                 hn::Set(d, 2.0f * kTileSize));
}

/// True where mean +- reach is outside of [0, size].
HWY_INLINE M outside(D d, V mean, V reach, int tiles) {
  const V size = hn::Set(d, static_cast<float>(tiles * kTileSize));
  return hn::Or(hn::Lt(hn::Add(mean, reach), hn::Zero(d)), hn::Gt(hn::Sub(mean, reach), size));
}

void project_block(const View<float>& view, const FootprintRules& rules, TileGrid grid,
                   const Block& block, Survivors& out) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  const auto& m = view.view_from_world;
  const auto row = [&](int r, V x, V y, V z) HWY_ATTR {
    return hn::Add(dot(hn::Set(d, m[0][r]), hn::Set(d, m[1][r]), hn::Set(d, m[2][r]), x, y, z),
                   hn::Set(d, m[3][r]));
  };
  const V fx = hn::Set(d, view.focal_px.x), fy = hn::Set(d, view.focal_px.y);
  const V scale2 = hn::Set(d, rules.splat_scale * rules.splat_scale);
  const V dilation = hn::Set(d, rules.dilation);

  std::size_t count = 0;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    const V wx = hn::Load(d, block.x + i), wy = hn::Load(d, block.y + i),
            wz = hn::Load(d, block.z + i);
    const V z = row(2, wx, wy, wz);
    M keep = hn::Gt(z, hn::Set(d, view.near_depth));
    if (hn::AllFalse(d, keep)) continue;
    const V x = row(0, wx, wy, wz), y = row(1, wx, wy, wz);
    const V slope_x = hn::Div(x, z), slope_y = hn::Div(y, z);

    // project_covariance()
    const V tx = hn::Mul(clamp(d, slope_x, view.slope_limit.x), z);
    const V ty = hn::Mul(clamp(d, slope_y, view.slope_limit.y), z);
    const V zz = hn::Mul(z, z);
    const V j00 = hn::Div(fx, z), j02 = hn::Div(hn::Neg(hn::Mul(fx, tx)), zz);
    const V j11 = hn::Div(fy, z), j12 = hn::Div(hn::Neg(hn::Mul(fy, ty)), zz);
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
    V xx = hn::Mul(dot(ux, uy, uz, sux, suy, suz), scale2);
    const V xy = hn::Mul(dot(vx, vy, vz, sux, suy, suz), scale2);
    V yy = hn::Mul(dot(vx, vy, vz, svx, svy, svz), scale2);

    // project()
    const V before = determinant(xx, xy, yy);
    xx = hn::Add(xx, dilation);
    yy = hn::Add(yy, dilation);
    const V det = determinant(xx, xy, yy);
    keep = hn::And(keep, hn::And(hn::Gt(det, hn::Zero(d)), hn::Lt(det, hn::Set(d, INFINITY))));
    V log2_255_opacity = hn::Load(d, block.log2_255_opacity + i);
    if (rules.antialiased) {
      const V ratio = hn::Div(before, det), floor = hn::Set(d, float(kCompensationFloor));
      const V factor = hn::Sqrt(hn::IfThenElse(hn::Gt(ratio, floor), ratio, floor));
      log2_255_opacity = hn::Add(log2_255_opacity, log2_portable(d, factor));
    }
    const V gamma = hn::Mul(hn::Set(d, 2.0f * static_cast<float>(kLn2)), log2_255_opacity);
    if (!rules.keep_faint) keep = hn::And(keep, hn::Gt(gamma, hn::Zero(d)));
    const V mean_x = hn::Add(hn::Mul(fx, slope_x), hn::Set(d, view.center_px.x));
    const V mean_y = hn::Add(hn::Mul(fy, slope_y), hn::Set(d, view.center_px.y));
    const V a = hn::Div(yy, det), b = hn::Div(hn::Neg(xy), det), c = hn::Div(xx, det);
    const V sum = hn::Add(hn::Add(hn::Add(hn::Add(mean_x, mean_y), a), b), c);
    keep = hn::And(keep, hn::Eq(hn::Sub(sum, sum), hn::Zero(d)));
    const V reach = farthest_reach(d, xx, yy, det, gamma);
    keep = hn::AndNot(outside(d, mean_x, reach, grid.columns), keep);
    keep = hn::AndNot(outside(d, mean_y, reach, grid.rows), keep);
    if (hn::AllFalse(d, keep)) continue;

    const Packer pack{d, keep, count};
    pack(mean_x, out.mean_x);
    pack(mean_y, out.mean_y);
    pack(xx, out.xx);
    pack(xy, out.xy);
    pack(yy, out.yy);
    pack(a, out.conic_a);
    pack(b, out.conic_b);
    pack(c, out.conic_c);
    pack(det, out.determinant);
    pack(gamma, out.gamma);
    pack(z, out.depth);
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
             const Block& block, Survivors& out) {
  HWY_DYNAMIC_DISPATCH(project_block)(view, rules, grid, block, out);
}

}  // namespace qs::cpu::fast
#endif
