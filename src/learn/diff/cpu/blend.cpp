// SPDX-License-Identifier: MIT
#include "learn/diff/cpu/blend.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <type_traits>

#include <glm/common.hpp>

#include "raster/kernel/composite.h"

namespace qs::cpu::diff {
namespace {

/// Calls f(kDeep, kDefaultRules), two std::bool_constant. `deep`: a frame with depths, or
/// derivatives by other pictures than the colour. For the default rules and three channels alone,
/// as in training, the tiles are also compiled with the rules as constants, which is 5 % faster.
template <int kChannels, class Real, class F>
void with_variant(const PixelRules<Real>& rules, bool deep, const F& f) {
  if (deep) return f(std::true_type{}, std::false_type{});
  if constexpr (kChannels == 3) {
    if (rules.are_default()) return f(std::false_type{}, std::true_type{});
  }
  f(std::false_type{}, std::false_type{});
}

/// The colours of the listed Gaussians.
template <class Real, int kChannels>
struct ColorsOf {
  const BlendInput<Real>& in;
  const FrameView<Real>& frame;

  Color<Real, kChannels> operator()(std::uint32_t slot) const {
    if constexpr (kChannels == 3) {
      if (!in.channels) return frame.splats[slot].color;
    }
    Color<Real, kChannels> color(0);
    for (int c = 0; c < in.channel_count; ++c) color[c] = in.channels.at(frame.gaussians[slot], c);
    return color;
  }
};

/// A picture that is not given is 0.
template <class Real>
Real value_of(const Pixels<const Real>& picture, int x, int y) {
  return picture ? picture.at(x, y) : Real(0);
}

// ---- forward

template <int kChannels, bool kDepth, bool kDefaultRules, class Real>
void blend_tile(const BlendInput<Real>& in, const FrameView<Real>& frame, std::size_t tile,
                const PixelState<Real>& state, const Pictures<Real>& out) {
  using ColorN = Color<Real, kChannels>;
  const TileBox box = TileBox::of(in.size, tile);
  const ColorsOf<Real, kChannels> colors{in, frame};
  const PixelRules<Real> rules = kDefaultRules ? PixelRules<Real>{} : in.rules;
  std::array<ColorN, kTilePixels> color;
  std::array<Real, kTilePixels> transmittance;
  std::array<std::uint32_t, kTilePixels> last{};
  std::array<bool, kTilePixels> live;
  std::array<Real, kDepth ? kTilePixels : 0> depth, inverse_depth;
  color.fill(ColorN(0));
  transmittance.fill(1);
  live.fill(true);
  depth.fill(0);
  inverse_depth.fill(0);

  // Composite the list front to back until all pixels have stopped.
  int left = box.width * box.height;
  const auto length =
      static_cast<std::uint32_t>(frame.list_begin[tile + 1] - frame.list_begin[tile]);
  const std::uint32_t* list = frame.listed + frame.list_begin[tile];
  for (std::uint32_t entry = 0; entry < length && left > 0; ++entry) {
    const std::uint32_t slot = list[entry];
    const auto& splat = frame.splats[slot];
    const ColorN own = colors(slot);
    box.for_each_pixel(frame.areas[slot], [&](int x, int y, std::size_t p) {
      if (!live[p]) return;
      const Real in_front = transmittance[p];
      Real alpha = 0;
      switch (composite(splat, static_cast<Real>(x), static_cast<Real>(y), transmittance[p], alpha,
                        rules)) {
        case Step::skips:
          break;
        case Step::blends:
          color[p] += alpha * in_front * own;
          if constexpr (kDepth) {
            depth[p] += alpha * in_front * frame.depths[slot];
            inverse_depth[p] += alpha * in_front / frame.depths[slot];
          }
          last[p] = entry + 1;
          break;
        case Step::stops:
          live[p] = false;
          --left;
          break;
      }
    });
  }

  // Add the background and store the pixels.
  ColorN background(0);
  for (int c = 0; c < in.channel_count && in.background != nullptr; ++c)
    background[c] = in.background[c];
  const auto channels = static_cast<std::size_t>(in.channel_count);
  box.for_each_pixel([&](int x, int y, std::size_t p) {
    const std::size_t at = in.size.pixel(x, y);
    const ColorN final_color = color[p] + transmittance[p] * background;
    for (int c = 0; c < in.channel_count; ++c) {
      state.color[at * channels + static_cast<std::size_t>(c)] = final_color[c];
      if (out.color) out.color.at(x, y, c) = final_color[c];
    }
    state.transmittance[at] = transmittance[p];
    state.last[at] = last[p];
    if (out.alpha) out.alpha.at(x, y) = 1 - transmittance[p];
    if constexpr (kDepth) {
      state.depth[at] = depth[p];
      state.inverse_depth[at] = inverse_depth[p];
      if (out.depth) out.depth.at(x, y) = depth[p];
      if (out.inverse_depth) out.inverse_depth.at(x, y) = inverse_depth[p];
    }
  });
}

// ---- backward

/// The pixels of a tile beside their colours, for derivatives by alpha and by depths.
template <class Real>
struct DeepPixels {
  std::array<Real, kTilePixels> end, depth_to_come, inverse_to_come;
  std::array<Real, kTilePixels> d_alpha, d_depth, d_inverse;

