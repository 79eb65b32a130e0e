// SPDX-License-Identifier: MIT
//
// Structs of the caller that begin with their size. The caller may have been built for an older or
// a newer header than the library.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "library/check/call.h"
#include "quadsplat/quadsplat.h"

namespace qs::library {

/// The bytes that a struct had in version 1 of the interface. A struct that grew gets a row with
/// its first size.
template <class T>
constexpr std::size_t first_bytes() {
  if (std::is_same_v<T, QsCamera>) return 152;
  if (std::is_same_v<T, QsInputs>) return 888;
  if (std::is_same_v<T, QsStageFrame>) return 72;
  if (std::is_same_v<T, QsGaussians>) return 544;
  if (std::is_same_v<T, QsPicture>) return 632;
  if (std::is_same_v<T, QsAdam>) return 488;
  if (std::is_same_v<T, QsComparison>) return 144;
  if (std::is_same_v<T, QsConversion>) return 32;
  return sizeof(T);
}
template <class T>
inline constexpr std::size_t kFirstBytes = first_bytes<T>();

/// No struct of the interface is larger, so larger sizes were never set.
inline constexpr std::size_t kMostBytes = 4096;

/// The size that the struct states. Throws Error(usage) unless it is known, or the members that are
/// not known are 0.
template <class T>
std::size_t checked_size(const T* given, const Where& where) {
  require(given, where);
  std::uint32_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size < kFirstBytes<T> || size > kMostBytes)
    refuse(where / "size", "is {}: set it to the size of the struct, {} bytes in this library",
           size, sizeof(T));
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  if (size > sizeof(T) &&
      std::any_of(bytes + sizeof(T), bytes + size, [](unsigned char byte) { return byte != 0; }))
    refuse(where,
           "has members that this library does not have, and they are not 0: it needs a newer "
           "libquadsplat");
  return size;
}

/// The struct with all members that this library has. Members that the caller does not have are 0.
template <class T>
T read_struct(const T* given, const Where& where) {
  const std::size_t size = checked_size(given, where);
  T known{};
  std::memcpy(&known, given, std::min(size, sizeof(T)));
  return known;
}

/// Writes the members that the caller has. The caller's size stays.
template <class T>
void write_struct(const T& value, T* given, const Where& where) {
  const std::size_t size = std::min(checked_size(given, where), sizeof(T));
  constexpr std::size_t kSizeBytes = sizeof(std::uint32_t);
  std::memcpy(reinterpret_cast<unsigned char*>(given) + kSizeBytes,
              reinterpret_cast<const unsigned char*>(&value) + kSizeBytes, size - kSizeBytes);
}

/// Element `index` of an array of structs, whose first element states the size of all. Not null.
template <class T>
T* element(T* array, std::uint64_t index, const Where& where) {
  const std::size_t size = checked_size(array, where);
  using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
  return reinterpret_cast<T*>(reinterpret_cast<Byte*>(array) + index * size);
}

}  // namespace qs::library
