// SPDX-License-Identifier: MIT
//
// Prints every error as one sentence on stderr and turns it into the exit code.
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "base/error.h"

namespace {

int complain(int code, const char* sentence) {
  fmt::print(stderr, "quadsplat: {}\n", sentence);
  return code;
}

int run(const std::vector<std::string>& arguments) try {
  const int code = qs::run_program(arguments);
  if (std::fflush(stdout) != 0) return complain(qs::kExitInput, "the output could not be written");
  return code;
} catch (const qs::Error& error) {
  return complain(static_cast<int>(error.kind()), error.what());
} catch (const qs::Cancelled&) {
  return complain(qs::kExitInterrupted, "interrupted");
} catch (const std::bad_alloc&) {
  return complain(qs::kExitDevice, "not enough memory");
} catch (const std::exception& error) {
  return complain(qs::kExitInput, error.what());
}

}  // namespace

int main(int argc, char** argv) { return run(std::vector<std::string>(argv + 1, argv + argc)); }
