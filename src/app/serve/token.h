// SPDX-License-Identifier: MIT
//
// The secret that a visitor of the server must know. It is in the fragment of the printed address,
// which browsers send to nobody; the page sends it in its first message.
#pragma once

#include <string>
#include <string_view>

namespace qs {

/// 128 random bits of the system as 32 hexadecimal digits. Throws Error(device) without them.
std::string make_token();

/// True if both are equal. Takes the same time wherever they differ.
bool same_token(std::string_view token, std::string_view given);

}  // namespace qs
