// SPDX-License-Identifier: MIT
//
// Background jobs of the viewer in a window that is wider than high: their results, and the part of
// the view that they cover.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <regex>
#include <thread>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/inspect/inspection.h"
#include "app/inspect/reference_check.h"
#include "app/measure/camera_path.h"
#include "app/measure/statistics.h"
#include "app/support/rendering_viewer.h"
#include "app/support/run_program.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/panel_pictures.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/zoom_actions.h"
#include "app/viewer/window/presenter.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/pool.h"

namespace qs {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

class ViewerJobs : public test::RenderingViewer {
 protected:
  // Frames of the same scene without the viewer.
  const Frame& headless(const RenderSettings& settings, const Outputs& outputs) {
    return uploaded().render(viewer().camera, settings, outputs);
  }
  Renderer& uploaded() {
    if (!renderer_) {
      renderer_ = make_renderer(Backend::cpu, test::pool(1));
      renderer_->upload(test::random_cloud(300, 1, 5), {});
    }
    return *renderer_;
  }

 private:
  std::unique_ptr<Renderer> renderer_;
};

void expect_picture(const std::vector<std::uint8_t>& rgba, const Image& image) {
  ASSERT_EQ(rgba.size(), image.values.size() / 3 * 4);
  for (std::size_t i = 0; i < rgba.size(); ++i)
    ASSERT_EQ(rgba[i], i % 4 == 3 ? 255 : to_8bit(image.values[i / 4 * 3 + i % 4])) << i;
}

TEST_F(ViewerJobs, frames_are_the_renderer_s_pictures) {
  const auto frame = draw(request_);
  ASSERT_TRUE(frame);
  const Frame& expected = headless(request_.settings, {});
  EXPECT_EQ(frame->width, 96);
  EXPECT_EQ(frame->height, 64);
  expect_picture(frame->rgba, expected.color);
  EXPECT_TRUE(frame->other.empty());
  EXPECT_EQ(frame->shown.version, request_.version);
  EXPECT_EQ(frame->shown.mode, request_.settings.mode);
  EXPECT_EQ(frame->shown.stats.tile_pairs, expected.stats.tile_pairs);
  EXPECT_FALSE(frame->shown.interop);
}

TEST_F(ViewerJobs, smaller_frames_round_both_sides_down_to_at_least_one) {
  request_.divisor = 7;
  const auto frame = draw(request_);
  EXPECT_EQ(frame->width, 13);
  EXPECT_EQ(frame->height, 9);
  EXPECT_EQ(frame->rgba.size(), 4u * 13 * 9);
  request_.divisor = 80;
  EXPECT_EQ(draw(request_)->height, 1);
  EXPECT_EQ(draw(request_)->width, 1);
}

// Without ffmpeg, so that films are folders of pictures.
class FilmJob : public ViewerJobs {
 protected:
  FilmJob() : path_variable_(std::getenv("PATH")) { setenv("PATH", "", 1); }
  ~FilmJob() override { setenv("PATH", path_variable_.c_str(), 1); }
  std::vector<std::filesystem::path> films() const {
    std::vector<std::filesystem::path> found;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(scenes_ / "film", missing))
      found.push_back(entry.path());
    return found;
  }

 private:
  std::string path_variable_;
};

TEST_F(FilmJob, films_the_path_of_the_window) {
  const Camera first = viewer().camera;
  press("K");
  apply(call(action::orbit, glm::dvec2(40, 0)));
  press("K");
  apply(call(action::resize, 97, 65));
  press("Ctrl+K");
  settle();
  EXPECT_THAT(viewer().toasts.back().text,
              HasSubstr(": PNG files, because ffmpeg is not installed"));
  EXPECT_FALSE(viewer().loading);
  ASSERT_THAT(films(), SizeIs(1));
  const auto picture = [&](int number) {
    return read_image(films()[0] / fmt::format("frame_{:05}.png", number));
  };
  EXPECT_FALSE(std::filesystem::exists(films()[0] / "frame_00030.png"));
  const std::pair<int, Camera> ends[] = {{0, first}, {29, viewer().keyframes[1].camera}};
  for (const auto& [number, camera] : ends) {
    request_.camera = camera.resized(96, 64);
    const auto frame = draw(request_);
    const Image seen = picture(number);
    ASSERT_EQ(seen.width, 96);
    for (std::size_t i = 0; i < seen.values.size(); ++i)
      ASSERT_EQ(to_8bit(seen.values[i]), frame->rgba[i / 3 * 4 + i % 3]) << number;
  }
}

TEST_F(FilmJob, films_both_sides_of_a_split_window) {
  press("K");
  apply(call(action::orbit, glm::dvec2(40, 0)));
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 0.1));
  apply(call(action::resize, 600, 300));
  press("C");
  settle();
  press("Ctrl+K");
  settle();
  ASSERT_THAT(films(), SizeIs(1));
  const Image seen = read_image(films()[0] / "frame_00000.png");
  EXPECT_EQ(seen.width, 600);
  EXPECT_GT(seen.at(300, 20, 0), 0.8f);  // the line between the strips
}

