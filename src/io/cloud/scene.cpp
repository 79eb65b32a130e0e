// SPDX-License-Identifier: MIT
#include "io/cloud/scene.h"

#include "io/cloud/cloud_memory.h"

namespace qs {

SceneSample make_sample(const Scene& scene, std::size_t count, const Sampling& sampling) {
  SceneSample sample;
  sample.of = count;
  sample.step = sample_step(count, sampling.most);
  sample.scene.path = scene.path;
  sample.scene.file_bytes = scene.file_bytes;
  sample.scene.cloud.resize((count + sample.step - 1) / sample.step, 0);
  return sample;
}

SceneSample sample_of(const Scene& scene, const Sampling& sampling) {
  const GaussianCloud& all = scene.cloud;
  SceneSample sample = make_sample(scene, all.size(), sampling);
  sample.scene.format = scene.format;
  sample.scene.axes = scene.axes;
  sample.scene.vertical_axis = scene.vertical_axis;
  GaussianCloud& cloud = sample.scene.cloud;
  cloud.antialiased = all.antialiased;
  cloud.origin = all.origin;
  for (std::size_t k = 0; k < cloud.size(); ++k) copy_gaussian(all, k * sample.step, cloud, k);
  return sample;
}

}  // namespace qs
