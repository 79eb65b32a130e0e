// SPDX-License-Identifier: MIT
//
// quadsplat judge and compare with two scenes, as users run them, on a generated scene.
#include <cmath>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/inspect/picture_pair.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "raster/api/renderer.h"
#include "raster/scene/image_metrics.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;

constexpr int kJudgedViews = 3;

class Judge : public testing::Test {
 protected:
  // Three cameras; the folder `truth` holds their renders.
  void SetUp() override {
    cloud_ = test::random_cloud(400, 1, 5);
    test::write_scene(cloud_, folder_ / "scene.ply");
    for (int i = 0; i < kJudgedViews; ++i) {
      Camera camera = test::front_camera(60, 40);
      camera.view_from_world[3].x = 0.05 * i;
      camera.name = "view" + std::to_string(i);
      cameras_.push_back(camera);
    }
    test::write_cameras(cameras_, folder_ / "cameras.json");
    for (const char* name : {"truth", "other"}) std::filesystem::create_directories(folder_ / name);
    for (int i = 0; i < kJudgedViews; ++i) write_image(render(i), picture("truth", i));
  }

  std::filesystem::path picture(const std::string& folder, int i) const {
    return folder_ / folder / ("view" + std::to_string(i) + ".pfm");
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Image render(int i) const {
    const auto renderer = make_renderer(Backend::cpu, test::pool());
    renderer->upload(cloud_, {});
    Image image = renderer->render(cameras_[static_cast<std::size_t>(i)]).color;
    clamp_to_unit(image);
    return image;
  }

  // The picture of a view with a brighter rectangle, larger for higher views.
  Image changed(int i) const {
    Image image = render(i);
    for (int y = 0; y < 10 + 10 * i; ++y)
      for (int x = 0; x < 20; ++x) image.at(x, y, 1) = std::min(1.0f, image.at(x, y, 1) + 0.2f);
    return image;
  }

  json report(std::vector<std::string> words) const {
    words.insert(words.end(), {"--backend", "cpu", "--json", "-"});
    const ProgramRun run = run_quadsplat(words);
    EXPECT_EQ(run.exit_code, kExitOk) << run.err;
    return parse_json(run.out, "test");
  }

  GaussianCloud cloud_;
  std::vector<Camera> cameras_;
  TemporaryFolder folder_;
};

TEST_F(Judge, two_folders_are_compared_by_the_names_of_their_pictures) {
  for (int i = 0; i < kJudgedViews; ++i) write_image(changed(i), picture("other", i));
  const json result = report({"judge", path("truth"), path("other")});
  ASSERT_EQ(result["views"].size(), static_cast<std::size_t>(kJudgedViews));
  double psnr_sum = 0, flip_sum = 0;
  for (int k = 0; k < kJudgedViews; ++k) {
    const json& view = result["views"][static_cast<std::size_t>(k)];
    const int i = kJudgedViews - 1 - k;  // the worst first
    EXPECT_EQ(view["view"], "view" + std::to_string(i));
    EXPECT_NEAR(view["psnr"], psnr(render(i), changed(i), test::pool()), 1e-9);
    EXPECT_NEAR(view["ssim"], ssim(render(i), changed(i), test::pool()), 1e-9);
    EXPECT_NEAR(view["flip"], flip(render(i), changed(i), test::pool()), 1e-9);
    psnr_sum += view["psnr"].get<double>();
    flip_sum += view["flip"].get<double>();
  }
  EXPECT_NEAR(result["mean"]["psnr"], psnr_sum / kJudgedViews, 1e-9);
  EXPECT_NEAR(result["mean"]["flip"], flip_sum / kJudgedViews, 1e-9);
}

TEST_F(Judge, a_scene_is_drawn_in_the_size_of_the_pictures_that_it_is_compared_with) {
  const json equal = report({"judge", path("truth"), path("scene.ply")});
  for (const json& view : equal["views"]) {
    EXPECT_TRUE(view["psnr"].is_null() || view["psnr"] > 100) << view["psnr"];
    EXPECT_NEAR(view["ssim"].get<double>(), 1, 1e-9);
    EXPECT_NEAR(view["flip"].get<double>(), 0, 1e-3);
  }
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(cloud_, {});
  write_image(renderer->render(cameras_[1].resized(30, 20)).color, picture("other", 1));
  const json small = report({"judge", path("scene.ply"), path("other")});
  ASSERT_EQ(small["views"].size(), 1u);
  EXPECT_EQ(small["views"][0]["width"], 30);
  EXPECT_TRUE(small["views"][0]["psnr"].is_null() || small["views"][0]["psnr"] > 100);
}

TEST_F(Judge, the_files_of_render_are_found_by_the_camera_at_the_end_of_their_names) {
  const ProgramRun run = run_quadsplat({"render", path("scene.ply"), "--backend", "cpu",
                                        "--all-cameras", "--output", path("other/out.pfm")});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const json result = report({"judge", path("scene.ply"), path("other")});
  ASSERT_EQ(result["views"].size(), static_cast<std::size_t>(kJudgedViews));
  for (const json& view : result["views"]) EXPECT_TRUE(view["psnr"].is_null()) << view["psnr"];
}

TEST_F(Judge, compare_with_two_scenes_draws_both_with_the_cameras_of_the_first) {
  GaussianCloud dimmer = cloud_;
  for (float& logit : dimmer.opacity_logits) logit -= 1;
  std::filesystem::create_directories(folder_ / "elsewhere");
  test::write_scene(dimmer, folder_ / "elsewhere/dimmer.ply");
  const json result = report({"compare", path("scene.ply"), path("elsewhere/dimmer.ply")});
  ASSERT_EQ(result["views"].size(), static_cast<std::size_t>(kJudgedViews));
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(dimmer, {});
  for (const json& view : result["views"]) {
    const int i = view["view"].get<std::string>().back() - '0';
    Image judged = renderer->render(cameras_[static_cast<std::size_t>(i)]).color;
    clamp_to_unit(judged);
    EXPECT_NEAR(view["psnr"], psnr(render(i), judged, test::pool()), 1e-3);
  }
}

TEST_F(Judge, transparent_pictures_are_judged_over_black_or_the_given_background) {
  write_image(Image(60, 40, 3), folder_ / "other/clear.png");
  std::filesystem::create_directories(folder_ / "clear");
  Image clear(60, 40, 4);
  for (std::size_t i = 0; i < clear.values.size(); ++i) clear.values[i] = i % 4 == 3 ? 0 : 0.5f;
  write_image(clear, folder_ / "clear/clear.png");
  const auto psnr_over = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"judge", path("other"), path("clear")};
    words.insert(words.end(), more.begin(), more.end());
    return report(words)["views"][0]["psnr"];
  };
  EXPECT_TRUE(psnr_over({}).is_null());  // infinite
  EXPECT_NEAR(psnr_over({"--background", "1,1,1"}), 0, 1e-6);
}

