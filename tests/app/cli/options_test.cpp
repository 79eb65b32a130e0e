// SPDX-License-Identifier: MIT
#include "app/cli/options.h"

#include <functional>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "base/error.h"

namespace qs {
namespace {

using testing::HasSubstr;

std::string usage_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    return error.what();
  }
  return "no error";
}

struct Values {
  std::filesystem::path in, out;
  bool json = false;
  std::optional<int> count;
  float scale = 1;
  int chosen = -1;

  Options options() {
    Options o("try", "tries");
    o.positional("IN", in, "in", {"a"});
    o.positional("OUT", out, "out", {"b"});
    o.flag("--json", json, "json");
    o.integer("--count", "N", 0, 10, count, "count");
    o.real("--scale", "X", 0, 5, scale, "scale");
    o.choice(
        "--mode", {"a", "b"}, [this](int i) { chosen = i; }, "mode");
    return o;
  }
  bool parse(const std::vector<std::string>& arguments) { return options().parse(arguments); }
};

TEST(Options, fill_their_variables_in_any_order) {
  Values v;
  EXPECT_TRUE(v.parse({"--count", "7", "x.ply", "--scale=2.5", "--mode", "b", "--json", "y.ply"}));
  EXPECT_EQ(v.in, "x.ply");
  EXPECT_EQ(v.out, "y.ply");
  EXPECT_TRUE(v.json);
  EXPECT_EQ(v.count, 7);
  EXPECT_EQ(v.scale, 2.5f);
  EXPECT_EQ(v.chosen, 1);
}

// A person who learned an option with one command knows it for all.
TEST(Options, of_one_name_mean_one_thing_in_all_commands) {
  std::map<std::string, std::pair<std::string, std::string>> placeholders;
  for (const Command& command : commands()) {
    Options options(command.name, command.summary);
    command.declare(options);
    for (const Option& option : options.table()) {
      if (option.positional()) continue;
      const std::string values = option.choices.empty() ? option.placeholder : "a name";
      const auto [known, added] = placeholders.try_emplace(
          option.name, fmt::format("{} {}", option.most, values), command.name);
      EXPECT_EQ(known->second.first, fmt::format("{} {}", option.most, values))
          << option.name << " of " << command.name << " and " << known->second.second;
    }
  }
}

TEST(Options, mistyped_names_and_values_get_a_suggestion) {
  const auto sentence = [](const std::vector<std::string>& words) {
    return usage_error([&] { run_program(words); });
  };
  EXPECT_THAT(sentence({"--verison"}), HasSubstr("did you mean '--version'?"));
  EXPECT_THAT(sentence({"--list-gpu"}), HasSubstr("did you mean '--list-gpus'?"));
  EXPECT_THAT(sentence({"info", "a.ply", "--jsom"}), HasSubstr("did you mean '--json'?"));
  EXPECT_THAT(sentence({"render", "a.ply", "--cull", "quadboxx"}),
              HasSubstr("did you mean 'quadbox'?"));
  EXPECT_THAT(sentence({"render", "a.ply", "--pipeline", "clasic"}),
              HasSubstr("did you mean 'classic'?"));
  EXPECT_THAT(sentence({"bench", "a.ply", "--baseline", "quadbo"}),
              HasSubstr("did you mean 'quadbox'?"));
  EXPECT_THAT(sentence({"compare", "a.ply", "--against", "exactt"}),
              HasSubstr("did you mean 'exact'?"));
  EXPECT_THAT(sentence({"--threads", "2", "bench", "a.ply"}),
              HasSubstr("the command comes before its options: 'quadsplat bench --threads ...'"));
}

TEST(Options, that_are_not_given_keep_their_variables) {
  Values v;
  v.parse({"x", "y"});
  EXPECT_FALSE(v.json);
  EXPECT_EQ(v.count, std::nullopt);
  EXPECT_EQ(v.scale, 1.0f);
}

TEST(Options, given_twice_take_the_last_value) {
  Values v;
  v.parse({"x", "y", "--count", "1", "--count", "2"});
  EXPECT_EQ(v.count, 2);
}

TEST(Options, name_what_is_wrong) {
  const auto message = [](const std::vector<std::string>& arguments) {
    return usage_error([&] { Values().parse(arguments); });
  };
  EXPECT_THAT(message({"x", "y", "--bogus", "5"}), HasSubstr("try: unknown option '--bogus'"));
  EXPECT_THAT(message({"x", "y", "-z"}), HasSubstr("unknown option '-z'"));
  EXPECT_THAT(message({"x"}), HasSubstr("try: OUT is required (see 'quadsplat try --help')"));
  EXPECT_THAT(message({"x", "y", "z"}), HasSubstr("unexpected argument 'z'"));
  EXPECT_THAT(message({"x", "y", "--count"}), HasSubstr("try: --count needs a value"));
  EXPECT_THAT(message({"x", "y", "--json=maybe"}), HasSubstr("--json"));
  EXPECT_THAT(message({"x", "y", "--count", "11"}),
              HasSubstr("--count: '11' is not a whole number from 0 to 10"));
  EXPECT_THAT(message({"x", "y", "--count", "3x"}), HasSubstr("'3x'"));
  EXPECT_THAT(message({"x", "y", "--scale", "nan"}),
              HasSubstr("--scale: 'nan' is not a number from 0 to 5"));
  EXPECT_THAT(message({"x", "y", "--mode", "c"}), HasSubstr("--mode: 'c' is none of a, b"));
}