TEST_F(FilmJob, films_two_scenes_beside_each_other) {
  auto scene = std::make_shared<Scene>();
  scene->cloud = test::random_cloud(120, 1, 9);
  scene->path = scenes_ / "other.ply";
  show_beside_it(scene);
  ASSERT_TRUE(viewer().beside);
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 0.1));
  press("Ctrl+K");
  settle();
  ASSERT_THAT(films(), SizeIs(1)) << viewer().toasts.back().text;
  const Image seen = read_image(films()[0] / "frame_00000.png");
  const auto renderer = make_renderer(Backend::cpu, test::pool(1));
  renderer->upload(scene->cloud, {});
  const Image other = renderer->render(viewer().camera, request_.settings).color;
  const auto frame = draw(request_);
  // Above the labels; the line between the strips is at x = 48.
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (std::abs(x - 48) <= 1) continue;
      const auto expected = x < 48 ? frame->rgba[static_cast<std::size_t>(4 * (y * 96 + x))]
                                   : to_8bit(other.at(x, y, 0));
      ASSERT_EQ(to_8bit(seen.at(x, y, 0)), expected) << x << " " << y;
    }
  }
}

TEST_F(FilmJob, a_film_can_be_stopped_and_leaves_nothing) {
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 3600.0));
  press("Ctrl+K");
  while (!viewer().loading && thread_.busy()) {
    take_reports();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(viewer().loading);
  EXPECT_EQ(viewer().loading->what, "filming");
  stop_job();
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("the film was stopped, nothing was saved"));
  EXPECT_FALSE(viewer().loading);
  EXPECT_THAT(films(), testing::IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(scenes_ / "film")) << "an empty folder";
}

TEST_F(FilmJob, keys_work_meanwhile_and_leaving_keeps_the_film_as_far_as_it_got) {
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 3600.0));
  press("Ctrl+K");
  while (!viewer().loading && thread_.busy()) take_reports();
  press("H");
  thread_.request(full_frame(viewer()));
  std::optional<RenderedFrame> frame;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!(frame = thread_.take_frame()) && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->shown.heatmap);
  EXPECT_TRUE(viewer().loading) << "the film is still drawn";
  leave_job(true);
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("it ends where it was stopped"));
  ASSERT_THAT(films(), SizeIs(1));
  EXPECT_TRUE(std::filesystem::exists(films()[0] / "frame_00000.png"));
}

TEST_F(FilmJob, a_film_that_cannot_be_written_any_more_is_kept_as_far_as_it_got) {
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 3600.0));
  press("Ctrl+K");
  while (films().empty() && thread_.busy()) take_reports();
  ASSERT_THAT(films(), SizeIs(1)) << "the hidden folder of its pictures";
  const std::filesystem::path hidden = films()[0];
  while (!std::filesystem::exists(hidden / "frame_00001.png")) take_reports();
  std::filesystem::create_directory(hidden / "frame_00300.png");
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("only as far as it got: "));
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("frame_00300.png: cannot be written"));
  ASSERT_THAT(films(), SizeIs(1));
  EXPECT_TRUE(std::filesystem::exists(films()[0] / "frame_00299.png"));
  EXPECT_FALSE(viewer().loading);
}

TEST_F(FilmJob, nothing_is_drawn_for_a_place_that_cannot_be_written) {
  change([&](Viewer& viewer) { viewer.out_dir = scenes_ / "random scene.ply"; });
  press("Ctrl+K");
  settle();
  EXPECT_TRUE(viewer().toasts.back().error);
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("cannot be created"));
}

TEST_F(ViewerJobs, a_heat_map_has_the_scale_of_the_baseline_s_map) {
  request_.heatmap = HeatQuantity::pairs;
  request_.settings.mode = find_culler("quadbox");
  const auto frame = draw(request_);
  RenderSettings settings = request_.settings;
  settings.mode = find_culler("3dgs");
  Outputs outputs;
  outputs.pairs = true;
  const Scale baseline = scale_for(headless(settings, outputs).pairs);
  ASSERT_TRUE(frame && frame->shown.heatmap);
  const Heatmap& map = *frame->shown.heatmap;
  EXPECT_EQ(map.columns, 6);
  EXPECT_EQ(map.rows, 4);
  EXPECT_EQ(frame->shown.map_scale, baseline);
  EXPECT_EQ(frame->shown.scale_version, request_.view_version);
  const auto layer = layers_of(frame->shown).picture;
  ASSERT_TRUE(layer);
  EXPECT_EQ(layer->columns, 6);
  EXPECT_EQ(layer->rows, 4);
  EXPECT_EQ(layer->cell_px, 16);
  EXPECT_EQ(layer->low, 0);
  EXPECT_EQ(layer->high, static_cast<float>(frame->shown.map_scale.maximum));
  for (std::size_t i = 0; i < map.values.size(); ++i)
    EXPECT_EQ(layer->values[i], static_cast<float>(map.values[i]));
  EXPECT_FALSE(layers_of(ShownFrame()).picture);
}

