// SPDX-License-Identifier: MIT
//
// The controls of the panels as a table: their words, ranges, values and effects, apart from their
// drawing. The page of `quadsplat serve` draws its controls from it. The window's panels have their
// own drawing and repeat the words.
// To add a control: one row in controls.cpp.
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
  bool is_logarithmic = false;            ///< a slider of this number
  std::vector<std::string> choices = {};  ///< of a choice
  std::string text = {};                  ///< on a button, in place of the name
};

struct Control {
  bool Panels::*panel;  ///< that has it
  std::string name;     ///< its label; no other control has it
  ControlKind kind;
  /// Unset if the control is of no use now.
  std::function<std::optional<ControlNow>(const Viewer& viewer)> now;
  /// `value`: finite and of now(); for an item any. `index`: of an item.
  std::function<Action(const Viewer& viewer, double value, std::size_t index)> set;
  const char* help = "";
};

std::span<const Control> controls();

/// Null if there is none.
const Control* find_control(std::string_view name);

/// The action of a value that may come from anywhere; unset if the control is of no use now or the
/// value is not one of its values.
std::optional<Action> set_control(const Viewer& viewer, const Control& control, double value,
                                  std::size_t index);

}  // namespace qs
