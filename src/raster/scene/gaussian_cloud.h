// SPDX-License-Identifier: MIT
//
// A scene of 3D Gaussians as trained: logarithms, logits and raw SH, so that reading and writing a
// file loses nothing. A renderer activates the values once, at upload. World axes are RDF (x right,
// y down, z forward) as in INRIA .ply files; readers convert other axes.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// std::allocator that leaves new elements uninitialised, so that a reader which fills an array of
/// 200 MB does not zero it first.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitialisedAllocator<U>;
  };
  template <class U>
  void construct(U* pointer) {
    ::new (static_cast<void*>(pointer)) U;
  }
  template <class U, class... Args>
  void construct(U* pointer, Args&&... args) {
    ::new (static_cast<void*>(pointer)) U(std::forward<Args>(args)...);
  }
};

/// A std::vector whose resize() leaves new elements of trivial types uninitialised.
template <class T>
using Array = std::vector<T, UninitialisedAllocator<T>>;

/// Number of SH coefficients per colour channel of a degree (0..3), DC included: 1, 4, 9, 16.
constexpr int sh_coefficient_count(int degree) { return (degree + 1) * (degree + 1); }

constexpr int kMaxShDegree = 3;

inline bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

struct GaussianCloud {
  Array<glm::vec3> positions;   ///< world units, finite
  Array<glm::vec3> log_scales;  ///< ln of the standard deviations; -inf = flat
  Array<glm::quat> rotations;   ///< unit length
  Array<float> opacity_logits;  ///< +-inf allowed (opacity 1 and 0)
  Array<glm::vec3> sh;       ///< sh_coefficient_count(sh_degree) RGB triples per Gaussian, DC first
  int sh_degree = 0;         ///< 0..3
  bool antialiased = false;  ///< trained with Mip-Splatting's opacity compensation
  /// The place in the world from which positions count; not 0 for georeferenced data. Cameras count
  /// from the same place, see Camera::placed().
  glm::dvec3 origin{0.0};

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }

  /// Resizes every array for `count` Gaussians of `degree`; new values are uninitialised.
  void resize(std::size_t count, int degree) {
    positions.resize(count);
    log_scales.resize(count);
    rotations.resize(count);
    opacity_logits.resize(count);
    sh.resize(count * static_cast<std::size_t>(sh_coefficient_count(degree)));
    sh_degree = degree;
  }
};

}  // namespace qs
