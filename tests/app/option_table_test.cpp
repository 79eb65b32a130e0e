// SPDX-License-Identifier: MIT
//
// The help of every command, and what every option says to a wrong value, which names its limits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "raster/base/error.h"
#include "support/golden.h"

namespace qs {
namespace {

std::string answer(const Option& option, const std::string& value) {
  try {
    option.accept({value});
    return "is taken";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(OptionTable, help_samples_and_limits_of_every_command) {
  std::string text;
  for (const Command& command : commands()) {
    Options options(command.name, command.summary);
    const Action action = command.declare(options);
    text += options.help() + "\n";
    for (const Option& option : options.table()) {
      if (option.most == 0) continue;
      text += fmt::format("{}: {} .. {} values, samples {}\n", option.name, option.least,
                          option.most, joined(option.samples, " "));
      for (const std::string value : {"x", "99999999999", "-1,-1", "0,0,0,-1", "0x0"}) {
        const std::string said = answer(option, value);
        if (said != "is taken") text += fmt::format("    {}\n", said);
      }
      for (const std::string& sample : option.samples)
        EXPECT_EQ(answer(option, sample), "is taken") << command.name << " " << option.name;
    }
    text += "\n";
  }
  test::expect_golden_text("options.txt", text);
}

TEST(OptionTable, values_are_taken_up_to_their_limits_and_no_further) {
  struct Case {
    const char *command, *option, *taken, *refused;
  };
  const Case cases[] = {
      {"inspect", "--pixel", "0,0", "-1,0"},
      {"inspect", "--pixel", "1000000,1000000", "0,1000001"},
      {"inspect", "--pixel", "1000000,0", "1000001,0"},
      {"inspect", "--pixel", "0,0", "0,-1"},
      {"compare", "--crop", "0,0,1,1", "0,0,1,0"},
      {"compare", "--crop", "0,0,1,1", "0,0,0,1"},
      {"compare", "--crop", "0,0,1,1", "0,-1,1,1"},
      {"compare", "--crop", "0,0,1,1", "-1,0,1,1"},
      {"compare", "--crop", "1000000,1000000,1000000,1000000", "0,1000001,1,1"},
      {"bench", "--camera-index", "0,1000000000", "0,1000000001"},
      {"bench", "--camera-index", "0", "-1"},
      {"zoom", "--target", "-1000000000,0,1000000000", "0,0,1000000001"},
      {"zoom", "--target", "0,0,0", "0,-1000000001,0"},
      {"render", "--background", "0,1,1", "0,1,1.01"},
  };
  for (const Case& c : cases) {
    for (const Command& command : commands()) {
      if (command.name != std::string(c.command)) continue;
      Options options(command.name, command.summary);
      const Action action = command.declare(options);
      for (const Option& option : options.table()) {
        if (option.name != c.option) continue;
        EXPECT_EQ(answer(option, c.taken), "is taken") << c.option;
        EXPECT_NE(answer(option, c.refused), "is taken") << c.option << " " << c.refused;
      }
    }
  }
}

}  // namespace
}  // namespace qs
