// SPDX-License-Identifier: MIT
//
// Writes .safetensors files for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "learn/lpips/lpips.h"
#include "support/corpus.h"

namespace qs::test {

/// A file with this header and these bytes behind it.
inline std::vector<std::byte> safetensors_bytes(const std::string& header,
                                                const std::vector<std::byte>& data) {
  const std::uint64_t length = header.size();
  std::vector<std::byte> bytes(sizeof length);
  std::memcpy(bytes.data(), &length, sizeof length);
  for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

/// The weights as scripts/lpips_weights writes them.
inline void write_lpips_weights(const lpips::Weights& weights, const std::filesystem::path& path) {
  nlohmann::ordered_json header;
  header["__metadata__"] = {{"network", weights.network->name}};
  std::vector<std::byte> data;
  const auto add = [&](const std::string& name, const std::vector<int>& shape,
                       const std::vector<float>& values) {
    const std::size_t begin = data.size(), bytes = values.size() * sizeof(float);
    data.resize(begin + bytes);
    std::memcpy(data.data() + begin, values.data(), bytes);
    header[name] = {{"dtype", "F32"}, {"shape", shape}, {"data_offsets", {begin, data.size()}}};
  };
  std::size_t compared = 0;
  for (std::size_t i = 0; i < weights.filters.size(); ++i) {
    const lpips::Convolution& layer = weights.network->convolutions[i];
    const std::string name = "features." + std::to_string(layer.number);
    add(name + ".weight", {layer.outputs, layer.inputs, layer.size, layer.size},
        weights.filters[i]);
    add(name + ".bias", {layer.outputs}, weights.biases[i]);
    if (layer.compared) {
      add("lin" + std::to_string(compared) + ".weight", {layer.outputs}, weights.linear[compared]);
      ++compared;
    }
  }
  write_bytes(path, safetensors_bytes(header.dump(), data));
}

}  // namespace qs::test
