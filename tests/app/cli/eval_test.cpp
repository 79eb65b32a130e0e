// SPDX-License-Identifier: MIT
//
// quadsplat eval as users run it, on a generated scene whose photographs are its own renders.
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/report/eval_report.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "io/scene/writer.h"
#include "raster/api/renderer.h"
#include "raster/scene/image_metrics.h"
#include "support/lpips_weights.h"
#include "support/pool.h"
#include "support/safetensors.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::EndsWith;
using testing::HasSubstr;

constexpr int kViews = 9;

class Eval : public testing::Test {
 protected:
  // Nine cameras, not in the order of their names, and their renders as exact pictures.
  void SetUp() override {
    const GaussianCloud cloud = test::random_cloud(400, 1, 5);
    test::write_scene(cloud, folder_ / "scene.ply");
    std::filesystem::create_directories(folder_ / "images");
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    renderer->upload(cloud, {});
    std::vector<Camera> cameras;
    for (int i = kViews; i-- > 0;) {
      Camera camera = test::front_camera(60, 40);
      camera.view_from_world[3].x = 0.05 * i;
      camera.name = "view" + std::to_string(i);
      cameras.push_back(camera);
      Image image = renderer->render(camera).color;
      clamp_to_unit(image);
      write_image(image, photograph(i));
    }
    test::write_cameras(cameras, folder_ / "cameras.json");
  }

