// SPDX-License-Identifier: MIT
#include "app/inspect/reference_check.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/inspect/pixel.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr float kAlphaTolerance = 2e-3f, kColorTolerance = 2e-3f;
constexpr int kBands = 16;  // bands of rows; progress and cancellation are checked between them

// The frame's behaviour in words, index = Disagreement.
constexpr const char* kDisagreements[] = {"does not blend it",
                                          "should not blend it",
                                          "blends it with another alpha",
                                          "blends it with another colour",
                                          "stops at another Gaussian",
                                          "differs by rounding only"};

bool in_front(const Contribution& a, const Contribution& b) {
  return a.depth != b.depth ? a.depth < b.depth : a.gaussian < b.gaussian;
}

/// Walks both lists of contributions front to back and stores the first disagreement.
void find_gaussian(const PixelReport& mine, const PixelReport& truth, ReferenceCheck& check) {
  const auto blame = [&](std::uint32_t gaussian, Disagreement why) {
    check.gaussian = gaussian;
    check.why = why;
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
    // Close to 1/255, rounding decides whether a contribution counts.
    if (next.alpha > kAlphaMin + kAlphaTolerance)
      return blame(next.gaussian, mine_is_next ? Disagreement::extra : Disagreement::missing);
    ++(mine_is_next ? i : j);
  }
}

}  // namespace

Image render_reference(Renderer& cpu, const CheckedView& view, const Progress& progress) {
  const PixelBox region = view.pixels();
  RenderSettings settings = view.settings;
  settings.mode = kReferenceMode;
  Image image(view.camera.width, view.camera.height, 3);
  const int height = region.y1 - region.y0;
  const int band = std::max((height + kBands - 1) / kBands, 16);
  for (int y = region.y0; y < region.y1; y += band) {
    progress.update(static_cast<float>(y - region.y0) / static_cast<float>(height));
    const PixelBox part{region.x0, y, region.x1, std::min(y + band, region.y1)};
    const Frame& frame =
        cpu.render(view.camera, settings, {.region = part}, HostImage{}, progress.stop);
    for (int row = y; row < part.y1; ++row)
      std::copy(frame.color.row(row) + 3 * part.x0, frame.color.row(row) + 3 * part.x1,
                image.row(row) + 3 * part.x0);
  }
  progress.update(1);
  return image;
}

ReferenceCheck check_against_reference(Renderer& cpu, const CheckedView& view, const Frame& frame,
                                       const Image& reference, int tolerance,
                                       const Progress& progress) {
  assert(!frame.color.values.empty() && !frame.trace.tile_begin.empty());
  ReferenceCheck check;
  check.region = view.pixels();
  check.difference = image_difference(frame.color, reference, check.region, tolerance);
  if (!check.difference.first) return check;
  const glm::ivec2 pixel = *check.difference.first;
  check.tile = frame.grid.tile_of(pixel.x, pixel.y);
  const PixelReport mine = inspect_pixel(frame, pixel, view.settings.background);
  // Walk the same pixel in the reference.
  const Outputs outputs{.color = false,
                        .trace = true,
                        .region = PixelBox{pixel.x, pixel.y, pixel.x + 1, pixel.y + 1}};
  RenderSettings settings = view.settings;
  settings.mode = kReferenceMode;
  const Frame& truth = cpu.render(view.camera, settings, outputs, HostImage{}, progress.stop);
  find_gaussian(mine, inspect_pixel(truth, pixel, settings.background), check);
  return check;
}

const char* disagreement_text(Disagreement why) { return kDisagreements[static_cast<int>(why)]; }

std::string check_sentence(const ReferenceCheck& check, int tolerance) {
  const ImageDifference& difference = check.difference;
  const std::string psnr = decibels(difference.psnr);
  if (!difference.first)
    return fmt::format("equal to the reference within {}/255, {} dB", tolerance, psnr);
  const std::string first = fmt::format(
      "{} pixels differ from the reference by more than {}/255, {} dB, first pixel {},{} in tile "
      "{}",
      grouped(difference.pixels), tolerance, psnr, difference.first->x, difference.first->y,
      check.tile);
  const char* why = disagreement_text(check.why);
  if (!check.gaussian) return fmt::format("{}, which {}", first, why);
  return fmt::format("{}, first Gaussian {}: the frame {}", first, *check.gaussian, why);
}

}  // namespace qs
