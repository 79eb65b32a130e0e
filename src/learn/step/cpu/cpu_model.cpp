// SPDX-License-Identifier: MIT
#include "learn/step/cpu/cpu_model.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "learn/step/cpu/field_pass.h"
#include "learn/step/cpu/passes.h"
#include "learn/step/shape_codes.h"
#include "raster/scene/image_metrics.h"

namespace qs::cpu::train {

void CpuModel::set_state(ModelState state) {
  state_ = std::move(state);
  counts_ = {};
}

const GaussianFacts& CpuModel::facts() {
  facts_ = facts_of(state_);
  facts_.counts = counts_;
  return facts_;
}

void CpuModel::forward(const Camera& camera, const RenderSettings& settings, std::stop_token stop) {
  camera_ = camera;
  settings_ = settings;
  stop_ = std::move(stop);
  field_.reset();
  if (state_.color_field.exists()) {
    const ColorField& field = state_.color_field.field;
    field_.emplace(field.grid, field.width, field.grid_values, field.weights);
  }
  if (state_.codes.exist()) code_shapes(state_.parameters, state_.codes, pool_, coded_);
  train::forward(view(), drawn(), frame_, field());
}

Quality CpuModel::quality(const Photograph& photograph) {
  const auto image_of = [&](const std::vector<glm::vec3>& pixels) {
    Image image(camera_.width, camera_.height, 3);
    assert(3 * pixels.size() == image.values.size());
    std::copy_n(&pixels[0][0], image.values.size(), image.values.begin());
    return image;
  };
  Image image = image_of(frame_.color);
  clamp_to_unit(image);
  const Image target = image_of(photograph.over(settings_.background));
  return {psnr(image, target, pool_, photograph.mask),
          ssim(image, target, pool_, SsimBorder::zeros, photograph.mask)};
}

void CpuModel::compare_with(std::optional<std::size_t> /*number*/, const Photograph& photograph) {
  const std::vector<glm::vec3> target = photograph.over(settings_.background);
  assert(target.size() == frame_.color.size());
  result_ = compare<float>({camera_.width, camera_.height, frame_.color, target, photograph.mask},
                           pool_, loss_, d_color_);
}

void CpuModel::count_errors(std::optional<std::size_t> /*number*/, const Photograph& photograph) {
  train::count_errors(view(), frame_, photograph.over(settings_.background), photograph.mask,
                      size(), counts_);
}

void CpuModel::backward(const BackwardOrder& order) {
  train::backward<float>(view(), drawn(), frame_, d_color_, backward_, gradients_, order, field());
  if (state_.codes.exist()) pass_through_codes(state_.parameters, coded_, pool_, gradients_.by);
}

void CpuModel::step(const StepOrder& order) {
  if (order.counts_density)
    add_view(gradients_, order.counts_by_mode ? frame_.listed : gradients_.visible, camera_.width,
             camera_.height, state_.density);
  qs::train::Parameters& p = state_.parameters;
  const auto for_gaussians = [&](const auto& each) { pool_.for_each(p.size(), 1024, each); };
  const auto count = static_cast<double>(p.size());
  if (order.moves && order.sparsity) {
    for_gaussians([&](std::size_t i) {
      order.sparsity->add_gradient(count, p.log_scales[i], p.opacity_logits[i],
                                   gradients_.by.log_scales[i], gradients_.by.opacity_logits[i]);
    });
  }
  if (order.moves && p.has_masks) {
    for_gaussians([&](std::size_t i) {
      gradients_.by.mask_logits[i] +=
          mask_weight_gradient(order.mask_weight, count, p.mask_logits[i]);
    });
  }
  if (order.sums) add_gradients(gradients_.by, pool_, state_.summed);
  if (order.moves) {
    const bool moves_rest = !(order.sums && order.rest_waits);
    take_step(p, order.sums ? state_.summed : gradients_.by, order.rates, state_.adam, pool_,
              moves_rest);
    if (order.sums) clear_sums(moves_rest, state_.summed);
  }
  if (state_.color_field.exists())
    take_field_step(gradients_.by_field, order.field_rate, state_.color_field, pool_);
  if (order.noise) {
    for_gaussians([&](std::size_t i) {
      p.means[i] =
          order.noise->moved(i, p.means[i], p.log_scales[i], p.rotations[i], p.opacity_logits[i]);
    });
  }
  if (state_.codes.exist()) {
    take_code_step(state_.codes.scales, scale_vectors(p), pool_);
    take_code_step(state_.codes.rotations, rotation_vectors(p), pool_);
  }
  state_.iteration = order.iteration;
}

}  // namespace qs::cpu::train
