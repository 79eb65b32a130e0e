// SPDX-License-Identifier: MIT
//
// BT.601's coefficients for 8-bit colours, times 256. The coefficients of a chroma
// have the sum 0, so greys stay grey.
#include <algorithm>

#include "io/picture/vp9.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "io/picture/i420.cpp"
#include "base/simd.h"

#ifndef QS_ROW_PAIR
#define QS_ROW_PAIR
namespace qs::i420 {

constexpr std::size_t kPadding = 64;  ///< a multiple of all vectors

/// Two rows of a picture, and their place in the planes.
struct RowPair {
  const std::uint8_t *top, *bottom;  ///< RGBA
  std::size_t width;
  std::uint8_t *y_top, *y_bottom, *u, *v;
  std::int16_t* sums;  ///< three rows of `sums_step` values
  std::size_t sums_step;
};

}  // namespace qs::i420
#endif

HWY_BEFORE_NAMESPACE();
namespace qs::i420 {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<std::int16_t, 32>;
using U = hn::RebindToUnsigned<D>;
using Bytes = hn::Rebind<std::uint8_t, D>;
using V = hn::Vec<D>;

struct Colors {
  V r, g, b;
};

HWY_INLINE V widened(hn::Vec<Bytes> values) { return hn::PromoteTo(D(), values); }

HWY_INLINE Colors load(const std::uint8_t* rgba) {
  hn::Vec<Bytes> r, g, b, a;
  hn::LoadInterleaved4(Bytes(), rgba, r, g, b, a);
  return {widened(r), widened(g), widened(b)};
}

// The sum is below 65536, but not below 32768.
HWY_INLINE void store_luma(const Colors& c, std::uint8_t* to) {
  const U u;
  const auto times = [&](V value, std::uint16_t factor) {
    return hn::Mul(hn::BitCast(u, value), hn::Set(u, factor));
  };
  const auto sum =
      hn::Add(hn::Add(times(c.r, 66), times(c.g, 129)), hn::Add(times(c.b, 25), hn::Set(u, 128)));
  const V luma = hn::Add(hn::BitCast(D(), hn::ShiftRight<8>(sum)), hn::Set(D(), 16));
  hn::StoreU(hn::DemoteTo(Bytes(), luma), Bytes(), to);
}

HWY_INLINE void store_chroma(const Colors& c, std::int16_t r, std::int16_t g, std::int16_t b,
                             std::uint8_t* to) {
  const D d;
  const V sum = hn::Add(hn::Add(hn::Mul(c.r, hn::Set(d, r)), hn::Mul(c.g, hn::Set(d, g))),
                        hn::Add(hn::Mul(c.b, hn::Set(d, b)), hn::Set(d, 128)));
  const V chroma = hn::Add(hn::ShiftRight<8>(sum), hn::Set(d, 128));
  hn::StoreU(hn::DemoteTo(Bytes(), chroma), Bytes(), to);
}

HWY_INLINE void convert_pixels(const RowPair& rows, std::size_t x, const std::uint8_t* top,
                               const std::uint8_t* bottom) {
  const D d;
  const Colors a = load(top), b = load(bottom);
  store_luma(a, rows.y_top + x);
  store_luma(b, rows.y_bottom + x);
  hn::StoreU(hn::Add(a.r, b.r), d, rows.sums + x);
  hn::StoreU(hn::Add(a.g, b.g), d, rows.sums + rows.sums_step + x);
  hn::StoreU(hn::Add(a.b, b.b), d, rows.sums + 2 * rows.sums_step + x);
}

// The mean of four pixels, from sums of two.
HWY_INLINE V mean(const std::int16_t* sums) {
  const D d;
  V even, odd;
  hn::LoadInterleaved2(d, sums, even, odd);
  return hn::ShiftRight<2>(hn::Add(hn::Add(even, odd), hn::Set(d, 2)));
}

void convert_rows(const RowPair& rows) {
  const std::size_t lanes = hn::Lanes(D()), width = rows.width;
  std::size_t x = 0;
  for (; x + lanes <= width; x += lanes)
    convert_pixels(rows, x, rows.top + 4 * x, rows.bottom + 4 * x);
  if (x < width) {
    std::uint8_t top[4 * kPadding] = {}, bottom[4 * kPadding] = {};
    std::copy(rows.top + 4 * x, rows.top + 4 * width, top);
    std::copy(rows.bottom + 4 * x, rows.bottom + 4 * width, bottom);
    convert_pixels(rows, x, top, bottom);
  }
  if (width % 2 != 0) {
    for (std::size_t c = 0; c < 3; ++c) {
      std::int16_t* const sums = rows.sums + c * rows.sums_step;
      sums[width] = sums[width - 1];
    }
  }
  for (x = 0; 2 * x < width; x += lanes) {
    const std::int16_t* const sums = rows.sums + 2 * x;
    const Colors c{mean(sums), mean(sums + rows.sums_step), mean(sums + 2 * rows.sums_step)};
    store_chroma(c, -38, -74, 112, rows.u + x);
    store_chroma(c, 112, -94, -18, rows.v + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::i420
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs {
namespace i420 {
HWY_EXPORT(convert_rows);
void convert(const RowPair& rows) { HWY_DYNAMIC_DISPATCH(convert_rows)(rows); }
}  // namespace i420

void I420::set(const RgbaPixels& pixels) {
  using i420::kPadding;
  width_ = pixels.width;
  height_ = pixels.height;
  const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
  // A vector of chroma may begin at the last pixels of a row.
  stride_ = (width / (2 * kPadding) + 2) * (2 * kPadding);
  values_.resize(stride_ * rows() * 3 / 2);
  sums_.resize(3 * stride_);
  std::uint8_t* const y = values_.data();
  std::uint8_t* const u = y + stride_ * rows();
  std::uint8_t* const v = u + chroma_stride() * rows() / 2;
  for (std::size_t row = 0; row < height; row += 2) {
    const std::uint8_t* const top = pixels.values.data() + 4 * width * row;
    const std::uint8_t* const bottom = row + 1 < height ? top + 4 * width : top;
    const std::size_t chroma = chroma_stride() * row / 2;
    i420::convert({top, bottom, width, y + stride_ * row, y + stride_ * (row + 1), u + chroma,
                   v + chroma, sums_.data(), stride_});
  }
}

}  // namespace qs
#endif
