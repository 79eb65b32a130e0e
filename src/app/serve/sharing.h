// SPDX-License-Identifier: MIT
//
// The parts of a scene that all its visitors share, because there is one renderer: the edits and
// the backend. Whoever changes one changes it for all; the others follow with a message.
#pragma once

#include <map>

#include "app/serve/visitor.h"

namespace qs {

class Sharing {
 public:
  /// Makes the visitor follow the others' changes, and takes the visitor's own. True if the
  /// visitor has changed the scene, so that meet() is due for the others. Called after every change
  /// of a visitor.
  bool meet(Visitor& visitor, double now);

  /// The crop that a scene should show; it may show another if a visitor left in the middle of one.
  CropRequest crop_of(std::size_t scene);

 private:
  struct Shared {
    Editing editing;
    std::uint64_t gaussians = 0;
    EditFacts edits;
    std::optional<Backend> backend;  // unset: as opened
  };
  static void follow_edits(Viewer& viewer, const Shared& shared);

  std::map<std::size_t, Shared> shared_;  // by scene
};

}  // namespace qs
