// SPDX-License-Identifier: MIT
#include "app/viewer/render/kept_frames.h"

namespace qs {

void KeptFrames::keep(const FrameRequest& request, const RenderedFrame& frame) {
  constexpr std::size_t kMost = 2;
  std::erase_if(frames_, [&](const Kept& kept) {
    return kept.picture != request.picture || kept.frame.shown.mode == frame.shown.mode;
  });
  if (request.picture < 0 || request.divisor > 1 || frame.texture.name != 0) return;
  frames_.push_back({request.picture, frame});
  if (frames_.size() > kMost) frames_.pop_front();
}

std::optional<RenderedFrame> KeptFrames::find(const FrameRequest& request) const {
  if (request.picture < 0 || request.divisor > 1 || frames_.empty() ||
      frames_.back().frame.shown.mode == request.settings.mode)
    return std::nullopt;
  for (const Kept& kept : frames_) {
    if (kept.picture != request.picture || kept.frame.shown.mode != request.settings.mode) continue;
    if (request.counted && kept.frame.shown.mode_pairs.empty()) return std::nullopt;
    RenderedFrame frame = kept.frame;
    frame.shown.version = request.version;
    return frame;
  }
  return std::nullopt;
}

}  // namespace qs
