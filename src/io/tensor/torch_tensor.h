// SPDX-License-Identifier: MIT
//
// Reads the dictionaries of tensors (state_dict) that PyTorch saves: .pth files, which are zip
// archives since PyTorch 1.6 and a stream of pickles before, and tensors inside other pickles,
// whose values are such a stream. Values are 32-bit or 16-bit floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/tensor/pickle.h"
#include "io/tensor/tensor.h"

namespace qs {

/// The values behind a tensor.
struct TorchStorage {
  ByteSpan bytes;
  bool halves = false;          ///< 16-bit floats, else 32-bit floats
  Array<std::byte> owned = {};  ///< backing storage of `bytes` if it is unpacked
};

/// Returns the storage that an object of a pickle stands for.
using TorchStorages = std::function<TorchStorage(const Pickle& pickle, PickleRef object)>;

/// The tensor that an object of a pickle stands for. `what` names it in messages. Throws
/// Error(input).
Tensor read_torch_tensor(const Pickle& pickle, PickleRef object, const TorchStorages& storages,
                         const std::string& what);

/// The storage of a tensor in a pickle that PyTorch did not write itself, such as an array of
/// NumPy.
TorchStorage embedded_torch_storage(const Pickle& pickle, PickleRef object);

/// A .pth file that holds a dictionary.
class TorchFile {
 public:
  /// `content` must outlive this. Throws Error(input).
  TorchFile(ByteSpan content, const std::filesystem::path& path);

  /// True if the dictionary has this key.
  bool has(std::string_view name) const { return pickle_->find(pickle_->root(), name) != 0; }

  /// Throws Error(input) if there is no such tensor or its values are cut off.
  Tensor tensor(std::string_view name) const;

 private:
  void open_archive(ByteSpan content);
  void open_stream(ByteSpan content);

  std::filesystem::path path_;
  std::unique_ptr<FileSource> files_;  // the files of an archive
  Array<std::byte> text_;              // the pickle in an archive
  std::unique_ptr<Pickle> pickle_;
  TorchStorages storages_;
};

// Writes tensors as PyTorch saves them; torch_tensor.h reads them. Values are 32-bit floats.

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
