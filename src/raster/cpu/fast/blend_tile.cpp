// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/blend_tile.h"

#include <algorithm>
#include <bit>

#include "raster/kernel/constants.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/cpu/fast/blend_tile.cpp"
#include "raster/cpu/fast/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::cpu::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kTileSize>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
/// A row of a tile is cut into strips of one vector.
constexpr int kStrips = kTileSize / kLanes;

/// List entries ahead of the one being blended whose records are fetched: they lie scattered.
constexpr std::uint32_t kPrefetch = 8;

/// kernel/blend.h's exp2_polynomial().
HWY_INLINE V exp2_polynomial(D d, V x) {
  const hn::RebindToUnsigned<D> du;
  x = hn::Max(x, hn::Set(d, -126.0f));
  const V round = hn::Set(d, 12582912.0f);
  const V shifted = hn::Add(x, round);
  const V fraction = hn::Sub(x, hn::Sub(shifted, round));
  V p = hn::Set(d, 0.001326472731307149f);
  p = hn::MulAdd(p, fraction, hn::Set(d, 0.009671512991189957f));
  p = hn::MulAdd(p, fraction, hn::Set(d, 0.05550733581185341f));
  p = hn::MulAdd(p, fraction, hn::Set(d, 0.24022242426872253f));
  p = hn::MulAdd(p, fraction, hn::Set(d, 0.6931470036506653f));
  p = hn::MulAdd(p, fraction, hn::Set(d, 1.0f));
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(du, shifted));
  return hn::BitCast(d, hn::Add(hn::BitCast(du, p), exponent));
}

HWY_INLINE std::uint32_t bits_of(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
}

/// A tile while it is composited: planes of pixels, row by row.
struct Tile {
  static constexpr int kPixels = kTileSize * kTileSize;

  alignas(64) float transmittance[kPixels];
  alignas(64) float red[kPixels];
  alignas(64) float green[kPixels];
  alignas(64) float blue[kPixels];
  alignas(64) float alpha_min[kPixels];  ///< what counts: kAlphaMin until the pixel stops, then inf
  std::uint32_t live_rows[kStrips];      ///< bit y: a pixel of that strip in row y is not finished
  std::uint32_t evaluated[kPixels];      ///< list entries up to and including the one it stopped at

  Tile(int width, int height, std::uint32_t length) {
    for (int i = 0; i < kPixels; ++i) {
      const bool inside = i % kTileSize < width && i / kTileSize < height;
      transmittance[i] = 1;
      red[i] = green[i] = blue[i] = 0;
      alpha_min[i] = inside ? kAlphaMin : INFINITY;
      evaluated[i] = length;
    }
    for (int strip = 0; strip < kStrips; ++strip)
      live_rows[strip] = strip * kLanes < width ? (1u << height) - 1 : 0;
  }

  bool live() const {
    std::uint32_t any = 0;
    for (const std::uint32_t rows : live_rows) any |= rows;
    return any != 0;
  }
};

/// Bit y: row y of the strip whose pixels are dx0 .. dx0 + kLanes - 1 from the mean can have a
/// pixel that counts. Errs towards yes; dy0 belongs to row 0.
HWY_INLINE std::uint32_t reached_rows(D d, const Record& record, float dx0, float dy0) {
  std::uint32_t rows = 0;
  const V a = hn::Set(d, record.a), b = hn::Set(d, record.b), c = hn::Set(d, record.c);
  for (int y = 0; y < kTileSize; y += kLanes) {
    const V dy = hn::Add(hn::Set(d, dy0), hn::Iota(d, static_cast<float>(y)));
    const V x = hn::Min(hn::Max(hn::Mul(hn::Set(d, record.slope), dy), hn::Set(d, dx0)),
                        hn::Set(d, dx0 + (kLanes - 1)));
    const V xx = hn::Mul(a, hn::Mul(x, x)), yy = hn::Mul(c, hn::Mul(dy, dy));
    const V sum = hn::Add(xx, yy);
    // The terms cancel on needles, which leaves their rounding.
    const V largest = hn::MulAdd(hn::Set(d, -4e-6f), sum, hn::MulAdd(b, hn::Mul(x, dy), sum));
    rows |= bits_of(d, hn::Ge(largest, hn::Set(d, record.threshold))) << y;
  }
  return rows;
}

/// Takes the pixels of `stop` out of the tile. `entry` is the 1-based place of the Gaussian.
HWY_NOINLINE void stop_pixels(Tile& tile, int strip, int y, std::uint32_t stop,
                              std::uint32_t entry) {
  const int first = y * kTileSize + strip * kLanes;
  bool any = false;
  for (int lane = 0; lane < kLanes; ++lane) {
    if ((stop >> lane & 1) != 0) {
      tile.alpha_min[first + lane] = INFINITY;
      tile.evaluated[first + lane] = entry;
    }
    any = any || tile.alpha_min[first + lane] == kAlphaMin;
  }
  if (!any) tile.live_rows[strip] &= ~(1u << y);
}

