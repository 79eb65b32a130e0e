// SPDX-License-Identifier: MIT
#include <array>
#include <atomic>

#include "learn/diff/cpu/blend.h"
#include "raster/kernel/composite.h"

namespace qs::cpu::diff {
namespace {

template <class Real>
void count_tile(const PictureSize& size, const PixelRules<Real>& rules,
                const FrameView<Real>& frame, std::size_t tile, Real behind,
                const qs::diff::Rows<std::int32_t>& counts) {
  const TileBox box = TileBox::of(size, tile);
  std::array<Real, kTilePixels> transmittance;
  std::array<bool, kTilePixels> live;
  transmittance.fill(1);
  live.fill(true);
  int left = box.width * box.height;
  for (std::uint64_t at = frame.list_begin[tile]; at < frame.list_begin[tile + 1] && left > 0;
       ++at) {
    const std::uint32_t slot = frame.listed[at];
    std::int32_t pixels = 0;
    box.for_each_pixel(frame.areas[slot], [&](int x, int y, std::size_t p) {
      if (!live[p]) return;
      Real alpha = 0;
      const Step step = composite(frame.splats[slot], static_cast<Real>(x), static_cast<Real>(y),
                                  transmittance[p], alpha, rules);
      if (step == Step::skips) return;
      if (step == Step::blends && transmittance[p] > behind) {
        ++pixels;
      } else {  // the Gaussians behind this one do not count either
        live[p] = false;
        --left;
      }
    });
    // Several tiles may add to a Gaussian. The order does not matter for integers.
    if (pixels > 0) {
      std::atomic_ref(counts.at(frame.gaussians[slot]))
          .fetch_add(pixels, std::memory_order_relaxed);
    }
  }
}

}  // namespace

template <class Real>
void count_pixels(const PictureSize& size, const PixelRules<Real>& rules,
                  const FrameView<Real>& frame, std::size_t gaussians, Real behind,
                  const Workers& workers, const qs::diff::Rows<std::int32_t>& counts) {
  workers.for_each(gaussians, 4096, [&](std::size_t i) { counts.at(i) = 0; });
  workers.for_each(size.tiles(), 1,
                   [&](std::size_t tile) { count_tile(size, rules, frame, tile, behind, counts); });
}

template decltype(count_pixels<float>) count_pixels<float>;
template decltype(count_pixels<double>) count_pixels<double>;

}  // namespace qs::cpu::diff
