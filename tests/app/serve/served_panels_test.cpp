// SPDX-License-Identifier: MIT
//
// The page's panels as visitors use them: table, split, inspector, recorder, crop, settings, path
// and film, with the renderer that all share; and the sections that are sent for them.
#include <algorithm>
#include <limits>
#include <thread>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/film/film.h"
#include "app/serve/pictures.h"
#include "app/serve/served_room.h"
#include "app/serve/state_json.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/mode_table.h"
#include "base/text.h"

namespace qs {
namespace {

using Json = nlohmann::json;
using test::ServedRoom;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

constexpr const char* kTable = "FPS of all modes";
constexpr const char* kInspector = "Inspector: boxes of a Gaussian";
constexpr const char* kSplit = "Split: beside another mode or scene";
constexpr const char* kSettings = "Scene and render settings";
constexpr const char* kCrop = "Crop and clean";
constexpr const char* kPath = "Cameras and path";
constexpr const char* kRecorder = "Zoom recorder";

Json section(const Visitor& visitor, const char* name) { return panel_sections(visitor).at(name); }

std::string text_in(const Visitor& visitor, const char* name) {
  return section(visitor, name).at("text");
}

bool is_measured(ServedRoom& room, int number = 1) {
  return numbers_are_current(room.viewer(number)) && !room.viewer(number).numbers.rows.empty();
}

void click(ServedRoom& room, glm::dvec2 at) {
  room.take(message::Button{0, true, at});
  room.take(message::Button{0, false, at});
}

// ---- whose table is measured
// -------------------------------------------------------------------
MeasuringTurns::Turn turn_of(int visitor, int version = 1) {
  MeasuringTurns::Turn turn;
  turn.visitor = visitor;
  turn.request.version = version;
  return turn;
}

TEST(ServeMeasuringTurns, the_visitor_who_was_measured_least_is_next) {
  MeasuringTurns turns;
  EXPECT_FALSE(turns.next());
  std::vector<int> order;
  for (int i = 0; i < 4; ++i) {
    turns.want(turn_of(1));
    turns.want(turn_of(2));
    const int next = turns.next()->visitor;
    order.push_back(next);
    turns.measured(next, 1, 100, true);
  }
  EXPECT_THAT(order, ElementsAre(1, 2, 1, 2));
  turns.want(turn_of(1));
  turns.want(turn_of(2));
  turns.want(turn_of(3));
  turns.measured(turns.next()->visitor, 1, 1, true);
  turns.measured(turns.next()->visitor, 1, 1000, true);
  EXPECT_LT(turns.next()->visitor, 4) << "a newcomer has no claim on the time before";
}

TEST(ServeMeasuringTurns, a_request_stays_until_it_is_answered) {
  MeasuringTurns turns;
  turns.want(turn_of(1, 7));
  turns.measured(1, 7, 10, false);
  EXPECT_EQ(turns.next()->request.version, 7) << "it was interrupted";
  turns.want(turn_of(1, 8));
  turns.measured(1, 7, 10, true);
  EXPECT_EQ(turns.next()->request.version, 8) << "it is a newer one";
  turns.measured(1, 8, 10, true);
  EXPECT_FALSE(turns.next());
  turns.want(turn_of(1, 9));
  turns.drop(1);
  EXPECT_FALSE(turns.next());
  turns.want(turn_of(1, 9));
  turns.forget(1);
  turns.measured(1, 9, 10, true);
  EXPECT_FALSE(turns.next());
}

// ---- the table
// ---------------------------------------------------------------------------------
TEST(ServePanels, the_table_has_the_window_s_columns_and_rows) {
  ServedRoom room;
  EXPECT_TRUE(section(room.of(1), "table").is_null());
  room.command(kTable);
  EXPECT_THAT(text_in(room.of(1), "table/text"),
              HasSubstr("not measured yet; measured once this view is still"));
  ASSERT_TRUE(room.until([&] { return is_measured(room); }));
  const Viewer& v = room.viewer();
  const Json table = section(room.of(1), "table/table");
  const auto columns = table_columns(v);
  ASSERT_EQ(table.at("columns").size(), columns.size());
  const auto rows = hud_rows(v);
  ASSERT_EQ(table.at("rows").size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json& cells = table.at("rows")[i].at("cells");
    for (std::size_t c = 0; c < columns.size(); ++c) {
      EXPECT_EQ(table.at("columns")[c].at("title"), columns[c].title);
      if (columns[c].cell == nullptr) continue;
      const HudCell& cell = rows[i].*columns[c].cell;
      EXPECT_EQ(cells[c].at("text"), cell.text);
      EXPECT_EQ(cells[c].at("tone"), cell.noisy ? "faint" : "") << columns[c].title;
    }
    EXPECT_EQ(cells.back().at("parts").size(), std::size_t{kStageCount});
    EXPECT_EQ(cells[0].at("use"), Json({"mode", 0.0, rows[i].mode}));
  }
  EXPECT_EQ(text_in(room.of(1), "table/text"), hud_status(v));
  EXPECT_EQ(table.at("caption"), table_caption(v));
}

TEST(ServePanels, a_flight_has_the_rates_of_all_modes) {
  ServedRoom room;
  room.command(kTable);
  constexpr int kForward = 87;  // W
  room.take(message::Key{kForward, true, false, 0});
  const auto has_rates = [&] {
    return std::ranges::all_of(hud_rows(room.viewer()),
                               [](const HudRow& row) { return row.is_live && row.fps.value > 0; });
  };
  ASSERT_TRUE(room.until(has_rates));
  EXPECT_TRUE(room.viewer().moving());
  room.take(message::Key{kForward, false, false, 0});
}

TEST(ServePanels, a_view_that_moves_is_not_measured) {
  ServedRoom room;
  room.command(kTable);
  ASSERT_TRUE(room.until([&] { return is_measured(room); }));
  room.take(message::Wheel{1, 0});
  EXPECT_FALSE(room.of(1).measuring_wish().request) << "it moves";
  EXPECT_EQ(room.of(1).measuring(), Measuring::none);
  room.of(1).tick(room.now);  // a measurement may have run until then
  EXPECT_THAT(text_in(room.of(1), "table/text"), HasSubstr("measured once this view is still"));
  ASSERT_TRUE(room.until([&] { return is_measured(room); })) << "it rests";
  const auto before = room.measured.size();
  room.command(kTable);
  for (int i = 0; i < 40; ++i) room.turn();
  EXPECT_EQ(room.measured.size(), before) << "a closed table costs nothing";
}

TEST(ServePanels, visitors_at_rest_take_turns) {
  ServedRoom room(3);
  for (int number = 1; number <= 3; ++number) room.command(kTable, number);
  ASSERT_TRUE(room.until(
      [&] { return is_measured(room, 1) && is_measured(room, 2) && is_measured(room, 3); }));
  const std::set<int> all(room.measured.begin(), room.measured.end());
  EXPECT_EQ(all.size(), 3u);
}

// A renderer without visitors: the answers are recorded.
struct Records {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> events;

