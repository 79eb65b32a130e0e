// SPDX-License-Identifier: MIT
//
// The walks of the culling modes for a vector of Gaussians. They equal the walks of kernel/cull/
// bit for bit. A file with vector code includes this header behind simd.h, so it is read once per
// instruction set, as Highway requires.
#if defined(QS_WALK_VECTORS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_WALK_VECTORS_H
#undef QS_WALK_VECTORS_H
#else
#define QS_WALK_VECTORS_H
#endif

#include <hwy/highway.h>

#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/cull/modes.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using I = hn::Vec<DI>;
using M = hn::Mask<D>;

struct Spans {
  I begin, end;

  HWY_INLINE I size() const { return hn::Max(hn::Sub(end, begin), hn::Zero(DI())); }
};

HWY_INLINE V set(float value) { return hn::Set(D(), value); }
HWY_INLINE V larger(V a, V b) { return hn::IfThenElse(hn::Gt(a, b), a, b); }

HWY_INLINE I clamp_to_int(V value, V limit) {
  const V below = hn::IfThenElse(hn::Lt(value, limit), value, limit);
  return hn::ConvertTo(DI(), hn::IfThenElseZero(hn::Gt(value, hn::Zero(D())), below));
}

HWY_INLINE Spans tiles_meeting(V low, V high, V limit) {
  const V inverse = set(1.0f / kTileSize);
  return {clamp_to_int(hn::Floor(hn::Mul(low, inverse)), limit),
          clamp_to_int(hn::Ceil(hn::Mul(high, inverse)), limit)};
}

HWY_INLINE V select(M mask, V yes, V no) { return hn::IfThenElse(mask, yes, no); }

/// The values that all walks read from a vector of footprints.
struct Footprints {
  V mean_x, mean_y, xx, xy, yy, gamma, determinant, conic_b;

  HWY_INLINE Footprints(const Survivors& s, std::size_t k) {
    const D d;
    mean_x = hn::Load(d, s.mean_x + k);
    mean_y = hn::Load(d, s.mean_y + k);
    xx = hn::Load(d, s.xx + k);
    xy = hn::Load(d, s.xy + k);
    yy = hn::Load(d, s.yy + k);
    gamma = hn::Load(d, s.gamma + k);
    determinant = hn::Load(d, s.determinant + k);
    conic_b = hn::Load(d, s.conic_b + k);
  }
};

/// extents() of kernel/cull/culler.h.
struct FootprintExtents {
  V max_x, max_y, f, k;

  HWY_INLINE explicit FootprintExtents(const Footprints& p) {
    const V f2 = hn::Div(p.determinant, hn::Mul(p.xx, p.yy));
    k = hn::Add(set(1.0f), hn::Div(set(4.0f * 5.9604644775390625e-8f), f2));
    max_x = hn::Mul(k, hn::Sqrt(hn::Mul(p.gamma, p.xx)));
    max_y = hn::Mul(k, hn::Sqrt(hn::Mul(p.gamma, p.yy)));
    f = hn::Mul(k, hn::Sqrt(f2));
  }
};

/// TileRect with walks_rows().
struct Rects {
  Spans columns, rows;
  M by_rows;

  HWY_INLINE Rects(const Spans& some_columns, const Spans& some_rows)
      : columns(some_columns), rows(some_rows) {
    by_rows = hn::RebindMask(D(), hn::Not(hn::Gt(rows.size(), columns.size())));
  }

  static HWY_INLINE Rects of_box(const Footprints& p, V half_x, V half_y, TileGrid grid) {
    return {tiles_meeting(hn::Sub(p.mean_x, half_x), hn::Add(p.mean_x, half_x),
                          set(static_cast<float>(grid.columns))),
            tiles_meeting(hn::Sub(p.mean_y, half_y), hn::Add(p.mean_y, half_y),
                          set(static_cast<float>(grid.rows)))};
  }

  HWY_INLINE Spans lines() const { return choose(rows, columns); }
  HWY_INLINE Spans along() const { return choose(columns, rows); }

 private:
  HWY_INLINE Spans choose(const Spans& by_row, const Spans& by_column) const {
    const auto mask = hn::RebindMask(DI(), by_rows);
    return {hn::IfThenElse(mask, by_row.begin, by_column.begin),
            hn::IfThenElse(mask, by_row.end, by_column.end)};
  }
};

/// The walk of mode P for a vector of Gaussians. Undefined for a mode without vectors.
template <class P>
struct Walk;

template <class P>
concept HasVectors = requires {
  sizeof(Walk<P>);
};

