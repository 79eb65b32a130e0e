// SPDX-License-Identifier: MIT
//
// Drawings compared with pictures in tests/golden/drawings. No picture is square and no data is
// symmetric, so that exchanged coordinates and shifted pixels are noticed.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "app/inspect/comparison_sheet.h"
#include "app/inspect/construction.h"
#include "app/inspect/picture_pair.h"
#include "app/picture/canvas.h"
#include "app/picture/heatmap.h"
#include "app/picture/image_difference.h"
#include "app/picture/palette.h"
#include "raster/scene/image_metrics.h"
#include "support/golden.h"
#include "support/inspector.h"

namespace qs {
namespace {

void expect_golden(const std::string& name, const Image& image) {
  test::expect_golden_image("drawings/" + name + ".png", image);
}

/// The same at 1/factor of its size, for large drawings. Every pixel still counts.
void expect_golden_reduced(const std::string& name, const Image& image, int factor) {
  ThreadPool pool(1);
  Image clamped = image;
  clamp_to_unit(clamped);
  expect_golden(name, area_average(clamped, image.width / factor, image.height / factor, pool));
}

/// A smooth picture that differs in x, y and all channels.
Image gradient(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = static_cast<float>(x) / static_cast<float>(width);
      image.at(x, y, 1) = static_cast<float>(y) / static_cast<float>(height);
      image.at(x, y, 2) = 0.25f + 0.5f * static_cast<float>(x / 8 % 2);
    }
  }
  return image;
}

Heatmap heatmap_of(HeatQuantity quantity, int width, int height, int cell_px) {
  Heatmap map;
  map.quantity = quantity;
  map.cell_px = cell_px;
  map.columns = (width + cell_px - 1) / cell_px;
  map.rows = (height + cell_px - 1) / cell_px;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.columns; ++x)
      map.values.push_back(static_cast<std::uint32_t>(400 * x / map.columns + 100 * y));
  }
  sum_up(map);
  return map;
}

TEST(Drawings, heat_map_with_a_narrow_legend) {
  const Heatmap map = heatmap_of(HeatQuantity::pairs, 310, 41, 16);
  expect_golden("heatmap_narrow", draw_heatmap(gradient(310, 41), map, round_scale(450), "adr"));
}

TEST(Drawings, heat_map_of_pixels_with_its_legend_in_one_line) {
  const Heatmap map = heatmap_of(HeatQuantity::evaluated, 760, 20, 1);
  expect_golden("heatmap_pixels",
                draw_heatmap(gradient(760, 20), map, round_scale(2000), "quadbox"));
}

TEST(Drawings, heat_map_with_a_share_and_larger_text) {
  Heatmap map = heatmap_of(HeatQuantity::false_positive, 1500, 24, 32);
  map.whole = 3 * map.total;
  expect_golden("heatmap_share", draw_heatmap(gradient(1500, 24), map, round_scale(300), "3dgs"));
}

TEST(Drawings, heat_map_with_the_largest_text) {
  Image flat(2460, 4, 3);
  Heatmap map = heatmap_of(HeatQuantity::missed, 2460, 4, 1);
  expect_golden_reduced("heatmap_large", draw_heatmap(flat, map, round_scale(7), "dualbox"), 4);
}

TEST(Drawings, contact_sheet_of_views_of_two_sizes) {
  ThreadPool& pool = test::pool(1);
  std::vector<SheetRow> rows;
  for (const int width : {150, 220}) {
    Image judged = gradient(width, 90);
    for (int x = 20; x < 80; ++x)
      for (int y = 30; y < 60; ++y) judged.at(x, y, 0) += 0.05f;
    rows.push_back(sheet_row(
        judge_pictures("view " + std::to_string(width), gradient(width, 90), judged, pool), 180,
        pool));
  }
  EXPECT_EQ(flip_scale(rows), 0.2);
  expect_golden_reduced("contact_sheet", draw_contact_sheet(rows, "truth", "judged", 0.2), 2);
}

TEST(Drawings, the_error_scale_is_the_least_round_number_that_almost_all_errors_meet) {
  const auto scale_of = [](float most, float outlier = 0) {
    SheetRow row;
    row.flip = Image(100, 10, 1);
    row.flip.values.assign(1000, most);
    row.flip.values.front() = std::max(most, outlier);
    return flip_scale({&row, 1});
  };
  EXPECT_EQ(flip_scale({}), 1);
  EXPECT_EQ(scale_of(0), 0.05);
  EXPECT_EQ(scale_of(0.04f, 1), 0.05) << "a pixel of 1,000";
  EXPECT_EQ(scale_of(0.06f), 0.1);
  EXPECT_EQ(scale_of(0.15f), 0.2);
  EXPECT_EQ(scale_of(0.3f), 0.5);
  EXPECT_EQ(scale_of(0.6f), 1);
}

