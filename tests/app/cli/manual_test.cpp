// SPDX-License-Identifier: MIT
//
// The manual page, the completion of bash, suggestions for mistyped words, and the order of the
// help.

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "options/suggestion.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Suggestion, is_the_nearest_word_within_two_edits) {
  const std::vector<std::string> words = {"render", "report",   "train",
                                          "zoom",   "--output", "--size"};
  EXPECT_EQ(suggestion("rendr", words), "; did you mean 'render'?");    // missing
  EXPECT_EQ(suggestion("rendder", words), "; did you mean 'render'?");  // extra
  EXPECT_EQ(suggestion("rander", words), "; did you mean 'render'?");   // wrong
  EXPECT_EQ(suggestion("redner", words), "; did you mean 'render'?");   // exchanged
  EXPECT_EQ(suggestion("--ouptupt", words), "; did you mean '--output'?");
  EXPECT_EQ(suggestion("zom", words), "; did you mean 'zoom'?");
  EXPECT_EQ(suggestion("zo", words), "");  // too short for an error
  EXPECT_EQ(suggestion("garden", words), "");
  EXPECT_EQ(suggestion("", words), "");
}

TEST(Suggestion, is_part_of_the_sentence_about_a_wrong_word) {
  const auto said = [](std::vector<std::string> words) {
    return error_of([&] { run_program(words); }, ErrorKind::usage);
  };
  EXPECT_EQ(said({"rendr", "x.ply", "--output", "x.png"}),
            "'rendr' is neither a command nor a file; did you mean 'render'?");
  EXPECT_THAT(said({"render", "x.ply", "--ouptut", "x.png"}),
              HasSubstr("render: unknown option '--ouptut'; did you mean '--output'? (see"));
  EXPECT_THAT(said({"render", "x.ply", "--bakend=cpu"}), HasSubstr("did you mean '--backend'?"));
  EXPECT_THAT(said({"render", "x.ply", "--nothing-like-it"}), Not(HasSubstr("did you mean")));
}

TEST(Help, has_the_command_s_own_options_first_and_the_common_ones_last) {
  Options options("render", "");
  const auto render = std::find_if(commands().begin(), commands().end(), [](const Command& row) {
    return row.name == std::string("render");
  });
  const CommandAction action = render->declare(options);
  const std::string help = options.help();
  const auto at = [&](const char* text) {
    EXPECT_NE(help.find(text), std::string::npos) << text;
    return help.find(text);
  };
  EXPECT_LT(at("  -o, --output FILE"), at("  --shard"));
  EXPECT_LT(at("  --shard"), at("\nscene and rendering:\n"));
  EXPECT_LT(at("\nscene and rendering:\n"), at("  --cull"));
  EXPECT_LT(at("  --antialiased"), at("\nexamples:\n"));
}

TEST(Help, o_is_the_short_form_of_output_everywhere) {
  for (const Command& command : commands()) {
    Options options(command.name, command.summary);
    const CommandAction action = command.declare(options);
    for (const Option& option : options.table())
      EXPECT_EQ(option.short_name(), option.name == "--output" ? "-o" : "") << command.name;
  }
  std::string output;
  Options options("try", "");
  options.text("--output", "FILE", output, "", {});
  EXPECT_TRUE(options.parse(std::vector<std::string>{"-o", "a.png"}));
  EXPECT_EQ(output, "a.png");
  EXPECT_TRUE(options.parse(std::vector<std::string>{"--output", "b.png"}));
  EXPECT_EQ(output, "b.png");
}

TEST(ManPage, describes_every_command_with_every_option) {
  const std::string page = man_page();
  const std::vector<std::string> lines = lines_of(page);
  const auto in_roff = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('-', at)) != text.npos; at += 2) text.insert(at, "\\");
    return text;
  };
  EXPECT_THAT(lines, Contains(".SH NAME"));
  EXPECT_THAT(lines, Contains("quadsplat \\- viewer and laboratory for 3D Gaussian Splatting"));
  for (const Command& command : commands()) {
    Options options(command.name, command.summary);
    const CommandAction action = command.declare(options);
    EXPECT_THAT(page, HasSubstr(fmt::format("\n.SS quadsplat {} ", command.name)));
    for (const Option& option : options.table())
      EXPECT_THAT(lines, Contains(".B " + in_roff(option.shown()))) << command.name;
    for (const auto& example : options.examples())
      EXPECT_THAT(lines, Contains(".B " + in_roff(example.command_line)));
  }
  for (const std::string& line : lines) {
    EXPECT_FALSE(line.empty());
    if (!line.starts_with('.')) continue;
    EXPECT_TRUE(line.starts_with(".TH ") || line.starts_with(".SH ") || line.starts_with(".SS ") ||
                line == ".TP" || line == ".br" || line.starts_with(".B "))
        << line;
  }
}

// The completions of bash after these words, the last of which is incomplete.
std::vector<std::string> completed(const std::string& words) {
  const TemporaryFolder folder;
  std::ofstream(folder / "completion") << bash_completion();
  std::ofstream(folder / "scene.ply") << "";
  const std::string line = fmt::format(
      "cd {0} && bash -c 'source ./completion; COMP_WORDS=(quadsplat {1}); "
      "COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _quadsplat; printf \"%s\\n\" "
      "\"${{COMPREPLY[@]}}\"' "
      "> out",
      folder.path().string(), words);
  EXPECT_EQ(std::system(line.c_str()), 0) << line;
  std::vector<std::string> found = lines_of(read_text_file(folder / "out", 1 << 20));
  std::erase(found, "");
  return found;
}

TEST(Completion, offers_commands_options_values_and_files) {
  EXPECT_THAT(completed("ren"), ElementsAre("render"));
  EXPECT_THAT(completed("\"\""), Contains("film"));
  EXPECT_THAT(completed("render sc"), ElementsAre("scene.ply"));
  EXPECT_THAT(completed("render scene.ply --back"), ElementsAre("--backend", "--background"));
  EXPECT_THAT(completed("render scene.ply --backend c"), ElementsAre("cpu", "cuda"));
  EXPECT_THAT(completed("render scene.ply --cull quad"), ElementsAre("quadbox-naive", "quadbox"));
  EXPECT_THAT(completed("render scene.ply --nothing"), IsEmpty());
  EXPECT_THAT(completed("film scene.ply --ea"), ElementsAre("--ease"));
  EXPECT_THAT(completed("film scene.ply --ease a"), ElementsAre("all"));
  EXPECT_THAT(completed("--ver"), ElementsAre("--version"));
  EXPECT_THAT(completed("scene.ply --besi"), ElementsAre("--beside"));  // the command is view
  EXPECT_THAT(completed("convert scene.ply --keep"), ElementsAre("--keep-largest"));
}

TEST(Manual, the_program_prints_both) {
  EXPECT_EQ(test::run_quadsplat({"--man-page"}).out, man_page());
  EXPECT_EQ(test::run_quadsplat({"--bash-completion"}).out, bash_completion());
}

}  // namespace
}  // namespace qs