/// RectWalk of kernel/cull/culler.h.
struct WalkOfRect {
  M by_rows;
  Spans lines, tiles;

  HWY_INLINE explicit WalkOfRect(const Rects& rects)
      : by_rows(rects.by_rows), lines(rects.lines()), tiles(rects.along()) {}
  HWY_INLINE Spans span(I) const { return tiles; }
};

template <>
struct Walk<AdrAabb> : WalkOfRect {
  HWY_INLINE Walk(const Footprints& p, TileGrid grid) : WalkOfRect(rects(p, grid)) {}

  static HWY_INLINE Rects rects(const Footprints& p, TileGrid grid) {
    const FootprintExtents e(p);
    return Rects::of_box(p, e.max_x, e.max_y, grid);
  }
};

template <>
struct Walk<Square> : WalkOfRect {
  HWY_INLINE Walk(const Footprints& p, TileGrid grid) : WalkOfRect(rects(p, grid)) {}

  static HWY_INLINE Rects rects(const Footprints& p, TileGrid grid) {
    const V mid = hn::Mul(set(0.5f), hn::Add(p.xx, p.yy));
    const V discriminant = hn::Sub(hn::Mul(mid, mid), p.determinant);
    const M is_solid = hn::Ge(p.gamma, set(kSolidGamma));
    const V floor = select(is_solid, set(0.0f), set(kEigenvalueFloor));
    const V variance = hn::Add(mid, hn::Sqrt(larger(discriminant, floor)));
    const V radius =
        hn::Ceil(select(is_solid, hn::Add(hn::Sqrt(hn::Mul(p.gamma, variance)), set(1.0f)),
                        hn::Mul(set(kSigmas), hn::Sqrt(variance))));
    return {tiles(p.mean_x, radius, grid.columns), tiles(p.mean_y, radius, grid.rows)};
  }

  static HWY_INLINE Spans tiles(V center, V radius, int limit) {
    const V inverse = set(1.0f / kTileSize), most = set(static_cast<float>(limit));
    const V last = hn::Add(hn::Add(center, radius), set(kTileSize - 1));
    return {clamp_to_int(hn::Mul(hn::Sub(center, radius), inverse), most),
            clamp_to_int(hn::Mul(last, inverse), most)};
  }
};

/// QuadBoxWalk of kernel/cull/quad_box.h.
struct WalkOfBoxes {
  M by_rows;
  Spans lines;
  V limit, mean_u, mean_v, same_u, same_v, opposite_u, opposite_v;

  /// The boxes reach (major_x, major_y) along the major axis, else (minor_x, minor_y).
  HWY_INLINE WalkOfBoxes(const Footprints& p, V major_x, V major_y, V minor_x, V minor_y,
                         TileGrid grid) {
    const M major_is_same = hn::Lt(p.conic_b, hn::Zero(D()));
    const V same_x = select(major_is_same, major_x, minor_x);
    const V same_y = select(major_is_same, major_y, minor_y);
    const V opposite_x = select(major_is_same, minor_x, major_x);
    const V opposite_y = select(major_is_same, minor_y, major_y);
    const Rects range =
        Rects::of_box(p, larger(opposite_x, same_x), larger(opposite_y, same_y), grid);
    by_rows = range.by_rows;
    lines = range.lines();
    limit =
        select(by_rows, set(static_cast<float>(grid.columns)), set(static_cast<float>(grid.rows)));
    mean_u = select(by_rows, p.mean_x, p.mean_y);
    mean_v = select(by_rows, p.mean_y, p.mean_x);
    same_u = select(by_rows, same_x, same_y);
    same_v = select(by_rows, same_y, same_x);
    opposite_u = select(by_rows, opposite_x, opposite_y);
    opposite_v = select(by_rows, opposite_y, opposite_x);
  }

  HWY_INLINE Spans span(I line) const {
    const D d;
    const V low = hn::ConvertTo(d, hn::Mul(line, hn::Set(DI(), kTileSize)));
    const V high = hn::Add(low, set(kTileSize));
    const M before = hn::Lt(low, mean_v), after = hn::Gt(high, mean_v);
    const M same_before = hn::And(before, hn::Gt(high, hn::Sub(mean_v, same_v)));
    const M opposite_before = hn::And(before, hn::Gt(high, hn::Sub(mean_v, opposite_v)));
    const M same_after = hn::And(after, hn::Lt(low, hn::Add(mean_v, same_v)));
    const M opposite_after = hn::And(after, hn::Lt(low, hn::Add(mean_v, opposite_v)));
    const V left = larger(hn::IfThenElseZero(same_before, same_u),
                          hn::IfThenElseZero(opposite_after, opposite_u));
    const V right = larger(hn::IfThenElseZero(same_after, same_u),
                           hn::IfThenElseZero(opposite_before, opposite_u));
    return tiles_meeting(hn::Sub(mean_u, left), hn::Add(mean_u, right), limit);
  }
};