TEST_F(ViewerJobs, a_split_frame_s_layer_goes_from_fewer_to_more_pairs) {
  request_.other = Variant{find_culler("3dgs"), Pipeline::classic, Backend::cpu};
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.other && frame->shown.other->pairs);
  const auto layer = layers_of(frame->shown).difference;
  ASSERT_TRUE(layer);
  EXPECT_EQ(layer->columns, 6);
  EXPECT_EQ(layer->rows, 4);
  EXPECT_EQ(layer->low, -layer->high);
  EXPECT_EQ(layer->high, static_cast<float>(frame->shown.other->pairs_scale.maximum));
  float largest = 0, sum = 0;
  for (const float value : layer->values) {
    largest = std::max(largest, std::abs(value));
    sum += value;
  }
  EXPECT_GE(layer->high, largest);
  EXPECT_EQ(static_cast<std::int64_t>(sum), frame->shown.other->pairs->total);
  EXPECT_EQ(frame->shown.other->region.x1, 96);
  EXPECT_EQ(frame->shown.other->region.y1, 64);
  RenderSettings settings = request_.settings;
  settings.mode = find_culler("3dgs");
  settings.pipeline = Pipeline::classic;
  expect_picture(frame->other, headless(settings, {}).color);
}

TEST_F(ViewerJobs, both_sides_of_a_split_have_a_heat_map_of_one_scale) {
  request_.heatmap = HeatQuantity::pairs;
  request_.settings.mode = find_culler("quadbox");
  request_.other = Variant{find_culler("3dgs"), Pipeline::fast, Backend::cpu};
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.heatmap && frame->shown.other && frame->shown.other->heatmap);
  const Heatmap &first = *frame->shown.heatmap, &other = *frame->shown.other->heatmap;
  EXPECT_EQ(first.total, frame->shown.stats.tile_pairs);
  EXPECT_EQ(other.total, frame->shown.other->stats.tile_pairs);
  EXPECT_LT(first.total, other.total);
  EXPECT_EQ(frame->shown.map_scale, scale_for(other.values)) << "3dgs is the baseline";
  const HeatLayers layers = layers_of(frame->shown);
  ASSERT_TRUE(layers.picture && layers.other && layers.difference);
  EXPECT_EQ(layers.picture->high, layers.other->high);
}

TEST_F(ViewerJobs, a_scale_is_held_while_the_camera_moves_and_fits_again_at_rest) {
  request_.heatmap = HeatQuantity::pairs;
  const Scale far = draw(request_)->shown.map_scale;
  request_.camera.view_from_world[3].z -= 3;  // nearer: other tiles are full
  ++request_.version;
  ++request_.view_version;
  request_.moving = true;
  const auto moving = draw(request_);
  EXPECT_EQ(moving->shown.map_scale, far);
  EXPECT_NE(moving->shown.scale_version, request_.view_version);
  request_.moving = false;
  ++request_.version;
  const auto resting = draw(request_);
  EXPECT_EQ(resting->shown.scale_version, request_.view_version);
  request_.heat_maximum = 750;
  ++request_.version;
  const auto fixed = draw(request_);
  EXPECT_EQ(fixed->shown.map_scale.maximum, 750u);
}

TEST_F(ViewerJobs, the_grid_has_the_counts_of_every_mode_and_the_pictures_at_their_places) {
  request_.grid = true;
  request_.heatmap = HeatQuantity::pairs;
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.grid);
  EXPECT_EQ(frame->width, 96);
  EXPECT_EQ(frame->height, 64);
  ASSERT_EQ(frame->shown.grid->stats.size(), static_cast<std::size_t>(culler_count()));
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    RenderSettings settings = request_.settings;
    settings.mode = mode;
    const auto index = static_cast<std::size_t>(mode - 1);
    const auto pairs = headless(settings, {}).stats.tile_pairs;
    EXPECT_EQ(frame->shown.grid->stats[index].tile_pairs, pairs) << mode_name(mode);
    EXPECT_EQ(frame->shown.grid->totals[index], pairs) << mode_name(mode);
  }
  EXPECT_FALSE(layers_of(frame->shown).picture) << "the map is drawn into the pictures";
}

