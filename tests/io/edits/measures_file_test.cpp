// SPDX-License-Identifier: MIT
//
// Files of measures: the round trip, files by hand, and files that do not fit.
#include "io/edits/measures_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/bytes/json_text.h"
#include "support/error_of.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

MeasuresFile parsed(const std::string& text, glm::dvec3 origin = glm::dvec3(0)) {
  return parse_measures(text, "a", origin);
}

std::string refused(const std::string& text) {
  return error_of([&] { parsed(text); }, ErrorKind::input);
}

std::string refused_point(const std::string& members) {
  return refused(R"({"version": 1, "lines": [[], [{"position": [1, 2, 3]}, )" + members + "]]}");
}

TEST(MeasuresFiles, that_were_written_read_back_to_the_same_measures) {
  MeasuresFile file{{"a.ply", "crc32:12345678", 7, 5, "RDF"}, {}};
  const SurfacePoint a{{1, 2, 3}, {0, 0, 1}, 3, 0.1, 0.02}, b{{4, 5, 6}, {0.6, 0, 0.8}, 9, 0, 0.5};
  file.measures = {{{a, b}, {b}}, {0.25, 0.01, "cm"}, GroundPlane{{0, 1, 0}, {0, -1, 0}}};
  const glm::dvec3 origin(512, 0, -64);
  const std::string text = format_measures(file, origin);
  EXPECT_THAT(text, HasSubstr(R"("position":[513.0,2.0,-61.0])"));
  const MeasuresFile read = parsed(text, origin);
  EXPECT_EQ(read.measures, file.measures);
  EXPECT_EQ(read.scene.hash, "crc32:12345678");
  EXPECT_EQ(read.scene.gaussians, 5u);
  EXPECT_THAT(read.warnings, SizeIs(0));
  EXPECT_EQ(format_measures(read, origin), text);
  // Empty lines are left out; nothing at all is a file too.
  file.measures.lines = {{}, {a, b}, {}, {b}, {}};
  EXPECT_EQ(format_measures(file, origin), text);
  EXPECT_EQ(parsed(format_measures({}, origin), origin).measures, Measures());
}

TEST(MeasuresFiles, by_hand_have_exact_points_and_warnings) {
  const MeasuresFile file = parsed(R"({"version": 1, "by": 1, "scale": {"factor": 2, "why": 0},
                 "lines": [[{"position": [1, 2, 3], "name": "door"}]]})");
  ASSERT_THAT(file.measures.lines, SizeIs(1));
  EXPECT_EQ(file.measures.lines[0][0], (SurfacePoint{.position = {1, 2, 3}}));
  EXPECT_EQ(file.measures.scale, MeasureScale{2});
  EXPECT_FALSE(file.measures.ground);
  EXPECT_THAT(file.warnings, ElementsAre("a: scale: the member why is not known",
                                         "a: point 1: the member name is not known",
                                         "a: the member by is not known"));
}

TEST(MeasuresFiles, that_do_not_fit_are_refused_in_a_sentence) {
  EXPECT_THAT(refused("{"), HasSubstr("not valid JSON"));
  EXPECT_EQ(refused("[1]"), "a: is not a file of measures: it has no object");
  EXPECT_EQ(refused(R"({"version": 1, "steps": []})"),
            "a: is not a file of measures: it has no version or no lines");
  EXPECT_EQ(refused(R"({"version": 2, "lines": []})"), "a: version 2 is not readable, only 1");
  EXPECT_EQ(refused(R"({"version": 1, "lines": {}})"), "a: lines: is not a list");
  EXPECT_EQ(refused(R"({"version": 1, "lines": [7]})"), "a: line 1: is not a list");
  EXPECT_EQ(refused(R"({"version": 1, "lines": [[7]]})"), "a: point 1: is not an object");
  const std::pair<const char*, const char*> kWrong[] = {
      {"{}", "position is missing"},
      {R"({"position": [1, 2]})", "position is not a list of 3 numbers"},
      {R"({"position": [1e308, 2, 3]})", "position is farther than 1e+15 from the scene"},
      {R"({"position": [1, 2, 3], "direction": [0, 0, 2]})", "direction is not of length 1"},
      {R"({"position": [1, 2, 3], "direction": [1e300, 0, 0]})", "direction is not of length 1"},
      {R"({"position": [1, 2, 3], "along": -1})",
       "along is -1, but must be within 0 and 1000000000000000"}};
  for (const auto& [point, problem] : kWrong)
    EXPECT_EQ(refused_point(point), std::string("a: point 2: ") + problem);
  const std::pair<const char*, const char*> kWrongParts[] = {
      {R"("scale": 3)", "a: scale is not an object"},
      {R"("scale": {})", "a: scale: factor is missing"},
      {R"("scale": {"factor": 0})",
       "a: scale: factor is 0, but must be within 1e-09 and 1000000000"},
      {R"("scale": {"factor": 1, "unit": "mile"})",
       "a: scale: unit is 'mile', which is none of m, cm, mm, ft, in"},
      {R"("ground": {"point": [0, 0, 0]})", "a: ground: up is missing"},
      {R"("ground": {"point": [0, 0, 0], "up": [0, 0, 0]})", "a: ground: up is not of length 1"}};
  for (const auto& [part, problem] : kWrongParts)
    EXPECT_EQ(refused(R"({"version": 1, "lines": [], )" + std::string(part) + "}"), problem);
  std::string many = R"({"version": 1, "lines": [[{"position": [1, 2, 3]})";
  for (std::size_t i = 0; i < kMaxMeasuredPoints; ++i) many += R"(,{"position": [1, 2, 3]})";
  EXPECT_EQ(refused(many + "]]}"), "a: there are more than 10,000 points");
}

}  // namespace
}  // namespace qs::test
