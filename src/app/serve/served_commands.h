// SPDX-License-Identifier: MIT
//
// The commands of the window that a visitor may use. key_commands() has their keys, names and
// effects; this list only allows them. Commands that write files, open files, train or quit
// are missing on purpose.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "app/viewer/commands/commands.h"

namespace qs {

/// Rows of key_commands(), in their order.
std::span<const KeyCommand* const> served_commands();

/// The command with this KeyCommand::help; null if visitors may not use it.
const KeyCommand* find_served_command(std::string_view help);

/// True if the command is of use only while a model is trained.
bool is_of_training(const KeyCommand& command);

/// True unless the key belongs to a command that visitors may not use.
bool may_press(int key, int mods);

}  // namespace qs
