// SPDX-License-Identifier: MIT
//
// Files of edits: selections against an independent program, the round trip, and files that do not
// fit.
#include "io/edits/edits_file.h"

#include <fstream>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "io/bytes/base64.h"
#include "io/bytes/inflate.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "raster/scene/cloud_order.h"
#include "raster/select/by_shape.h"
#include "raster/select/editing.h"
#include "support/error_of.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class EditsFiles : public testing::Test {
 protected:
  EditsFile read(const std::string& text, const glm::dvec3& origin = glm::dvec3(0)) {
    std::ofstream(folder_ / "a.edits.json") << text;
    return read_edits(folder_ / "a.edits.json", origin);
  }
  /// The message without the file's name.
  std::string refused(const std::string& text) {
    const std::string message = error_of([&] { read(text); }, ErrorKind::input);
    const std::string name = (folder_ / "a.edits.json").string() + ": ";
    EXPECT_EQ(message.substr(0, name.size()), name);
    return message.substr(std::min(message.size(), name.size()));
  }
  std::string refused_step(const std::string& members) {
    return refused(R"({"version": 1, "steps": [{"step": "show"}, {)" + members + "}]}");
  }

  const TemporaryFolder folder_;
};

// The bundled scene as it is edited.
class Edited {
 public:
  std::string carry_out(const EditStep& step) {
    return qs::carry_out(step, tools_, "a: step 3", state_);
  }
  EditState& state() { return state_; }
  const GaussianCloud& cloud() const { return *cloud_; }
  EditTools& tools() { return tools_; }

 private:
  std::shared_ptr<const GaussianCloud> cloud_ = std::make_shared<const GaussianCloud>(
      read_scene(source_path("assets/plush.ply"), pool()).cloud);
  std::unique_ptr<Renderer> renderer_ = make_renderer(Backend::cpu, pool());
  EditTools tools_{*cloud_, pool(), seen_with(*renderer_, cloud_, pool()), set_hash};
  EditState state_{cloud_->size()};
};

// tests/golden/selections.py computed the counts and hashes; carry_out() refuses others.
TEST_F(EditsFiles, selections_are_those_of_an_independent_program) {
  EditsFile edits = read_edits(source_path("tests/golden/selections.edits.json"), glm::dvec3(0));
  EXPECT_THAT(edits.warnings, IsEmpty());
  ASSERT_EQ(edits.steps.size(), 14u);
  Edited scene;
  for (EditStep& step : edits.steps) {
    ASSERT_TRUE(step.select.count && !step.select.crc.empty());
    EXPECT_EQ(error_of([&] { scene.carry_out(step); }), "");
    EXPECT_EQ(scene.state().selected.count(), *step.select.count);
    SelectStep noted = step.select;
    note_result(scene.state(), set_hash, noted);
    EXPECT_EQ(noted.crc, step.select.crc);
    EXPECT_FALSE(noted.members);
  }
  // Another count or hash is an error, and a sentence if it is computed again.
  EditStep other = edits.steps[1];
  *other.select.count += 1;
  EXPECT_EQ(error_of([&] { scene.carry_out(other); }, ErrorKind::input),
            "a: step 3: it selects 1,511 in place of 1,512 Gaussians");
  other = edits.steps[1];
  other.select.crc = "crc32:00000000";
  EXPECT_EQ(error_of([&] { scene.carry_out(other); }, ErrorKind::input),
            "a: step 3: it selects 1,511 other Gaussians than it did");
  scene.tools().recomputes = true;
  EXPECT_EQ(scene.carry_out(other), "a: step 3: it selects 1,511 other Gaussians than it did");
}

// One step of each kind, and most tools.
std::string all_steps() {
  return read_text_file(source_path("tests/data/all_steps.edits.json"), 1 << 16);
}

const std::string kCamera =
    R"({"id":0,"img_name":"view","width":8,"height":6,"position":[0.0,0.0,-2.0],"rotation":[[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1.0]],"fy":9.0,"fx":9.0})";

TEST_F(EditsFiles, that_were_written_read_back_to_the_same_text) {
  const glm::dvec3 origin(100, 0, 0);
  const EditsFile edits = read(all_steps(), origin);
  EXPECT_THAT(edits.warnings, IsEmpty());
  ASSERT_EQ(edits.steps.size(), 19u);
  EXPECT_THAT(*edits.steps[0].select.members, ElementsAre(GaussianRun{0, 2}, GaussianRun{4, 1}));
  EXPECT_EQ(edits.steps[3].select.point, glm::dvec3(1, 2, 3));
  EXPECT_EQ(edits.steps[5].select.box.low, glm::vec3(-0.5f, 0, 0));
  EXPECT_EQ(edits.steps[17].rotation.w, 0.8);
  const std::string text = format_edits(edits, origin);
  EXPECT_EQ(format_edits(read(text, origin), origin), text);
  // The same members as in the file, but for the cameras.
  auto written = parse_own_json(text), given = parse_own_json(all_steps());
  for (auto* file : {&written, &given})
    for (auto& step : (*file)["steps"]) step.erase("camera");
  EXPECT_EQ(written, given);
}

