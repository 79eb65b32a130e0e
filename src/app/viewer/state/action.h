// SPDX-License-Identifier: MIT
//
// An action is a change of the Viewer that is carried out later: input, panels and threads collect
// actions, and ViewerStore::apply() runs them one by one on the main thread. Any function of the
// form f(Viewer&, arguments...) or f(Viewer&, Host&, arguments...) can be an action.
#pragma once

#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "app/viewer/state/host.h"
#include "app/viewer/state/viewer.h"

namespace qs {

using Action = std::function<void(Viewer&, Host&)>;
using Actions = std::vector<Action>;

/// The action that calls `function` with these arguments after the viewer (and the host).
template <class Function, class... Arguments>
Action call(Function function, Arguments... arguments) {
  return [function, ... kept = std::move(arguments)](Viewer& viewer, Host& host) {
    if constexpr (std::is_invocable_v<Function, Viewer&, Host&, const Arguments&...>) {
      function(viewer, host, kept...);
    } else {
      function(viewer, kept...);
    }
  };
}

/// Owns the Viewer: everything may read it, and only actions change it.
class ViewerStore {
 public:
  explicit ViewerStore(Viewer viewer) : viewer_(std::move(viewer)) {}

  const Viewer& viewer() const { return viewer_; }

  /// An Error that the action throws is shown to the user.
  void apply(const Action& action, Host& host);

 private:
  Viewer viewer_;
};

}  // namespace qs
