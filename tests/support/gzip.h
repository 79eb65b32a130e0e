// SPDX-License-Identifier: MIT
//
// Compresses and decompresses bytes for tests of readers that inflate.
#pragma once

#include <zlib.h>

namespace qs::test {

template <class Bytes>
void connect(z_stream& stream, const Bytes& from, Bytes& to) {
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<typename Bytes::value_type*>(from.data()));
  stream.avail_in = static_cast<uInt>(from.size());
  stream.next_out = reinterpret_cast<Bytef*>(to.data());
  stream.avail_out = static_cast<uInt>(to.size());
}

/// One gzip member holding `plain`, a container of one-byte elements; level 1 (fast) to 9 (small).
template <class Bytes>
Bytes gzip(const Bytes& plain, int level) {
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  Bytes packed(plain);
  packed.resize(plain.size() + 1000);
  connect(stream, plain, packed);
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// The content of the gzip member `packed`, at most 1 MiB.
template <class Bytes>
Bytes gunzip(const Bytes& packed) {
  z_stream stream{};
  inflateInit2(&stream, 15 + 16);
  Bytes plain;
  plain.resize(1 << 20);
  connect(stream, packed, plain);
  inflate(&stream, Z_FINISH);
  plain.resize(stream.total_out);
  inflateEnd(&stream);
  return plain;
}

}  // namespace qs::test