  void add(std::string event) {
    const std::lock_guard lock(mutex);
    events.push_back(std::move(event));
    changed.notify_all();
  }
  bool wait_for(const std::string& event, int times = 1) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(60), [&] {
      return std::count(events.begin(), events.end(), event) >= times;
    });
  }
  auto count(const std::string& event) {
    const std::lock_guard lock(mutex);
    return std::count(events.begin(), events.end(), event);
  }
  bool has(const std::string& event) { return count(event) > 0; }
  Pictures::Receiver receiver() {
    return {[](int) {},
            [this](int visitor, const Picture& picture) {
              add(fmt::format("picture of {}{}", visitor, picture.error));
            },
            [this](int visitor, const Actions& actions) {
              if (!actions.empty()) add(fmt::format("report of {}", visitor));
            },
            [this](int visitor, int, Measuring state) {
              constexpr const char* kWords[] = {"is measured", "waits", "measures"};
              add(fmt::format("{} {}", visitor, kWords[static_cast<int>(state)]));
            }};
  }
};

class ServeSharedRenderer : public testing::Test {
 protected:
  test::SmallScenes small_{1};
  Visitor visitor_{small_.opened, {64, 48}, 100};
  Records records_;

  PictureOrder order() {
    PictureOrder order;
    order.request = full_frame(visitor_.viewer());
    return order;
  }
  MeasuringTurns::Turn long_measurement() {
    MeasuringTurns::Turn turn = turn_of(1);
    turn.request.camera = small_.opened[0]->facts.cameras[0].resized(1600, 1200);
    turn.request.settings = visitor_.viewer().settings;
    return turn;
  }
};

TEST_F(ServeSharedRenderer, a_picture_interrupts_a_measurement_which_begins_again) {
  Pictures pictures(small_.scenes, records_.receiver());
  pictures.measure(long_measurement());
  ASSERT_TRUE(records_.wait_for("1 measures"));
  pictures.order(2, order());
  ASSERT_TRUE(records_.wait_for("picture of 2"));
  if (!records_.has("1 waits")) GTEST_SKIP() << "the measurement ended before the order came";
  EXPECT_TRUE(records_.wait_for("1 measures", 2));
  EXPECT_TRUE(records_.wait_for("1 is measured"));
}

TEST_F(ServeSharedRenderer, a_measurement_that_nobody_wants_is_not_answered) {
  Pictures pictures(small_.scenes, records_.receiver());
  pictures.measure(long_measurement());
  ASSERT_TRUE(records_.wait_for("1 measures"));
  pictures.stop_measuring(1);
  pictures.order(2, order());
  ASSERT_TRUE(records_.wait_for("picture of 2"));
  EXPECT_EQ(records_.count("1 measures"), 1);
  EXPECT_EQ(records_.count("1 is measured"), 0);
}