TEST(Drawings, lines_and_polygons) {
  Image image = gradient(110, 70);
  const glm::vec2 open[] = {{5.5f, 8}, {40, 20.25f}, {12, 33}};
  stroke(image, open, false, {{1, 1, 1}, 3});
  const glm::vec2 closed[] = {{50.3f, 6}, {90, 11}, {60, 30.7f}};
  stroke(image, closed, true, {{1, 0, 0}, 0.6f});
  stroke(image, open, true, {{0, 0, 0}, 1.5f, 0.5f, 4});
  const glm::vec2 dashed[] = {{100, 5}, {104, 66}, {70, 66}};
  stroke(image, dashed, false, {{1, 1, 0}, 4, 0.8f, 7});
  const glm::vec2 star[] = {{30, 38}, {40, 66}, {14, 48.5f}, {46, 48}, {20, 65}};
  fill_polygon(image, star, {0, 1, 1}, 0.75f);
  const glm::vec2 beyond[] = {{-20, 60}, {130, 50}, {60, 90}};
  fill_polygon(image, beyond, {0.1f, 0.1f, 0.1f}, 0.4f);
  const glm::vec2 thin[] = {{70.2f, 35.1f}, {95.7f, 35.6f}, {95.7f, 36.3f}, {70.2f, 35.9f}};
  fill_polygon(image, thin, {1, 1, 1}, 1);
  const glm::vec2 point[] = {{85, 45}, {85, 45}};
  stroke(image, point, false, {{0, 0, 1}, 8});
  expect_golden("strokes", image);
}

TEST(Drawings, text_rectangles_and_pasted_pictures) {
  Image image(260, 100, 3);
  fill_rect(image, {0, 0, 260, 100}, {0.9f, 0.9f, 0.95f});
  fill_rect(image, {-5, 70, 40, 50}, {0.2f, 0.5f, 0.1f});
  fill_rect(image, {240, -9, 50, 25}, {0.8f, 0.2f, 0.1f});
  const Font small(13), large(30), least(2);
  EXPECT_EQ(draw_text(image, large, {10, 4}, "Tile \u00d7 16", {0, 0, 0}),
            large.width("Tile \u00d7 16"));
  draw_text(image, small, {130, 45}, "centred, j\u00e9\u00df", {0.6f, 0, 0}, Align::center);
  draw_text(image, small, {250, 62}, "right 1,234.5", {0, 0, 0.7f}, Align::right);
  draw_text(image, least, {45, 85}, "at least 8 pixels \u2026", {0, 0.4f, 0.2f});
  draw_text(image, small, {220, 92}, "clipped off", {0, 0, 0});
  draw_text(image, small, {-20, 40}, "clipped", {0, 0, 0});
  const Image part = gradient(37, 21);
  paste(image, part, {180, 20});
  paste(image, part, {-10, -8});
  paste(image, cropped(part, {9, 4, 20, 14}), {245, 80});
  expect_golden("text", image);
}

TEST(Drawings, comparison_sheet) {
  ViewComparison comparison;
  comparison.truth_name = "reference";
  comparison.truth = gradient(90, 50);
  comparison.crop = {30, 12, 66, 36};
  for (int i = 0; i < 2; ++i) {
    ViewVariant& variant = comparison.variants.emplace_back();
    variant.name = i == 0 ? "dualbox" : "quadbox, cuda fast";
    variant.color = comparison.truth;
    fill_rect(variant.color, {40 + 10 * i, 15 + 9 * i, 7, 4}, {0.5f, 0.4f, 0.35f});
    variant.psnr = 31.25 + 10 * i;
    variant.largest = 77 - i;
    variant.stats.tile_pairs = i == 0 ? 1234567 : 0;
    variant.stats.used_pairs = 1000000;
  }
  ThreadPool pool(2);
  expect_golden("comparison", draw_comparison(comparison, 3, "plush, camera 7", pool));
}

