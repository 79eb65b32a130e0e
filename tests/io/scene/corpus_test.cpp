// SPDX-License-Identifier: MIT
//
// Every file of the corpora, valid or broken, has the outcome listed for it.
#include "support/corpus.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/scene/reader.h"
#include "io/support/limits.h"
#include "raster/kernel/constants.h"
#include "support/error_of.h"
#include "support/oracle.h"
#include "support/scene_files.h"
#include "support/shared.h"

namespace qs::test {
namespace {

using nlohmann::json;

glm::dvec3 vector(const json& value) { return {value[0], value[1], value[2]}; }

// Listed values have six digits.
void expect_near(const glm::dvec3& value, const glm::dvec3& expected, const char* what) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(value[axis], expected[axis], 1e-5 * (1 + std::abs(expected[axis])))
        << what << " " << axis;
  }
}

// The listed values are in the frame of the file.
glm::dvec3 turn_of(const CorpusFile& file) {
  const auto frame = file.expected.at("frame").get<std::string>();
  if (frame == "RUB" || frame == "RDF (unmarked)") return {1, -1, -1};  // both are taken as RUB
  if (frame.find("glTF") != frame.npos) return {-1, -1, 1};
  return glm::dvec3(1);
}

void expect_sample(const GaussianCloud& cloud, const json& sample, const glm::dvec3& turn) {
  const auto i = sample.at("i").get<std::size_t>();
  SCOPED_TRACE("sample " + std::to_string(i));
  ASSERT_LT(i, cloud.size());
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const glm::vec3* const sh = &cloud.sh[i * coefficients];
  expect_near(cloud.origin + glm::dvec3(cloud.positions[i]), vector(sample.at("pos")) * turn,
              "position");
  EXPECT_NEAR(1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logits[i]))),
              sample.at("alpha").get<double>(), 1e-5);
  expect_near(0.5 + kSh0 * glm::dvec3(sh[0]), vector(sample.at("rgb_dc")), "colour");

  const glm::dvec3 scale = vector(sample.at("scale"));
  expect_near(glm::exp(glm::dvec3(cloud.log_scales[i])), scale, "scale");
  const json& q = sample.at("quat_wxyz");
  const glm::dmat3 flip(turn.x, 0, 0, 0, turn.y, 0, 0, 0, turn.z);
  const glm::dmat3 expected =
      flip *
      covariance(glm::normalize(glm::dquat(q[0].get<double>(), q[1].get<double>(),
                                           q[2].get<double>(), q[3].get<double>())),
                 scale) *
      flip;
  const glm::dmat3 actual = covariance(cloud, i);
  const double largest = std::max({scale.x, scale.y, scale.z});
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(actual[column][row], expected[column][row], 2e-5 * largest * largest);
    }
  }
  // Y_1^-1 is odd in y; the last function of odd degrees is odd in x.
  if (cloud.sh_degree == 0) return;
  expect_near(sh[1], vector(sample.at("sh_first")) * turn.y, "first SH coefficient");
  expect_near(sh[coefficients - 1],
              vector(sample.at("sh_last")) * (cloud.sh_degree % 2 != 0 ? turn.x : 1.0),
              "last SH coefficient");
}

void expect_as_listed(const Scene& scene, const CorpusFile& file) {
  const GaussianCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), file.expected.at("n").get<std::size_t>());
  EXPECT_EQ(cloud.sh_degree, file.expected.at("sh_degree").get<int>());
  if (std::filesystem::is_regular_file(file.path)) {
    EXPECT_GE(scene.file_bytes, std::filesystem::file_size(file.path));
  }
  if (!file.expected.contains("samples")) return;

  const glm::dvec3 turn = turn_of(file);
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low, color(0);
  double alpha = 0;
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    low = glm::min(low, cloud.origin + glm::dvec3(cloud.positions[i]));
    high = glm::max(high, cloud.origin + glm::dvec3(cloud.positions[i]));
    alpha += 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logits[i])));
    color += 0.5 + kSh0 * glm::dvec3(cloud.sh[i * coefficients]);
  }
  const auto count = static_cast<double>(cloud.size());
  const glm::dvec3 a = vector(file.expected.at("bbox_min")) * turn;
  const glm::dvec3 b = vector(file.expected.at("bbox_max")) * turn;
  expect_near(low, glm::min(a, b), "lowest position");
  expect_near(high, glm::max(a, b), "highest position");
  EXPECT_NEAR(alpha / count, file.expected.at("mean_alpha").get<double>(), 1e-5);
  expect_near(color / count, vector(file.expected.at("mean_rgb")), "mean colour");
  for (const json& sample : file.expected.at("samples")) expect_sample(cloud, sample, turn);
}

void expect_valid_files_read_as_listed(const std::filesystem::path& corpus) {
  int read = 0;
  for (const CorpusFile& file : corpus_files(corpus)) {
    if (!file.valid()) continue;
    SCOPED_TRACE(file.name);
    try {
      expect_as_listed(read_scene(file.path), file);
    } catch (const Error& error) {
      ADD_FAILURE() << error.what();
    }
    ++read;
  }
  EXPECT_GT(read, 10);
}

