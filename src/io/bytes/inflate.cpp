// SPDX-License-Identifier: MIT
#include "io/bytes/inflate.h"

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

#include <libdeflate.h>

#include "base/fail.h"
#include "io/bytes/byte_text.h"

namespace qs {
namespace {

// zlib counts in 32 bits, and files may be longer.
constexpr std::size_t kPiece = 1u << 30;

// zlib's number for the form: 32 KiB; 16 more: with a gzip header; negative: without a header.
int window_of(DeflateForm form) {
  constexpr int kWindow = 15;
  return form == DeflateForm::gzip ? kWindow + 16 : -kWindow;
}

}  // namespace

Inflater::Inflater(ByteSpan compressed, std::string source, DeflateForm form)
    : compressed_(compressed),
      source_(std::move(source)),
      form_(form == DeflateForm::gzip ? "gzip" : "deflate") {
  if (inflateInit2(&stream_, window_of(form)) != Z_OK) throw std::bad_alloc();
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

Deflater::Deflater(DeflateForm form, int level, int memory,
                   std::function<void(std::string_view packed)> take)
    : take_(std::move(take)) {
  if (deflateInit2(&stream_, level, Z_DEFLATED, window_of(form), memory, Z_DEFAULT_STRATEGY) !=
      Z_OK)
    throw std::bad_alloc();
}

Deflater::~Deflater() { deflateEnd(&stream_); }

void Deflater::write(std::string_view bytes) {
  stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  while (!bytes.empty()) {
    const std::size_t piece = std::min(bytes.size(), kPiece);
    stream_.avail_in = static_cast<uInt>(piece);
    run(Z_NO_FLUSH);
    bytes.remove_prefix(piece);
  }
}

void Deflater::run(int flush) {
  char block[1 << 16];
  do {
    stream_.next_out = reinterpret_cast<Bytef*>(block);
    stream_.avail_out = sizeof block;
    deflate(&stream_, flush);
    take_({block, sizeof block - stream_.avail_out});
  } while (stream_.avail_out == 0);
}

std::string deflated(std::string_view content, int level) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string packed(libdeflate_deflate_compress_bound(compressor.get(), content.size()), '\0');
  packed.resize(libdeflate_deflate_compress(compressor.get(), content.data(), content.size(),
                                            packed.data(), packed.size()));
  return packed;
}

void inflate_all(ByteSpan compressed, std::span<std::byte> out, const std::string& source) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!decompressor) throw std::bad_alloc();
  std::size_t bytes = 0;
  const libdeflate_result result = libdeflate_deflate_decompress(
      decompressor.get(), compressed.data(), compressed.size(), out.data(), out.size(), &bytes);
  if (result == LIBDEFLATE_BAD_DATA) fail("{}: the deflate data is damaged or cut off", source);
  const bool is_more = result == LIBDEFLATE_INSUFFICIENT_SPACE;
  if (is_more || bytes != out.size())
    fail("{}: {} {} bytes unpacked, {} are needed", source, is_more ? "more than" : "only",
         is_more ? out.size() : bytes, out.size());
}

bool is_gzip(ByteSpan content) {
  return content.size() >= 2 && content[0] == std::byte{0x1f} && content[1] == std::byte{0x8b};
}

}  // namespace qs
