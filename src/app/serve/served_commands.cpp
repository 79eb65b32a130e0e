// SPDX-License-Identifier: MIT
#include "app/serve/served_commands.h"

#include <algorithm>
#include <array>

namespace qs {
namespace {

// The culling modes and the moves of the cross are allowed too.
constexpr std::string_view kServed[] = {
    "Heat map",
    "Next heat map",
    "Depth or alpha instead of colours",
    "Next of depth, median depth and alpha",
    "Larger splats",
    "Smaller splats",
    "Draw splats",
    "Draw points",
    "Draw ellipsoids",
    "Pinhole camera",
    "Panorama of 360 degrees",
    "Fisheye of 180 degrees",
    "Orthographic",
    "Previous camera",
    "Next camera",
    "First camera",
    "Last camera",
    "Nearest camera",
    "Frame the scene",
    "First view",
    "Bookmark this view",
    "Back to the view before",
    "Forward to the next view",
    "This view is upright",
    "Orbit or fly",
    "Previous mode, while held",
    "FPS of all modes",
    "Scene and render settings",
    "Inspector: boxes of a Gaussian",
    "Crop and clean",
    "Apply or undo the crop",
    "Select with the next tool",
    "Leave the selecting tool",
    "Larger brush",
    "Smaller brush",
    "Select all",
    "Select nothing",
    "Invert the selection",
    "Grow the selection",
    "Shrink the selection",
    "Remove the selected Gaussians",
    "Keep only the selected Gaussians",
    "Hide the selected Gaussians",
    "Show hidden Gaussians again",
    "Save the edits",
    "Measure distances",
    "Copy the measures",
    "Use the cross; close the shape or the line",
    "Cameras and path",
    "Set a keyframe",
    "Undo",
    "Redo",
    "Play the path",
    "Film of the path, or round the scene",
    "All modes side by side",
    "Split: beside another mode or scene",
    "Next view of the split",
    "Flip the split",
    "Zoom recorder",
    "Record a zoom",
    "Training",
    "Pause or resume training",
};

bool is_served(const KeyCommand& command) {
  const std::string_view name = command.help;
  const CullMode mode = command.menu == Menu::mode ? find_culler(command.help) : -1;
  return std::ranges::find(kServed, name) != std::end(kServed) ||
         name.starts_with("Move the cross of a tool") || (mode >= 1 && mode <= culler_count());
}

}  // namespace

std::span<const KeyCommand* const> served_commands() {
  static const std::vector<const KeyCommand*> kCommands = [] {
    std::vector<const KeyCommand*> served;
    for (const KeyCommand& command : key_commands())
      if (is_served(command)) served.push_back(&command);
    std::ranges::stable_sort(served, {}, &KeyCommand::menu);
    return served;
  }();
  return kCommands;
}

const KeyCommand* find_served_command(std::string_view help) {
  const auto served = served_commands();
  const auto found = std::ranges::find(served, help, &KeyCommand::help);
  return found == served.end() ? nullptr : *found;
}

bool is_of_training(const KeyCommand& command) {
  return command.panel == &Panels::training ||
         std::string_view(command.help).ends_with(" training");
}

bool may_press(int key, int mods) {
  const KeyCommand* const command = find_key_command(key, mods);
  return command == nullptr || is_served(*command);
}

}  // namespace qs