TEST_F(ViewerJobs, the_figure_of_all_modes_ends_with_a_margin_below_its_last_line) {
  for (const bool maps : {false, true}) {
    SCOPED_TRACE(maps);
    change([maps](Viewer& viewer) {
      viewer.heatmap = maps ? std::optional(HeatQuantity::pairs) : std::nullopt;
    });
    std::filesystem::remove_all(scenes_ / "figures");
    press("Ctrl+F9");
    settle();
    std::filesystem::path file;
    for (const auto& entry : std::filesystem::directory_iterator(scenes_ / "figures"))
      if (entry.path().extension() == ".png") file = entry.path();
    const Image figure = read_image(file);
    int last = 0;  // row with ink
    for (int y = 0; y < figure.height; ++y)
      for (int x = 0; x < figure.width; ++x)
        if (figure.at(x, y, 0) < 0.95f) last = y;
    EXPECT_GE(figure.height - 1 - last, 30);
    EXPECT_LE(figure.height - 1 - last, 80);
  }
}

// ---- pictures and numbers say what they are ----------------------------------------------------
class AlteredViewer : public FilmJob {
 protected:
  AlteredViewer() {
    change([](Viewer& viewer) {
      ViewedScene& scene = *viewer.scene;
      scene.sh_degree = 1;
      viewer.panels.crop = true;
      viewer.crop.wish.boxed = true;
      viewer.crop.wish.box = {{-9, -9, -9}, {0.5f, 9, 9}};
    });
  }
  void alter() {
    change([](Viewer& viewer) { viewer.settings.splat_scale = 2; });
    crop();
    press("Shift+R");
    crop();
  }
  void crop() {
    do {
      apply(call(action::follow_edits));
      settle();
    } while (viewer().editing.busy || viewer().crop.asked != wanted_crop(viewer()));
  }
  std::string edits() const {
    return fmt::format("{} of 300 Gaussians", viewer().scene->gaussians);
  }
  // The only new file below a folder, by its ending.
  std::string content(const std::string& folder, const std::string& ending) const {
    std::string found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(scenes_ / folder))
      if (entry.path().string().ends_with(ending)) found = test::content_of(entry.path());
    return found;
  }
};

TEST_F(AlteredViewer, all_that_is_saved_shown_and_copied_says_the_scale_and_the_crop) {
  for (const bool altered : {false, true}) {
    SCOPED_TRACE(altered);
    if (altered) alter();
    for (const char* folder : {"bench", "zoom", "film", "screenshots", "figures"})
      std::filesystem::remove_all(scenes_ / folder);
    ZoomPlan plan;
    plan.steps = 2;
    plan.modes = {1};
    apply(call(action::change_zoom_plan, plan));
    press("K");
    press("K");
    apply(call(action::delay_keyframe, std::size_t{1}, 0.1));
    for (const char* key : {"P", "Shift+Z", "Ctrl+K", "Ctrl+F12", "Ctrl+F9"}) {
      press(key);
      settle();
    }
    const std::pair<const char*, std::string> outputs[] = {
        {"bench.json", content("bench", "bench.json")},
        {"bench.md", content("bench", "bench.md")},
        {"bench.csv", content("bench", "bench.csv")},
        {"bench's plot", content("bench", "fps.gp")},
        {"zoom.json", content("zoom", "zoom.json")},
        {"zoom.csv", content("zoom", "zoom.csv")},
        {"zoom's plot", content("zoom", "zoom_fps.gp")},
        {"zoom's own figure", content("zoom", "zoom_ms.svg")},
        {"film", content("film", "frame_00000.png")},
        {"screenshot", content("screenshots", ".png")},
        {"figure", content("figures", ".png")},
        {"figure as SVG", content("figures", ".svg")},
        {"copied CSV", table_text(viewer(), TableFormat::csv)},
        {"copied Markdown", table_text(viewer(), TableFormat::markdown)},
        {"copied LaTeX", table_text(viewer(), TableFormat::latex)},
        {"list of zooms", zoom_label(viewer().zoom.records.back())},
    };
    const std::string words = "splat scale 2, edited: 1 step, " + edits() + ", crc32:";
    for (const auto& [name, saved_text] : outputs) {
      ASSERT_NE(saved_text, "") << name;
      if (altered) {
        EXPECT_THAT(saved_text, HasSubstr(words)) << name;
      } else {
        EXPECT_THAT(saved_text, Not(AnyOf(HasSubstr("ltered"), HasSubstr("edited")))) << name;
      }
    }
    const std::string brief = "splat scale 2, edited: " + edits();
    EXPECT_EQ(window_title(viewer()),
              altered ? "random (" + brief + ") - quadsplat" : "random - quadsplat");
    const std::string line = status_line(viewer()).numbers;
    EXPECT_EQ(line.find(brief) != std::string::npos, altered) << line;
  }
}

