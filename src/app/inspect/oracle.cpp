// SPDX-License-Identifier: MIT
#include "app/inspect/oracle.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/inspect/pixel.h"
#include "app/session/text.h"

namespace qs {
namespace {

constexpr float kAlphaTolerance = 2e-3f, kColorTolerance = 2e-3f;
constexpr int kBands = 16;  // of rows, between two looks at the stop token

void compare_pixels(const Image& color, const Image& truth, int tolerance, Verdict& verdict) {
  double squares = 0;
  const PixelBox& box = verdict.region;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      int largest = 0;
      for (int c = 0; c < 3; ++c) {
        const int d = std::abs(to_8bit(color.at(x, y, c)) - to_8bit(truth.at(x, y, c)));
        largest = std::max(largest, d);
        squares += d * d;
      }
      verdict.largest = std::max(verdict.largest, largest);
      if (largest <= tolerance) continue;
      ++verdict.different_pixels;
      if (!verdict.pixel) verdict.pixel = glm::ivec2(x, y);
    }
  }
  const double values = 3.0 * (box.x1 - box.x0) * (box.y1 - box.y0);
  verdict.psnr = squares > 0 ? 10 * std::log10(255.0 * 255.0 * values / squares)
                             : std::numeric_limits<double>::infinity();
}

bool in_front(const Contribution& a, const Contribution& b) {
  return a.depth != b.depth ? a.depth < b.depth : a.gaussian < b.gaussian;
}

/// Walks both front to back.
void find_gaussian(const PixelReport& mine, const PixelReport& truth, Verdict& verdict) {
  const auto blame = [&](std::uint32_t gaussian, Disagreement why) {
    verdict.gaussian = gaussian;
    verdict.why = why;
  };
  const auto stops_at = [](const PixelReport& pixel, std::uint32_t gaussian) {
    return pixel.stopped_by && pixel.stopped_by->gaussian == gaussian;
  };
  std::size_t i = 0, j = 0;
  while (i < mine.contributions.size() || j < truth.contributions.size()) {
    const Contribution* a = i < mine.contributions.size() ? &mine.contributions[i] : nullptr;
    const Contribution* b = j < truth.contributions.size() ? &truth.contributions[j] : nullptr;
    if (a && b && a->gaussian == b->gaussian) {
      if (std::abs(a->alpha - b->alpha) > kAlphaTolerance)
        return blame(a->gaussian, Disagreement::alpha);
      const glm::vec3 d = glm::abs(a->color - b->color);
      if (std::max({d.x, d.y, d.z}) > kColorTolerance)
        return blame(a->gaussian, Disagreement::color);
      ++i, ++j;
      continue;
    }
    const bool mine_is_next = a && (!b || in_front(*a, *b));
    const Contribution& next = mine_is_next ? *a : *b;
    if (stops_at(mine, next.gaussian) || stops_at(truth, next.gaussian))
      return blame(next.gaussian, Disagreement::stops);
    // Next to 1/255 rounding decides whether a contribution counts.
    if (next.alpha > kAlphaMin + kAlphaTolerance)
      return blame(next.gaussian, mine_is_next ? Disagreement::extra : Disagreement::missing);
    ++(mine_is_next ? i : j);
  }
}

PixelBox region_or_whole(const std::optional<PixelBox>& region, const Camera& camera) {
  return region.value_or(PixelBox{0, 0, camera.width, camera.height});
}

}  // namespace

Image reference_of(Renderer& cpu, const Camera& camera, RenderSettings settings,
                   std::optional<PixelBox> region_or_all, const Progress& progress) {
  const PixelBox region = region_or_whole(region_or_all, camera);
  settings.mode = kReferenceMode;
  Image image(camera.width, camera.height, 3);
  const int height = region.y1 - region.y0;
  const int band = std::max((height + kBands - 1) / kBands, 16);
  for (int y = region.y0; y < region.y1; y += band) {
    progress.update(static_cast<float>(y - region.y0) / static_cast<float>(height));
    Outputs outputs;
    outputs.region = {region.x0, y, region.x1, std::min(y + band, region.y1)};
    const Frame& frame = cpu.render(camera, settings, outputs, HostImage{}, progress.stop);
    for (int row = y; row < outputs.region->y1; ++row) {
      std::copy(frame.color.row(row) + 3 * region.x0, frame.color.row(row) + 3 * region.x1,
                image.row(row) + 3 * region.x0);
    }
  }
  progress.update(1);
  return image;
}

Verdict ask_oracle(Renderer& cpu, const Camera& camera, RenderSettings settings, const Frame& frame,
                   std::optional<PixelBox> region, int tolerance, const Progress& progress) {
  const Frame mine = frame;  // it may be the CPU renderer's own, which the reference overwrites
  const Image truth = reference_of(cpu, camera, settings, region, progress);
  return judge(cpu, camera, settings, mine, truth, region, tolerance, progress);
}

Verdict judge(Renderer& cpu, const Camera& camera, RenderSettings settings, const Frame& frame,
              const Image& truth, std::optional<PixelBox> region, int tolerance,
              const Progress& progress) {
  assert(!frame.color.values.empty() && !frame.trace.tile_begin.empty());
  Verdict verdict;
  verdict.region = region_or_whole(region, camera);
  compare_pixels(frame.color, truth, tolerance, verdict);
  if (!verdict.pixel) return verdict;
  const glm::ivec2 pixel = *verdict.pixel;
  verdict.tile = frame.grid.tile_of(pixel.x, pixel.y);
  const PixelReport mine = inspect_pixel(frame, pixel, settings.background);
  Outputs outputs;
  outputs.color = false;
  outputs.trace = true;
  outputs.region = {pixel.x, pixel.y, pixel.x + 1, pixel.y + 1};
  settings.mode = kReferenceMode;
  const Frame& reference = cpu.render(camera, settings, outputs, HostImage{}, progress.stop);
  find_gaussian(mine, inspect_pixel(reference, pixel, settings.background), verdict);
  return verdict;
}

std::string verdict_sentence(const Verdict& verdict, int tolerance) {
  if (!verdict.pixel) {
    return fmt::format("equal to the reference within {}/255, {} dB", tolerance,
                       decibels(verdict.psnr));
  }
  const std::string first = fmt::format(
      "{} pixels differ from the reference by more than {}/255, {} dB, first pixel {},{} in tile "
      "{}",
      grouped(verdict.different_pixels), tolerance, decibels(verdict.psnr), verdict.pixel->x,
      verdict.pixel->y, verdict.tile);
  const char* why = kDisagreements[static_cast<int>(verdict.why)];
  if (!verdict.gaussian) return fmt::format("{}, which {}", first, why);
  return fmt::format("{}, first Gaussian {}: the frame {}", first, *verdict.gaussian, why);
}

}  // namespace qs
