// SPDX-License-Identifier: MIT
//
// A .ply, alone in a zip archive as programs share it. The archive's other files, such as a licence
// or cameras, are not read.
#include <string>

#include "base/fail.h"
#include "io/bytes/file_source.h"
#include "io/scene/ply/ply.h"

namespace qs {

// A .sog is a zip archive too, so this one needs the usual ending.
bool recognises_zipped_ply(ByteSpan content, const std::filesystem::path& path) {
  return lower_case(path.extension().string()) == ".zip" && is_zip(content) && ply_in_zip(content);
}

void read_zipped_ply(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                     const ReadOptions& options, Scene& scene) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;  // files_in_zip() has a lower limit
  const std::string name = ply_in_zip(content).value_or("");
  if (name.empty())
    fail("{}: a zip archive with no .ply or several: unpack it and open one of its files",
         path.string());
  const Array<std::byte> unpacked = files_in_zip(content, path, name)->read(name, kMostBytes);
  const std::filesystem::path inner(path.string() + ": " + name);
  const bool is_compressed = recognises_compressed_ply(unpacked, inner);
  (is_compressed ? read_compressed_ply : read_ply)(unpacked, inner, pool, options, scene);
  scene.format = "zipped " + scene.format;
}

}  // namespace qs