TEST_F(EditsFiles, that_do_not_fit_are_refused_in_a_sentence) {
  const std::string camera = R"("camera": )" + kCamera;
  EXPECT_THAT(refused("{"), HasSubstr("not valid JSON"));
  EXPECT_EQ(refused("[1]"), "is not a file of edits: it has no object");
  EXPECT_EQ(refused("{}"), "is not a file of edits: it has no version or no steps");
  EXPECT_EQ(refused(R"({"version": 3, "steps": []})"), "version 3 is not readable, only 1 and 2");
  EXPECT_EQ(refused(R"({"version": 1, "steps": {}})"),
            "steps is not a list of at most 10,000 objects");
  EXPECT_EQ(refused(R"({"version": 1, "steps": [7]})"), "step 1: is not an object");
  EXPECT_EQ(refused(R"({"version": 1, "scene": 3, "steps": []})"), "scene is not an object");
  const std::pair<std::string, std::string> kWrong[] = {
      {R"("tool": "all")", "step is missing"},
      {R"("step": "jump")",
       "step is 'jump', which is none of select, hide, show, remove, keep, crop, floaters, scale, "
       "level"},
      {R"("step": "select")", "tool is missing"},
      {R"("step": "select", "tool": "wand")",
       "tool is 'wand', which is none of rectangle, polygon, lasso, brush, sphere, box, color, "
       "opacity, size, distance, list, flood, grow, shrink, invert, all, none"},
      {R"("step": "select", "tool": "rectangle")", "camera is missing"},
      {R"("step": "select", "tool": "rectangle", "pixels": [[1,2],[3,4]])", "camera is missing"},
      {R"("step": "select", "tool": "rectangle", "pixels": [[1,2]], )" + camera,
       "pixels is not a list of 2 to 2 points"},
      {R"("step": "select", "tool": "lasso", "pixels": [[1,2],[3,4]], )" + camera,
       "pixels is not a list of 3 to 4096 points"},
      {R"("step": "select", "tool": "rectangle", "pixels": [[1,2],[3,1e300]], )" + camera,
       "pixels are outside of any picture"},
      {R"("step": "select", "tool": "rectangle", "weight": 2, "pixels": [[1,2],[3,4]], )" + camera,
       "weight is 2, but must be within 0 and 1"},
      {R"("step": "select", "tool": "brush", "pixels": [[1,2]], )" + camera, "radius is missing"},
      {R"("step": "select", "tool": "brush", "radius": 0, "pixels": [[1,2]], )" + camera,
       "radius is 0, but must be within 1e-09 and 1000000000"},
      {R"("step": "select", "tool": "sphere", "radius": 1, "point": [1, 2])",
       "point is not a list of 3 numbers"},
      {R"("step": "select", "tool": "distance", "point": [1, 2, 3], "normal": [0, 0, 0])",
       "normal has no direction"},
      {R"("step": "select", "tool": "box", "box": [[0, 0, 0], [1, -1, 1]])",
       "box has a side below 0"},
      {R"("step": "select", "tool": "box", "box": [0, 0, 0, 1, 1, 1])",
       "box is not a list of 2 corners"},
      {R"("step": "select", "tool": "all", "members": [1])", "members is not a list of pairs"},
      {R"("step": "select", "tool": "all", "members": [1, -2])",
       "members is -2, but must be a whole number from 0 up"},
      {R"("step": "select", "tool": "all", "members": [5, 3, 7, 1])",
       "members 7 + 1 are no ascending run"},
      {R"("step": "select", "tool": "all", "members": [5, 0])",
       "members 5 + 0 are no ascending run"},
      {R"("step": "select", "tool": "all", "members": [0, 1000000000000])",
       "members 0 + 1000000000000 are no ascending run"},
      {R"("step": "select", "tool": "all", "bits": 7)", "bits is not a string"},
      {R"("step": "select", "tool": "all", "count": 1.5)",
       "count is 1.5, but must be a whole number from 0 up"},
      {R"("step": "scale", "factor": 0)", "factor is 0, but must be within 1e-09 and 1000000000"},
      {R"("step": "level", "rotation": [0, 0, 0, 0])", "rotation has no direction"},
  };
  for (const auto& [members, problem] : kWrong)
    EXPECT_EQ(refused_step(members), "step 2: " + problem);
  EXPECT_THAT(refused_step(R"("step": "select", "tool": "rectangle", "pixels": [[1,2],[3,4]],
                              "camera": {"fx": 0})"),
              HasSubstr("step 2: camera"));
  EXPECT_THAT(read(R"({"version": 1, "by": 1, "steps": [{"step": "hide", "radius": 2}]})").warnings,
              ElementsAre(HasSubstr("step 1: the member radius is not known"),
                          HasSubstr("a.edits.json: the member by is not known")));
}

