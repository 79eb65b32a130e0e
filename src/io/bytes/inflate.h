// SPDX-License-Identifier: MIT
//
// Takes a gzip member apart into buffers whose sizes the caller has decided on: a small file can
// never make this program hold more than it asked for. The checksum is verified at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <zlib.h>

namespace qs {

/// Deflate never expands data by more than this; a claim beyond it is a lie.
constexpr std::uint64_t kMaxInflation = 1032;

class Inflater {
 public:
  /// `source` names the file in messages. `compressed` must outlive this.
  Inflater(std::span<const std::byte> compressed, std::string source);
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Fills `out` as far as the member goes and returns the number of bytes. Throws Error(input)
  /// when the data is damaged or ends before the member does.
  std::size_t read(std::span<std::byte> out);

  /// The same without throwing: stops where the data is damaged. problem() then is not empty.
  std::size_t try_read(std::span<std::byte> out);
  const std::string& problem() const { return problem_; }

  /// Compressed bytes that were not needed so far.
  std::uint64_t left() const { return compressed_.size() + stream_.avail_in; }

 private:
  std::span<const std::byte> compressed_;  // not handed to zlib yet
  std::string source_;
  z_stream stream_{};
  bool ended_ = false;
  std::string problem_;
};

bool is_gzip(std::span<const std::byte> content);

}  // namespace qs
