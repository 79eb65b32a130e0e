// SPDX-License-Identifier: MIT
//
// Decompresses a gzip member, or the bare deflate data of a zip archive, into buffers of sizes that
// the caller chose, so that a small file cannot make the program allocate more than the caller
// allows. A member's checksum is verified at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <zlib.h>

namespace qs {

/// The highest compression ratio of deflate; a header that implies more is wrong.
constexpr std::uint64_t kMaxInflation = 1032;

class Inflater {
 public:
  enum class Form { gzip, deflate };

  /// `source` names the file in messages. `compressed` must outlive this.
  Inflater(std::span<const std::byte> compressed, std::string source, Form form = Form::gzip);
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Fills `out` up to the end of the member and returns the number of bytes. Throws Error(input)
  /// if the data is damaged or ends before the member does.
  std::size_t read(std::span<std::byte> out);

  /// As read(), but does not throw: it stops where the data is damaged, and problem() is not empty.
  std::size_t try_read(std::span<std::byte> out);
  const std::string& problem() const { return problem_; }

  /// Compressed bytes that were not consumed so far.
  std::uint64_t left() const { return compressed_.size() + stream_.avail_in; }

 private:
  std::span<const std::byte> compressed_;  // not passed to zlib yet
  std::string source_;
  const char* form_;  ///< its name
  z_stream stream_{};
  bool ended_ = false;
  std::string problem_;
};

bool is_gzip(std::span<const std::byte> content);

}  // namespace qs
