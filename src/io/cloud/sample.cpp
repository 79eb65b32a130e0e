// SPDX-License-Identifier: MIT
#include "io/cloud/sample.h"

namespace qs {

bool is_sampled(std::size_t count, const Sampling& sampling) {
  return sampling.take && count >= sampling.fewest;
}

SceneSample sample_of(const Scene& scene, const Sampling& sampling) {
  const GaussianCloud& all = scene.cloud;
  SceneSample sample;
  sample.of = all.size();
  sample.step = sample_step(all.size(), sampling.most);
  sample.scene.path = scene.path;
  sample.scene.format = scene.format;
  sample.scene.axes = scene.axes;
  sample.scene.vertical_axis = scene.vertical_axis;
  sample.scene.file_bytes = scene.file_bytes;
  GaussianCloud& cloud = sample.scene.cloud;
  cloud.antialiased = all.antialiased;
  cloud.resize((all.size() + sample.step - 1) / sample.step, 0);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(all.sh_degree));
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const std::size_t i = k * sample.step;
    cloud.positions[k] = all.positions[i];
    cloud.log_scales[k] = all.log_scales[i];
    cloud.rotations[k] = all.rotations[i];
    cloud.opacity_logits[k] = all.opacity_logits[i];
    cloud.sh[k] = all.sh[i * coefficients];
  }
  return sample;
}

}  // namespace qs