template <>
struct Walk<QuadBox> : WalkOfBoxes {
  HWY_INLINE Walk(const Footprints& p, TileGrid grid) : Walk(p, FootprintExtents(p), grid) {}
  HWY_INLINE Walk(const Footprints& p, const FootprintExtents& e, TileGrid grid)
      : WalkOfBoxes(p, e.max_x, e.max_y, hn::Mul(e.f, e.max_x), hn::Mul(e.f, e.max_y), grid) {}
};

template <>
struct Walk<DualBox> : WalkOfBoxes {
  HWY_INLINE Walk(const Footprints& p, TileGrid grid) : Walk(p, FootprintExtents(p), grid) {}
  HWY_INLINE Walk(const Footprints& p, const FootprintExtents& e, TileGrid grid)
      : WalkOfBoxes(p, e.max_x, e.max_y, hn::Zero(D()), hn::Zero(D()), grid) {}
};

/// ExactWalk of kernel/cull/exact.h.
template <>
struct Walk<Exact> : Walk<QuadBox> {
  V gamma, s_vv, s_uv, determinant, v_max, v_at_u_max;

  HWY_INLINE Walk(const Footprints& p, TileGrid grid) : Walk(p, FootprintExtents(p), grid) {}
  HWY_INLINE Walk(const Footprints& p, const FootprintExtents& e, TileGrid grid)
      : Walk<QuadBox>(p, e, grid) {
    gamma = hn::Mul(hn::Mul(hn::Mul(p.gamma, set(kExactSlack)), e.k), e.k);
    const V s_uu = select(by_rows, p.xx, p.yy);
    s_vv = select(by_rows, p.yy, p.xx);
    s_uv = p.xy;
    determinant = p.determinant;
    v_max = hn::Sqrt(hn::Mul(gamma, s_vv));
    v_at_u_max = hn::Mul(p.xy, hn::Sqrt(hn::Div(gamma, s_uu)));
  }

  HWY_INLINE Spans span(I line) const {
    const DI di;
    const V low = hn::Sub(hn::ConvertTo(D(), hn::Mul(line, hn::Set(di, kTileSize))), mean_v);
    const V high = hn::Add(low, set(kTileSize - 1));
    const V v0 = larger(low, hn::Neg(v_max)), v1 = smaller(high, v_max);
    const V right =
        hn::Add(hn::Mul(s_uv, clamp(v_at_u_max, v0, v1)), half_at(clamp(v_at_u_max, v0, v1)));
    const V left = hn::Sub(hn::Mul(s_uv, clamp(hn::Neg(v_at_u_max), v0, v1)),
                           half_at(clamp(hn::Neg(v_at_u_max), v0, v1)));
    const Spans centers = tiles_with_centers(hn::Add(mean_u, hn::Div(left, s_vv)),
                                             hn::Add(mean_u, hn::Div(right, s_vv)));
    const Spans boxes = Walk<QuadBox>::span(line);
    const auto misses = hn::RebindMask(di, hn::Gt(v0, v1));
    return {hn::IfThenZeroElse(misses, hn::Max(centers.begin, boxes.begin)),
            hn::IfThenZeroElse(misses, hn::Min(centers.end, boxes.end))};
  }

 private:
  static HWY_INLINE V smaller(V a, V b) { return select(hn::Lt(a, b), a, b); }
  static HWY_INLINE V clamp(V x, V low, V high) {
    return select(hn::Lt(x, low), low, select(hn::Gt(x, high), high, x));
  }
  HWY_INLINE V half_at(V v) const {
    const V under = hn::Mul(hn::Sub(hn::Mul(s_vv, gamma), hn::Mul(v, v)), determinant);
    return hn::Sqrt(hn::IfThenElseZero(hn::Gt(under, hn::Zero(D())), under));
  }
  HWY_INLINE Spans tiles_with_centers(V low, V high) const {
    const V inverse = set(1.0f / kTileSize);
    const V first = hn::Ceil(hn::Mul(hn::Sub(low, set(kTileSize - 1)), inverse));
    return {clamp_to_int(first, limit),
            clamp_to_int(hn::Add(hn::Floor(hn::Mul(high, inverse)), set(1.0f)), limit)};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#endif  // QS_WALK_VECTORS_H
