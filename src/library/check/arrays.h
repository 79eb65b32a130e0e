// SPDX-License-Identifier: MIT
//
// Arrays of the caller (QsArray): checks before any element is touched, reading and storing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <type_traits>

#include "base/parallel.h"
#include "library/check/call.h"
#include "quadsplat/quadsplat.h"
#include "raster/scene/image.h"

namespace qs::library {

/// A set of element types: bit QS_FLOAT32 for QS_FLOAT32, and so on.
using Types = std::uint32_t;
inline constexpr Types kFloat32 = 1u << QS_FLOAT32;
inline constexpr Types kReals = kFloat32 | 1u << QS_FLOAT64;
inline constexpr Types kColors = kFloat32 | 1u << QS_UINT8;
inline constexpr Types kBytes = 1u << QS_UINT8;
inline constexpr Types kIntegers =
    1u << QS_INT32 | 1u << QS_UINT32 | 1u << QS_INT64 | 1u << QS_UINT64;

enum class Access { reads, writes };

/// The memory in which the arrays of a call must be.
struct Place {
  std::uint32_t memory = QS_MEMORY_HOST;
  std::int32_t device = 0;
  const char* decided_by = nullptr;  ///< an argument; null: the function knows no other memory

  bool is_gpu() const { return memory == QS_MEMORY_CUDA; }
  /// "host memory", "the memory of GPU 0"
  std::string text() const;
};

inline bool is_absent(const QsArray& array) { return array.dimensions == 0; }

/// Throws Error(usage) unless the array has exactly these sizes, one of the types, and elements in
/// this place. Each element of an array that is written has an address of its own along every
/// dimension.
void check_array(const QsArray& array, const Where& where, std::span<const std::int64_t> sizes,
                 Types types, Access access, const Place& place = {});
inline void check_array(const QsArray& array, const Where& where,
                        std::initializer_list<std::int64_t> sizes, Types types, Access access,
                        const Place& place = {}) {
  check_array(array, where, std::span(sizes.begin(), sizes.size()), types, access, place);
}

/// Throws Error(usage) unless the array has `dimensions`, of any sizes.
void check_dimensions(const QsArray& array, const Where& where, std::uint32_t dimensions);

/// Checks of the arrays of a struct. All of them throw Error(usage).
struct ArrayChecks {
  Where where;  ///< the struct
  Types types;
  Access access;
  Place place = {};

