// SPDX-License-Identifier: MIT
//
// Views of a subject: the distance from which it fills the picture, seen from a given direction,
// and the quality of a view of a sample, measured from pictures of thumbnail size.
#pragma once

#include <memory>
#include <vector>

#include "app/framing/first_view.h"
#include "app/framing/subject.h"
#include "raster/api/renderer.h"

namespace qs {

/// The shape to which a view is fitted.
struct Shape {
  std::vector<glm::dvec3> corners;  ///< the corners of the subject's box
  std::vector<glm::dvec3> points;   ///< some hundred of its Gaussians
  std::vector<float> weights;       ///< the weights of the points
  glm::dvec3 center{0.0};
  double radius = 0;  ///< the radius of the sphere around the box, > 0
};

/// A box smaller than `smallest` gets this half side.
Shape shape_of(const Subject& subject, double smallest);

/// The view from `toward_eye`, a unit vector that is not parallel to `up`, with the shape's box in
/// the middle and 72 % as high as the picture, or less if much of the shape extends beyond the box.
Framing fit_view(const Shape& shape, glm::dvec3 toward_eye, glm::dvec3 up);

/// Measures of one view, 0 to 1.
struct ViewQuality {
  double coverage = 0;      ///< share of the picture that shows the subject
  double detail = 0;        ///< mean difference of neighbouring pixels of the subject
  double third_detail = 0;  ///< the same of the third channel
  double shown = 0;         ///< share of the subject that is inside the picture
  double cut = 0;           ///< share of the picture's edge that shows the subject
  double obstruction = 0;   ///< change of the picture when nothing near the eye is drawn
  bool blocked = false;     ///< the eye is inside a Gaussian
};

/// A picture has brightness, subject, and the distance from the subject's middle to its border, or
/// the hue, from blue to red and yellow.
enum class ThirdChannel { border, hue };

class CandidateViews {
 public:
  /// `sample` and `ground` must outlive the object.
  CandidateViews(const CloudSample& sample, const Subject& subject, const Ground& ground,
                 ThreadPool& pool, ThirdChannel third = ThirdChannel::border);

  const GaussianCloud& gaussians() const { return sample_.gaussians; }
  const Ground& ground() const { return ground_; }
  const Shape& shape() const { return shape_; }  ///< the shape of the subject

  /// `free`: Gaussians nearer to the eye than this obstruct the view; world units.
  ViewQuality measure(const Framing& framing, double free);

  /// The share of a picture, 0 to 1, that shows the border of the subject. Gaussians half way
  /// between its middle and its border count half. Needs ThirdChannel::border.
  double border_share(const Camera& camera);

  /// True if a point is inside a Gaussian: within 3 standard deviations of a visible Gaussian.
  bool is_inside_a_gaussian(glm::dvec3 point) const;

 private:
  const CloudSample& sample_;
  const Ground& ground_;
  Shape shape_;
  std::vector<double> sizes_;  // per Gaussian of the sample: largest standard deviation
  RenderSettings settings_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace qs
