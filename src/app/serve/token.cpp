// SPDX-License-Identifier: MIT
#include "app/serve/token.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include <sys/random.h>

#include "base/fail.h"

namespace qs {

std::string make_token() {
  std::array<std::uint8_t, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size()))
    fail(ErrorKind::device, "serve: the system has no random numbers");
  std::string token;
  for (const std::uint8_t byte : bits) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_token(std::string_view token, std::string_view given) {
  if (token.size() != given.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i)
    difference = static_cast<unsigned char>(difference | (token[i] ^ given[i]));
  return difference == 0;
}

}  // namespace qs
