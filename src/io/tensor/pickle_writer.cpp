// SPDX-License-Identifier: MIT
#include <bit>
#include <limits>
#include <utility>

#include "io/tensor/pickle.h"

namespace qs {
namespace {

// The lowest `count` bytes, little endian.
std::string low_bytes(std::uint64_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
  return bytes;
}

}  // namespace

PickleWriter& PickleWriter::text(std::string_view value) {
  return put("X").put(low_bytes(value.size(), 4)).put(value);
}

PickleWriter& PickleWriter::bytes(std::string_view value) {
  return put("B").put(low_bytes(value.size(), 4)).put(value);
}

PickleWriter& PickleWriter::integer(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  if (value >= 0 && value < 0x100) return put("K").put(low_bytes(bits, 1));
  constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min(),
                         kMost = std::numeric_limits<std::int32_t>::max();
  if (value >= kLeast && value <= kMost) return put("J").put(low_bytes(bits, 4));
  return put("\x8a\x08").put(low_bytes(bits, 8));
}

PickleWriter& PickleWriter::real(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  put("G");
  for (int i = 7; i >= 0; --i) out_ += static_cast<char>(bits >> 8 * i & 0xff);
  return *this;
}

PickleWriter& PickleWriter::name(std::string_view module, std::string_view name) {
  return put("c").put(module).put("\n").put(name).put("\n");
}

std::string PickleWriter::take() { return std::move(out_) + "."; }

}  // namespace qs