TEST(Drawings, comparison_sheet_of_a_tall_crop) {
  ViewComparison comparison;
  comparison.truth_name = "exact";
  comparison.truth = gradient(40, 90);
  comparison.crop = {2, 3, 22, 83};
  comparison.variants.push_back({"3dgs", gradient(40, 90), {}, INFINITY, 0, {}});
  ThreadPool pool(1);
  expect_golden_reduced("comparison_tall", draw_comparison(comparison, 1, "tall", pool), 4);
}

TEST(Drawings, differences_are_amplified_inside_the_box) {
  const Image truth = gradient(60, 40);
  Image other = truth;
  for (int y = 5; y < 30; ++y) {
    for (int x = 10; x < 50; ++x) other.at(x, y, y % 3) += 0.001f * static_cast<float>(x - 2 * y);
  }
  expect_golden("difference", amplified_difference(other, truth, {8, 3, 55, 33}, 9));
}

TEST(Drawings, canvas_of_a_frame_that_ends_inside_the_window) {
  const TileGrid grid{3, 2, 16};
  FrameCanvas canvas({{-18, -10}, {62, 40}}, {330, 220});
  canvas.draw_frame(gradient(44, 29), 0.6f);
  canvas.draw_grid(grid, {44, 29});
  canvas.fill_box(box_of_tile(grid, 4), {0.9f, 0.2f, 0}, 0.5f);
  canvas.outline_box(box_of_tile(grid, 2), {{0, 0.5f, 0}, 3});
  canvas.fill_box({{3, 4}, {21, 9}}, {0, 0, 1}, 0.4f);
  canvas.outline_box({{-9, 12}, {14, 33}}, {{0, 0, 0}, 2, 1, 6});
  canvas.draw_dot({30, 5}, 4, {1, 0, 1});
  canvas.draw_line({2, 36}, {58, 30}, {{0.5f, 0.1f, 0.1f}, 1.5f});
  canvas.draw_ellipse(make_footprint({34, 18}, {90, 35, 30}, 2.5f), {{0, 0.3f, 0.6f}, 2}, 0.3f);
  expect_golden("canvas", canvas.picture());
  EXPECT_EQ(FrameCanvas({{0, 0}, {4, 2}}, {900, 900}).scale(), 40) << "not enlarged without limit";
  EXPECT_EQ(FrameCanvas({{0, 0}, {4, 2}}, {900, 900}, 7).picture().width, 28);
}

class Construction : public testing::Test {
 protected:
  /// A frame with one long Gaussian at `angle` among others that hide parts of it.
  Image draw(glm::vec3 log_scales, float angle, float opacity_logit, glm::ivec2 pixel) {
    GaussianCloud cloud =
        test::single_gaussian({0.1f, -0.05f, 4}, 0.1f, {0.9f, 0.4f, 0.2f}, opacity_logit);
    cloud.log_scales[0] = log_scales;
    cloud.rotations[0] = glm::quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
    for (int i = 0; i < 6; ++i)
      test::append(cloud, test::single_gaussian({0.8f, 0.36f, 2.0f + 0.01f * static_cast<float>(i)},
                                                0.2f, {0.2f, 0.3f, 0.7f}, 9));
    ThreadPool pool(2);
    const auto renderer = make_renderer(Backend::cpu, pool);
    renderer->upload(cloud, {});
    const Camera camera = test::front_camera(250, 170);
    RenderSettings settings;
    settings.mode = find_culler("3dgs");
    const Frame& frame = renderer->render(camera, settings, inspection_outputs());
    const Inspection inspection = inspect(frame, {250, 170}, pixel, {0.1f, 0.2f, 0.3f}, 0u);
    return draw_construction({inspection, frame.color, frame.grid, "plush, camera 3"});
  }
};

TEST_F(Construction, of_a_gaussian_that_qpass_walks_in_rows) {
  expect_golden_reduced("construction_rows", draw({-0.5f, -2.2f, -2}, 0.5f, 3, {150, 90}), 3);
}

TEST_F(Construction, of_a_gaussian_that_qpass_walks_in_columns) {
  expect_golden_reduced("construction_columns", draw({-3, -1.2f, -2}, 0.35f, -1, {101, 60}), 3);
}

TEST_F(Construction, of_a_gaussian_that_is_too_faint_for_an_ellipse) {
  expect_golden_reduced("construction_faint", draw({-2, -2.2f, -2}, 0.5f, -5.6f, {125, 85}), 4);
}

}  // namespace
}  // namespace qs