// Gaussian i is in the list if has(i).
EditStep list_of(std::size_t size, const std::function<bool(std::size_t)>& has) {
  GaussianSet set(size);
  for (std::size_t i = 0; i < size; ++i)
    if (has(i)) set.add(i);
  return {.select = {.tool = SelectTool::list, .members = set.runs()}};
}

std::string packed_step(const std::string& packed) {
  return R"("step": "select", "tool": "list", "bits": "data:application/octet-stream;base64,)" +
         base64(packed) + "\"";
}
std::string bits_step(const std::string& content) { return packed_step(deflated(content, 6)); }

TEST_F(EditsFiles, long_lists_are_bits_and_read_back) {
  for (const std::size_t size : {2002u, 2003u, 524'288u, 524'289u, 1'048'576u, 3'000'000u}) {
    SCOPED_TRACE(size);
    std::minstd_rand random(7);
    const EditStep steps[] = {
        list_of(size, [](std::size_t i) { return i % 2 == 0; }),
        list_of(size, [](std::size_t i) { return i % 2 == 1; }),
        list_of(size, [&](std::size_t) { return random() % 10 < 3; }),
        list_of(size, [&](std::size_t i) { return i % 700 < 300 && (i < 9000 || i % 3 == 0); })};
    for (const EditStep& step : steps) {
      const std::string text = format_edits({{}, {step}}, glm::dvec3(0));
      const bool is_long = step.select.members->size() > 1000;
      EXPECT_EQ(text.find("\"bits\"") != std::string::npos, is_long);
      EXPECT_EQ(text.find("\"version\": 2") != std::string::npos, is_long);
      const EditsFile back = read(text, glm::dvec3(0));
      EXPECT_THAT(back.warnings, IsEmpty());
      EXPECT_EQ(*back.steps[0].select.members, *step.select.members);
      EXPECT_LT(text.size(), size / 5 + 20'000) << "a bit and a third for each Gaussian";
    }
  }
  // Another program wrote this one: python3 -c "import zlib, base64".
  const EditsFile other = read_edits(source_path("tests/data/long_list.edits.json"), glm::dvec3(0));
  const std::vector<GaussianRun>& runs = *other.steps[0].select.members;
  ASSERT_EQ(runs.size(), 200u);
  EXPECT_EQ(runs[0], (GaussianRun{0, 1}));
  EXPECT_EQ(runs[4], (GaussianRun{16, 11}));
  EXPECT_EQ(runs[199], (GaussianRun{32 * 39 + 16, 11}));
  // Few runs stay pairs that a person can read.
  EXPECT_THAT(
      format_edits({{}, {list_of(100, [](std::size_t i) { return i < 7; })}}, glm::dvec3(0)),
      AllOf(HasSubstr("\"members\":[0,7]"), HasSubstr("\"version\": 1")));
}

TEST_F(EditsFiles, damaged_bits_are_refused_in_a_sentence) {
  EXPECT_THAT(*read("{\"version\": 2, \"steps\": [{" + bits_step("\x05\x80") + "}]}", glm::dvec3(0))
                   .steps[0]
                   .select.members,
              ElementsAre(GaussianRun{0, 1}, GaussianRun{2, 1}, GaussianRun{15, 1}));
  const std::string good = bits_step(std::string(5000, 'a'));
  const std::size_t begin = good.find("base64,") + 7;
  EXPECT_THAT(refused_step(R"("step": "select", "tool": "list", "bits": "abc")"),
              HasSubstr("step 2: bits"));
  EXPECT_THAT(refused_step(good.substr(0, begin) + "!\""), HasSubstr("step 2: bits"));
  EXPECT_THAT(refused_step(good.substr(0, begin + 8) + "\""), HasSubstr("step 2: bits"));
  EXPECT_THAT(refused_step(packed_step("")), HasSubstr("step 2: bits"));
  std::string longer = good;
  longer.insert(longer.size() - 1, "AAAA");
  EXPECT_THAT(refused_step(longer), HasSubstr("step 2: bits"));
  // A small file cannot take all memory: 600 MB of zeros, and 20 million runs.
  std::string zeros;
  Deflater deflater(DeflateForm::deflate, 1, 8, [&](std::string_view part) { zeros += part; });
  for (int i = 0; i < 600; ++i) deflater.write(std::string(1'000'000, '\0'));
  deflater.finish();
  EXPECT_THAT(refused_step(packed_step(zeros)),
              HasSubstr("step 2: bits: the lists of the file are too large"));
  EXPECT_THAT(refused_step(bits_step(std::string(5'000'000, 'U'))),
              HasSubstr("step 2: bits: the lists of the file are too large"));
}

TEST_F(EditsFiles, lists_that_are_no_runs_of_the_scene_are_refused) {
  Edited scene;
  EditStep step;
  for (const std::vector<GaussianRun>& runs : {std::vector<GaussianRun>{{0, 34322}},
                                               {{34321, 1}},
                                               {{5, 3}, {7, 1}},
                                               {{5, 0}},
                                               {{9, 1}, {2, 1}},
                                               {{1, 1'000'000'000'000}}}) {
    step.select.members = runs;
    EXPECT_THAT(error_of([&] { scene.carry_out(step); }, ErrorKind::input),
                HasSubstr("are no ascending run of 34,321 Gaussians"));
  }
}

SelectStep rectangle_step(const Camera& camera, SelectKind kind) {
  SelectStep step;
  step.tool = SelectTool::rectangle;
  step.kind = kind;
  step.camera = camera;
  step.pixels = {{300, 250}, {500, 450}};
  return step;
}

TEST_F(EditsFiles, hidden_and_removed_gaussians_are_never_selected_nor_in_front) {
  Edited scene;
  const Camera camera =
      camera_of(nlohmann::ordered_json(parse_json(
                    read_text_file(source_path("assets/cameras.json"), 1 << 20), "cameras"))[0],
                "camera")
          .resized(800, 600);
  EditStep front;
  front.select = rectangle_step(camera, SelectKind::visible);
  scene.carry_out(front);
  const GaussianSet first = scene.state().selected;
  EXPECT_GT(first.count(), 300u);
  note_result(scene.state(), set_hash, front.select);
  ASSERT_TRUE(front.select.members);
  scene.carry_out({.kind = EditKind::hide});
  EXPECT_TRUE(scene.state().selected.empty());
  EXPECT_EQ(scene.state().hidden, first);
  // Now those behind are visible.
  front.select.members.reset();
  front.select.count.reset();
  front.select.crc.clear();
  scene.carry_out(front);
  const GaussianSet second = scene.state().selected;
  GaussianSet both = second;
  EXPECT_TRUE((both &= first).empty());
  EXPECT_GT(second.count(), 100u);
  // They are the visible Gaussians of the rest as a scene of its own.
  const std::vector<std::uint32_t> numbers = first.complement().numbers();
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(select(scene.cloud(), numbers), {});
  GaussianSet expected(first.size());
  seen_by(*renderer, select(scene.cloud(), numbers), camera, shape_of(front.select), kSelectWeight,
          pool(), {})
      .for_each([&](std::size_t i) { expected.add(numbers[i]); });
  EXPECT_EQ(second, expected);
  // Selecting all or inverting leaves the hidden ones out; showing does not select them.
  scene.carry_out({.kind = EditKind::remove});
  EXPECT_EQ(scene.state().removed, second);
  for (const SelectTool tool : {SelectTool::all, SelectTool::invert, SelectTool::invert}) {
    scene.carry_out({.select = {.tool = tool}});
    GaussianSet gone = scene.state().selected;
    EXPECT_TRUE((gone -= scene.state().rest()).empty());
  }
  EXPECT_EQ(scene.state().selected.count(), 34321 - first.count() - second.count());
  scene.carry_out({.kind = EditKind::show});
  EXPECT_TRUE(scene.state().hidden.empty());
  EXPECT_EQ(scene.state().rest(), second.complement());
}

TEST_F(EditsFiles, crops_and_floaters_are_searched_in_the_rest) {
  Edited scene;
  EditStep crop{.kind = EditKind::crop, .box = {glm::vec3(-2, 0, -1), glm::vec3(1, 3, 2)}};
  scene.carry_out(crop);
  const GaussianSet rest = scene.state().rest();
  for (std::size_t i = 0; i < rest.size(); ++i)
    ASSERT_EQ(rest[i], crop.box.contains(scene.cloud().positions[i]));
  const GaussianCloud left = select(scene.cloud(), rest.numbers());
  const Removal removal = find_removal(left, {}, Floaters());
  scene.carry_out({.kind = EditKind::floaters});
  EXPECT_EQ(scene.state().rest().count(), removal.staying());
  EXPECT_LT(removal.staying(), left.size());
}

}  // namespace
}  // namespace qs::test
