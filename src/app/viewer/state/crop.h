// SPDX-License-Identifier: MIT
//
// Crop and clean, as plain data: the criteria of removal, and the part of the scene that the window
// shows. The scene that was read stays whole; render/crop_scene.h shows parts of it.
#pragma once

#include <optional>
#include <vector>

#include "raster/scene/removal.h"

namespace qs {

/// The user's criteria of removal. Numbers stay while their switch is off.
struct CropWish {
  bool boxed = false, cleans = false;
  CropBox box;
  Floaters floaters;

  bool removes() const { return boxed || cleans; }
  std::optional<CropBox> used_box() const { return boxed ? std::optional(box) : std::nullopt; }
  std::optional<Floaters> used_floaters() const {
    return cleans ? std::optional(floaters) : std::nullopt;
  }
  bool operator==(const CropWish&) const = default;
};

/// The whole scene; the same with a count of the Gaussians to remove; with these tinted; or only
/// the rest.
enum class CropView { whole, counted, marked, rest };

/// The view of the scene that the render thread should show.
struct CropRequest {
  CropWish wish;  ///< empty for CropView::whole
  CropView view = CropView::whole;
  std::vector<CropWish> done = {};  ///< crops that were applied before this one, in their order
  bool operator==(const CropRequest&) const = default;
};

struct Crop {
  CropWish wish;
  bool marks = true;                ///< while the panel is open, the Gaussians to remove are tinted
  bool applied = false;             ///< the window shows the rest
  std::vector<CropWish> done = {};  ///< crops that were applied before this one, in their order
  CropRequest asked;                ///< the last request
  bool busy = false;                ///< the render thread has not answered it yet
  std::optional<RemovalCounts> counts;  ///< of `asked`; unset for CropView::whole
};

}  // namespace qs