  std::filesystem::path photograph(int i) const {
    return folder_ / ("images/view" + std::to_string(i) + ".pfm");
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun eval(std::vector<std::string> options) const {
    options.insert(options.begin(),
                   {"eval", path("scene.ply"), "--backend", "cpu", "--images", path("images")});
    return run_quadsplat(options);
  }

  // The JSON report of a run that succeeds.
  json report(std::vector<std::string> options) const {
    options.insert(options.end(), {"--json", "-"});
    const ProgramRun run = eval(options);
    EXPECT_EQ(run.exit_code, kExitOk) << run.err;
    return parse_json(run.out, "test");
  }

  static std::vector<std::string> names(const json& report) {
    std::vector<std::string> result;
    for (const json& view : report["views"]) result.push_back(view["name"]);
    return result;
  }

  TemporaryFolder folder_;
};

TEST_F(Eval, a_scene_equals_its_own_renders) {
  const json result = report({"--cull", "quadbox"});
  ASSERT_EQ(result["views"].size(), static_cast<std::size_t>(kViews));
  for (const json& view : result["views"]) {
    EXPECT_TRUE(view["psnr"].is_null() || view["psnr"] > 100) << view["psnr"];
    EXPECT_NEAR(view["ssim"].get<double>(), 1, 1e-9);
  }
  EXPECT_EQ(result["means"][0]["mode"], "quadbox");
  EXPECT_EQ(result["means"][0]["views"], kViews);
  EXPECT_EQ(result["environment"]["backend"], "cpu");
  EXPECT_EQ(result["scene"]["gaussians"], 400);
}

TEST_F(Eval, the_table_has_a_line_per_view_and_mode_and_the_means) {
  const ProgramRun run = eval({"--cull", "quadbox,3dgs", "--csv", path("q.csv")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1 + 2 * kViews + 2);
  EXPECT_THAT(run.out, HasSubstr("mean of 9  quadbox "));
  EXPECT_THAT(run.out, HasSubstr("mean of 9  3dgs "));
  std::ifstream file(folder_ / "q.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_THAT(line, EndsWith(",psnr,ssim"));
  std::getline(file, line);
  EXPECT_THAT(line, HasSubstr("scene.ply,view0,quadbox,cpu,400,60,40,60,40,inf,1.0"));
}

TEST_F(Eval, values_are_those_of_the_definitions_at_the_photograph_s_size) {
  ThreadPool pool(2);
  std::map<std::string, Image> renders;
  for (int i = 0; i < kViews; ++i) {
    Image image = read_image(photograph(i));
    renders["view" + std::to_string(i)] = image;
    image = area_average(image, 30, 20, pool);
    for (float& value : image.values) value = 0.9f * value + 0.05f;
    write_image(image, photograph(i));
  }
  const json result = report({});
  double sum = 0;
  for (const json& view : result["views"]) {
    const std::string name = view["name"];
    const Image render = area_average(renders[name], 30, 20, pool);
    const Image truth = read_image(folder_ / ("images/" + name + ".pfm"));
    EXPECT_NEAR(view["psnr"], psnr(render, truth, pool), 1e-9);
    EXPECT_NEAR(view["ssim"], ssim(render, truth, pool), 1e-9);
    EXPECT_EQ(view["compared_width"], 30);
    sum += view["psnr"].get<double>();
  }
  EXPECT_NEAR(result["means"][0]["psnr"], sum / kViews, 1e-9);
}

TEST_F(Eval, ssim_border_crop_leaves_out_the_pixels_at_the_border) {
  ThreadPool pool(2);
  const Image render = read_image(photograph(0));
  Image truth = render;
  for (int x = 0; x < truth.width; ++x) truth.at(x, 20, 0) = 1;
  truth.at(0, 0, 1) += 0.5f;  // counts with zeros only
  write_image(truth, photograph(0));
  for (const auto& [name, border] :
       {std::pair{"zeros", SsimBorder::zeros}, {"crop", SsimBorder::crop}}) {
    const json result = report({"--ssim-border", name});
    EXPECT_NEAR(result["views"][0]["ssim"], ssim(render, truth, pool, border), 1e-6) << name;
  }
  const ProgramRun run = eval({"--ssim-border", "crop", "--images-scale", "4"});
  EXPECT_EQ(run.exit_code, kExitUsage);
  EXPECT_THAT(run.err, HasSubstr("has 15 x 10 pixels, and 11 at least are needed"));
}

TEST_F(Eval, holdout_takes_every_nth_view_by_name) {
  EXPECT_THAT(names(report({"--holdout", "8"})), testing::ElementsAre("view0", "view8"));
  EXPECT_THAT(names(report({"--holdout", "4"})), testing::ElementsAre("view0", "view4", "view8"));
}

TEST_F(Eval, the_images_scale_divides_the_photograph_s_size) {
  const json result = report({"--images-scale", "4"});
  EXPECT_EQ(result["views"][0]["compared_width"], 15);
  EXPECT_EQ(result["views"][0]["compared_height"], 10);
  EXPECT_TRUE(result["views"][0]["psnr"].is_null() || result["views"][0]["psnr"] > 100);
}

TEST_F(Eval, views_without_a_photograph_are_counted_and_left_out) {
  for (int i = 2; i < kViews; ++i) std::filesystem::remove(photograph(i));
  const ProgramRun run = eval({});
  EXPECT_EQ(run.exit_code, kExitOk);
  EXPECT_THAT(run.err, HasSubstr("2 of 9 cameras in "));
  EXPECT_THAT(run.out, HasSubstr("mean of 2"));
}

TEST_F(Eval, saved_pictures_are_what_was_compared) {
  ASSERT_EQ(eval({"--holdout", "8", "--cull", "adr,exact", "--save", path("deep/er"),
                  "--save-format", "pfm"})
                .exit_code,
            kExitOk);
  for (const char* name :
       {"view_view0_photograph.pfm", "view_view0_adr.pfm", "view_view8_exact.pfm"})
    ASSERT_TRUE(std::filesystem::exists(folder_ / "deep/er" / name)) << name;
  EXPECT_EQ(read_image(folder_ / "deep/er/view_view0_photograph.pfm").values,
            read_image(photograph(0)).values);
}

TEST_F(Eval, lpips_is_computed_for_both_ranges_of_the_network_s_input) {
  const lpips::Weights weights = test::golden_weights(lpips::kNetworks[1]);
  test::write_lpips_weights(weights, folder_ / "alexnet.safetensors");
  const Image render = read_image(photograph(0));
  Image truth = render;
  for (float& value : truth.values) value = 0.8f * value + 0.1f;
  write_image(truth, photograph(0));
  const json result =
      report({"--holdout", "8", "--cull", "adr,quadbox", "--lpips", path("alexnet.safetensors")});
  ASSERT_EQ(result["views"].size(), 4u);
  const lpips::Metric metric(weights);
  const double paper = metric.distance(render, truth, lpips::InputRange::unit, test::pool());
  const double usual = metric.distance(render, truth, lpips::InputRange::symmetric, test::pool());
  EXPECT_NE(paper, usual);
  for (const std::size_t mode : {0u, 1u}) {  // lossless modes
    EXPECT_NEAR(result["views"][mode]["lpips_paper"], paper, 1e-6 * paper);
    EXPECT_NEAR(result["views"][mode]["lpips"], usual, 1e-6 * usual);
    EXPECT_LT(result["views"][2 + mode]["lpips"], 1e-6);
    EXPECT_NEAR(result["means"][mode]["lpips_paper"], paper / 2, 1e-6 * paper);
    EXPECT_NEAR(result["means"][mode]["lpips"], usual / 2, 1e-6 * usual);
  }
  EXPECT_EQ(result["method"]["lpips"]["network"], "alexnet");
  EXPECT_FALSE(report({"--holdout", "8"})["method"].contains("lpips"));
}

TEST_F(Eval, weights_of_lpips_that_do_not_fit_are_refused) {
  const auto expect = [&](const lpips::Weights& weights, const std::string& sentence) {
    test::write_lpips_weights(weights, folder_ / "w.safetensors");
    const ProgramRun run = eval({"--lpips", path("w.safetensors")});
    EXPECT_EQ(run.exit_code, kExitInput);
    EXPECT_EQ(run.err, "quadsplat: " + path("w.safetensors") + ": " + sentence + "\n");
  };
  lpips::Network network = lpips::kNetworks[1];
  lpips::Weights weights = test::golden_weights(network);
  weights.network = &network;
  network.name = "resnet";
  expect(weights, "its metadata name another network than vgg16 or alexnet");
  network.name = "vgg16";
  expect(weights, "features.0.weight has the shape (64, 3, 11, 11) instead of (64, 3, 3, 3)");
  network.name = "alexnet";
  weights.biases[4][7] = std::nanf("");
  expect(weights, "features.10.bias has a value that is not a finite number");
  network.convolutions = network.convolutions.first(4);
  weights.filters.pop_back();
  weights.biases.pop_back();
  expect(weights, "features.10.weight is missing");
  std::ofstream(folder_ / "w.safetensors", std::ios::binary) << "no weights";
  EXPECT_THAT(eval({"--lpips", path("w.safetensors")}).err, HasSubstr("w.safetensors: cut off"));
  EXPECT_THAT(eval({"--lpips", path("nowhere")}).err, HasSubstr("nowhere: cannot be opened"));

  test::write_lpips_weights(test::golden_weights(lpips::kNetworks[1]), folder_ / "w.safetensors");
  const ProgramRun small = eval({"--lpips", path("w.safetensors"), "--images-scale", "2"});
  EXPECT_EQ(small.exit_code, kExitUsage);
  EXPECT_THAT(small.err, HasSubstr("has 30 x 20 pixels, and alexnet needs 31 x 31 at least"));
}

TEST_F(Eval, wrong_use_ends_with_one_sentence) {
  const auto expect_failure = [](const ProgramRun& run, int exit_code, const std::string& part) {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_THAT(run.err, HasSubstr(part));
    // Only the line about the data may stand before the sentence.
    const auto lines = std::count(run.err.begin(), run.err.end(), '\n');
    EXPECT_EQ(lines, run.err.find(" cameras in ") == run.err.npos ? 1 : 2) << run.err;
  };
  expect_failure(run_quadsplat({"eval", path("scene.ply")}), kExitUsage, "--images is required");
  expect_failure(eval({"--holdout", "0"}), kExitUsage, "--holdout");
  expect_failure(eval({"--csv", "-", "--json", "-"}), kExitUsage, "cannot both go to stdout");
  expect_failure(eval({"--images", path("nowhere")}), kExitInput, "nowhere: not a folder");
  expect_failure(eval({"--cameras", path("nowhere")}), kExitInput, "nowhere: cannot be read");
  std::filesystem::create_directories(folder_ / "empty");
  const ProgramRun none = eval({"--images", path("empty")});
  expect_failure(none, kExitInput,
                 path("empty") + ": holds no photograph named like one of the 9 views of");
  EXPECT_THAT(none.err, HasSubstr(path("cameras.json")));
  write_image(Image(60, 30, 3), photograph(4));
  expect_failure(eval({}), kExitInput,
                 "view4.pfm: 60 x 30 pixels do not have the aspect ratio of its camera");
  std::filesystem::remove(folder_ / "cameras.json");
  expect_failure(eval({}), kExitInput, "name their file with --cameras");
}

TEST(EvalReport, every_number_stands_in_its_column) {
  EvalReport report;
  report.environment = {{"backend", "cpu"}};
  report.scene = {{"file", "a/plush.ply"}, {"gaussians", 400}};
  Camera camera = test::front_camera(60, 40);
  camera.name = "left";
  report.rows = {{camera, "left.png", 30, 20, find_culler("3dgs"), 31.5, 0.75, 0},
                 {camera, "left.png", 30, 20, find_culler("3dgs"), 32.5, 0.25, 1},
                 {camera, "left.png", 30, 20, find_culler("adr"), 40, 0.5, 1}};
  EXPECT_THAT(format_eval_csv(report),
              EndsWith("\nplush.ply,left,adr,cpu,400,60,40,30,20,40.000000,0.50000000\n"));
  const std::string table = format_eval_table(report);
  EXPECT_THAT(table, HasSubstr("\nleft       3dgs             31.50  0.7500\n"));
  EXPECT_THAT(table, HasSubstr("\nmean of 2  3dgs             32.00  0.5000\n"));
  EXPECT_THAT(table, EndsWith("\nmean of 1  adr              40.00  0.5000\n"));

  report.rows[0].lpips = {0.125, 0.25};
  report.rows[1].lpips = {0.375, 0.5};
  report.rows[2].lpips = {0.5, 1.5};
  const std::string csv = format_eval_csv(report);
  EXPECT_THAT(csv, HasSubstr(",psnr,ssim,lpips_paper,lpips\n"));
  EXPECT_THAT(csv, EndsWith(",40.000000,0.50000000,0.50000000,1.50000000\n"));
  const std::string wide = format_eval_table(report);
  EXPECT_THAT(wide, HasSubstr(" PSNR dB    SSIM  LPIPS (paper)   LPIPS\n"));
  EXPECT_THAT(wide,
              HasSubstr("\nleft       3dgs             31.50  0.7500         0.1250  0.2500\n"));
  EXPECT_THAT(wide,
              HasSubstr("\nmean of 2  3dgs             32.00  0.5000         0.2500  0.3750\n"));
  report.scene["hash"] = "1";
  report.view_count = 2;
  const EvalReport again = parse_eval_report(parse_own_json(format_eval_json(report)));
  EXPECT_EQ(format_eval_csv(again), csv);
}

TEST(Photographs, are_rgb_with_the_background_behind_them) {
  const TemporaryFolder folder;
  ThreadPool pool(1);
  Image transparent(2, 1, 4);
  transparent.values = {1, 0, 0, 1, 1, 1, 1, 0};
  write_image(transparent, folder / "a.png");
  EXPECT_EQ(read_photograph(folder / "a.png", {0, 1, 0}, 1, pool).values,
            (std::vector<float>{1, 0, 0, 0, 1, 0}));
  Image gray(3, 3, 1);
  gray.values.assign(9, 1.0f);
  write_image(gray, folder / "g.pfm");
  const Image image = read_photograph(folder / "g.pfm", {}, 2, pool);
  EXPECT_EQ(image.width, 2);
  EXPECT_NEAR(image.at(1, 1, 2), 1, 1e-6);
}

// A row of numbers for every face of a black photograph.
TEST_F(Eval, photographs_of_wide_lenses_are_compared_face_by_face) {
  struct Row {
    const char* lens;
    int width, height;
    std::size_t faces;
    const char* used;
  };
  const Row rows[] = {
      {"SIMPLE_FISHEYE 60 60 19.1 30 30", 60, 60, 5, "(SIMPLE_FISHEYE, 5 faces each, 100 % of"},
      {"EQUIRECTANGULAR 120 60 120 60", 120, 60, 6, "(EQUIRECTANGULAR, 6 faces each, 100 % of"},
      {"EUCM 60 60 20 20 30 30 0.6 1.1", 60, 60, 5, "(EUCM, 5 faces each, "},
      {"FOV 60 40 50 50 30 20 0.9", 60, 40, 1, "(FOV, undistorted, "},
  };
  const auto folder = folder_ / "wide";
  std::filesystem::create_directories(folder / "images");
  for (const Row& row : rows) {
    SCOPED_TRACE(row.lens);
    std::ofstream(folder / "cameras.txt") << "1 " << row.lens << "\n";
    std::ofstream(folder / "images.txt") << "1 1 0 0 0 0 0 3 1 a.pfm\n\n";
    write_image(Image(row.width, row.height, 3), folder / "images/a.pfm");
    const ProgramRun run = run_quadsplat({"eval", (folder_ / "scene.ply").string(), "--backend",
                                          "cpu", "--cull", "quadbox", "--cameras", folder.string(),
                                          "--images", (folder / "images").string(), "--csv", "-"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr(row.used));
    EXPECT_EQ(std::ranges::count(run.out, '\n'), static_cast<long>(row.faces) + 1) << run.out;
  }
}

// Photographs are views drawn through their lens and 0.1 brighter, with rubbish where the lens
// shows nothing.
TEST_F(Eval, photographs_are_compared_in_their_own_lens) {
  constexpr double kPi = std::numbers::pi;
  struct Row {
    const char* lens;
    int width, height;
    std::size_t faces;
    double shown;  // of the area
  };
  const Row rows[] = {
      // A circle of pi times the focal length.
      {"SIMPLE_FISHEYE 60 60 8 30 30", 60, 60, 6, kPi * kPi * kPi * 64 / 3600},
      {"OPENCV_FISHEYE 64 48 22 22 32 24 0.02 0 0 0", 64, 48, 5, 1},
      {"EQUIRECTANGULAR 120 60 120 60", 120, 60, 6, 1},
      {"EUCM 60 60 20 20 30 30 0.6 1.1", 60, 60, 5, 1},
      {"SIMPLE_RADIAL 60 40 60 30 20 -0.05", 60, 40, 1, 1},
      {"PINHOLE 60 40 60 60 30 20", 60, 40, 1, 0},
  };
  const auto folder = folder_ / "wide";
  std::filesystem::create_directories(folder / "images");
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(400, 1, 5), {});
  for (const Row& row : rows) {
    SCOPED_TRACE(row.lens);
    std::ofstream(folder / "cameras.txt") << "1 " << row.lens << "\n";
    std::ofstream(folder / "images.txt") << "1 1 0 0 0 0 0 1 1 a.pfm\n\n";
    std::string words = row.lens;
    std::ranges::replace(words, ' ', ',');
    const Lens lens = parse_lens(words.starts_with("EQUI") ? "EQUIRECTANGULAR,120,60" : words, "");
    RenderSettings settings;
    settings.lens = std::make_shared<const LensView>(photograph_view(lens));
    Camera camera = test::front_camera(row.width, row.height);
    camera.view_from_world = glm::dmat4x3(1.0);
    camera.view_from_world[3] = {0, 0, 1};
    Image photograph = renderer->render(camera, settings).color;
    clamp_to_unit(photograph);
    const SizedLens sized = settings.lens->sized({row.width, row.height});
    for (std::size_t i = 0; i < photograph.values.size(); ++i) {
      const auto width = static_cast<std::size_t>(row.width);
      const bool is_shown = sized.direction({i / 3 % width, i / 3 / width}).has_value();
      photograph.values[i] = is_shown ? photograph.values[i] + 0.1f : 0.9f;
    }
    write_image(photograph, folder / "images/a.pfm");
    const auto run = [&](std::vector<std::string> more) {
      more.insert(more.begin(), {"eval", (folder_ / "scene.ply").string(), "--backend", "cpu",
                                 "--cull", "quadbox,3dgs", "--lens-eval", "--cameras",
                                 folder.string(), "--images", (folder / "images").string()});
      return run_quadsplat(more);
    };
    const ProgramRun table = run({"--json", (folder_ / "lens.json").string(), "--overwrite"});
    ASSERT_EQ(table.exit_code, 0) << table.err;
    const json found = json::parse(test::content_of(folder_ / "lens.json"));
    ASSERT_EQ(found["views"].size(), 2 * row.faces);
    const bool has_lens = row.shown > 0;
    EXPECT_EQ(table.out.find("in the lens: PSNR") != std::string::npos, has_lens);
    EXPECT_EQ(table.err.find("--lens-eval: no photograph has a lens") != std::string::npos,
              !has_lens);
    for (std::size_t i = 0; i < found["views"].size(); ++i)
      EXPECT_EQ(found["views"][i].contains("lens_psnr"), has_lens && i < 2) << i;
    if (!has_lens) continue;
    for (const json& entry : {found["views"][0], found["means"][0], found["views"][1]}) {
      const double tolerance = entry["mode"] == "3dgs" ? 0.01 : 1e-4;  // it drops a little
      EXPECT_NEAR(entry["lens_psnr"].get<double>(), 20, tolerance);
      EXPECT_NEAR(entry["lens_shown"].get<double>(), row.shown, 0.01);
      EXPECT_GT(entry["lens_ssim"].get<double>(), 0.3);
    }
    EXPECT_EQ(found["means"][0]["photographs"], 1);
    EXPECT_EQ(found["means"][0]["views"], row.faces);
    const ProgramRun csv = run({"--csv", "-"});
    EXPECT_THAT(csv.out, HasSubstr(",psnr,ssim,lens_psnr,lens_ssim,lens_shown\n"));
    if (row.faces > 1) {
      EXPECT_THAT(csv.out, EndsWith(",,,\n"));
    }
    const EvalReport again = parse_eval_report(nlohmann::ordered_json(
        nlohmann::ordered_json::parse(test::content_of(folder_ / "lens.json"))));
    EXPECT_EQ(format_eval_csv(again), csv.out);
    // Half the size: a pixel counts if the lens shows all four of the photograph's.
    const ProgramRun half = run({"--images-scale", "2", "--json", "-"});
    const json small = json::parse(half.out);
    EXPECT_NEAR(small["views"][0]["lens_psnr"].get<double>(), 20, 1e-3);
    EXPECT_LE(small["views"][0]["lens_shown"].get<double>(), row.shown + 0.005);
    EXPECT_GT(small["views"][0]["lens_shown"].get<double>(), row.shown - 0.06);
  }
  const ProgramRun sized = eval({"--lens-eval", "--size", "30x20"});
  EXPECT_EQ(sized.exit_code, 1);
  EXPECT_THAT(sized.err, HasSubstr("--lens-eval draws at the size of the photographs' camera"));
}

}  // namespace
}  // namespace qs