TEST_F(AlteredViewer, a_second_crop_is_a_second_step_and_undoing_it_leaves_the_first) {
  alter();
  const EditFacts first = viewer().scene->edits;
  EXPECT_EQ(first.steps, 1);
  EXPECT_LT(first.kept, 300u);
  EXPECT_EQ(first.of, 300u);
  CropWish wish = viewer().crop.wish;
  EXPECT_FALSE(wish.boxed) << "it is done";
  wish.boxed = true;
  wish.box.high.y = 0;
  apply(call(action::change_crop, wish));
  crop();
  EXPECT_TRUE(viewer().crop.tint);
  press("Shift+R");
  crop();
  const EditFacts second = viewer().scene->edits;
  EXPECT_EQ(second.steps, 2);
  EXPECT_LT(second.kept, first.kept);
  EXPECT_NE(second.crc, first.crc);
  press("Shift+R");
  crop();
  EXPECT_EQ(viewer().scene->edits, first);
  press("Shift+R");
  crop();
  EXPECT_EQ(viewer().scene->edits, EditFacts());
}

TEST_F(ViewerJobs, a_screenshot_names_its_mode_its_map_and_its_own_size) {
  const auto saved = [&] {
    std::filesystem::remove_all(scenes_ / "screenshots");
    press("Ctrl+F12");
    settle();
    std::filesystem::path file;
    for (const auto& entry : std::filesystem::directory_iterator(scenes_ / "screenshots"))
      file = entry.path();
    return file;
  };
  EXPECT_EQ(saved().filename(), "random_scene_view_quadbox_96x64_0001.png");
  press("C");
  settle();
  const std::filesystem::path half = saved();
  EXPECT_EQ(half.filename(), "random_scene_view_quadbox_alone_96x64_0001.png");
  EXPECT_THAT(test::content_of(half), HasSubstr("quadbox alone"));
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr(": quadbox alone"));
  press("C");
  press("H");
  settle();
  const std::filesystem::path map = saved();
  const Image picture = read_image(map);
  EXPECT_GT(picture.height, 64) << "with its legend";
  EXPECT_EQ(map.filename(), fmt::format("random_scene_view_quadbox_pairs_{}x{}_0001.png",
                                        picture.width, picture.height));
  EXPECT_THAT(test::content_of(map), HasSubstr("HeatmapTotal"));
  press("J");
  settle();
  EXPECT_THAT(saved().filename().string(), HasSubstr("_quadbox_depth_"));
}

TEST_F(ViewerJobs, the_figure_of_all_modes_says_who_measured_when_and_what_lossy_modes_lose) {
  press("F10");
  press("F9");
  thread_.request(
      NumbersRequest{measured_camera(viewer()), viewer().settings, viewer().view_version, false});
  settle();
  press("Ctrl+F9");
  settle();
  std::string svg;
  for (const auto& entry : std::filesystem::directory_iterator(scenes_ / "figures"))
    if (entry.path().extension() == ".svg") svg = test::content_of(entry.path());
  EXPECT_THAT(svg, HasSubstr(", 1 thread; 20"));  // the processor and the year
  EXPECT_THAT(svg, HasSubstr("; medians of "));
  EXPECT_THAT(svg, testing::ContainsRegex("FPS .+ [0-9,]+ pairs .+ [0-9.]+x .+ lossless"));
  EXPECT_THAT(svg, testing::ContainsRegex("pairs .+ PSNR ([0-9.]+|inf) dB"));
  const std::regex ratio("[0-9]+\\.([0-9]+)x ");
  for (std::sregex_iterator each(svg.begin(), svg.end(), ratio), end; each != end; ++each)
    EXPECT_EQ((*each)[1].length(), 2) << each->str();
}

TEST_F(ViewerJobs, the_inspector_works_up_to_the_right_and_the_lower_border) {
  press("B");
  for (const glm::ivec2 pixel : {glm::ivec2(95, 10), {40, 63}, {0, 0}}) {
    SCOPED_TRACE(testing::Message() << pixel.x << " " << pixel.y);
    apply(call(action::inspect_pixel, glm::dvec2(pixel) + 0.7));
    settle();
    ASSERT_TRUE(viewer().inspected);
    EXPECT_EQ(viewer().inspected->version, viewer().version);
    const Frame& frame = headless(viewer().settings, inspection_outputs());
    const Inspection expected = inspect(frame, {96, 64}, pixel, viewer().settings.background, {});
    const Inspection& actual = viewer().inspected->inspection;
    EXPECT_EQ(actual.pixel.pixel, pixel);
    EXPECT_EQ(inspection_json(actual), inspection_json(expected));
    EXPECT_EQ(viewer().inspected->grid.columns, frame.grid.columns);
    EXPECT_EQ(viewer().inspected->grid.tile_px, frame.grid.tile_px);
  }
}

