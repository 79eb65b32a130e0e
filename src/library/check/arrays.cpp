// SPDX-License-Identifier: MIT
#include "library/check/arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>

#include "library/check/gpu_arrays.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::library {
namespace {

struct ElementType {
  const char* name;
  std::uintptr_t bytes;
};

/// Index = QS_FLOAT32, ...
constexpr std::array kElementTypes = {ElementType{"float32", 4}, ElementType{"float64", 8},
                                      ElementType{"uint8", 1},   ElementType{"int32", 4},
                                      ElementType{"uint32", 4},  ElementType{"int64", 8},
                                      ElementType{"uint64", 8}};

std::string names_of(Types types) {
  std::string names;
  for (std::size_t type = 0; type < kElementTypes.size(); ++type)
    if ((types >> type & 1) != 0)
      names += fmt::format("{}{}", names.empty() ? "" : " or ", kElementTypes[type].name);
  return names;
}

template <class Sizes>
std::string shape_of(const Sizes& sizes, std::size_t dimensions) {
  std::string text;
  for (std::size_t i = 0; i < dimensions; ++i)
    text += fmt::format("{}{}", i == 0 ? "" : " x ", *(std::begin(sizes) + i));
  return text;
}

/// Throws Error(usage) if an element's place does not fit into 64 bits.
void check_strides(const QsArray& array, const Where& where, Access access,
                   std::uintptr_t element_bytes) {
  double reach = 0;  // distance of the farthest element, in elements
  for (std::size_t i = 0; i < array.dimensions; ++i) {
    const std::int64_t size = array.sizes[i], stride = array.strides[i];
    if (size <= 1) continue;
    if (access == Access::writes && stride == 0)
      refuse(where, "its stride of dimension {} is 0, so that elements would be overwritten", i);
    reach += static_cast<double>(size - 1) * std::abs(static_cast<double>(stride));
  }
  if (reach * static_cast<double>(element_bytes) > 9e18)
    refuse(where, "its sizes and strides reach beyond 64 bits");
}

/// Throws Error(usage) unless the array is in this place.
void check_place(const QsArray& array, const Where& where, const Place& place) {
  if (array.memory > QS_MEMORY_CUDA) refuse(where, "its memory {} is unknown", array.memory);
  if (array.memory == place.memory && (!place.is_gpu() || array.device == place.device)) return;
  if (place.decided_by == nullptr)
    refuse(where, "is in the memory of a GPU, but this array must be in host memory");
  refuse(where, "is in {}, but {} is in {}", Place{array.memory, array.device}.text(),
         place.decided_by, place.text());
}

/// Throws Error(usage) if the array names another GPU than the owner of its memory. A kernel that
/// used it would fault, and end all work of the process on the GPU.
void check_gpu(const QsArray& array, const Where& where) {
  if (const std::optional<int> gpu = other_gpu_of(array))
    refuse(where, "its device is {}, but its data is in the memory of GPU {}", array.device, *gpu);
}

}  // namespace

std::string Place::text() const {
  return is_gpu() ? fmt::format("the memory of GPU {}", device) : "host memory";
}

void check_dimensions(const QsArray& array, const Where& where, std::uint32_t dimensions) {
  if (is_absent(array)) refuse(where, "is absent: it needs {} dimensions", dimensions);
  if (array.dimensions != dimensions)
    refuse(where, "has {} dimensions instead of {}", array.dimensions, dimensions);
  for (std::uint32_t i = 0; i < dimensions; ++i)
    if (array.sizes[i] < 0) refuse(where, "its size of dimension {} is {}", i, array.sizes[i]);
}

void check_array(const QsArray& array, const Where& where, std::span<const std::int64_t> sizes,
                 Types types, Access access, const Place& place) {
  check_dimensions(array, where, static_cast<std::uint32_t>(sizes.size()));
  if (!std::equal(sizes.begin(), sizes.end(), array.sizes))
    refuse(where, "has {} elements instead of {}", shape_of(array.sizes, sizes.size()),
           shape_of(sizes, sizes.size()));
  check_place(array, where, place);
  if (array.type >= kElementTypes.size()) refuse(where, "its type {} is unknown", array.type);
  const ElementType& type = kElementTypes[array.type];
  if ((types >> array.type & 1) == 0)
    refuse(where, "has elements of type {} instead of {}", type.name, names_of(types));
  if (std::ranges::find(sizes, 0) != sizes.end()) return;  // no element
  if (array.data == nullptr) refuse(where, "its data is null");
  if (reinterpret_cast<std::uintptr_t>(array.data) % type.bytes != 0)
    refuse(where, "its data is not aligned to its elements of {} bytes", type.bytes);
  check_strides(array, where, access, type.bytes);
  if (place.is_gpu()) check_gpu(array, where);
}

int sh_degree_of(std::int64_t coefficients) {
  int degree = 0;
  while (degree < kMaxShDegree && sh_coefficient_count(degree) < coefficients) ++degree;
  return degree;
}

std::int64_t ArrayChecks::sh(const QsArray& first, const char* name, const QsArray& rest,
                             const char* name_of_rest, std::int64_t count) const {
  check_dimensions(first, where / name, 3);
  const bool split = !is_absent(rest);
  const std::int64_t in_first = first.sizes[1];
  if (split) {
    check_dimensions(rest, where / name_of_rest, 3);
    if (in_first != 1)
      refuse(where / name, "has {} coefficients instead of the DC alone", in_first);
  }
  const std::int64_t coefficients = split ? 1 + rest.sizes[1] : in_first;
  if (sh_coefficient_count(sh_degree_of(coefficients)) != coefficients)
    refuse(where / name, "{} coefficients of spherical harmonics are not 1, 4, 9 or 16",
           coefficients);
  given(first, name, {count, in_first, 3});
  if (split) given(rest, name_of_rest, {count, coefficients - 1, 3});
  return coefficients;
}

Image image_of(const QsArray& array, ThreadPool& pool) {
  const std::int64_t channels = array.dimensions == 3 ? array.sizes[2] : 1;
  Image image(static_cast<int>(array.sizes[1]), static_cast<int>(array.sizes[0]),
              static_cast<int>(channels));
  gather(array, pool, image.values.data(), [](auto value) {
    constexpr bool kIs8Bit = std::is_same_v<decltype(value), std::uint8_t>;
    return static_cast<float>(value) / (kIs8Bit ? 255 : 1);
  });
  return image;
}

QsArray view_of(const void* data, std::size_t count, std::uint32_t type, std::int64_t columns,
                std::int64_t stride) {
  QsArray array{};
  array.data = const_cast<void*>(data);
  array.dimensions = columns == 0 ? 1 : 2;
  array.sizes[0] = static_cast<std::int64_t>(count);
  array.sizes[1] = columns;
  array.strides[0] = stride;
  array.strides[1] = columns == 0 ? 0 : 1;
  array.type = type;
  return array;
}

}  // namespace qs::library