  using Sizes = std::initializer_list<std::int64_t>;
  void given(const QsArray& array, const char* name, Sizes sizes) const {
    check_array(array, where / name, sizes, types, access, place);
  }
  void optional(const QsArray& array, const char* name, Sizes sizes) const {
    if (!is_absent(array)) given(array, name, sizes);
  }
  /// An array whose size does not depend on the number of Gaussians. It may also be in host memory.
  void optional_small(const QsArray& array, const char* name, Sizes sizes) const {
    if (is_absent(array)) return;
    const bool is_on_host = array.memory == QS_MEMORY_HOST;
    check_array(array, where / name, sizes, types, access, is_on_host ? Place{} : place);
  }
  void absent(const QsArray& array, const char* name, const char* reason) const {
    if (!is_absent(array)) refuse(where / name, "{}", reason);
  }
  /// Returns the coefficients of spherical harmonics per channel, 1, 4, 9 or 16, of `count`
  /// Gaussians: `first` is count x K x 3, or count x 1 x 3 and `rest` count x (K - 1) x 3.
  std::int64_t sh(const QsArray& first, const char* name, const QsArray& rest,
                  const char* name_of_rest, std::int64_t count) const;
};

inline constexpr std::int64_t kMostGaussians = INT32_MAX;

/// The offset of an element from `data`. Indices of dimensions that the array does not have count
/// nothing.
template <class... Index>
std::ptrdiff_t offset_of(const QsArray& array, Index... indices) {
  std::ptrdiff_t offset = 0;
  std::uint32_t dimension = 0;
  const auto add = [&](std::ptrdiff_t index) {
    if (dimension < array.dimensions) offset += index * array.strides[dimension];
    ++dimension;
  };
  (add(static_cast<std::ptrdiff_t>(indices)), ...);
  return offset;
}

/// Calls f(pointer) with `data` as a pointer to elements of the array's type.
template <class F>
decltype(auto) with_type(const QsArray& array, F&& f) {
  if (array.type == QS_FLOAT64) return f(static_cast<double*>(array.data));
  if (array.type == QS_UINT8) return f(static_cast<std::uint8_t*>(array.data));
  if (array.type == QS_INT32) return f(static_cast<std::int32_t*>(array.data));
  if (array.type == QS_UINT32) return f(static_cast<std::uint32_t*>(array.data));
  if (array.type == QS_INT64) return f(static_cast<std::int64_t*>(array.data));
  if (array.type == QS_UINT64) return f(static_cast<std::uint64_t*>(array.data));
  return f(static_cast<float*>(array.data));
}

/// The value as an element of type T: 8-bit values by to_8bit().
template <class T, class Value>
T converted(Value value) {
  if constexpr (std::is_same_v<T, std::uint8_t> && std::is_floating_point_v<Value>) {
    return to_8bit(value);
  } else {
    return static_cast<T>(value);
  }
}

/// Stores rows x columns x channels values, row by row, in a checked array of rows x columns, or
/// rows x columns x channels. Allocates nothing.
template <class Value>
void store(const QsArray& array, ThreadPool& pool, const Value* values, int rows, int columns,
           int channels = 1) {
  const std::ptrdiff_t down = array.strides[0], right = array.strides[1];
  const std::ptrdiff_t deep = channels > 1 ? array.strides[2] : 0;
  with_type(array, [&](auto* elements) {
    using Element = std::remove_pointer_t<decltype(elements)>;
    const auto store_rows = [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t row = begin; row < end; ++row) {
        const Value* from =
            values + row * static_cast<std::size_t>(columns) * static_cast<std::size_t>(channels);
        Element* to = elements + static_cast<std::ptrdiff_t>(row) * down;
        if constexpr (std::is_same_v<Element, Value>) {
          if (right == channels && (channels == 1 || deep == 1)) {
            std::copy_n(from, columns * channels, to);
            continue;
          }
        }
        for (int column = 0; column < columns; ++column, to += right)
          for (int channel = 0; channel < channels; ++channel)
            to[channel * deep] = converted<Element>(*from++);
      }
    };
    pool.for_chunks(static_cast<std::size_t>(rows), 16, std::ref(store_rows));
  });
}

/// Copies the values of a checked array of rows x columns, or rows x columns x channels, row by
/// row.
template <class To, class Convert>
void gather(const QsArray& array, ThreadPool& pool, To* to, const Convert& convert) {
  const auto columns = static_cast<std::size_t>(array.sizes[1]);
  const std::size_t channels = array.dimensions == 3 ? static_cast<std::size_t>(array.sizes[2]) : 1;
  const std::ptrdiff_t deep = array.dimensions == 3 ? array.strides[2] : 0;
  with_type(array, [&](const auto* elements) {
    pool.for_chunks(
        static_cast<std::size_t>(array.sizes[0]), 16, [&](std::size_t begin, std::size_t end, int) {
          To* next = to + begin * columns * channels;
          for (std::size_t y = begin; y < end; ++y)
            for (std::size_t x = 0; x < columns; ++x)
              for (std::size_t c = 0; c < channels; ++c)
                *next++ = convert(elements[static_cast<std::ptrdiff_t>(y) * array.strides[0] +
                                           static_cast<std::ptrdiff_t>(x) * array.strides[1] +
                                           static_cast<std::ptrdiff_t>(c) * deep]);
        });
  });
}

/// The values of a checked array of rows x columns, or rows x columns x channels; 8-bit values as
/// value / 255.
Image image_of(const QsArray& array, ThreadPool& pool);

/// The degree of spherical harmonics with this number of coefficients per channel; 0 for none.
int sh_degree_of(std::int64_t coefficients);

/// A view of values in the library's memory: `count` rows, `columns` values each, or one dimension
/// if `columns` is 0. `stride`: elements from a row to the next.
QsArray view_of(const void* data, std::size_t count, std::uint32_t type, std::int64_t columns = 0,
                std::int64_t stride = 1);

}  // namespace qs::library
