// SPDX-License-Identifier: MIT
#include "io/bytes/inflate.h"

#include <algorithm>
#include <new>
#include <utility>

#include "base/fail.h"

namespace qs {
namespace {

// zlib counts in 32 bits, and files may be longer.
constexpr std::size_t kPiece = 1u << 30;

}  // namespace

Inflater::Inflater(std::span<const std::byte> compressed, std::string source, Form form)
    : compressed_(compressed),
      source_(std::move(source)),
      form_(form == Form::gzip ? "gzip" : "deflate") {
  constexpr int kWindow = 15;  // 32 KiB; 16 more: with a gzip header; negative: without a header
  if (inflateInit2(&stream_, form == Form::gzip ? kWindow + 16 : -kWindow) != Z_OK)
    throw std::bad_alloc();
}

Inflater::~Inflater() { inflateEnd(&stream_); }

std::size_t Inflater::read(std::span<std::byte> out) {
  const std::size_t filled = try_read(out);
  if (!problem_.empty()) fail("{}: {}", source_, problem_);
  return filled;
}

std::size_t Inflater::try_read(std::span<std::byte> out) {
  std::size_t filled = 0;
  while (filled < out.size() && !ended_ && problem_.empty()) {
    if (stream_.avail_in == 0) {
      const std::size_t piece = std::min(compressed_.size(), kPiece);
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(compressed_.data()));
      stream_.avail_in = static_cast<uInt>(piece);
      compressed_ = compressed_.subspan(piece);
    }
    const std::size_t room = std::min(out.size() - filled, kPiece);
    stream_.next_out = reinterpret_cast<Bytef*>(out.data() + filled);
    stream_.avail_out = static_cast<uInt>(room);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    filled += room - stream_.avail_out;
    ended_ = result == Z_STREAM_END;
    if (result == Z_BUF_ERROR) {
      problem_ = fmt::format("cut off: the {} data ends early", form_);
    } else if (result != Z_OK && !ended_) {
      problem_ = fmt::format("the {} data is damaged ({})", form_,
                             stream_.msg != nullptr ? stream_.msg : "unknown reason");
    }
  }
  return filled;
}

bool is_gzip(std::span<const std::byte> content) {
  return content.size() >= 2 && content[0] == std::byte{0x1f} && content[1] == std::byte{0x8b};
}

}  // namespace qs
