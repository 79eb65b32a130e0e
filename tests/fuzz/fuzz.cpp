// SPDX-License-Identifier: MIT
//
// The libFuzzer program. `fuzz --list` prints a line "NAME ENDING..." per target; the environment
// variable QUADSPLAT_FUZZ chooses the target that runs. scripts/fuzz runs them all.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "fuzz/targets.h"

namespace {

const qs::test::FuzzTarget* chosen_target() {
  static const std::vector<qs::test::FuzzTarget> targets = qs::test::fuzz_targets();
  const char* const name = std::getenv("QUADSPLAT_FUZZ");
  for (const auto& target : targets) {
    if (name != nullptr && target.name == name) return &target;
  }
  std::fprintf(stderr, "QUADSPLAT_FUZZ names no target\n");
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  if (*count < 2 || std::string_view((*arguments)[1]) != "--list") return 0;
  for (const auto& target : qs::test::fuzz_targets())
    std::printf("%s %s\n", target.name.c_str(), target.ending.c_str());
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const qs::test::FuzzTarget& target = *chosen_target();
  // A copy of exactly this size: AddressSanitizer sees a read of one byte too many.
  const std::vector<std::byte> content(reinterpret_cast<const std::byte*>(data),
                                       reinterpret_cast<const std::byte*>(data) + size);
  target.run(content);
  return 0;
}