TEST_F(ViewerJobs, the_comparison_around_the_cursor_covers_256_pixels) {
  apply(call(action::resize, 600, 400));
  const auto region = [&](double x, double y) {
    change([=](Viewer& viewer) {
      viewer.cursor = {x, y};
      viewer.panels.split = true;
      viewer.split.other = {kReferenceMode, Pipeline::fast, Backend::cpu};
    });
    press("Shift+0");
    const auto frame = settle();
    EXPECT_TRUE(viewer().comparison && frame && frame->shown.other);
    const PixelBox box = viewer().comparison->verdict.region;
    if (frame && frame->shown.other) {
      EXPECT_EQ(frame->shown.other->region.x0, box.x0);
      EXPECT_EQ(frame->shown.other->region.y1, box.y1);
      EXPECT_LE(frame->shown.other->pixels.largest, 2);
    }
    return std::array{box.x0, box.y0, box.x1, box.y1};
  };
  EXPECT_THAT(region(300.5, 200.5), ElementsAre(172, 72, 428, 328));
  EXPECT_THAT(region(900, 900), ElementsAre(471, 271, 600, 400));
  EXPECT_EQ(viewer().comparison->view_version, viewer().view_version);
  EXPECT_TRUE(verdict_is_current(viewer()));
  EXPECT_THAT(viewer().comparison->sentence,
              testing::StartsWith("quadbox: equal to the reference within 2/255"));
}

TEST_F(ViewerJobs, progress_is_reported_in_steps_of_one_per_cent) {
  ActionQueue queue([] {});
  ViewerStore store{Viewer()};
  std::vector<float> shown;
  const Progress progress = shown_progress("/a.ply", "reading", {}, queue);
  for (const float fraction : {0.0f, 0.005f, 0.0125f, 0.015f, 0.02f, 0.5f, 0.505f, 1.0f}) {
    progress.update(fraction);
    Actions actions;
    queue.take(actions);
    for (const Action& action : actions) {
      store.apply(action, *this);
      shown.push_back(store.viewer().loading->fraction);
    }
  }
  EXPECT_THAT(shown, ElementsAre(0.0125f, 0.5f, 1.0f));
  EXPECT_EQ(store.viewer().loading->path, "/a.ply");
  EXPECT_EQ(store.viewer().loading->what, "reading");
}

TEST_F(ViewerJobs, requests_follow_the_state_of_the_view) {
  FrameRequests requests;
  EXPECT_FALSE(requests.are_up_to_date(viewer()));
  requests.update(viewer(), thread_, false);
  EXPECT_TRUE(requests.are_up_to_date(viewer()));
  auto frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.version, viewer().version);
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());  // nothing changed
  // While the camera moves a slow backend draws fewer pixels, and the whole picture afterwards.
  frame->shown.stats.frame_ms = frame->shown.stats.stage_ms[static_cast<int>(Stage::blend)] = 250;
  requests.learn(*frame);
  apply(call(action::orbit, glm::dvec2(1, 1)));
  requests.update(viewer(), thread_, false);
  frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.divisor, 3);
  apply(call(action::tick, Turn{viewer().now + 0.3}, 0.0));
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());  // the window does not show that frame yet
  for (const int divisor : {2, 1}) {
    apply(call(action::frame_shown, frame->shown));
    requests.update(viewer(), thread_, false);
    frame = settle();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->shown.divisor, divisor);
    requests.update(viewer(), thread_, false);
    EXPECT_FALSE(settle());
  }
  apply(call(action::frame_shown, frame->shown));
  // Once the view is still and the window rests, the numbers of all modes, if the table is open.
  requests.update(viewer(), thread_, true);
  EXPECT_FALSE(settle());
  EXPECT_EQ(viewer().numbers.version, -1);
  press("F10");
  requests.update(viewer(), thread_, false);
  frame = settle();  // the same picture, with the pairs of all modes
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->shown.mode_pairs.empty());
  apply(call(action::frame_shown, frame->shown));
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());
  EXPECT_EQ(viewer().numbers.version, -1);
  requests.update(viewer(), thread_, true);
  settle();
  EXPECT_EQ(viewer().numbers.version, viewer().view_version);
  change([](Viewer& viewer) { viewer.reduce_when_moving = false; });
  apply(call(action::orbit, glm::dvec2(1, 1)));
  requests.update(viewer(), thread_, false);
  EXPECT_EQ(settle()->shown.divisor, 1);
  change([](Viewer& viewer) {
    viewer.zoom.running = true;
    ++viewer.version;
  });
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());
}

// ---- the zoom recorder --------------------------------------------------------------------------
class ZoomJobs : public ViewerJobs {
 protected:
  void plan(const ZoomPlan& plan) { apply(call(action::change_zoom_plan, plan)); }
  const ZoomRecord& record() {
    press("Shift+Z");
    settle();
    return viewer().zoom.records.back();
  }
};

TEST_F(ZoomJobs, a_zoom_has_twenty_frames_of_every_mode_and_step) {
  ZoomPlan three;
  three.steps = 3;
  plan(three);
  const ZoomRecord& zoom = record();
  EXPECT_FALSE(viewer().zoom.running);
  EXPECT_EQ(&zoom, shown_zoom(viewer().zoom));
  EXPECT_EQ(zoom.steps, 3);
  EXPECT_EQ(zoom.closest, 0.05);
  ASSERT_THAT(zoom.rows, SizeIs(3 * culler_count()));
  for (const BenchRow& row : zoom.rows) {
    EXPECT_EQ(row.frames, 20u);
    EXPECT_TRUE(row.ms_spread);
    EXPECT_EQ(row.width, 96);
  }
  EXPECT_EQ(zoom.folder, scenes_ / "zoom/random scene_0001");
  EXPECT_EQ(zoom.scene, "random scene");
  EXPECT_EQ(zoom.pipeline, "cpu");
}