TEST_F(ServeSharedRenderer, long_jobs_give_way_to_pictures_and_short_jobs) {
  Pictures pictures(small_.scenes, records_.receiver());
  pictures.run_long(1, 0, [&](RenderContext& context) {
    records_.add("began");
    while (!(records_.has("picture of 2") && records_.has("short job"))) {
      if (context.stop.stop_requested()) throw Cancelled();
      context.give_way();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    records_.add("ended");
  });
  ASSERT_TRUE(records_.wait_for("began"));
  pictures.order(2, order());
  pictures.run(3, 0, [&](RenderContext& context) {
    context.report(action::notify, std::string("x"));
    records_.add("short job");
  });
  EXPECT_TRUE(records_.wait_for("ended"));
  EXPECT_TRUE(records_.wait_for("report of 3")) << "reports go to the visitor of the job";
  EXPECT_FALSE(records_.has("report of 1"));
}

TEST_F(ServeSharedRenderer, a_long_job_ends_with_its_visitor) {
  Pictures pictures(small_.scenes, records_.receiver());
  const auto endless = [&](RenderContext& context) {
    records_.add("began");
    while (!context.stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    records_.add("stopped");
  };
  pictures.run_long(1, 0, endless);
  ASSERT_TRUE(records_.wait_for("began"));
  pictures.run_long(2, 0, endless);
  pictures.stop_long(2);  // it has not begun
  pictures.forget(1);
  EXPECT_TRUE(records_.wait_for("stopped"));
  pictures.order(3, order());
  ASSERT_TRUE(records_.wait_for("picture of 3"));
  EXPECT_EQ(records_.count("began"), 1);
}

// ---- split and grid
// ----------------------------------------------------------------------------
TEST(ServePanels, a_split_shows_two_modes_and_their_facts) {
  ServedRoom room;
  room.command(kSplit);
  ASSERT_TRUE(room.until([&] { return room.viewer().shown.other.has_value(); }));
  const Json split = section(room.of(1), "divider");
  EXPECT_EQ(section(room.of(1), "split/facts").at("facts").size(),
            split_facts(room.viewer()).size());
  EXPECT_EQ(split.at("names")[1], mode_name(room.viewer().split.other.mode));
  EXPECT_EQ(split.at("divider"), 0.5f);
  const int version = room.viewer().version;
  room.set("divider", 0.25);
  EXPECT_EQ(room.viewer().split.divider, 0.25f);
  EXPECT_GT(room.viewer().version, version) << "the picture is drawn again";
  EXPECT_EQ(room.of(1).next_order()->split->divider, 0.25f);
}

TEST(ServePanels, all_modes_have_labels_beside_their_pictures) {
  ServedRoom room;
  room.command("All modes side by side");
  ASSERT_TRUE(room.until([&] { return room.viewer().shown.grid.has_value(); }));
  const Json grid = section(room.of(1), "grid");
  ASSERT_EQ(grid.at("labels").size(), static_cast<std::size_t>(culler_count()));
  for (const Json& label : grid.at("labels")) {
    EXPECT_THAT(label.at("text").get<std::string>(), HasSubstr("pairs"));
    EXPECT_LE(label.at("x").get<double>() + grid.at("side").get<double>(), 1.0 + 1e-6);
  }
}

RenderedFrame two_frames(int width, int height) {
  RenderedFrame frame;
  frame.width = width;
  frame.height = height;
  frame.rgba.assign(static_cast<std::size_t>(4 * width * height), 200);
  frame.other.assign(frame.rgba.size(), 190);
  ShownOther other;
  other.pixels = image_difference(frame.rgba, frame.other, width, {0, 0, width, height});
  frame.shown.other = other;
  return frame;
}

TEST(ServePaint, the_divider_is_between_the_two_frames) {
  Split split;
  for (const auto& [divider, columns] :
       {std::pair(0.0f, 0), std::pair(0.25f, 2), std::pair(1.0f, 8), std::pair(-5.0f, 0)}) {
    split.divider = divider;
    const auto pixels = painted({}, split, two_frames(8, 2));
    for (int x = 0; x < 8; ++x)
      EXPECT_EQ(pixels[static_cast<std::size_t>(4 * x)], x < columns ? 200 : 190) << divider;
  }
  split.divider = 1;
  split.flipped = true;
  EXPECT_EQ(painted({}, split, two_frames(8, 2))[0], 190);
  split.view = SplitView::whole;
  EXPECT_EQ(painted({}, split, two_frames(8, 2))[28], 190);
}

TEST(ServePaint, differences_are_amplified_and_opaque) {
  Split split;
  split.view = SplitView::difference;
  split.amplification = 3;
  const auto pixels = painted({}, split, two_frames(8, 2));
  EXPECT_EQ(pixels[0], 30);
  EXPECT_EQ(pixels[3], 255);
  split.amplification = 0;
  EXPECT_EQ(painted({}, split, two_frames(8, 2))[0], 160) << "16 times is the largest that fits";
  split.view = SplitView::tile_pairs;
  EXPECT_EQ(painted({}, split, two_frames(8, 2))[0], 200) << "without pairs the frame itself";
  EXPECT_EQ(painted({}, std::nullopt, two_frames(8, 2))[0], 200);
}

// ---- the inspector
// -----------------------------------------------------------------------------
TEST(ServePanels, a_click_inspects_a_pixel) {
  ServedRoom room;
  click(room, {32, 24});
  for (int i = 0; i < 10; ++i) room.turn();
  EXPECT_FALSE(room.viewer().inspected) << "the inspector is closed";
  room.command(kInspector);
  EXPECT_EQ(text_in(room.of(1), "inspector/text"), kNothingInspected);
  click(room, {32, 24});
  ASSERT_TRUE(room.until([&] { return room.viewer().inspected.has_value(); }));
  const Inspection& inspection = room.viewer().inspected->inspection;
  const Json sections = panel_sections(room.of(1));
  EXPECT_EQ(text_in(room.of(1), "inspector/text"), inspected_pixel_text(inspection.pixel));
  EXPECT_EQ(inspection.pixel.pixel, glm::ivec2(32, 24));
  const Json rows = sections.at("inspector/table").at("rows");
  ASSERT_GE(rows.size(), inspection.pixel.contributions.size());
  ASSERT_FALSE(inspection.pixel.contributions.empty());
  const auto cells = contribution_cells(inspection.pixel.contributions[0], false);
  for (std::size_t i = 0; i < cells.size(); ++i)
    EXPECT_EQ(rows[0].at("cells")[i + 1].at("text"), cells[i]);
  EXPECT_EQ(sections.at("inspector/table2").at("rows").size(), inspection.gaussian->modes.size());
  EXPECT_GT(sections.at("inspector/figure").at("shapes").size(), 4u);
  EXPECT_NE(text_in(room.of(1), "inspector/text2"), kInspectedEarlier);
  const std::uint32_t last = inspection.pixel.contributions.back().gaussian;
  room.set("Gaussian", 0, last);
  EXPECT_TRUE(
      room.until([&] { return room.viewer().inspected->inspection.gaussian->gaussian == last; }));
  room.take(message::Wheel{1, 0});
  EXPECT_EQ(text_in(room.of(1), "inspector/text2"), kInspectedEarlier);
}

// ---- the zoom recorder
// -------------------------------------------------------------------------
TEST(ServePanels, a_zoom_is_recorded_charted_and_sent_as_csv) {
  ServedRoom room;
  room.command(kRecorder);
  room.set("splat scale", 3);  // something is in the middle of the picture
  room.set("steps", 2);
  room.set("x closer", 2);
  ASSERT_TRUE(room.until([&] { return room.viewer().shown.divisor == 1; }));
  room.command("Record a zoom");
  EXPECT_FALSE(section(room.of(1), "job").is_null());
  ASSERT_TRUE(
      room.until([&] { return !room.viewer().zoom.running && !room.viewer().zoom.starting; }));
  const ZoomRecord* const record = shown_zoom(room.viewer().zoom);
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(record->rows.size(), 2u * static_cast<std::size_t>(culler_count()));
  EXPECT_TRUE(record->folder.empty()) << "nothing is written";
  EXPECT_THAT(panel_sections(room.of(1)).dump(), HasSubstr("\"all 2 steps, not saved\""));
  const ZoomChart chart = zoom_chart(record, nullptr, ZoomQuantity::fps);
  const Json json = section(room.of(1), "recorder/chart");
  ASSERT_EQ(json.at("curves").size(), chart.curves.size());
  EXPECT_EQ(json.at("title"), chart.title);
  EXPECT_EQ(json.at("curves")[0].at("points")[1][0], 1.0);
  room.set("chart of", static_cast<double>(ZoomQuantity::pairs));
  EXPECT_EQ(room.viewer().zoom.quantity, ZoomQuantity::pairs);
  room.set("The zoom as CSV", 0);
  room.turn();
  ASSERT_EQ(room.files.size(), 1u);
  EXPECT_EQ(room.files[0].name, "scene0_zoom.csv");
  EXPECT_THAT(*room.files[0].bytes, HasSubstr("quadbox"));
  EXPECT_THAT(*room.files[0].bytes, Not(HasSubstr("secret")));
}

TEST(ServePanels, a_recording_is_stopped_by_its_visitor) {
  ServedRoom room;
  room.set("splat scale", 3);
  room.set("steps", 200);
  room.set("frames per mode and step", 1000);
  room.command("Record a zoom");
  ASSERT_TRUE(
      room.until([&] { return room.viewer().zoom.running || !room.viewer().zoom.starting; }));
  ASSERT_TRUE(room.viewer().zoom.running);
  room.take(message::Stop{});
  EXPECT_TRUE(room.until([&] { return !room.viewer().zoom.running; }));
}

// ---- crop and clean
// ----------------------------------------------------------------------------
TEST(ServePanels, a_crop_is_shared_and_a_box_is_not) {
  ServedRoom room(2);
  const std::uint64_t whole = room.viewer(1).scene->gaussians;
  room.command(kCrop);
  room.set("Box", 1);
  const CropBox box = room.viewer().crop.wish.box;
  const double middle = static_cast<double>((box.low.x + box.high.x) / 2);
  room.set("x right, from", middle);
  ASSERT_TRUE(room.until([&] { return room.viewer().crop.counts && !room.viewer().crop.busy; }));
  EXPECT_THAT(text_in(room.of(1), "crop/text"), HasSubstr("would go"));
  const auto handles = section(room.of(1), "box").at("handles");
  ASSERT_EQ(handles.size(), std::size_t{kBoxFaces});
  const Camera& camera = room.viewer().camera;
  for (int face = 0; face < kBoxFaces; ++face) {
    const auto pixel = handle_in_picture(camera, room.viewer().crop.wish.box, face);
    const auto& handle = handles.at(static_cast<std::size_t>(face));
    ASSERT_EQ(handle.is_null(), !pixel.has_value());
    if (!pixel) continue;
    EXPECT_NEAR(handle.at(0).get<double>(), (pixel->x + 0.5) / camera.width, 1e-6);
  }
  EXPECT_FALSE(room.viewer(2).crop.wish.boxed);
  const int before = room.viewer(2).view_version;

  room.set("Apply", 0);
  ASSERT_TRUE(room.until([&] { return room.viewer(2).editing.gone != nullptr; }));
  const std::uint64_t rest = room.viewer(1).scene->gaussians;
  EXPECT_LT(rest, whole);
  EXPECT_GT(rest, 0u);
  EXPECT_EQ(room.viewer(2).scene->gaussians, rest);
  EXPECT_GT(room.viewer(2).view_version, before);
  EXPECT_THAT(room.viewer(2).log.back().text,
              HasSubstr(fmt::format("edited for all visitors: {} of", grouped(rest))));
  room.add();
  room.turn();
  EXPECT_TRUE(room.viewer(3).editing.gone) << "a newcomer sees the same";
  for (int i = 0; i < 20; ++i) room.turn();
  EXPECT_EQ(room.viewer(1).scene->gaussians, rest) << "nobody undoes it by following";

  room.set("Save the cropped scene", 0);
  ASSERT_TRUE(room.until([&] { return !room.files.empty(); }));
  EXPECT_EQ(room.files[0].name, "scene0_cropped.ply");
  EXPECT_THAT(*room.files[0].bytes, HasSubstr(fmt::format("element vertex {}\n", rest)));
  EXPECT_THAT(*room.files[0].bytes, Not(HasSubstr("secret")));

  room.set("Undo", 0, 0, 2);
  ASSERT_TRUE(room.until([&] { return !room.viewer(1).editing.gone; }));
  EXPECT_EQ(room.viewer(1).scene->gaussians, whole);
  EXPECT_THAT(room.viewer(1).log.back().text, HasSubstr("the whole scene again"));
}

TEST(ServePanels, two_visitors_who_crop_at_once_end_with_one_scene) {
  ServedRoom room(2);
  for (const int number : {1, 2}) {
    room.command(kCrop, number);
    room.set("Box", 1, 0, number);
    room.set(number == 1 ? "x right, from" : "y down, from", 0, 0, number);
    room.set("Apply", 0, 0, number);
  }
  ASSERT_TRUE(room.until([&] {
    return !room.viewer(1).crop.busy && !room.viewer(2).crop.busy &&
           room.viewer(1).crop.asked.gone == room.viewer(2).crop.asked.gone &&
           room.viewer(1).editing.gone && !room.viewer(1).editing.busy &&
           !room.viewer(2).editing.busy;
  }));
  for (int i = 0; i < 20; ++i) room.turn();
  EXPECT_EQ(room.viewer(1).scene->gaussians, room.viewer(2).scene->gaussians);
  EXPECT_EQ(drawn_count(room.small.scenes[0]->context.session), room.viewer(1).scene->gaussians);
}

// A visitor drags with the left button from one place of the picture to another, or clicks.
void drag(ServedRoom& room, glm::dvec2 from, glm::dvec2 to, int number = 1) {
  room.take(message::Button{0, true, from}, number);
  if (to != from) room.take(message::Cursor{to}, number);
  room.take(message::Button{0, false, to}, number);
}

TEST(ServePanels, a_selection_and_its_tint_are_a_visitor_s_and_hiding_is_for_all) {
  ServedRoom room(2);
  const int before = room.viewer(2).version;
  room.command("Select with the next tool");
  drag(room, {5, 5}, {60, 44});
  ASSERT_TRUE(room.until([&] { return room.viewer().crop.tint && !room.viewer().crop.busy; }));
  EXPECT_EQ(*room.viewer().crop.tint, *room.viewer().editing.selected);
  EXPECT_EQ(full_frame(room.viewer()).tint, room.viewer().crop.tint);
  for (int i = 0; i < 10; ++i) room.turn();
  EXPECT_FALSE(room.viewer(2).editing.selected);
  EXPECT_FALSE(full_frame(room.viewer(2)).tint);
  EXPECT_EQ(room.viewer(2).version, before);
  const std::size_t selected = room.viewer().editing.selected->count();
  room.command("Hide the selected Gaussians");
  ASSERT_TRUE(room.until([&] { return room.viewer(2).editing.gone != nullptr; }));
  EXPECT_EQ(room.viewer(2).editing.gone->count(), selected);
  EXPECT_THAT(room.viewer(2).log.back().text,
              HasSubstr(fmt::format("of 300 Gaussians are left: {} hidden", selected)));
  room.command("Save the edits");
  ASSERT_TRUE(room.until([&] { return !room.files.empty(); }));
  const std::string text = *room.files[0].bytes;
  EXPECT_THAT(text, HasSubstr("\"step\":\"hide\""));
  // Another visitor opens that file.
  room.command("Undo");
  ASSERT_TRUE(
      room.until([&] { return !room.viewer(1).editing.gone && !room.viewer(2).editing.gone; }));
  room.take(message::OpenFile{"mine.edits.json", text}, 2);
  ASSERT_TRUE(
      room.until([&] { return room.viewer(1).editing.gone && room.viewer(2).editing.gone; }));
  EXPECT_EQ(room.viewer(1).editing.gone->count(), selected);
  room.take(message::OpenFile{"other.edits.json", "{"}, 2);
  ASSERT_TRUE(room.until([&] { return !room.viewer(2).editing.busy; }));
  EXPECT_THAT(room.viewer(2).log.back().text, HasSubstr("other.edits.json: "));
  room.take(message::OpenFile{"scene.ply", "ply"}, 2);
  EXPECT_THAT(room.viewer(2).log.back().text, HasSubstr("scene.ply: only files "));
}

TEST(ServePanels, points_are_measured_by_a_visitor_and_drawn_over_the_picture) {
  ServedRoom room(2);
  room.command("Measure distances");
  EXPECT_TRUE(room.viewer().panels.measures);
  std::size_t points = 0;
  for (int i = 0; i < 300 && points < 2; ++i) {
    const glm::dvec2 at(4 + i * 7 % 56, 4 + i * 5 % 40);
    drag(room, at, at);
    ASSERT_TRUE(room.until([&] { return !room.viewer().measures.busy; }));
    points = room.viewer().measures.points();
  }
  ASSERT_EQ(points, 2u) << "half of the light is stopped somewhere";
  EXPECT_EQ(room.viewer(2).measures.points(), 0u);
  const Json drawn = section(room.of(1), "box");
  EXPECT_EQ(drawn.at("lines").size(), 5u) << "a ruler and two crosses";
  ASSERT_EQ(drawn.at("labels").size(), 3u);
  EXPECT_THAT(drawn.at("labels").at(0).at(1).get<std::string>(), HasSubstr(" units"));
  EXPECT_EQ(drawn.at("labels").at(2).at(1), "2");
  EXPECT_TRUE(section(room.of(2), "box").is_null());
  EXPECT_THAT(section(room.of(1), "measures/facts").dump(), HasSubstr("1 to 2"));
  room.set("Copy", 0);
  ASSERT_EQ(room.files.size() + room.of(1).host().take_files().size(), 1u);
  room.set("known length", 2);
  room.set("Set the scale", 0);
  EXPECT_THAT(section(room.of(1), "measures/facts").dump(), HasSubstr("2 \u00b1"));
  room.files.clear();
  room.set("Save the measures", 0);
  ASSERT_TRUE(room.until([&] { return !room.files.empty(); }));
  room.take(message::OpenFile{"mine.measures.json", *room.files[0].bytes}, 2);
  EXPECT_TRUE(room.until([&] { return room.viewer(2).measures.points() == 2; }));
  EXPECT_EQ(room.viewer(2).measures.scale, room.viewer(1).measures.scale);
  room.command("Undo");
  EXPECT_EQ(room.viewer().measures.points(), 1u);
}

TEST(ServePanels, the_box_is_dragged_by_its_handles) {
  ServedRoom room;
  room.take(message::DragHandle{0, {10, 10}});
  EXPECT_FALSE(room.viewer().crop.wish.boxed) << "there is no box";
  room.command(kCrop);
  room.set("Box", 1);
  const auto handle = handle_in_picture(room.viewer().camera, room.viewer().crop.wish.box, 0);
  ASSERT_TRUE(handle);
  const float before = room.viewer().crop.wish.box.low.x;
  room.take(message::DragHandle{0, *handle + glm::dvec2(5, 0)});
  EXPECT_GT(room.viewer().crop.wish.box.low.x, before);
  room.set("Box", 0);
  EXPECT_TRUE(section(room.of(1), "box").is_null());
}

// ---- settings, path and film
// -------------------------------------------------------------------
TEST(ServeControls, every_control_has_a_name_and_takes_its_own_value) {
  ServedRoom room;
  std::set<std::string> names;
  for (const Control& control : controls()) {
    EXPECT_TRUE(names.insert(control.name).second) << control.name;
    EXPECT_EQ(find_control(control.name), &control);
    const auto now = control_now(room.viewer(), control);
    if (!now) continue;
    EXPECT_EQ(set_control(room.viewer(), control, now->value, 0).has_value(), now->is_enabled)
        << control.name;
    for (const double wrong :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
      EXPECT_FALSE(set_control(room.viewer(), control, wrong, 0)) << control.name;
    if (control.kind == ControlKind::button || control.kind == ControlKind::item) continue;
    for (const double wrong : {-2e7, 2e7})
      EXPECT_FALSE(set_control(room.viewer(), control, wrong, 0)) << control.name;
    if (control.kind == ControlKind::number) continue;
    EXPECT_FALSE(set_control(room.viewer(), control, now->value + 0.5, 0)) << control.name;
  }
  EXPECT_EQ(find_control("no such control"), nullptr);
}

TEST(ServeControls, without_a_scene_only_those_that_need_none_are_of_use) {
  Viewer viewer;
  viewer.training.emplace();
  std::vector<std::string> names;
  for (const Control& control : controls()) {
    if (control_now(viewer, control)) names.push_back(control.name);
  }
  EXPECT_THAT(names, UnorderedElementsAre("Draw smaller while moving (CPU)",
                                          "Leave out hidden Gaussians (GPU)", "Pause training",
                                          "Step", "Save the model", "Stop training"));
}

TEST(ServeControls, a_gray_control_cannot_be_set) {
  ServedRoom room;
  room.command(kSettings);
  const Control& end = *find_control("end here");
  const auto now = end.now(room.viewer());
  ASSERT_TRUE(now);
  EXPECT_FALSE(now->is_enabled) << "there is no start";
  EXPECT_FALSE(set_control(room.viewer(), end, 0, 0));
  room.set("start here", 0);
  EXPECT_TRUE(end.now(room.viewer())->is_enabled);
  EXPECT_TRUE(set_control(room.viewer(), end, 0, 0));
}

TEST(ServeControls, no_item_is_beyond_its_list) {
  ServedRoom room;
  for (const Control& control : controls()) {
    if (control.kind != ControlKind::item) continue;
    room.set(control.name, 1, ~std::uint32_t{0});
    room.set(control.name, -1e9, 0);
    room.set(control.name, 1e9, 7);
  }
  room.set("no such control", 1);
  for (const LogEntry& entry : room.viewer().log) EXPECT_FALSE(entry.error) << entry.text;
}

TEST(ServePanels, a_chosen_map_is_named_at_once_and_covers_the_map_before) {
  ServedRoom room;
  EXPECT_TRUE(section(room.of(1), "awaited").is_null());
  room.command("Heat map");
  const Json first = section(room.of(1), "awaited");
  EXPECT_THAT(first.at("text").get<std::string>(), HasSubstr("Tile pairs"));
  EXPECT_THAT(first.at("text").get<std::string>(), HasSubstr("computing"));
  EXPECT_FALSE(first.at("covers").get<bool>());
  ASSERT_TRUE(room.until([&] { return room.viewer().shown.heatmap.has_value(); }));
  EXPECT_TRUE(section(room.of(1), "awaited").is_null());
  room.command("Next heat map");
  EXPECT_TRUE(section(room.of(1), "awaited").at("covers").get<bool>());
}

TEST(ServePanels, settings_change_the_visitor_s_own_picture) {
  ServedRoom room(2);
  room.command(kSettings);
  room.set("splat scale", 2);
  room.set("style", 2);
  room.set("background", 0xff8000);
  room.set("Heat map", 3);
  EXPECT_EQ(room.viewer().settings.splat_scale, 2);
  EXPECT_FLOAT_EQ(room.viewer().settings.background.g, 128.0f / 255);
  EXPECT_EQ(room.viewer().heatmap, HeatQuantity::false_positive);
  EXPECT_EQ(room.viewer().settings.style, DrawStyle::ellipsoids);
  EXPECT_EQ(room.viewer(2).settings.splat_scale, 1);
  EXPECT_EQ(room.viewer(2).settings.style, DrawStyle::splats);
  const int version = room.viewer().version;
  room.set("opacity over the colours", 50);
  EXPECT_GT(room.viewer().version, version);
  const Json rows = section(room.of(1), "settings/controls").at("rows");
  const auto scale = std::find_if(rows.begin(), rows.end(),
                                  [](const Json& row) { return row.at("name") == "splat scale"; });
  ASSERT_NE(scale, rows.end());
  EXPECT_EQ(scale->at("value"), 2);
  EXPECT_EQ(scale->at("log"), true);
  const Json facts = section(room.of(1), "settings/facts").at("facts");
  for (const Json& fact : facts) EXPECT_NE(fact[0], "file");
}

TEST(ServePanels, a_path_is_made_played_and_sent) {
  ServedRoom room;
  room.command(kPath);
  room.set("Set here", 0);
  room.set("camera", 0, 1);
  for (int i = 0; i < 60; ++i) room.turn();
  EXPECT_EQ(room.viewer().dataset_camera, 1);
  room.set("Set here", 0);
  room.set("seconds", 0.5, 1);
  room.set("ease", 1, 1);
  const Json keyframes = section(room.of(1), "path/items").at("rows");
  ASSERT_EQ(keyframes.size(), 2u);
  const auto item = [&](const char* control) {
    for (const Json& each : keyframes[1]) {
      if (each.at("control") == control) return each.at("value").get<double>();
    }
    return -1.0;
  };
  EXPECT_EQ(item("seconds"), 0.5);
  EXPECT_EQ(item("ease"), 1);
  EXPECT_EQ(section(room.of(1), "path/list").at("labels").size(), 2u);
  room.set("Play", 0);
  EXPECT_TRUE(room.of(1).is_busy());
  EXPECT_TRUE(room.until([&] { return !room.viewer().playback.running; }));
  room.set("Save", 0);
  room.turn();
  ASSERT_EQ(room.files.size(), 1u);
  EXPECT_THAT(room.files[0].name, HasSubstr("_path.json"));
  EXPECT_EQ(Json::parse(*room.files[0].bytes).size(), 2u);
  room.set("remove keyframe", 0, 0);
  EXPECT_EQ(room.viewer().keyframes.size(), 1u);
}

TEST(ServePanels, views_are_bookmarked) {
  ServedRoom room;
  room.command("Bookmark this view");
  room.set("Bookmark", 0);
  const Json rows = section(room.of(1), "path/items2").at("rows");
  ASSERT_EQ(rows.size(), 2u) << "the panel is open";
  EXPECT_EQ(rows[1][1].at("label"), "view 2");
  const glm::dvec3 place = room.viewer().camera.position();
  room.set("camera", 0, 1);
  for (int i = 0; i < 60; ++i) room.turn();
  EXPECT_NE(room.viewer().camera.position(), place);
  room.set("bookmark", 0, 0);
  for (int i = 0; i < 60; ++i) room.turn();
  EXPECT_NEAR(glm::distance(room.viewer().camera.position(), place), 0, 1e-9);
  room.set("remove bookmark", 0, 0);
  EXPECT_EQ(section(room.of(1), "path/items2").at("rows").size(), 1u);
}

TEST(ServePanels, a_film_is_sent_and_leaves_no_file) {
  if (!ffmpeg_is_installed()) GTEST_SKIP() << "films need ffmpeg";
  ServedRoom room;
  room.command(kPath);
  room.set("Set here", 0);
  room.set("camera", 0, 1);
  for (int i = 0; i < 60; ++i) room.turn();
  room.set("Set here", 0);
  room.set("seconds", 0.2, 1);
  room.set("Film", 0);
  ASSERT_TRUE(room.until([&] { return !room.files.empty(); }));
  EXPECT_EQ(room.files[0].name, "scene0.mp4");
  EXPECT_GT(room.files[0].bytes->size(), 100u);
  EXPECT_EQ(room.files[0].bytes->substr(4, 4), "ftyp");
  EXPECT_FALSE(std::filesystem::exists("film"));
}

TEST(ServePanels, endless_films_are_refused) {
  ServedRoom room;
  room.set("Set here", 0);
  room.set("Set here", 0);
  room.set("seconds", 3600, 1);
  room.set("Film", 0);
  ASSERT_TRUE(
      room.until([&] { return !room.viewer().log.empty() && room.viewer().log.back().error; }));
  EXPECT_TRUE(room.files.empty());
}

TEST(ServePanels, a_visitor_cannot_ask_for_endless_work) {
  ServedRoom room;
  room.command(kInspector);
  for (int i = 0; i < 100; ++i) click(room, {32, 24});
  EXPECT_LE(room.of(1).host().take_jobs().size(), 8u);
  for (int i = 0; i < 100; ++i) click(room, {32, 24});
  EXPECT_TRUE(room.of(1).host().take_jobs().empty()) << "none of them has ended";
  EXPECT_TRUE(room.viewer().log.back().error);
  room.of(1).host().job_ended();
  click(room, {32, 24});
  EXPECT_EQ(room.of(1).host().take_jobs().size(), 1u);
  for (int i = 0; i < 1000; ++i) room.set("Set here", 0);
  EXPECT_EQ(room.viewer().keyframes.size(), 500u);
}

// ---- views and sections
// ------------------------------------------------------------------------
TEST(ServePanels, a_kept_view_comes_back) {
  ServedRoom room;
  room.take(message::ShowScene{1});
  room.take(message::Wheel{3, 0});
  room.command(mode_name(2));
  for (int i = 0; i < 40; ++i) room.turn();
  const Json view = Json::parse(state_sections(room.of(1), room.small.opened).at("view"));
  room.add();
  room.take(message::ShowView{1, view.at("pose"), view.at("mode")}, 2);
  EXPECT_EQ(room.of(2).scene(), 1u);
  EXPECT_EQ(room.viewer(2).settings.mode, 2);
  for (int i = 0; i < 60; ++i) room.turn();
  EXPECT_LT(glm::distance(room.viewer(2).camera.position(), room.viewer(1).camera.position()),
            1e-9);
  room.take(message::ShowView{9, "{", "no mode"}, 2);
  EXPECT_EQ(room.of(2).scene(), 1u);
}

TEST(ServePanels, closed_panels_send_nothing_and_open_ones_only_changes) {
  ServedRoom room;
  for (const char* name : {"table", "split", "grid", "inspector", "recorder", "crop", "path",
                           "settings", "job", "awaited", "divider", "box"})
    EXPECT_TRUE(section(room.of(1), name).is_null()) << name;
  const Json closed = panel_sections(room.of(1));  // items() refers to it
  for (const auto& [name, value] : closed.items())
    EXPECT_EQ(name.find('/'), name.npos) << "a block of a closed panel";
  EXPECT_EQ(section(room.of(1), "panels").size(), 8u);
  for (const Json& panel : section(room.of(1), "panels")) {
    EXPECT_FALSE(panel.at("open").get<bool>());
    room.command(panel.at("title"));
  }
  for (const Json& panel : section(room.of(1), "panels")) EXPECT_TRUE(panel.at("open").get<bool>());
  const StateSections before = state_sections(room.of(1), room.small.opened);
  room.set("ratios to", 0);
  EXPECT_EQ(state_message(before, state_sections(room.of(1), room.small.opened), 2), "")
      << "3dgs is the first already";
  room.set("ratios to", 1);
  const Json sent =
      Json::parse(state_message(before, state_sections(room.of(1), room.small.opened), 3));
  EXPECT_EQ(sent.at("version"), 3);
  EXPECT_TRUE(sent.at("sections").contains("table/table"));
  EXPECT_TRUE(sent.at("sections").contains("table/controls"));
  EXPECT_FALSE(sent.at("sections").contains("table/facts"));
  EXPECT_FALSE(sent.at("sections").contains("path/list"));
}

TEST(ServePanels, a_panel_of_the_table_is_sent) {
  ServedRoom room;
  std::vector<PanelRow> panels(panel_rows().begin(), panel_rows().end());
  panels.push_back({&Panels::cameras, "count", "Count", [](const Viewer& v) -> Blocks {
                      return {block::Text{fmt::format("{} keyframes", v.keyframes.size())},
                              block::Controls{{{"Set here"}}}};
                    }});
  EXPECT_FALSE(panel_sections(room.of(1), panels).contains("count/text"));
  room.command(kPath);
  room.set("Set here", 0);
  const Json sections = panel_sections(room.of(1), panels);
  EXPECT_EQ(sections.at("count"), Json({"count/text", "count/controls"}));
  EXPECT_EQ(sections.at("count/text").at("text"), "1 keyframes");
  EXPECT_EQ(sections.at("count/controls").at("rows")[0].at("name"), "Set here");
}

TEST(ServePanels, no_section_and_no_file_has_a_path) {
  ServedRoom room;
  std::string all;
  const auto keep = [&] {
    all += state_message({}, state_sections(room.of(1), room.small.opened), 1);
  };
  for (const Json& panel : section(room.of(1), "panels")) room.command(panel.at("title"));
  room.set("Set points", 0);  // a click inspects
  click(room, {32, 24});
  room.set("Set here", 0);
  room.set("Set here", 0);
  room.set("Save", 0);
  ASSERT_TRUE(room.until([&] { return room.viewer().inspected.has_value(); }));
  keep();
  room.set("Floaters", 1);
  room.set("Apply", 0);
  ASSERT_TRUE(room.until([&] { return !room.viewer().crop.busy; }));
  keep();
  room.set("splat scale", 3);
  room.set("steps", 2);
  room.set("Record", 0);
  room.set("Film", 0);
  for (int i = 0; i < 100; ++i) {
    room.turn();
    keep();
  }
  ASSERT_TRUE(room.until([&] {
    return !room.viewer().zoom.running && !room.viewer().zoom.starting && !room.viewer().loading;
  }));
  room.take(message::Stop{});
  keep();
  const std::string folder = room.small.folder.path().string();
  room.of(1).apply({call(action::notify_error, folder + "/secret0/scene0.ply: is broken"),
                    call(action::notify, "see " + folder + "/secret0, or ../secret0/x.")},
                   room.now);
  keep();
  EXPECT_THAT(all, HasSubstr("scene0: is broken"));
  EXPECT_EQ(all.find("secret0/"), all.npos);
  EXPECT_EQ(all.find(folder), all.npos);
  EXPECT_EQ(all.find(std::filesystem::temp_directory_path().string() + "/"), all.npos);
  for (const SentFile& file : room.files) {
    EXPECT_EQ(file.bytes->find("secret"), std::string::npos) << file.name;
    EXPECT_EQ(file.name.find('/'), std::string::npos);
  }
}

TEST(ServePanels, paths_in_messages_become_names) {
  Viewer viewer;
  viewer.scene.emplace();
  viewer.scene->path = "my scenes/garden.ply";
  viewer.scene->name = "garden";
  EXPECT_EQ(public_text(viewer, "my scenes/garden.ply: is broken"), "garden: is broken");
  EXPECT_EQ(public_text(viewer, "cannot read '/home/me/x.png'"), "cannot read 'x.png'");
  EXPECT_EQ(public_text(viewer, "3 of 500 Gaussians, 12 ms/frame"),
            "3 of 500 Gaussians, 12 ms/frame");
  EXPECT_EQ(public_text(viewer, "/"), "/");
  EXPECT_EQ(public_text(viewer, ""), "");
}

// ---- files
// -------------------------------------------------------------------------------------
TEST(ServeFiles, a_file_is_sent_in_parts) {
  const SentFile file{"a.csv", std::make_shared<const std::string>(kFilePart + 3, 'x')};
  const std::string first = file_message(file, 5, 0), last = file_message(file, 5, kFilePart);
  EXPECT_EQ(first.size(), 16 + 5 + kFilePart);
  EXPECT_EQ(first[0], 2);
  EXPECT_EQ(first[1], 0);
  EXPECT_EQ(last[1], 4);
  EXPECT_EQ(last.substr(16), "a.csvxxx");
  EXPECT_EQ(static_cast<unsigned char>(first[8]), (kFilePart + 3) % 256);
  const SentFile empty{"e", std::make_shared<const std::string>()};
  EXPECT_EQ(file_message(empty, 1, 0).substr(16), "e");
  EXPECT_EQ(file_message(empty, 1, 0)[1], 4);
}

TEST(ServeFiles, names_are_harmless) {
  EXPECT_EQ(harmless_name("/etc/passwd"), "passwd");
  EXPECT_EQ(harmless_name("..\\..\\x.csv"), "x.csv");
  EXPECT_EQ(harmless_name("..."), "file");
  EXPECT_EQ(harmless_name(""), "file");
  EXPECT_EQ(harmless_name("a<b>\n.mp4"), "a_b__.mp4");
  EXPECT_EQ(harmless_name(std::string(500, 'x')).size(), 200u);
}

}  // namespace
}  // namespace qs
