// SPDX-License-Identifier: MIT
//
// Collects what floats over the picture in one drawing of the window, and draws it at its place.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/viewer/state/floats.h"

namespace qs {

class Floats {
 public:
  explicit Floats(const Rect& picture) : picture_(picture) {}

  const Rect& picture() const { return picture_; }
  /// The width that a thing may have.
  float room() const;

  void add(Floating thing, std::function<void(const Rect& place)> draw);
  /// A text on a dark plate.
  void add_plate(FloatKind kind, const std::string& text, std::optional<glm::vec2> at = {});

  /// Draws everything that has a place. Returns true if the mouse is over a message.
  bool draw() const;

 private:
  Rect picture_;
  std::vector<Floating> shown_;
  std::vector<std::function<void(const Rect&)>> draw_;
};

}  // namespace qs
