// SPDX-License-Identifier: MIT
//
// The keys of a browser as the window's tables name them.
#pragma once

#include <string_view>

namespace qs {

/// The GLFW_KEY_* of a KeyboardEvent.code such as "KeyW"; 0 if no command can have this key.
int key_of_code(std::string_view code);

}  // namespace qs
