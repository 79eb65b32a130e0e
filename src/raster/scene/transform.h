// SPDX-License-Identifier: MIT
//
// Applies an affine transform, such as a glTF node's, to Gaussians: positions, covariances and SH.
// A similarity keeps every Gaussian's shape; any other transform recomputes scale and rotation from
// the transformed covariance. SH are rotated by the transform's polar part.
#pragma once

#include <array>
#include <cstddef>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Eigenvectors (columns of `axes`) and eigenvalues of a symmetric matrix by Jacobi rotations.
void diagonalise(glm::dmat3 matrix, glm::dmat3& axes, glm::dvec3& values);

class Transform {
 public:
  /// is_invertible(matrix) must hold.
  explicit Transform(const glm::dmat4& matrix);

  /// True if the last row is 0 0 0 1 and the rest does not flatten space.
  static bool is_invertible(const glm::dmat4& matrix);

  bool is_identity() const { return matrix_ == glm::dmat4(1); }
  /// True if the transform consists of rotation, translation and uniform scaling.
  bool is_similarity() const { return is_similarity_; }

  /// Applies the transform to Gaussian `i`.
  void apply(GaussianCloud& cloud, std::size_t i) const;

 private:
  void turn_sh(glm::vec3* sh, int degree) const;

  glm::dmat4 matrix_;
  glm::dmat3 linear_;
  glm::dquat rotation_{1, 0, 0, 0};  // the similarity's
  float log_scale_ = 0;              // the similarity's
  bool is_similarity_ = false;
  // New coefficient k from old coefficients j within a degree: k, j below 7.
  std::array<std::array<std::array<float, 7>, 7>, kMaxShDegree + 1> sh_{};
};

/// Places a Gaussian of an instance: transforms it and multiplies its colours by `tint`.
struct Placement {
  Transform transform;
  glm::vec3 tint{1};

  void apply(GaussianCloud& cloud, std::size_t i) const;
};

/// Sets the scale and the rotation of Gaussian `i` so that it has this covariance: symmetric, world
/// units^2, eigenvalues below 0 count as 0.
void set_covariance(GaussianCloud& cloud, std::size_t i, const glm::dmat3& covariance);

}  // namespace qs
