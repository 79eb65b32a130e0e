// SPDX-License-Identifier: MIT
//
// The tables of options: help, manual page and completion list every option once, samples and
// defaults are taken, and messages about wrong values name what is right.
#include <algorithm>
#include <regex>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "base/error.h"

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

// Calls visit(command, options) for the table of options of every command.
template <class Visit>
void for_each_table(const Visit& visit) {
  for (const Command& command : commands()) {
    Options options(command.name, command.summary);
    const CommandAction action = command.declare(options);
    visit(std::string(command.name), options);
  }
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
  return found;
}

// The text from `begin` to the next `end`; "" without `begin`.
std::string section_of(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t at = text.find(begin);
  return at == text.npos ? "" : text.substr(at, text.find(end, at + begin.size()) - at);
}

TEST(OptionTable, help_lists_every_option_once_with_its_words_in_its_section) {
  for_each_table([](const std::string& command, const Options& options) {
    const std::string help = options.help();
    EXPECT_TRUE(help.starts_with("quadsplat " + command + ": "));
    const std::size_t shared = std::min(help.find("\nscene and rendering:\n"), help.size());
    for (const Option& option : options.table()) {
      const std::string shown = option.shown();
      const std::string line = shown.size() <= 28
                                   ? fmt::format("\n  {:28}  {}\n", shown, option.help)
                                   : fmt::format("\n  {}\n  {:28}  {}\n", shown, "", option.help);
      EXPECT_EQ(count(help, line), 1u) << command << line;
      EXPECT_EQ(count(help, "\n  " + shown + " "), shown.size() <= 28 ? 1u : 0u) << command << line;
      EXPECT_EQ(help.find(line) > shared, option.common) << command << line;
    }
    for (const auto& [command_line, what] : options.examples())
      EXPECT_EQ(count(help, "  " + command_line + "\n      " + what + "\n"), 1u) << command;
  });
}

TEST(OptionTable, manual_page_and_completion_list_every_option_once_for_its_command) {
  const std::string page = man_page(), completion = bash_completion();
  const auto in_roff = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('-', at)) != text.npos; at += 2) text.insert(at, "\\");
    return text;
  };
  const std::string shared = section_of(page, "\n.SH SCENE AND RENDERING\n", "\n.SH ");
  for_each_table([&](const std::string& command, const Options& options) {
    const std::string own = section_of(page, "\n.SS quadsplat " + command + " ", "\n.S");
    const std::string offered =
        section_of(completion, "\n    " + command + ") options='", "'") + " ";
    for (const Option& option : options.table()) {
      const std::string entry = in_roff(fmt::format("\n.B {}\n{}\n", option.shown(), option.help));
      EXPECT_EQ(count(own + "\n", entry), option.common ? 0u : 1u) << command << entry;
      if (option.common) {
        EXPECT_EQ(count(shared + "\n", entry), 1u) << command << entry;
      }
      if (option.positional()) continue;
      std::string names = offered;
      std::replace(names.begin(), names.end(), '\'', ' ');
      EXPECT_EQ(count(names, " " + option.name + " "), 1u) << command << " " << option.name;
    }
  });
}

TEST(OptionTable, samples_and_defaults_are_taken) {
  for_each_table([](const std::string& command, const Options& options) {
    for (const Option& option : options.table()) {
      if (option.most == 0) continue;
      EXPECT_FALSE(option.samples.empty()) << command << " " << option.name;
      for (const std::string& sample : option.samples)
        EXPECT_EQ(answer(option, sample), "is taken") << command << " " << option.name;
      const std::size_t at = option.help.find("(default: ");
      if (at == option.help.npos) continue;
      // The first word of the default, where it is a value of the option.
      const std::size_t begin = at + std::string("(default: ").size();
      const std::string word =
          option.help.substr(begin, option.help.find_first_of(",) ", begin) - begin);
      const bool is_number = word.find_first_not_of("0123456789.") == word.npos;
      const bool is_choice =
          std::find(option.choices.begin(), option.choices.end(), word) != option.choices.end();
      const bool has_limits = answer(option, "x").find(" number from ") != std::string::npos;
      if ((is_number && has_limits) || is_choice) {
        EXPECT_EQ(answer(option, word), "is taken") << command << " " << option.name;
      }
    }
  });
}

TEST(OptionTable, wrong_values_are_refused_with_the_option_the_value_and_what_is_right) {
  const std::regex limits("(.*): '(.*)' is not a (whole )?number from (.*) to (.*)");
  for_each_table([&](const std::string& command, const Options& options) {
    for (const Option& option : options.table()) {
      if (option.most == 0 || option.positional()) continue;
      const std::string where = command + " " + option.name;
      for (const std::string value : {"x", "99999999999", "-1,-1", "0,0,0,-1", "0x0", ""}) {
        const std::string said = answer(option, value);
        if (said == "is taken") continue;
        EXPECT_TRUE(said.starts_with(option.name + ": ")) << where << ": " << said;
        // The message quotes the value, or the wrong part of a list.
        const std::string quoted = section_of(said, ": '", "' ");
        EXPECT_TRUE(value.empty() || !quoted.empty()) << where << ": " << said;
        if (!quoted.empty()) {
          EXPECT_NE(value.find(quoted.substr(3)), value.npos) << where << ": " << said;
        }
      }
      const std::string said = answer(option, "x");
      std::smatch found;
      if (!option.choices.empty() && said.find(" is none of ") != said.npos) {
        EXPECT_NE(said.find(joined(option.choices, ", ")), said.npos) << where << ": " << said;
      } else if (std::regex_match(said, found, limits) && found[2] == "x") {
        const double low = std::stod(found[4]), high = std::stod(found[5]);
        EXPECT_EQ(answer(option, found[4]), "is taken") << where;
        EXPECT_EQ(answer(option, found[5]), "is taken") << where;
        const double beyond = found[3].matched ? 1 : 1e-6 * (high - low);
        EXPECT_NE(answer(option, fmt::format("{}", low - beyond)), "is taken") << where;
        EXPECT_NE(answer(option, fmt::format("{}", high + beyond)), "is taken") << where;
      }
    }
  });
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
  EXPECT_EQ(parsed({"--antialiased", "on"}).settings.antialiased, true);
  EXPECT_EQ(parsed({"--antialiased", "off"}).settings.antialiased, false);
  EXPECT_EQ(parsed({"--antialiased", "auto"}).settings.antialiased, std::nullopt);
  EXPECT_EQ(parsed({"--tile-size", "8"}).settings.tile_px, 8);
  EXPECT_EQ(parsed({"--tile-size", "32"}).settings.tile_px, 32);
  EXPECT_EQ(parsed({"--pipeline", "classic"}).settings.pipeline, Pipeline::classic);
  EXPECT_EQ(parsed({"--backend", "cuda"}).backend, Backend::cuda);
  EXPECT_EQ(parsed({"--axes", "RUB"}).axes, "RUB");
  EXPECT_EQ(parsed({"--cull", "exact,adr,exact"}).modes,
            (std::vector<CullMode>{find_culler("exact"), find_culler("adr")}));
  EXPECT_EQ(parsed({}).settings.antialiased, std::nullopt);
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