TEST_F(ZoomJobs, the_plan_sets_start_end_modes_and_size) {
  ZoomPlan some;
  some.steps = 2;
  some.closer = 4;
  some.modes = {5, 1};
  some.size = {48, 32};
  some.start = viewer().camera;
  plan(some);
  apply(call(action::orbit, glm::dvec2(9, 3)));
  const ZoomBundle bundle = read_zoom_json(record().folder / "zoom.json");
  EXPECT_EQ(bundle.closest, 0.25);
  EXPECT_EQ(bundle.steps, 2);
  EXPECT_THAT(bundle.modes, ElementsAre(1, 5));
  EXPECT_EQ(bundle.start.width, 48);
  EXPECT_EQ(bundle.start.view_from_world, some.start->view_from_world);
  EXPECT_THAT(bundle.rows, SizeIs(4));
}

TEST_F(ZoomJobs, the_end_is_at_the_distance_of_a_nearer_view) {
  apply(call(action::end_zoom_here));
  settle();
  EXPECT_EQ(viewer().zoom.plan.closer, 20) << "without a start";
  apply(call(action::start_zoom_here));
  const Camera start = viewer().camera;
  const auto target = find_point(uploaded(), start, viewer().settings, center_pixel(start));
  ASSERT_TRUE(target);
  apply(call(action::set_camera, moved_to(start, glm::mix(start.position(), *target, 0.75))));
  apply(call(action::end_zoom_here));
  settle();
  EXPECT_NEAR(viewer().zoom.plan.closer, 4, 1e-9);
  apply(call(action::set_camera, moved_to(start, glm::mix(start.position(), *target, -1.0))));
  apply(call(action::end_zoom_here));
  settle();
  EXPECT_NEAR(viewer().zoom.plan.closer, 4, 1e-9);
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("not nearer to the target"));
}

TEST_F(ZoomJobs, recordings_of_earlier_sessions_are_found_once_and_damaged_ones_are_left_out) {
  ZoomPlan two;
  two.steps = 2;
  plan(two);
  const std::filesystem::path first = record().folder;
  std::filesystem::create_directories(scenes_ / "zoom/damaged");
  std::ofstream(scenes_ / "zoom/damaged/zoom.json") << "{}";
  std::filesystem::create_directories(scenes_ / "zoom/empty");
  apply(call(action::find_zooms));
  settle();
  EXPECT_THAT(viewer().zoom.records, SizeIs(1)) << "this session's own";
  change([](Viewer& viewer) { viewer.zoom = ZoomRecorder(); });
  apply(call(action::find_zooms));
  apply(call(action::find_zooms));
  settle();
  ASSERT_THAT(viewer().zoom.records, SizeIs(1));
  EXPECT_EQ(viewer().zoom.records[0].folder, first);
  EXPECT_THAT(viewer().zoom.records[0].rows, SizeIs(2 * culler_count()));
  EXPECT_FALSE(viewer().zoom.shown);
}

TEST_F(ZoomJobs, nothing_is_recorded_towards_an_empty_middle) {
  Camera away = viewer().camera;
  away.view_from_world[3].z = -1e4;  // far behind the camera
  apply(call(action::set_camera, away));
  press("Shift+Z");
  settle();
  EXPECT_FALSE(viewer().zoom.running);
  EXPECT_FALSE(viewer().zoom.starting);
  EXPECT_THAT(viewer().zoom.records, SizeIs(0));
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("nothing to zoom to"));
}

TEST_F(ZoomJobs, a_stopped_zoom_ends_at_its_last_step_and_a_cancelled_one_is_not_saved) {
  ZoomPlan many;
  many.steps = 200;
  many.modes = {1};
  plan(many);
  const auto measure_some = [&] {
    press("Shift+Z");
    const auto measured = [&] {
      return viewer().zoom.running && viewer().zoom.records.back().rows.size() >= 3;
    };
    while (!measured() && thread_.busy()) take_reports();
    EXPECT_THAT(running_text(viewer()),
                testing::MatchesRegex("recording a zoom, step [0-9]+ of 200.*"));
  };
  measure_some();
  press("Shift+Z");
  settle();
  EXPECT_FALSE(viewer().zoom.running);
  const ZoomRecord& record = viewer().zoom.records.back();
  const ZoomBundle bundle = read_zoom_json(record.folder / "zoom.json");
  EXPECT_EQ(static_cast<std::size_t>(bundle.steps), bundle.rows.size());
  EXPECT_GE(bundle.steps, 3);
  EXPECT_LT(bundle.steps, 200);
  // The steps have the views that were measured.
  EXPECT_NEAR(zoom_factor(bundle.rows[2], bundle.steps, bundle.closest),
              zoom_factor(bundle.rows[2], 200, 0.05), 1e-9);
  measure_some();
  apply(call(action::cancel_running));
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("the zoom was stopped, nothing was saved"));
  EXPECT_TRUE(viewer().zoom.records.back().folder.empty());
}

