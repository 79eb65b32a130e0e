// SPDX-License-Identifier: MIT
//
// A plan that changes the set of Gaussians. A strategy reads a few numbers per Gaussian and makes
// the plan, which names the old Gaussian that each new one comes from. The backend, whose memory
// holds the rest of the model, gathers by the plan.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "learn/step/model_state.h"
#include "raster/kernel/activation.h"

namespace qs::train {

/// Pixels per Gaussian, over the views that TrainingModel::count_errors() has counted since the set
/// last changed. Empty if there are none.
struct PixelCounts {
  std::vector<std::uint32_t> blended;  ///< pixels that blend the Gaussian
  /// The blended pixels with a large error, see kernel/error_map.h.
  std::vector<std::uint32_t> flagged;

  /// The share of a Gaussian's pixels that are flagged, 0..1; 0 if no pixel blends it.
  double flagged_share(std::size_t i) const {
    return blended.empty() || blended[i] == 0 ? 0 : static_cast<double>(flagged[i]) / blended[i];
  }
};

/// The numbers per Gaussian from which strategies decide.
struct GaussianFacts {
  std::vector<glm::vec3> means, log_scales;
  std::vector<glm::quat> rotations;
  std::vector<float> opacity_logits;
  std::vector<float> mask_logits;  ///< empty without masks
  DensityStatistics density;
  PixelCounts counts;
  GrowthState growth;

  std::size_t size() const { return means.size(); }
};

/// Without counts.
GaussianFacts facts_of(const ModelState& state);

/// Opacity and largest standard deviation of Gaussian i of facts, a plan or parameters.
template <class Gaussians>
double opacity(const Gaussians& gaussians, std::size_t i) {
  return opacity_of(static_cast<double>(gaussians.opacity_logits[i]));
}
template <class Gaussians>
double largest_scale(const Gaussians& gaussians, std::size_t i) {
  const glm::vec3& s = gaussians.log_scales[i];
  return std::exp(static_cast<double>(std::max(s.x, std::max(s.y, s.z))));
}

struct Plan {
  static constexpr std::uint32_t kZeros = std::numeric_limits<std::uint32_t>::max();

  int iteration = 0;  ///< the set changes before this iteration

  // Per new Gaussian.
  std::vector<glm::vec3> means, log_scales;
  std::vector<float> opacity_logits;
  std::vector<std::uint32_t> sources;  ///< the old Gaussian whose rotation, SH and mask it gets
  /// the old Gaussian whose moments it gets; kZeros: moments 0
  std::vector<std::uint32_t> moment_sources;

  GrowthState growth;                   ///< after the change
  bool clears_opacity_moments = false;  ///< also of Gaussians that keep their other moments
  bool resets_statistics = false;       ///< must be true if the set changes

  /// Makes this a plan for the change before `iteration` that keeps every Gaussian as it is. Reuses
  /// the memory.
  void keep_all(const GaussianFacts& facts, int in_front_of);

  std::size_t size() const { return means.size(); }

  /// Appends a copy of new Gaussian i, without moments.
  void add_copy_of(std::size_t i);

  /// New Gaussian i becomes a copy of new Gaussian `source`, but keeps its moments.
  void replace(std::size_t i, std::size_t source);

  /// Keeps the new Gaussians with keeps(i), in their order.
  template <class Keeps>
  void keep_if(const Keeps& keeps) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      if (!keeps(i)) continue;
      for_each_array([&](auto& array) { array[kept] = array[i]; });
      ++kept;
    }
    for_each_array([&](auto& array) { array.resize(kept); });
  }

 private:
  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(means);
    visit(log_scales);
    visit(opacity_logits);
    visit(sources);
    visit(moment_sources);
  }
};

/// The state after the change. `state` stays as it is, so nothing is lost if memory runs out.
ModelState changed(const ModelState& state, const Plan& plan);

}  // namespace qs::train
