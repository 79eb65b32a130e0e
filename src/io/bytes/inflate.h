// SPDX-License-Identifier: MIT
//
// Gzip members, and the bare deflate data of zip archives and pages: piece by piece by zlib, or as
// a whole, in half of the time, by libdeflate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include <zlib.h>

#include "base/not_copied.h"
#include "io/bytes/byte_text.h"

namespace qs {

/// The highest compression ratio of deflate; a header that implies more is wrong.
constexpr std::uint64_t kMaxInflation = 1032;

enum class DeflateForm { gzip, deflate };

/// Decompresses into buffers of sizes that the caller chose, so that a small file cannot make the
/// program allocate more than the caller allows. A member's checksum is verified at the end.
class Inflater : NotCopied {
 public:
  /// `source` names the file in messages. `compressed` must outlive this.
  Inflater(ByteSpan compressed, std::string source, DeflateForm form = DeflateForm::gzip);
  ~Inflater();

  /// Fills `out` up to the end of the member and returns the number of bytes. Throws Error(input)
  /// if the data is damaged or ends before the member does.
  std::size_t read(std::span<std::byte> out);

  /// As read(), but does not throw: it stops where the data is damaged, and problem() is not empty.
  std::size_t try_read(std::span<std::byte> out);
  const std::string& problem() const { return problem_; }

  /// Compressed bytes that were not consumed so far.
  std::uint64_t left() const { return compressed_.size() + stream_.avail_in; }

 private:
  ByteSpan compressed_;  // not passed to zlib yet
  std::string source_;
  const char* form_;  ///< its name
  z_stream stream_{};
  bool ended_ = false;
  std::string problem_;
};

/// Compresses piece by piece. The packed bytes depend on the pieces' content alone.
class Deflater : NotCopied {
 public:
  /// `level` and `memory` as in zlib. `take` receives the packed bytes.
  Deflater(DeflateForm form, int level, int memory,
           std::function<void(std::string_view packed)> take);
  ~Deflater();

  void write(std::string_view bytes);
  void finish() { run(Z_FINISH); }

 private:
  void run(int flush);

  z_stream stream_{};
  std::function<void(std::string_view packed)> take_;
};

/// The content, compressed as one piece without a header. `level`: 0 to 12, as in libdeflate.
std::string deflated(std::string_view content, int level);

/// Fills `out` with the content of deflate data without a header. Throws Error(input), with
/// `source` in front, if the data is damaged or has more or fewer bytes.
void inflate_all(ByteSpan compressed, std::span<std::byte> out, const std::string& source);

bool is_gzip(ByteSpan content);

}  // namespace qs
