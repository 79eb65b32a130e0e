// SPDX-License-Identifier: MIT
//
// The picture of a film: upright strips of the same view, each drawn in another way, with the
// numbers of its frame.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "app/picture/canvas.h"

namespace qs {

/// The name of a strip and its colour.
struct StripName {
  std::string text;
  glm::vec3 color{1.0f};  ///< on a dark ground
};

class SplitScreen {
 public:
  /// One strip per name, all equally wide.
  SplitScreen(std::vector<StripName> names, int width, int height);

  /// Copies strip `index` from a whole view.
  void show(std::size_t index, const Image& view);

  /// Writes the strip's name and these lines at its bottom, over the picture of show(). A strip
  /// that is too narrow for readable letters gets no label.
  void label(std::size_t index, const std::vector<std::string>& lines);

  /// The strips with lines between them. A caller may draw over them; show() replaces that.
  Image& picture();

 private:
  PixelRect strip(std::size_t index) const;

  std::vector<StripName> names_;
  Image picture_;
  Font font_;
};

}  // namespace qs
