// SPDX-License-Identifier: MIT
//
// How good a view of a sample is, from pictures of it in the size of a thumbnail.
#pragma once

#include <memory>
#include <vector>

#include "app/framing/fit_view.h"
#include "app/framing/ground.h"
#include "raster/api/renderer.h"

namespace qs {

/// Measures of one view, 0 to 1.
struct ViewQuality {
  double coverage = 0;     ///< share of the picture that shows the subject
  double detail = 0;       ///< mean difference of neighbouring pixels of the subject
  double shown = 0;        ///< share of the subject that is inside the picture
  double cut = 0;          ///< share of the picture's edge that shows the subject
  double obstruction = 0;  ///< how much the picture changes without what is near the eye
  bool blocked = false;    ///< the eye is inside a Gaussian
};

class CandidateViews {
 public:
  CandidateViews(const CloudSample& sample, const Subject& subject, const Ground& ground,
                 const Shape& shape, ThreadPool& pool);

  /// `free`: what is nearer to the eye obstructs the view.
  ViewQuality measure(const Framing& framing, double free);

  /// How much of a picture shows what is at the border of the subject; what is half way from its
  /// middle counts half.
  double border_share(const Camera& camera);

  /// Whether a point lies in a Gaussian: within 3 standard deviations of one that can be seen.
  bool is_inside_a_gaussian(glm::dvec3 point) const;

 private:
  const CloudSample& sample_;
  const Shape& shape_;
  std::vector<double> sizes_;  // per Gaussian of the sample: largest standard deviation
  RenderSettings settings_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace qs
