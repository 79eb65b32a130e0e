// SPDX-License-Identifier: MIT
#include "io/cloud/sample.h"

#include "io/cloud/cloud_memory.h"

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
  for (std::size_t k = 0; k < cloud.size(); ++k) copy_gaussian(all, k * sample.step, cloud, k);
  return sample;
}

}  // namespace qs
