// SPDX-License-Identifier: MIT
//
// Writes tensors as PyTorch saves them; torch_tensor.h reads them. Values are 32-bit floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/tensor/pickle_writer.h"
#include "io/tensor/tensor.h"

namespace qs {

struct NamedTensor {
  std::string name;
  Tensor tensor;
};

/// Appends the dictionary (state_dict) of tensors to a pickle of another library, such as an array
/// of NumPy: their values are inside.
void add_embedded_tensors(PickleWriter& pickle, std::span<const NamedTensor> tensors);

/// Writes a .pth file of this dictionary, in the zip format of PyTorch 1.6 and later. Throws
/// Error(input).
void write_torch_file(const std::filesystem::path& path, std::span<const NamedTensor> tensors);

}  // namespace qs
