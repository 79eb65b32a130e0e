// SPDX-License-Identifier: MIT
//
// The help of every command, and the message of every option for a wrong value, which names its
// limits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "base/error.h"
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
    const CommandAction action = command.declare(options);
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
      {"compare", "--part", "0,0,1,1", "0,0,1,0"},
      {"compare", "--part", "0,0,1,1", "0,0,0,1"},
      {"compare", "--part", "0,0,1,1", "0,-1,1,1"},
      {"compare", "--part", "0,0,1,1", "-1,0,1,1"},
      {"compare", "--part", "1000000,1000000,1000000,1000000", "0,1000001,1,1"},
      {"bench", "--camera-index", "0,1000000000", "0,1000000001"},
      {"bench", "--camera-index", "0", "-1"},
      {"zoom", "--target", "-1000000000,0,1000000000", "0,0,1000000001"},
      {"zoom", "--target", "0,0,0", "0,-1000000001,0"},
      {"render", "--threads", "1", "0"},
      {"train", "--threads", "1", "0"},
      {"render", "--background", "0,1,1", "0,1,1.01"},
  };
  for (const Case& c : cases) {
    for (const Command& command : commands()) {
      if (command.name != std::string(c.command)) continue;
      Options options(command.name, command.summary);
      const CommandAction action = command.declare(options);
      for (const Option& option : options.table()) {
        if (option.name != c.option) continue;
        EXPECT_EQ(answer(option, c.taken), "is taken") << c.option;
        EXPECT_NE(answer(option, c.refused), "is taken") << c.option << " " << c.refused;
      }
    }
  }
}

TEST(OptionTable, choices_set_what_they_name) {
  const auto parsed = [](const std::vector<std::string>& words) {
    FrameOptions frame;
    Options options("try", "tries");
    declare_common_options(options, frame);
    EXPECT_TRUE(options.parse(words));
    return frame;
  };
  EXPECT_EQ(parsed({"--antialiased", "on"}).antialiased, true);
  EXPECT_EQ(parsed({"--antialiased", "off"}).antialiased, false);
  EXPECT_EQ(parsed({"--antialiased", "auto"}).antialiased, std::nullopt);
  EXPECT_EQ(parsed({"--tile-size", "8"}).tile_px, 8);
  EXPECT_EQ(parsed({"--tile-size", "32"}).tile_px, 32);
  EXPECT_EQ(parsed({"--pipeline", "classic"}).pipeline, Pipeline::classic);
  EXPECT_EQ(parsed({"--backend", "cuda"}).backend, Backend::cuda);
  EXPECT_EQ(parsed({"--axes", "RUB"}).axes, "RUB");
  EXPECT_EQ(parsed({"--cull", "exact,adr,exact"}).modes,
            (std::vector<CullMode>{find_culler("exact"), find_culler("adr")}));
  EXPECT_EQ(parsed({}).antialiased, std::nullopt);
}

TEST(Options, of_cull_add_the_peers_to_the_named_modes_or_to_the_usual_ones) {
  const auto parsed = [](std::vector<CullMode> usual, const char* words) {
    FrameOptions frame;
    frame.modes = std::move(usual);
    Options options("test", "");
    declare_common_options(options, frame);
    std::vector<std::string> arguments = {"--cull", words};
    EXPECT_TRUE(options.parse(arguments));
    return frame.modes;
  };
  const CullMode exact = find_culler("exact"), accutile = find_culler("accutile");
  std::vector<CullMode> everything = all_modes();
  EXPECT_EQ(parsed({exact}, "all"), everything);
  std::vector<CullMode> usual_and_peers = {exact}, peers_and_adr = peer_modes();
  for (const CullMode peer : peer_modes()) {
    everything.push_back(peer);
    usual_and_peers.push_back(peer);
  }
  EXPECT_EQ(parsed({exact}, "all,+peers"), everything);
  EXPECT_EQ(parsed({exact}, "+peers"), usual_and_peers);
  EXPECT_EQ(parsed({}, "+peers"), everything);
  peers_and_adr.push_back(find_culler("adr"));
  EXPECT_EQ(parsed({exact}, "+peers,accutile,adr"), peers_and_adr);
  EXPECT_EQ(parsed({exact}, "accutile"), std::vector<CullMode>{accutile});
}

}  // namespace
}  // namespace qs
