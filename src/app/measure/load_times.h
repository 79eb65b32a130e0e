// SPDX-License-Identifier: MIT
//
// `bench --load`: the time to read scenes, compared with a plain copy of the file into memory and,
// for gzip data, with zlib's inflate on one thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"

namespace qs {

/// Medians over the rounds in milliseconds, with a warm page cache.
struct LoadTimes {
  std::string file, format;
  std::size_t gaussians = 0;
  std::uint64_t file_bytes = 0;
  double total_ms = 0;
  double unpack_ms = 0;   ///< headers, decompression and allocation
  double fill_ms = 0;     ///< checking, converting and storing the values
  double copy_ms = 0;     ///< read() of the file into memory, as `cat` does
  double inflate_ms = 0;  ///< zlib alone; 0 for other data
};

/// Reads `path` rounds + 1 times; the first is a warm-up. Throws Error.
LoadTimes measure_loading(const std::filesystem::path& path, ThreadPool& pool, int rounds,
                          const Progress& progress = {});

/// A Markdown table.
std::string format_load_times(const std::vector<LoadTimes>& rows);

}  // namespace qs
