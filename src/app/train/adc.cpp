// SPDX-License-Identifier: MIT
//
// Adaptive density control (Kerbl et al. 2023, with the defaults of the published code). Gaussians
// that the loss wants to move far on the image are cloned if they are small and split in two if
// they are large; nearly transparent ones are removed. From time to time all become nearly
// transparent, so that those which nothing needs do not return. The published rule that removes
// Gaussians larger than 20 pixels never acts in the published code, and is left out.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/train/strategy.h"
#include "raster/kernel/gradient/activation.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr int kInterval = 100, kFirst = 600, kEnd = 15'000;  // densification: first, and not at end
constexpr int kResetInterval = 3000, kWhiteReset = 500;
constexpr float kGradientThreshold = 2e-4f;
constexpr double kSmall = 0.01, kHuge = 0.1;  // times the extent
constexpr double kLeastOpacity = 0.005, kResetOpacity = 0.01;
constexpr double kSplitShrink = 1.6;

// Whether Gaussians are added and removed between this iteration and the next.
bool changes_after(int iteration) {
  return iteration >= kFirst && iteration < kEnd && iteration % kInterval == 0;
}

// The Gaussians to clone or split, ascending; the ones with the largest gradients if the limit does
// not allow all.
std::vector<std::uint32_t> chosen(const ModelContext& context) {
  const ModelState& model = context.model;
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < model.size(); ++i) {
    if (model.density.mean(i) > kGradientThreshold) rows.push_back(i);
  }
  const std::size_t limit =
      find_strategy(context.settings.strategy).max_gaussians(context.settings);
  if (limit == 0) return rows;
  const std::size_t room = limit > model.size() ? limit - model.size() : 0;
  if (rows.size() <= room) return rows;
  std::stable_sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return model.density.mean(a) > model.density.mean(b);
  });
  rows.resize(room);
  std::sort(rows.begin(), rows.end());
  return rows;
}

// Replaces Gaussian `child`, a copy, by a smaller one at a point drawn from it.
void shrink_child(Parameters& parameters, std::size_t child, const glm::dvec3& normal) {
  const glm::dmat3 rotation =
      glm::mat3_cast(unit_rotation(glm::dquat(parameters.rotations[child])));
  const glm::dvec3 scale = glm::exp(glm::dvec3(parameters.log_scales[child]));
  parameters.means[child] += glm::vec3(rotation * (scale * normal));
  parameters.log_scales[child] -= static_cast<float>(std::log(kSplitShrink));
}

void clone_and_split(const ModelContext& context) {
  ModelState& model = context.model;
  std::vector<std::uint32_t> clones, splits;
  for (const std::uint32_t i : chosen(context)) {
    const bool small = largest_scale(model.parameters, i) <= kSmall * context.extent;
    (small ? clones : splits).push_back(i);
  }
  model.duplicate(clones);
  const std::size_t first_child = model.size();
  model.duplicate(splits);
  model.duplicate(splits);
  const Random random = Random::of(context.settings.seed, RandomUse::split,
                                   static_cast<std::uint64_t>(context.iteration));
  for (std::size_t child = first_child; child < model.size(); ++child)
    shrink_child(model.parameters, child, random.normal3(child - first_child));

  // The children replace the Gaussians that were split.
  std::vector<std::uint32_t> kept(model.size());
  std::iota(kept.begin(), kept.end(), 0u);
  kept.erase(std::remove_if(kept.begin(), kept.end(),
                            [&](std::uint32_t i) {
                              return std::binary_search(splits.begin(), splits.end(), i);
                            }),
             kept.end());
  model.keep(kept);
}

void prune(const ModelContext& context, int last) {
  ModelState& model = context.model;
  const bool after_reset = last > kResetInterval;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < model.size(); ++i) {
    const bool huge = after_reset && largest_scale(model.parameters, i) > kHuge * context.extent;
    if (opacity(model.parameters, i) >= kLeastOpacity && !huge) kept.push_back(i);
  }
  model.keep(kept);
}

void reset_opacities(ModelState& model) {
  const auto most = static_cast<float>(std::log(kResetOpacity / (1 - kResetOpacity)));
  for (float& logit : model.parameters.opacity_logits) logit = std::min(logit, most);
  auto& adam = model.adam;
  std::fill(adam.first.opacity_logits.begin(), adam.first.opacity_logits.end(), 0.0f);
  std::fill(adam.second.opacity_logits.begin(), adam.second.opacity_logits.end(), 0.0f);
}

}  // namespace

void adc_prepare(const ModelContext& context) {
  const int last = context.iteration - 1;
  if (changes_after(last)) {
    clone_and_split(context);
    prune(context, last);
  }
  const bool reset = last > 0 && last < kEnd && last % kResetInterval == 0;
  if (reset || (context.settings.white() && last == kWhiteReset)) reset_opacities(context.model);
}

void adc_step(const StepContext& context) {
  if (context.iteration < kEnd)
    context.model.density.add(context.gradients, context.width, context.height);
  if (!changes_after(context.iteration)) context.take_step();
}

}  // namespace qs::train
