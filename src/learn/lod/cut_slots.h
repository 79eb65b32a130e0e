// SPDX-License-Identifier: MIT
//
// The cuts of successive views in the slots of one cloud: a renderer reads the nodes again that
// differ from the cut before, and the other nodes stay where they are.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/pages/page_stream.h"
#include "raster/scene/gaussian_set.h"

namespace qs {

/// The step from the cut before.
struct CutChange {
  GaussianCloud whole = {};               ///< the cloud, if it has to be uploaded; otherwise empty
  std::vector<std::uint32_t> slots = {};  ///< slots of the cloud that have other Gaussians now
  GaussianCloud gaussians = {};           ///< for `slots`
  GaussianSet drawn = GaussianSet();      ///< the slots of the cut; of size 0: all
  GaussianSet selected = GaussianSet();   ///< slots of nodes in LodPage::selected
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

  LodCut shown_;
  std::uint32_t turn_ = 0;                         // decides the pages that a call looks at
  std::vector<std::vector<std::uint32_t>> slots_;  // by page and row; empty without drawn nodes
  std::vector<std::uint32_t> free_;                // slots
  std::vector<float> variances_;                   // by slot: of the filter, world units^2
  GaussianSet drawn_;                              // slots
};

}  // namespace qs