  void load(const PixelState<const Real>& state, std::size_t at, const Pictures<const Real>& by,
            int x, int y, std::size_t p) {
    end[p] = state.transmittance[at];
    depth_to_come[p] = state.depth != nullptr ? state.depth[at] : 0;
    inverse_to_come[p] = state.inverse_depth != nullptr ? state.inverse_depth[at] : 0;
    d_alpha[p] = value_of(by.alpha, x, y);
    d_depth[p] = value_of(by.depth, x, y);
    d_inverse[p] = value_of(by.inverse_depth, x, y);
  }

  /// Takes the Gaussian off the sums to come. Returns dL/dalpha, and adds to the derivative by z.
  Real blend(std::size_t p, Real alpha, Real in_front, Real z, Real& by_z) {
    const Real weight = alpha * in_front;
    depth_to_come[p] -= weight * z;
    inverse_to_come[p] -= weight / z;
    by_z += weight * (d_depth[p] - d_inverse[p] / (z * z));
    const Real rest = 1 - alpha;
    return d_alpha[p] * (end[p] / rest) + d_depth[p] * (z * in_front - depth_to_come[p] / rest) +
           d_inverse[p] * (in_front / z - inverse_to_come[p] / rest);
  }
};
struct NoDeepPixels {};

// Composites the tile front to back again. The final colour of a pixel is known, so the colour of
// the Gaussians behind is the difference to the colour so far.
template <int kChannels, bool kDeep, bool kDefaultRules, class Real>
void sum_tile(const BlendInput<Real>& in, const FrameView<Real>& frame, std::size_t tile,
              const PixelState<const Real>& state, const Pictures<const Real>& by,
              PairScratch<Real>& scratch) {
  using ColorN = Color<Real, kChannels>;
  using Stored = StoredSums<Real, kChannels>;
  const TileBox box = TileBox::of(in.size, tile);
  const ColorsOf<Real, kChannels> colors{in, frame};
  const auto channels = static_cast<std::size_t>(in.channel_count);
  const PixelRules<Real> rules = kDefaultRules ? PixelRules<Real>{} : in.rules;
  std::array<ColorN, kTilePixels> to_come, d_pixel;
  std::array<Real, kTilePixels> transmittance;
  std::array<std::uint32_t, kTilePixels> last{};
  std::conditional_t<kDeep, DeepPixels<Real>, NoDeepPixels> deep;
  transmittance.fill(1);
  std::uint32_t longest = 0;
  // Load the pixels of the tile.
  box.for_each_pixel([&](int x, int y, std::size_t p) {
    const std::size_t at = in.size.pixel(x, y);
    if constexpr (kChannels != 3) to_come[p] = d_pixel[p] = ColorN(0);
    for (int c = 0; c < in.channel_count; ++c) {
      to_come[p][c] = state.color[at * channels + static_cast<std::size_t>(c)];
      d_pixel[p][c] = by.color ? by.color.at(x, y, c) : Real(0);
    }
    last[p] = state.last[at];
    longest = std::max(longest, last[p]);
    if constexpr (kDeep) deep.load(state, at, by, x, y, p);
  });

  // Composite again, and sum the gradients of each pair.
  const std::uint64_t first = frame.list_begin[tile];
  for (std::uint32_t entry = 0; entry < longest; ++entry) {
    const std::uint32_t slot = frame.listed[first + entry];
    const auto& splat = frame.splats[slot];
    const ColorN own = colors(slot);
    typename Stored::Sums sums;
    glm::vec<2, Real> absolute(0);
    Real by_z = 0;
    box.for_each_pixel(frame.areas[slot], [&](int px, int py, std::size_t p) {
      if (entry >= last[p]) return;
      const auto x = static_cast<Real>(px), y = static_cast<Real>(py);
      const Real in_front = transmittance[p];
      Real alpha = 0;
      if (composite(splat, x, y, transmittance[p], alpha, rules) != Step::blends) return;
      to_come[p] -= alpha * in_front * own;
      Real d_alpha = alpha_gradient(own, alpha, in_front, to_come[p], d_pixel[p]);
      if constexpr (kDeep) d_alpha += deep.blend(p, alpha, in_front, frame.depths[slot], by_z);
      absolute += glm::abs(add_pixel<Real, ColorN>(
          splat, {x, y, alpha, in_front, to_come[p], d_pixel[p]}, d_alpha, sums, rules));
    });
    Stored::store(sums, first + entry, scratch.pairs);
    if (!scratch.absolute.empty()) scratch.absolute[first + entry] = absolute;
    if (!scratch.depths.empty()) scratch.depths[first + entry] = by_z;
  }
  // No pixel blends the rest of the list.
  const auto clear_rest = [&]<class T>(std::vector<T>& values, std::size_t per_pair) {
    if (values.empty()) return;
    std::fill(values.begin() + static_cast<std::ptrdiff_t>((first + longest) * per_pair),
              values.begin() + static_cast<std::ptrdiff_t>(frame.list_begin[tile + 1] * per_pair),
              T{0});
  };
  clear_rest(scratch.pairs, Stored::kNumbers);
  clear_rest(scratch.absolute, 1);
  clear_rest(scratch.depths, 1);
}

// Lists the pairs of every slot. Pairs are visited by tile, so each list is in the order of tiles.
template <class Real>
void order_by_slot(const FrameView<Real>& frame, PairScratch<Real>& scratch) {
  scratch.begin.assign(frame.slots + 1, 0);
  for (std::size_t pair = 0; pair < frame.pairs; ++pair) ++scratch.begin[frame.listed[pair] + 1];
  for (std::size_t slot = 0; slot < frame.slots; ++slot)
    scratch.begin[slot + 1] += scratch.begin[slot];
  scratch.order.resize(frame.pairs);
  std::vector<std::uint64_t> next(scratch.begin.begin(), scratch.begin.end() - 1);
  for (std::uint64_t pair = 0; pair < frame.pairs; ++pair)
    scratch.order[next[frame.listed[pair]]++] = pair;
}

/// Derivatives by the background: the transmittance behind the last Gaussian is its weight.
template <class Real>
void add_background(const BlendInput<Real>& in, const PixelState<const Real>& state,
                    const Pixels<const Real>& by, const Workers& workers, Real* out) {
  const auto height = static_cast<std::size_t>(in.size.height);
  const auto channels = static_cast<std::size_t>(in.channel_count);
  std::vector<double> rows(height * channels, 0);
  workers.for_each(by ? height : 0, 8, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < in.size.width; ++x) {
      const auto weight = static_cast<double>(state.transmittance[in.size.pixel(x, y)]);
      for (std::size_t c = 0; c < channels; ++c)
        rows[row * channels + c] += weight * static_cast<double>(by.at(x, y, static_cast<int>(c)));
    }
  });
  for (std::size_t c = 0; c < channels; ++c) {
    double sum = 0;
    for (std::size_t row = 0; row < height; ++row) sum += rows[row * channels + c];
    out[c] = static_cast<Real>(sum);
  }
}

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
    if (pixels > 0)
      std::atomic_ref(counts.at(frame.gaussians[slot]))
          .fetch_add(pixels, std::memory_order_relaxed);
  }
}

}  // namespace

