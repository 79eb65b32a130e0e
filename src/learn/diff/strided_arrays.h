// SPDX-License-Identifier: MIT
//
// Arrays in a caller's memory, with the caller's strides in elements. A stride may be 0 for arrays
// that are only read. A view without data stands for an array that is not given or not wanted.
#pragma once

#include <cstddef>
#include <type_traits>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"

namespace qs::diff {

/// A few numbers per Gaussian.
template <class T>
struct Rows {
  T* data = nullptr;
  std::ptrdiff_t row = 0;   ///< between Gaussians
  std::ptrdiff_t step = 1;  ///< between the numbers of a Gaussian

  /// `numbers` of each Gaussian behind each other.
  static QS_HD Rows packed(T* data, int numbers) { return {data, numbers, 1}; }

  QS_HD explicit operator bool() const { return data != nullptr; }
  template <class U>
  requires(std::is_same_v<U, const T> && !std::is_const_v<T>) QS_HD operator Rows<U>() const {
    return {data, row, step};
  }
  QS_HD T& at(std::size_t i, int k = 0) const {
    return data[static_cast<std::ptrdiff_t>(i) * row + k * step];
  }
  QS_HD auto vec2(std::size_t i) const {
    return glm::vec<2, std::remove_const_t<T>>(at(i), at(i, 1));
  }
  QS_HD auto vec3(std::size_t i) const {
    return glm::vec<3, std::remove_const_t<T>>(at(i), at(i, 1), at(i, 2));
  }
  /// The quaternion of the numbers w, x, y, z.
  QS_HD auto quaternion(std::size_t i) const {
    return glm::qua<std::remove_const_t<T>>(at(i), at(i, 1), at(i, 2), at(i, 3));
  }
  /// Writes a number or the numbers of a vector; nothing if the array is not wanted.
  QS_HD void set(std::size_t i, const T& value) const {
    if (data != nullptr) at(i) = value;
  }
  template <int kCount>
  QS_HD void set(std::size_t i, const glm::vec<kCount, T>& values) const {
    for (int k = 0; k < kCount && data != nullptr; ++k) at(i, k) = values[k];
  }
  QS_HD void fill(std::size_t i, int numbers, const T& value) const {
    for (int k = 0; k < numbers && data != nullptr; ++k) at(i, k) = value;
  }
};

/// Coefficients of colour, three numbers each. The first one may be in an array of its own.
template <class T>
struct ShRows {
  Rows<T> dc;                      ///< coefficient 0
  Rows<T> rest;                    ///< coefficient 1
  std::ptrdiff_t coefficient = 3;  ///< between the coefficients of `rest`

  /// `coefficients` of each Gaussian behind each other, DC first.
  static QS_HD ShRows packed(T* data, int coefficients) {
    T* const second = data != nullptr ? data + 3 : nullptr;
    return {{data, 3 * coefficients, 1}, {second, 3 * coefficients, 1}, 3};
  }

  QS_HD explicit operator bool() const { return static_cast<bool>(dc); }
  template <class U>
  requires(std::is_same_v<U, const T> && !std::is_const_v<T>) QS_HD operator ShRows<U>() const {
    return {dc, rest, coefficient};
  }
  QS_HD T& at(std::size_t i, int k, int channel) const {
    return k == 0 ? dc.at(i, channel) : (&rest.at(i, channel))[(k - 1) * coefficient];
  }
  QS_HD auto vec3(std::size_t i, int k) const {
    return glm::vec<3, std::remove_const_t<T>>(at(i, k, 0), at(i, k, 1), at(i, k, 2));
  }
  QS_HD void set(std::size_t i, int k, const glm::vec<3, T>& values) const {
    for (int c = 0; c < 3 && dc.data != nullptr; ++c) at(i, k, c) = values[c];
  }
};

/// A picture.
template <class T>
struct Pixels {
  T* data = nullptr;
  std::ptrdiff_t row = 0, column = 1, channel = 0;

  /// The channels of a pixel behind each other.
  static QS_HD Pixels packed(T* data, int width, int channels) {
    return {data, std::ptrdiff_t{width} * channels, channels, 1};
  }

  QS_HD explicit operator bool() const { return data != nullptr; }
  template <class U>
  requires(std::is_same_v<U, const T> && !std::is_const_v<T>) QS_HD operator Pixels<U>() const {
    return {data, row, column, channel};
  }
  QS_HD T& at(int x, int y, int c = 0) const { return data[y * row + x * column + c * channel]; }
};

}  // namespace qs::diff
