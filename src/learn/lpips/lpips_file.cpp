// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/tensor/tensor.h"
#include "learn/lpips/metric.h"

namespace qs {
namespace {

const lpips::Network& network_of(const TensorFile& file, const std::string& source) {
  const auto name = file.metadata.find("network");
  const auto known = [&] {
    std::string names;
    for (const lpips::Network& network : lpips::kNetworks)
      names += fmt::format("{}{}", names.empty() ? "" : " or ", network.name);
    return names;
  };
  if (name == file.metadata.end())
    fail("{}: its metadata name no network ({}): scripts/lpips_weights writes such files", source,
         known());
  for (const lpips::Network& network : lpips::kNetworks)
    if (network.name == name->second) return network;
  fail("{}: its metadata name another network than {}", source, known());
}

std::vector<float> take(TensorFile& file, const std::string& source, const std::string& name,
                        const std::vector<std::uint64_t>& shape) {
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end()) fail("{}: {} is missing", source, name);
  if (found->second.shape != shape)
    fail("{}: {} has the shape ({}) instead of ({})", source, name,
         fmt::join(found->second.shape, ", "), fmt::join(shape, ", "));
  std::vector<float>& values = found->second.values;
  if (!std::ranges::all_of(values, [](float v) { return std::isfinite(v); }))
    fail("{}: {} has a value that is not a finite number", source, name);
  return std::move(values);
}

}  // namespace

lpips::Weights read_lpips(const std::filesystem::path& path) {
  TensorFile file = read_safetensors(path);
  const std::string source = path.string();
  lpips::Weights weights;
  weights.network = &network_of(file, source);
  for (const lpips::Convolution& layer : weights.network->convolutions) {
    const auto outputs = static_cast<std::uint64_t>(layer.outputs);
    const auto inputs = static_cast<std::uint64_t>(layer.inputs);
    const auto size = static_cast<std::uint64_t>(layer.size);
    const std::string name = fmt::format("features.{}", layer.number);
    weights.filters.push_back(take(file, source, name + ".weight", {outputs, inputs, size, size}));
    weights.biases.push_back(take(file, source, name + ".bias", {outputs}));
    if (!layer.compared) continue;
    const std::string linear = fmt::format("lin{}.weight", weights.linear.size());
    weights.linear.push_back(take(file, source, linear, {outputs}));
  }
  return weights;
}

}  // namespace qs
