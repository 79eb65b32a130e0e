// SPDX-License-Identifier: MIT
#include <limits>
#include <vector>

#include "learn/step/cuda/parameters.cuh"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {
namespace {

// On the GPU every channel of a coefficient has its own row.
std::size_t sh_index(std::size_t coefficient, int channel, std::uint32_t count) {
  return (3 * coefficient + static_cast<std::size_t>(channel)) * sh_row(count);
}

}  // namespace

void Parameters::resize(std::uint32_t gaussians, int degree, bool masks) {
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(degree));
  sh_degree = degree;
  const auto room = sh_row(static_cast<std::uint32_t>(with_room(gaussians)));
  sh.reserve("the model", 3 * coefficients * room);
  resize_shapes(gaussians, masks);
}

void Parameters::resize_shapes(std::uint32_t gaussians, bool masks) {
  const std::size_t room = with_room(gaussians);
  means.reserve("the model", room);
  log_scales.reserve("the model", room);
  rotations.reserve("the model", room);
  opacity_logits.reserve("the model", room);
  if (masks) mask_logits.reserve("the model", room);
  has_masks = masks;
  count = gaussians;
}

void upload(const qs::train::Parameters& host, cudaStream_t stream, Parameters& parameters) {
  if (host.size() > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorKind::device, "cuda: the model has " + std::to_string(host.size()) +
                                       " Gaussians, at most 2147483647 can be trained");
  const std::size_t count = host.size(), width = host.sh_stride();
  parameters.resize(static_cast<std::uint32_t>(count), host.sh_degree, host.has_masks);
  std::vector<float> sh(3 * width * sh_row(parameters.count));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < width; ++k)
      for (int c = 0; c < 3; ++c)
        sh[sh_index(k, c, parameters.count) + i] = host.sh[i * width + k][c];
  copy_to_device(host.means.data(), parameters.means, count, stream);
  copy_to_device(host.log_scales.data(), parameters.log_scales, count, stream);
  copy_to_device(host.rotations.data(), parameters.rotations, count, stream);
  copy_to_device(host.opacity_logits.data(), parameters.opacity_logits, count, stream);
  copy_to_device(host.mask_logits.data(), parameters.mask_logits, host.mask_logits.size(), stream);
  copy_to_device(sh.data(), parameters.sh, sh.size(), stream);
}

qs::train::Parameters download(const Parameters& parameters, cudaStream_t stream) {
  const std::size_t count = parameters.count;
  qs::train::Parameters host;
  host.sh_degree = parameters.sh_degree;
  host.has_masks = parameters.has_masks;
  const std::size_t width = host.sh_stride();
  host.means = copied(parameters.means.data(), count, stream);
  host.log_scales = copied(parameters.log_scales.data(), count, stream);
  host.rotations = copied(parameters.rotations.data(), count, stream);
  host.opacity_logits = copied(parameters.opacity_logits.data(), count, stream);
  host.mask_logits =
      copied(parameters.mask_logits.data(), parameters.has_masks ? count : 0, stream);
  const std::vector<float> sh =
      copied(parameters.sh.data(), 3 * width * sh_row(parameters.count), stream);
  host.sh.resize(width * count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < width; ++k)
      for (int c = 0; c < 3; ++c)
        host.sh[i * width + k][c] = sh[sh_index(k, c, parameters.count) + i];
  return host;
}

void gather(Parameters& from, const DeviceBuffer<std::uint32_t>& sources, std::uint32_t count,
            cudaStream_t stream, Parameters& to) {
  to.resize(count, from.sh_degree, from.has_masks);
  for_each_item(
      "gather", count, stream,
      [from = from.view(), sources = sources.data(), to = to.view()] __device__(std::uint32_t i) {
        const std::uint32_t source = sources[i];
        const bool zeros = source == qs::train::Plan::kZeros;
        to.set_gaussian(i, zeros ? GaussianValues<float>::zero() : from.gaussian(source));
        for (int k = 0; k < to.sh_coefficients; ++k)
          to.set_coefficient(i, k, zeros ? glm::vec3(0.0f) : from.coefficient(source, k));
      });
}

}  // namespace qs::cuda::train