HWY_INLINE void blend_one(D d, const Record& record, float x0, float y0, std::uint32_t entry,
                          Tile& tile) {
  const float dx_of_tile = x0 - record.mean_x, dy_of_tile = y0 - record.mean_y;
  const V opacity = hn::Set(d, record.opacity), b = hn::Set(d, record.b), c = hn::Set(d, record.c);
  const V red = hn::Set(d, record.red), green = hn::Set(d, record.green),
          blue = hn::Set(d, record.blue);
  for (int strip = 0; strip < kStrips; ++strip) {
    const float dx0 = dx_of_tile + static_cast<float>(strip * kLanes);
    std::uint32_t rows = tile.live_rows[strip];
    if (rows == 0) continue;
    if (kStrips > 1 && (dx0 > record.half_x || dx0 + (kLanes - 1) < -record.half_x)) continue;
    rows &= reached_rows(d, record, dx0, dy_of_tile);
    const V dx = hn::Add(hn::Set(d, dx0), hn::Iota(d, 0.0f));
    const V axx = hn::Mul(hn::Mul(hn::Set(d, record.a), dx), dx), bx = hn::Mul(b, dx);
    for (; rows != 0; rows &= rows - 1) {
      const int y = std::countr_zero(rows);
      const int at = y * kTileSize + strip * kLanes;
      const V dy = hn::Set(d, dy_of_tile + static_cast<float>(y));
      const V power = hn::MulAdd(dy, hn::MulAdd(c, dy, bx), axx);
      const V whole = hn::Min(hn::Mul(opacity, exp2_polynomial(d, power)), hn::Set(d, kAlphaMax));
      const M counts =
          hn::And(hn::Ge(whole, hn::Load(d, tile.alpha_min + at)), hn::Le(power, hn::Zero(d)));
      V alpha = hn::IfThenElseZero(counts, whole);
      const V before = hn::Load(d, tile.transmittance + at);
      V after = hn::NegMulAdd(alpha, before, before);
      const M stop = hn::Lt(after, hn::Set(d, kTransmittanceMin));
      if (HWY_UNLIKELY(!hn::AllFalse(d, stop))) {
        stop_pixels(tile, strip, y, bits_of(d, stop), entry);
        alpha = hn::IfThenZeroElse(stop, alpha);
        after = hn::IfThenElse(stop, before, after);
      }
      const V weight = hn::Mul(alpha, before);
      hn::Store(after, d, tile.transmittance + at);
      hn::Store(hn::MulAdd(weight, red, hn::Load(d, tile.red + at)), d, tile.red + at);
      hn::Store(hn::MulAdd(weight, green, hn::Load(d, tile.green + at)), d, tile.green + at);
      hn::Store(hn::MulAdd(weight, blue, hn::Load(d, tile.blue + at)), d, tile.blue + at);
    }
  }
}

HWY_INLINE void write_color(const TileJob& job, Tile& tile) {
  const D d;
  alignas(64) float row[3 * kTileSize];
  for (int y = 0; y < job.height; ++y) {
    float* to = job.color + 3 * static_cast<std::size_t>(y) * job.stride;
    float* packed = job.width == kTileSize ? to : row;
    for (int x = 0; x < kTileSize; x += kLanes) {
      const int at = y * kTileSize + x;
      const V rest = hn::Load(d, tile.transmittance + at);
      hn::StoreInterleaved3(
          hn::MulAdd(rest, hn::Set(d, job.background.x), hn::Load(d, tile.red + at)),
          hn::MulAdd(rest, hn::Set(d, job.background.y), hn::Load(d, tile.green + at)),
          hn::MulAdd(rest, hn::Set(d, job.background.z), hn::Load(d, tile.blue + at)), d,
          packed + 3 * x);
    }
    if (packed == row) std::copy_n(row, 3 * job.width, to);
  }
}

void blend_one_tile(const TileJob& job) {
  const D d;
  Tile tile(job.width, job.height, job.length);
  const auto x0 = static_cast<float>(job.x0), y0 = static_cast<float>(job.y0);
  for (std::uint32_t entry = 0; entry < job.length && tile.live(); ++entry) {
    if (entry + kPrefetch < job.length)
      __builtin_prefetch(&job.records[job.list[entry + kPrefetch]]);
    blend_one(d, job.records[job.list[entry]], x0, y0, entry + 1, tile);
  }
  if (job.color != nullptr) write_color(job, tile);
  if (job.evaluated != nullptr) {
    for (int y = 0; y < job.height; ++y)
      std::copy_n(tile.evaluated + y * kTileSize, job.width,
                  job.evaluated + static_cast<std::size_t>(y) * job.stride);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::cpu::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::cpu::fast {

HWY_EXPORT(blend_one_tile);

void blend_tile(const TileJob& job) { HWY_DYNAMIC_DISPATCH(blend_one_tile)(job); }

}  // namespace qs::cpu::fast
#endif