template <class Real>
void blend(const BlendInput<Real>& in, const FrameView<Real>& frame, const Workers& workers,
           const PixelState<Real>& state, const Pictures<Real>& out) {
  in.check("blend", state.depth != nullptr, out.depth || out.inverse_depth);
  with_channels(in.channel_count, [&](auto channels) {
    constexpr int kChannels = channels();
    with_variant<kChannels>(in.rules, state.depth != nullptr, [&](auto deep, auto defaults) {
      workers.for_each(in.size.tiles(), 1, [&](std::size_t tile) {
        blend_tile<kChannels, deep(), defaults()>(in, frame, tile, state, out);
      });
    });
  });
}

template <int kChannels, class Real>
void sum_pairs(const BlendInput<Real>& in, const FrameView<Real>& frame,
               const PixelState<const Real>& state, const Pictures<const Real>& by, bool absolute,
               const Workers& workers, PairScratch<Real>& scratch) {
  const bool is_deep = by.alpha || by.depth || by.inverse_depth;
  scratch.pairs.resize(frame.pairs * StoredSums<Real, kChannels>::kNumbers);
  scratch.depths.resize(is_deep ? frame.pairs : 0);
  scratch.absolute.resize(absolute ? frame.pairs : 0);
  with_variant<kChannels>(in.rules, is_deep, [&](auto deep, auto defaults) {
    workers.for_each(in.size.tiles(), 1, [&](std::size_t tile) {
      sum_tile<kChannels, deep(), defaults()>(in, frame, tile, state, by, scratch);
    });
  });
  order_by_slot(frame, scratch);
}

