// SPDX-License-Identifier: MIT
//
// Draws controls of the common table (commands/controls.h) in the window. The table has their
// words, ranges, values and effects; a panel's model says where a control is and which form it has.
// Nothing is drawn of a control that is of no use now.
#pragma once

#include <functional>
#include <string_view>

#include "app/viewer/panel_model/panel_model.h"

namespace qs {

class ControlsDrawer {
 public:
  /// Both are used until the end of this object.
  ControlsDrawer(const Viewer& viewer, Actions& actions) : viewer_(viewer), actions_(actions) {}

  /// A check box, list, slider, field, colour or button, by the kind of the control.
  void draw(const block::Placed& placed) const;
  /// The choices below each other, or in lines.
  void draw_radio(std::string_view name, bool in_lines) const;
  /// An entry of a menu with a tick.
  void draw_menu_item(std::string_view name) const;

  /// For what a panel draws itself: sets the control, and shows its tooltip.
  void set(std::string_view name, double value, std::size_t index = 0) const;
  void set(const Use& use) const { set(use.control, use.value, use.index); }
  void show_tooltip(std::string_view name) const;

 private:
  // Calls the function with the control if it is of use now, and shows the tooltip afterwards.
  void with(std::string_view name,
            const std::function<void(const Control& control, const ControlNow& now)>& draw) const;
  void draw_range(const block::Placed& placed) const;

  const Viewer& viewer_;
  Actions& actions_;
};

}  // namespace qs