TEST_F(Judge, the_folder_holds_table_json_and_a_sheet_of_the_worst_views) {
  for (int i = 0; i < kJudgedViews; ++i) write_image(changed(i), picture("other", i));
  const ProgramRun run = run_quadsplat(
      {"judge", path("truth"), path("other"), "--out-dir", path("out"), "--sheet-views", "2"});
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("mean of 3"));
  const Image sheet = read_image(folder_ / "out/sheet.png");
  EXPECT_GT(sheet.width, 3 * 60);
  EXPECT_GT(sheet.height, 2 * 40);
  std::ifstream csv(folder_ / "out/judge.csv");
  std::string header, worst;
  std::getline(csv, header);
  std::getline(csv, worst);
  EXPECT_EQ(header, "truth,judged,view,width,height,psnr,ssim,flip");
  EXPECT_THAT(worst, HasSubstr(",view2,60,40,"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/judge.json"));
}

TEST_F(Judge, what_cannot_be_compared_gets_a_sentence) {
  const auto sentence = [&](std::vector<std::string> words) {
    const ProgramRun run = run_quadsplat(words);
    EXPECT_NE(run.exit_code, kExitOk);
    return run.err;
  };
  write_image(Image(60, 41, 3), folder_ / "other/view0.pfm");
  EXPECT_THAT(sentence({"judge", path("truth"), path("other")}),
              HasSubstr("only pictures of one size can be compared"));
  std::filesystem::rename(folder_ / "other/view0.pfm", folder_ / "other/else.pfm");
  EXPECT_THAT(sentence({"judge", path("truth"), path("other")}),
              HasSubstr("no view has a picture in both"));
  EXPECT_THAT(sentence({"judge", path("truth"), path("nowhere")}), HasSubstr("does not exist"));
  EXPECT_THAT(sentence({"judge", path("truth"), path("truth"), "--cull", "all"}),
              HasSubstr("choose one"));
  EXPECT_THAT(sentence({"compare", path("scene.ply"), path("scene.ply"), "--everywhere"}),
              HasSubstr("not two scenes"));
  EXPECT_THAT(sentence({"compare", path("scene.ply"), "--csv", "-"}),
              HasSubstr("need a second scene"));
}

}  // namespace

TEST(MeanQuality, counts_the_views_that_differ_for_psnr_and_all_for_the_others) {
  const double inf = std::numeric_limits<double>::infinity();
  const PictureQuality mean =
      mean_quality({{"a", 1, 1, inf, 1, 0}, {"b", 1, 1, 30, 0.5, 0.2}, {"c", 1, 1, 40, 0.9, 0.1}});
  EXPECT_DOUBLE_EQ(mean.psnr, 35);
  EXPECT_DOUBLE_EQ(mean.ssim, 0.8);
  EXPECT_DOUBLE_EQ(mean.flip, 0.1);
  EXPECT_EQ(mean_quality({{"a", 1, 1, inf, 1, 0}}).psnr, inf);
}

}  // namespace qs