TEST(Options, that_are_required_must_be_given) {
  std::filesystem::path folder;
  Options options("try", "tries");
  options.text("--images", "DIR", folder, "pictures", {"images"});
  options.required();
  EXPECT_THAT(usage_error([&] { options.parse({}); }), HasSubstr("try: --images is required"));
  const std::vector<std::string> words = {"--images", "a"};
  EXPECT_TRUE(options.parse(words));
  EXPECT_EQ(folder, "a");
}

TEST(Options, positionals_take_the_rest) {
  std::vector<std::filesystem::path> files;
  bool as_json = false;
  Options options("try", "tries");
  options.positionals("FILE", files, 1, "files", {"a"});
  options.flag("--json", as_json, "json");
  EXPECT_THAT(usage_error([&] { options.parse({}); }), HasSubstr("FILE is required"));
  const std::vector<std::string> words = {"a", "--json", "b", "--", "--c"};
  EXPECT_TRUE(options.parse(words));
  EXPECT_THAT(files, testing::ElementsAre("a", "b", "--c"));
  EXPECT_TRUE(as_json);
}

TEST(Options, flags_can_be_switched_off_by_value) {
  Values v;
  v.parse({"x", "y", "--json=false"});
  EXPECT_FALSE(v.json);
}

TEST(Options, help_is_printed_although_words_are_missing) {
  testing::internal::CaptureStdout();
  EXPECT_FALSE(Values().parse({"--help"}));
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("usage: quadsplat try IN OUT"));
}

TEST(Options, help_shows_every_option_and_example) {
  Values v;
  Options options = v.options();
  options.example("quadsplat try x y", "tries it");
  for (const char* part :
       {"IN OUT", "--json", "--count N", "--mode a|b", "quadsplat try x y", "tries it"}) {
    EXPECT_THAT(options.help(), HasSubstr(part));
  }
}

TEST(Text, sizes_and_colors_are_strict) {
  EXPECT_EQ(parse_size("--size", "640x480"), glm::ivec2(640, 480));
  EXPECT_EQ(parse_color("--background", "0,0.5,1"), glm::vec3(0, 0.5f, 1));
  for (const char* bad :
       {"", "640", "640x", "x480", "0x5", "5x-1", "5x5x5", "99999x5", " 5x5", "5.0x5"}) {
    EXPECT_THROW(parse_size("--size", bad), Error) << bad;
  }
  for (const char* bad : {"", "0,0", "0,0,0,0", "0,0,2", "0,0,-1", "a,b,c", "0,,0", "0,0,nan"}) {
    EXPECT_THROW(parse_color("--background", bad), Error) << bad;
  }
}

TEST(Text, bounds_are_inclusive) {
  EXPECT_EQ(parse_integer("-n", "-3", -3, 5), -3);
  EXPECT_EQ(parse_integer("-n", "5", -3, 5), 5);
  EXPECT_THROW(parse_integer("-n", "-4", -3, 5), Error);
  EXPECT_EQ(parse_real("-x", "0.5", 0.5, 1), 0.5);
  EXPECT_EQ(parse_real("-x", "1", 0.5, 1), 1);
  EXPECT_THROW(parse_real("-x", "0.4999", 0.5, 1), Error);
  EXPECT_EQ(parse_size("-s", "32768x1"), glm::ivec2(32768, 1));
  EXPECT_THROW(parse_size("-s", "32769x1"), Error);
}

TEST(Text, cells_with_separators_are_quoted) {
  EXPECT_EQ(csv_field("plain"), "plain");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
  EXPECT_THAT(separated("a,,b"), testing::ElementsAre("a", "", "b"));
  EXPECT_THAT(separated(""), testing::ElementsAre(""));
  EXPECT_EQ(joined(separated("a,b,c"), " + "), "a + b + c");
}

TEST(Text, numbers_are_grouped_for_people) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(18446744073709551615u), "18,446,744,073,709,551,615");
  EXPECT_EQ(bytes_text(18039653), "18.0 MB");
  EXPECT_EQ(bytes_text(12), "12 bytes");
  EXPECT_EQ(bytes_text(999), "999 bytes");
  EXPECT_EQ(bytes_text(1000), "1.0 kB");
  EXPECT_EQ(bytes_text(999'949), "999.9 kB");
  EXPECT_EQ(bytes_text(999'950), "1.0 MB");
  EXPECT_EQ(bytes_text(2'500'000'000'000), "2.5 TB");
  EXPECT_EQ(decibels(40.126), "40.13");
  EXPECT_EQ(decibels(std::numeric_limits<double>::infinity()), "inf");
}

}  // namespace
}  // namespace qs
