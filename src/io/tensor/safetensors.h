// SPDX-License-Identifier: MIT
//
// Reads .safetensors, the format of huggingface/safetensors: a 64-bit length, a JSON object that
// names the tensors with type, shape and place, and the values.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "io/bytes/byte_text.h"
#include "io/tensor/tensor.h"

namespace qs {

struct TensorFile {
  std::map<std::string, Tensor> tensors;
  std::map<std::string, std::string> metadata;  ///< `__metadata__`
};

/// Throws Error(input), one sentence that begins with `source`. Other types than F32 are refused.
TensorFile parse_safetensors(ByteSpan content, const std::string& source);

/// parse_safetensors() of a file.
TensorFile read_safetensors(const std::filesystem::path& path);

}  // namespace qs