template <class Real>
void blend_backward(const BlendInput<Real>& in, const FrameView<Real>& frame, std::size_t gaussians,
                    const PixelState<const Real>& state, const Pictures<const Real>& by,
                    const Workers& workers, PairScratch<Real>& scratch,
                    const BoundaryGradients<Real>& out) {
  in.check("blend_backward", state.depth != nullptr, by.depth || by.inverse_depth);
  workers.for_each(gaussians, 4096, [&](std::size_t i) {
    out.by.clear(i);
    out.channels.fill(i, in.channel_count, 0);
    out.absolute_px.fill(i, 2, 0);
  });
  if (out.background != nullptr) add_background(in, state, by.color, workers, out.background);
  with_channels(in.channel_count, [&](auto channels) {
    constexpr int kChannels = channels();
    sum_pairs<kChannels>(in, frame, state, by, static_cast<bool>(out.absolute_px), workers,
                         scratch);
    workers.for_each(frame.counts.size(), 1, [&](std::size_t chunk) {
      frame.for_chunk(chunk, [&](std::size_t slot) {
        const auto gradient = SlotGradient<Real, kChannels>::of(frame, slot, scratch);
        const std::uint32_t i = frame.gaussians[slot];
        out.by.mean_px.set(i, gradient.splat.mean_px);
        out.by.conic.set(i, gradient.splat.conic);
        out.by.depth.set(i, gradient.depth);
        out.by.opacity.set(i, gradient.splat.opacity);
        out.absolute_px.set(i, gradient.absolute);
        const Rows<Real>& color = in.channels ? out.channels : out.by.color;
        for (int c = 0; c < in.channel_count && color; ++c)
          color.at(i, c) = gradient.splat.color[c];
      });
    });
  });
}

template decltype(blend<float>) blend<float>;
template decltype(blend<double>) blend<double>;
template decltype(blend_backward<float>) blend_backward<float>;
template decltype(blend_backward<double>) blend_backward<double>;
template decltype(sum_pairs<3, float>) sum_pairs<3, float>;
template decltype(sum_pairs<3, double>) sum_pairs<3, double>;

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
