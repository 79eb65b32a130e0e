// SPDX-License-Identifier: MIT
#include "learn/step/plan.h"

#include <numeric>
#include <type_traits>

namespace qs::train {
namespace {

// The rows `sources` of an array with `values` numbers per Gaussian; kZeros gives zeros.
template <class T>
std::vector<T> gathered(const std::vector<T>& array, std::size_t values,
                        const std::vector<std::uint32_t>& sources) {
  std::vector<T> result;
  result.reserve(sources.size() * values);
  for (const std::uint32_t source : sources)
    for (std::size_t k = 0; k < values; ++k)
      result.push_back(source == Plan::kZeros ? T{} : array[source * values + k]);
  return result;
}

Parameters gathered(const Parameters& parameters, const std::vector<std::uint32_t>& sources) {
  Parameters result;
  result.sh_degree = parameters.sh_degree;
  result.has_masks = parameters.has_masks;
  for_each_array(
      [&](std::size_t values, const auto& from, auto& to) { to = gathered(from, values, sources); },
      parameters, result);
  return result;
}

}  // namespace

GaussianFacts facts_of(const ModelState& state) {
  const Parameters& p = state.parameters;
  return {p.means,       p.log_scales,  p.rotations, p.opacity_logits,
          p.mask_logits, state.density, {},          state.growth};
}

void Plan::keep_all(const GaussianFacts& facts, int in_front_of) {
  iteration = in_front_of;
  means = facts.means;
  log_scales = facts.log_scales;
  opacity_logits = facts.opacity_logits;
  sources.resize(facts.size());
  std::iota(sources.begin(), sources.end(), 0u);
  moment_sources = sources;
  growth = facts.growth;
  clears_opacity_moments = resets_statistics = false;
}

void Plan::add_copy_of(std::size_t i) {
  for_each_array([i](auto& array) { array.push_back(array[i]); });
  moment_sources.back() = kZeros;
}

void Plan::replace(std::size_t i, std::size_t source) {
  const std::uint32_t moments = moment_sources[i];
  for_each_array([&](auto& array) { array[i] = array[source]; });
  moment_sources[i] = moments;
}

ModelState changed(const ModelState& state, const Plan& plan) {
  ModelState next;
  next.iteration = state.iteration;
  next.changed_before = plan.iteration;
  next.parameters.sh_degree = state.parameters.sh_degree;
  next.parameters.has_masks = state.parameters.has_masks;
  next.parameters.means = plan.means;
  next.parameters.log_scales = plan.log_scales;
  next.parameters.opacity_logits = plan.opacity_logits;
  next.parameters.rotations = gathered(state.parameters.rotations, 1, plan.sources);
  next.parameters.sh = gathered(state.parameters.sh, state.parameters.sh_stride(), plan.sources);
  if (state.parameters.has_masks)
    next.parameters.mask_logits = gathered(state.parameters.mask_logits, 1, plan.sources);
  next.adam = {gathered(state.adam.first, plan.moment_sources),
               gathered(state.adam.second, plan.moment_sources), state.adam.steps,
               state.adam.rest_steps};
  if (plan.clears_opacity_moments)
    for (Parameters* moments : {&next.adam.first, &next.adam.second})
      std::ranges::fill(moments->opacity_logits, 0.0f);
  next.color_field = state.color_field;
  next.codes = state.codes;
  next.density = state.density;
  next.growth = plan.growth;
  if (plan.resets_statistics) next.density.reset(plan.size());
  return next;
}

}  // namespace qs::train
