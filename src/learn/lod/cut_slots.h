// SPDX-License-Identifier: MIT
//
// The cuts of successive views in the slots of one cloud: a renderer reads the nodes again that
// differ from the cut before, and the other nodes stay where they are.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raster/pages/page_stream.h"
#include "raster/scene/gaussian_set.h"

namespace qs {

/// A part of a step between cuts.
struct CutPart {
  std::vector<std::uint32_t> slots = {};    ///< slots of the cloud that have other Gaussians now
  GaussianCloud gaussians = {};             ///< for `slots`
  std::vector<std::uint32_t> toggled = {};  ///< slots that are drawn now, or no more
};

/// The step from the cut before: a whole cloud or parts.
struct CutChange {
  std::shared_ptr<GaussianCloud> whole = {};  ///< to upload; or null
  GaussianSet drawn = GaussianSet();          ///< slots of `whole`
  GaussianSet selected = GaussianSet();       ///< slots of nodes in LodPage::selected
  std::vector<CutPart> parts = {};            ///< after each of them the drawn slots are a cut
};

class CutSlots {
 public:
  /// `exact`: all Gaussians are as cut_cloud() makes them, in its order, so the cuts before do not
  /// matter. Otherwise nodes that stay keep their slots, and their opacities until the variance of
  /// the filter at a node differs by kRefit; a call looks at an eighth of the pages.
  CutChange follow(const StreamedCut& made, const LodView& view, double dilation, bool exact,
                   ThreadPool& pool);

  const LodCut& shown() const { return shown_; }  ///< the last cut

  static constexpr float kRefit = 1.1f;  ///< factor

 private:
  CutChange whole(const StreamedCut& made, const LodView& view, double dilation, ThreadPool& pool);
  CutChange parts(const StreamedCut& made, const LodView& view, double dilation, ThreadPool& pool);

  LodCut shown_;
  std::uint32_t turn_ = 0;                         // decides the pages that a call looks at
  std::vector<std::vector<std::uint32_t>> slots_;  // by page and row; empty without drawn nodes
  std::vector<std::uint32_t> free_;                // slots
  std::vector<float> variances_;                   // by slot: of the filter, world units^2
  GaussianSet drawn_;                              // slots
};

}  // namespace qs
