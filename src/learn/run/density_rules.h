// SPDX-License-Identifier: MIT
//
// Rules of density control (Kerbl et al. 2023) that several strategies share: how Gaussians are
// cloned and split, and which ones are removed.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "learn/run/strategy.h"

namespace qs::train {

inline constexpr double kLeastOpacity = 0.005, kResetOpacity = 0.01;
inline constexpr double kFinalOpacity = 0.1;  ///< final prunes remove lower opacities

inline double logit_of(double opacity) { return std::log(opacity / (1 - opacity)); }

/// A Gaussian that a strategy wants to clone or to split in two.
struct Candidate {
  std::uint32_t gaussian;
  double urgency;  ///< if the limit does not allow all candidates, the largest are chosen
  bool splits;
};

/// The choice of candidates by their mean gradients.
struct CandidateRule {
  double small;  ///< times the extent: smaller Gaussians are cloned, larger ones split
  std::optional<double> absolute_threshold = {};  ///< larger ones split by absolute gradients
  double least_share = 0;                         ///< of a Gaussian's pixels that are flagged
};
std::vector<Candidate> find_candidates(const IterationContext& context, const GaussianFacts& facts,
                                       const CandidateRule& rule);

/// Keeps the `number` most urgent candidates, in any order. Ties go to the lower index.
void keep_most_urgent(std::size_t number, std::vector<Candidate>& candidates);

/// A clone is a copy. The children of a split replace the Gaussian: they are smaller by 1.6, at
/// points drawn from it.
void clone_and_split(const IterationContext& context, const GaussianFacts& facts,
                     std::vector<Candidate> candidates, Plan& plan);

/// Removes Gaussians with an opacity below `least_opacity`, and after the first reset of opacities
/// also Gaussians larger than 10 % of the extent.
void prune(const IterationContext& context, double least_opacity, Plan& plan);

/// Removes Gaussians with an opacity below `least_opacity`, 0..1.
void remove_faint(double least_opacity, Plan& plan);

/// No opacity is above `most`, 0..1, afterwards. The moments of all opacities become 0.
void limit_opacities(double most, Plan& plan);

/// True if opacities are reset between this iteration and the next: every 3,000 iterations before
/// `end`, and with a white background also after 500.
bool resets_after(const TrainSettings& settings, int iteration, int end);

/// True if all Gaussians with an opacity below kFinalOpacity are removed between this iteration and
/// the next (FastGS, Ren et al. 2026, arXiv 2511.04283): 18,000, 21,000, 24,000 and 27,000, where
/// that is not before `first`.
bool final_prune_after(int iteration, int first);

}  // namespace qs::train
