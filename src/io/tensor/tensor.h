// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "io/bytes/byte_text.h"

namespace qs {

/// An array of any number of dimensions.
struct Tensor {
  std::vector<std::uint64_t> shape;  ///< the last index varies fastest
  std::vector<float> values;
};

// Reads .safetensors, the format of huggingface/safetensors: a 64-bit length, a JSON object that
// names the tensors with type, shape and place, and the values.

struct TensorFile {
  std::map<std::string, Tensor> tensors;
  std::map<std::string, std::string> metadata;  ///< `__metadata__`
};

/// Throws Error(input), one sentence that begins with `source`. Other types than F32 are refused.
TensorFile parse_safetensors(ByteSpan content, const std::string& source);

/// parse_safetensors() of a file.
TensorFile read_safetensors(const std::filesystem::path& path);

}  // namespace qs
