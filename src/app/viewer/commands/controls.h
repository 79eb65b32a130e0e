// SPDX-License-Identifier: MIT
//
// The controls of the panels as a table: their words, ranges, values and effects, apart from their
// drawing. The window's panels (app/viewer/panels/controls_drawer.h) and the page of `quadsplat
// serve` (assets/serve/controls.js) draw from it.
// To add a control: one row in controls.cpp, and its name in the window's panel.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

/// An `item` belongs to a row of a list, which gives its index; it has no value of its own.
enum class ControlKind { toggle, choice, number, color, button, item };

/// A control of a viewer now.
struct ControlNow {
  double value = 0;                       ///< toggle: 0, 1; choice: index; color: 0xRRGGBB
  double least = 0, most = 0, step = 0;   ///< of a number; step 0: any
  bool is_logarithmic = false;            ///< the number's slider
  bool is_typed = false;                  ///< the number has no slider
  int decimals = 2;                       ///< of the number, as it is shown
  const char* unit = "";                  ///< of the number: " s"
  std::vector<std::string> choices = {};  ///< of a choice
  std::string text = {};                  ///< the label, in place of the name
  bool is_enabled = true;                 ///< false: shown in gray
};

struct Control {
  std::string name;  ///< no other control has it
  ControlKind kind;
  /// Unset if the control is of no use now. Callers use control_now().
  std::function<std::optional<ControlNow>(const Viewer& viewer)> now;
  /// `value`: finite and of now(); for an item any. `index`: of an item.
  std::function<Action(double value, std::size_t index)> set;
  std::string help = "";       ///< its tooltip
  bool without_scene = false;  ///< also works without a scene
};

/// Unset if the control is of no use now.
std::optional<ControlNow> control_now(const Viewer& viewer, const Control& control);

/// ControlNow::value of a colour.
double hex_of(glm::vec3 color);

/// The text beside or on the control.
const std::string& label_of(const Control& control, const ControlNow& now);

std::span<const Control> controls();

/// Null if there is none.
const Control* find_control(std::string_view name);

/// The action of a value that may come from anywhere; unset if the control is of no use now or the
/// value is not one of its values.
std::optional<Action> set_control(const Viewer& viewer, const Control& control, double value,
                                  std::size_t index);

/// A use of a control by its words: "Floaters: on", "how: add", "weight: 0.2".
struct NamedUse {
  std::string label;
  Action action;
};

/// The uses that the text names now: of numbers, the value that ends the text. None without text.
std::vector<NamedUse> find_uses(const std::string& text, const Viewer& viewer);

}  // namespace qs
