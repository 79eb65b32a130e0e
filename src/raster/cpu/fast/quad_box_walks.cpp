// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/quad_box_walks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/quad_box_walks.cpp"
#include "raster/cpu/fast/simd.h"

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

/// QuadBoxWalk of kernel/cull/quad_box.h.
struct Walk {
  M by_rows;
  Spans lines;
  V limit, mean_u, mean_v, same_u, same_v, opposite_u, opposite_v;

  HWY_INLINE Walk(TileGrid grid, const Survivors& s, std::size_t k) {
    const D d;
    const V xx = hn::Load(d, s.xx + k), yy = hn::Load(d, s.yy + k);
    const V mean_x = hn::Load(d, s.mean_x + k), mean_y = hn::Load(d, s.mean_y + k);
    const V gamma = hn::Load(d, s.gamma + k);
    // extents()
    const V f2 = hn::Div(hn::Load(d, s.determinant + k), hn::Mul(xx, yy));
    const V wider = hn::Add(set(1.0f), hn::Div(set(4.0f * 5.9604644775390625e-8f), f2));
    const V max_x = hn::Mul(wider, hn::Sqrt(hn::Mul(gamma, xx)));
    const V max_y = hn::Mul(wider, hn::Sqrt(hn::Mul(gamma, yy)));
    const V f = hn::Mul(wider, hn::Sqrt(f2));
    // QuadBoxes::of()
    const V minor_x = hn::Mul(f, max_x), minor_y = hn::Mul(f, max_y);
    const M major_is_same = hn::Lt(hn::Load(d, s.conic_b + k), hn::Zero(d));
    const V same_x = hn::IfThenElse(major_is_same, max_x, minor_x);
    const V same_y = hn::IfThenElse(major_is_same, max_y, minor_y);
    const V opposite_x = hn::IfThenElse(major_is_same, minor_x, max_x);
    const V opposite_y = hn::IfThenElse(major_is_same, minor_y, max_y);
    // QuadBox::walk()
    const V outer_x = hn::IfThenElse(hn::Lt(same_x, opposite_x), opposite_x, same_x);
    const V outer_y = hn::IfThenElse(hn::Lt(same_y, opposite_y), opposite_y, same_y);
    const V columns_limit = set(static_cast<float>(grid.columns));
    const V rows_limit = set(static_cast<float>(grid.rows));
    const Spans columns =
        tiles_meeting(hn::Sub(mean_x, outer_x), hn::Add(mean_x, outer_x), columns_limit);
    const Spans rows = tiles_meeting(hn::Sub(mean_y, outer_y), hn::Add(mean_y, outer_y), rows_limit);
    const auto fewer_rows = hn::Not(hn::Gt(rows.size(), columns.size()));
    by_rows = hn::RebindMask(d, fewer_rows);
    lines = {hn::IfThenElse(fewer_rows, rows.begin, columns.begin),
             hn::IfThenElse(fewer_rows, rows.end, columns.end)};
    limit = hn::IfThenElse(by_rows, columns_limit, rows_limit);
    mean_u = hn::IfThenElse(by_rows, mean_x, mean_y);
    mean_v = hn::IfThenElse(by_rows, mean_y, mean_x);
    same_u = hn::IfThenElse(by_rows, same_x, same_y);
    same_v = hn::IfThenElse(by_rows, same_y, same_x);
    opposite_u = hn::IfThenElse(by_rows, opposite_x, opposite_y);
    opposite_v = hn::IfThenElse(by_rows, opposite_y, opposite_x);
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

void compute_walks(TileGrid grid, const Survivors& s, QuadBoxWalks& walks) {
  const DI di;
  for (std::size_t k = 0; k < s.count; k += hn::Lanes(di)) {
    const Walk walk(grid, s, k);
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, walk.by_rows)), di, walks.by_rows + k);
    hn::Store(walk.lines.begin, di, walks.lines_begin + k);
    hn::Store(walk.lines.end, di, walks.lines_end + k);
    for (int line = 0; line < QuadBoxWalks::kLines; ++line) {
      const Spans span = walk.span(hn::Add(walk.lines.begin, hn::Set(di, line)));
      hn::Store(span.begin, di, walks.begin[line] + k);
      hn::Store(span.end, di, walks.end[line] + k);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(compute_walks);

void QuadBoxWalks::compute(TileGrid grid, const Survivors& survivors) {
  HWY_DYNAMIC_DISPATCH(compute_walks)(grid, survivors, *this);
}

}  // namespace qs::cpu::fast
#endif