// The list calls its type float16 unknown, which readers of half precision know.
constexpr const char* kWithHalves = "ply_property_unknown_type.ply";

// Checks `expect` of expected.json: "REJECT ...", "ACCEPT ...", "EITHER ..." or "A or B". Returns
// the bytes of the scene, 0 if it was refused.
std::size_t expect_listed_outcome(const CorpusFile& file) {
  std::size_t decoded = 0;
  const auto expect = file.expected.at("expect").get<std::string>();
  const bool either = expect.starts_with("EITHER");
  const bool may_reject = either || expect.find("REJECT") != std::string::npos;
  const bool may_accept = !expect.starts_with("REJECT") ||
                          expect.find("or ACCEPT") != expect.npos || file.name == kWithHalves ||
                          expect.find("or DC only") != expect.npos ||
                          expect.find("or use one") != expect.npos;
  const bool must_warn = expect.starts_with("ACCEPT-WARN");
  try {
    const Scene scene = read_scene(file.path);
    decoded = bytes_of(scene.cloud);
    EXPECT_TRUE(may_accept) << expect;
    EXPECT_TRUE(!must_warn || !scene.warnings.empty()) << expect;
    if (!file.expected.at("n").is_null()) {
      EXPECT_EQ(scene.cloud.size(), file.expected.at("n").get<std::size_t>());
    }
    for (const std::string& warning : scene.warnings)
      EXPECT_TRUE(warning.ends_with(".")) << warning;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_TRUE(may_reject) << expect << " but " << message;
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_TRUE(message.starts_with(file.path.string() + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  return decoded;
}

void expect_broken_files_have_listed_outcomes(const std::filesystem::path& corpus) {
  int read = 0;
  for (const CorpusFile& file : corpus_files(corpus)) {
    if (file.valid()) continue;
    SCOPED_TRACE(file.name);
    expect_within_limits([&] { return expect_listed_outcome(file); });
    ++read;
  }
  EXPECT_GT(read, 50);
}

TEST(Corpus, valid_files_read_as_listed) { expect_valid_files_read_as_listed(committed_corpus()); }

TEST(Corpus, broken_files_have_their_listed_outcomes) {
  expect_broken_files_have_listed_outcomes(committed_corpus());
}

// The outcome of a file, without its folder and without messages of libraries.
json outcome_of(const CorpusFile& file) {
  const auto plain = [&](const std::string& message) {
    std::string text = without_folder(message, file.path.parent_path());
    if (const std::size_t open = text.find(" ("); open != text.npos && text.ends_with(")"))
      text.erase(open);
    constexpr std::string_view kOfLibrary = "not valid glTF";
    if (const std::size_t at = text.find(kOfLibrary); at != text.npos)
      text.erase(at + kOfLibrary.size());
    return text;
  };
  try {
    const Scene scene = read_scene(file.path);
    json outcome = {{"format", scene.format}, {"axes", scene.axes}, {"bytes", scene.file_bytes}};
    if (!scene.vertical_axis.empty()) outcome["vertical_axis"] = scene.vertical_axis;
    if (scene.cloud.antialiased) outcome["antialiased"] = true;
    for (const std::string& warning : scene.warnings) outcome["warnings"].push_back(plain(warning));
    return outcome;
  } catch (const Error& error) {
    return plain(error.what());
  }
}

TEST(Corpus, every_file_gives_exactly_the_listed_sentences) {
  std::ifstream stream(source_path("tests/data/corpus_sentences.json"));
  const json listed = json::parse(stream);
  json found;
  for (const CorpusFile& file : corpus_files(committed_corpus()))
    found[file.name] = outcome_of(file);
  ASSERT_EQ(found.size(), listed.size());
  for (const auto& [name, outcome] : found.items())
    EXPECT_EQ(outcome, listed.value(name, json())) << name;
}

TEST(Corpus, valid_files_of_the_shared_corpus_read_as_listed) {
  QS_NEEDS_SHARED("corpus/expected.json");
  expect_valid_files_read_as_listed(shared_path("corpus"));
}

TEST(Corpus, broken_files_of_the_shared_corpus_have_their_listed_outcomes) {
  QS_NEEDS_SHARED("corpus/expected.json");
  expect_broken_files_have_listed_outcomes(shared_path("corpus"));
}

TEST(Corpus, every_reader_reads_a_committed_file) {
  for (const ReaderRow& reader : readers()) {
    int read = 0;
    for (const CorpusFile& file : corpus_files(committed_corpus())) {
      if (!file.valid()) continue;
      read += read_scene(file.path).format.starts_with(reader.name) ? 1 : 0;
    }
    EXPECT_GT(read, 0) << reader.name;
  }
}

TEST(Corpus, exactly_one_reader_recognises_each_valid_file) {
  for (const CorpusFile& file : corpus_files(committed_corpus())) {
    if (!file.valid()) continue;
    if (!std::filesystem::is_regular_file(file.path)) continue;
    const auto bytes = file_bytes(file.path);
    int recognised = 0;
    for (const ReaderRow& reader : readers()) {
      recognised += reader.recognises(bytes, "a file" + file.path.extension().string()) ? 1 : 0;
    }
    EXPECT_EQ(recognised, 1) << file.name;
  }
}

}  // namespace
}  // namespace qs::test