TEST_F(ZoomJobs, nothing_is_measured_for_a_folder_that_cannot_be_written) {
  change([&](Viewer& viewer) { viewer.out_dir = scenes_ / "random scene.ply"; });
  for (const char* key : {"Shift+Z", "P"}) {
    press(key);
    settle();
    EXPECT_TRUE(viewer().toasts.back().error);
    EXPECT_THAT(viewer().toasts.back().text, HasSubstr("cannot be created"));
  }
  EXPECT_THAT(viewer().zoom.records, SizeIs(0));
  EXPECT_FALSE(viewer().zoom.starting);
  EXPECT_EQ(viewer().numbers.version, -1);
}

TEST_F(ZoomJobs, results_that_cannot_be_written_stay_and_are_saved_elsewhere) {
  ZoomPlan two;
  two.steps = 2;
  two.modes = {1};
  plan(two);
  press("Shift+Z");
  while (!viewer().zoom.running && thread_.busy()) take_reports();
  std::ofstream(scenes_ / "zoom") << "a file in the place of the folder";
  settle();
  EXPECT_EQ(viewer().unsaved_results, "zoom");
  EXPECT_EQ(viewer().toasts.back().offer, ToastOffer::save_results);
  EXPECT_EQ(zoom_status(viewer().zoom), "all 2 steps, not saved");
  change([&](Viewer& viewer) { viewer.out_dir = scenes_ / "later"; });
  press("P");
  while (!viewer().loading && thread_.busy()) take_reports();
  std::ofstream(scenes_ / "later") << "a file too";
  settle();
  EXPECT_EQ(viewer().unsaved_results, "zoom and a bench");
  apply(call(action::path_chosen, scenes_ / "random scene.ply", Choosing::results));
  settle();
  EXPECT_EQ(viewer().unsaved_results, "zoom and a bench") << "not there either";
  apply(call(action::path_chosen, scenes_ / "elsewhere", Choosing::results));
  settle();
  EXPECT_EQ(viewer().unsaved_results, "");
  const std::filesystem::path folder = scenes_ / "elsewhere/zoom/random scene_0001";
  EXPECT_EQ(viewer().zoom.records.back().folder, folder);
  EXPECT_THAT(read_zoom_json(folder / "zoom.json").rows, SizeIs(2));
  EXPECT_TRUE(std::filesystem::exists(scenes_ / "elsewhere/bench/random scene_0001/bench.json"));
}

TEST_F(ViewerJobs, a_bench_says_if_its_rows_are_noisy) {
  press("P");
  settle();
  const std::vector<BenchRow>& rows = viewer().numbers.rows;
  const auto noisy = std::ranges::count_if(rows, is_noisy);
  EXPECT_THAT(viewer().toasts.back().text,
              HasSubstr(noisy == 0 ? std::string("no row is noisy")
                                   : fmt::format("{} of {} rows are noisy: do not publish these",
                                                 noisy, rows.size())));
  EXPECT_FALSE(viewer().loading);
}

TEST_F(ViewerJobs, the_candidates_for_the_first_view_are_side_by_side) {
  std::vector<Framing> views(2);
  views[0].eye = {0, 0, -4};
  views[1].eye = {4, 0, 0.5};
  change([&](Viewer& viewer) {
    viewer.scene->candidates = views;
    viewer.view_choice.wanted = true;
  });
  if (auto frame = draw(full_frame(viewer()))) change([&](Viewer& v) { v.shown = frame->shown; });
  apply(call(action::follow_view_choice));
  settle();
  ASSERT_NE(viewer().view_choice.pictures, nullptr);
  const Image& strip = *viewer().view_choice.pictures;
  EXPECT_EQ(strip.width, 480);
  EXPECT_EQ(strip.height, 135);
  const auto renderer = make_renderer(Backend::cpu, test::pool(1));
  renderer->upload(test::random_cloud(300, 1, 5), {});
  for (int i = 0; i < 2; ++i) {
    const Camera camera = framed_camera(views[static_cast<std::size_t>(i)], 240, 135);
    const Image expected = renderer->render(camera, viewer().settings).color;
    for (int y = 0; y < 135; ++y) {
      for (int x = 0; x < 240; ++x) ASSERT_EQ(strip.at(240 * i + x, y, 1), expected.at(x, y, 1));
    }
  }
}

}  // namespace
}  // namespace qs
