// SPDX-License-Identifier: MIT
//
// The conformance kit: its scenes, the plain renderer, and the tables.
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/conformance/judge.h"
#include "app/conformance/kit_scenes.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/error_of.h"
#include "support/golden.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

float largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  float largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    largest = std::max(largest, std::abs(a.values[i] - b.values[i]));
  return largest;
}

TEST(Conformance, the_plain_renderer_without_mistakes_draws_the_image_of_mode_reference) {
  for (const KitScene& scene : kit_scenes()) {
    const KitView view = scene.make();
    EXPECT_LE(largest_difference(draw_with(view, {}), truth_of(view, test::pool(2))), 1e-6f)
        << scene.name;
  }
  for (const bool antialiased : {false, true}) {
    KitView view{test::random_cloud(300, 3, 5), test::front_camera(61, 43), {}};
    view.cloud.antialiased = antialiased;
    view.settings.background = {0.2f, 0.4f, 0.8f};
    EXPECT_LE(largest_difference(draw_with(view, {}), truth_of(view, test::pool(2))), 1e-6f);
  }
}

TEST(Conformance, no_scene_depends_on_the_rounding_of_a_threshold) {
  for (const KitScene& scene : kit_scenes()) {
    const KitView view = scene.make();
    const Picture8 truth = picture8(draw_with(view, {}));
    for (const double factor : {1 - 1e-5, 1 + 1e-5}) {
      Rules rules;
      rules.alpha_min *= factor;
      rules.transmittance_min *= factor;
      const Image image = draw_plain(view.cloud, view.camera, view.settings, rules);
      EXPECT_LE(fit_of(picture8(image), truth).largest, 1) << scene.name << " " << factor;
    }
  }
}

TEST(Conformance, all_values_of_the_scenes_are_finite) {
  for (const KitScene& scene : kit_scenes()) {
    const GaussianCloud cloud = scene.make().cloud;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::vec3 sum = cloud.positions[i] + cloud.log_scales[i];
      const glm::quat& q = cloud.rotations[i];
      EXPECT_TRUE(std::isfinite(sum.x + sum.y + sum.z + cloud.opacity_logits[i])) << scene.name;
      EXPECT_NEAR(glm::length(q), 1, 1e-6) << scene.name;
    }
    for (const glm::vec3& sh : cloud.sh) EXPECT_TRUE(std::isfinite(sh.x + sh.y + sh.z));
  }
}

TEST(Conformance, names_are_unique_and_sets_contain_no_mistakes_of_the_same_part) {
  std::set<std::string> names;
  for (const KitScene& scene : kit_scenes()) EXPECT_TRUE(names.insert(scene.name).second);
  for (const Mistake& mistake : mistakes()) EXPECT_TRUE(names.insert(mistake.name).second);
  EXPECT_EQ(sets_of_mistakes(0), std::vector<MistakeSet>{{}});
  EXPECT_EQ(sets_of_mistakes(1).size(), mistakes().size());
  for (const MistakeSet& set : sets_of_mistakes(2)) {
    ASSERT_EQ(set.size(), 2u);
    EXPECT_NE(mistakes()[set[0]].part, mistakes()[set[1]].part) << names_of(set);
  }
}

TEST(Conformance, the_files_of_the_kit_hold_its_scenes_and_truth) {
  TemporaryFolder folder;
  write_kit(folder.path(), test::pool(2));
  for (const KitScene& scene : kit_scenes()) {
    SCOPED_TRACE(scene.name);
    const KitView view = scene.make();
    const std::string name = scene.name;
    KitView read{test::read_scene(folder / (name + ".ply")).cloud,
                 read_cameras(folder / (name + ".cameras.json")).at(0), view.settings};
    EXPECT_EQ(read.cloud.size(), view.cloud.size());
    EXPECT_EQ(read.cloud.antialiased, view.cloud.antialiased);
    const Picture8 truth = picture8(read_image(folder / "truth" / (name + ".png")));
    EXPECT_LE(fit_of(picture8(draw_with(read, {})), truth).largest, 1);
    EXPECT_EQ(picture8(read_image(folder / "truth" / (name + ".pfm"))), truth);
  }
}

// The numbers of an array in one: each counts with another weight, so that exchanged numbers show.
template <class Values>
double digest(const Values& values) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (int k = 0; k < values[i].length(); ++k) {
      const double weight = 1 + std::fmod(0.6180339887498949 * static_cast<double>(4 * i + k), 1);
      if (const double value = values[i][k]; std::isfinite(value)) sum += weight * value;
    }
  }
  return sum;
}

// Authors compare results of the kit over years, so its scenes never change unnoticed.
TEST(Conformance, the_scenes_of_the_kit_stay) {
  std::string text;
  for (const KitScene& scene : kit_scenes()) {
    const KitView view = scene.make();
    const GaussianCloud& cloud = view.cloud;
    std::vector<glm::vec2> opacities;
    for (const float logit : cloud.opacity_logits) opacities.emplace_back(logit, 0);
    // In millionths, because a zero may have any sign.
    const glm::ivec3 eye = glm::round(1e6 * view.camera.position());
    text += fmt::format(
        "{}: {} Gaussians, SH degree {}; means {:.6f}, scales {:.6f}, rotations {:.6f}, opacities "
        "{:.6f}, SH {:.6f}; {} x {} pixels from {} {} {}, focal length {:.6f}\n",
        scene.name, cloud.size(), cloud.sh_degree, digest(cloud.positions),
        digest(cloud.log_scales), digest(cloud.rotations), digest(opacities), digest(cloud.sh),
        view.camera.width, view.camera.height, eye.x, eye.y, eye.z, view.camera.focal_px.x);
  }
  test::expect_golden_text("kit_scenes.txt", text);
}

TEST(Conformance, fits_are_measured_on_8_bit_values) {
  const Picture8 truth(48, 100);
  Picture8 picture = truth;
  EXPECT_TRUE(fit_of(picture, truth).matches());
  EXPECT_TRUE(std::isinf(fit_of(picture, truth).psnr));
  picture.assign(48, 101);  // every value is rounded up
  EXPECT_NEAR(fit_of(picture, truth).psnr, 20 * std::log10(255.0), 1e-9);
  EXPECT_TRUE(fit_of(picture, truth).matches());
  picture.assign(48, 98);
  EXPECT_FALSE(fit_of(picture, truth).matches());
  picture = truth;
  picture[7] = 103;
  EXPECT_TRUE(fit_of(picture, truth).matches());
  picture[7] = 96;
  EXPECT_FALSE(fit_of(picture, truth).matches());
  EXPECT_EQ(fit_of(picture, truth).largest, 4);
}

TEST(Conformance, a_folder_without_pictures_is_an_error_and_a_wrong_size_fails) {
  TemporaryFolder folder;
  EXPECT_EQ(test::error_of([&] { read_submission(folder.path()); }),
            folder.path().string() + ": it has no picture of the kit, such as one-gaussian.png");
  write_image(Image(63, 48, 3), folder / "dilation.png");
  const Submission submission = read_submission(folder.path());
  const KitVerdict judgement = judge_kit(submission, Variants(0, test::pool(2)), test::pool(2));
  EXPECT_EQ(judgement.count(Result::failed), 1u);
  EXPECT_EQ(judgement.count(Result::missing), kit_scenes().size() - 1);
  EXPECT_EQ(judgement.scenes[3].problem, "it has 63 x 48 pixels instead of 64 x 48");
  EXPECT_TRUE(judgement.causes.empty());
}

TEST(Conformance, all_modes_of_the_cpu_but_dualbox_pass) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (mode == find_culler("dualbox")) continue;  // it drops contributions
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      Submission submission;
      for (const KitScene& scene : kit_scenes()) {
        KitView view = scene.make();
        view.settings.mode = mode;
        view.settings.pipeline = pipeline;
        renderer->upload(view.cloud, {});
        submission.pictures.push_back(picture8(renderer->render(view.camera, view.settings).color));
        submission.problems.emplace_back();
      }
      const KitVerdict judgement = judge_kit(submission, Variants(0, test::pool(2)), test::pool(2));
      for (std::size_t i = 0; i < kit_scenes().size(); ++i) {
        EXPECT_EQ(judgement.scenes[i].result, Result::passed)
            << kit_scenes()[i].name << ", " << mode_name(mode) << ", "
            << judgement.scenes[i].fit.psnr << " dB, " << judgement.scenes[i].fit.largest;
      }
    }
  }
}

TEST(Conformance, the_command_writes_judges_and_reports) {
  TemporaryFolder folder;
  const std::string kit = (folder / "kit").string(), json = (folder / "judged.json").string(),
                    page = (folder / "judged.html").string();
  EXPECT_EQ(test::run_quadsplat({"conformance"}).exit_code, kExitUsage);
  EXPECT_EQ(test::run_quadsplat({"conformance", "--out-dir", kit}).exit_code, kExitOk);
  const test::ProgramRun correct = test::run_quadsplat({"conformance", "--judge", kit + "/truth"});
  EXPECT_EQ(correct.exit_code, kExitOk);
  EXPECT_THAT(correct.out, testing::HasSubstr("28 scenes pass, 0 fail, 0 are missing"));

  const std::string sub = (folder / "pictures").string();
  std::filesystem::create_directory(sub);
  const KitView view = kit_scenes()[3].make();
  RenderSettings settings = view.settings;
  settings.dilation = 0;
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(view.cloud, {});
  write_image(renderer->render(view.camera, settings).color, sub + "/dilation.png");
  std::filesystem::copy(kit + "/truth/many.png", sub);
  const test::ProgramRun wrong =
      test::run_quadsplat({"conformance", "--judge", sub, "--json", json, "--report", page});
  EXPECT_EQ(wrong.exit_code, kExitComparison);
  EXPECT_THAT(wrong.out, testing::HasSubstr("1 scenes pass, 1 fail, 26 are missing"));
  EXPECT_THAT(read_text_file(page, 1 << 26), testing::HasSubstr("data:image/png;base64"));
  const auto judged = parse_json(read_text_file(json, 1 << 20), "test");
  EXPECT_EQ(judged["scenes"][0]["result"], "missing");
  EXPECT_EQ(judged["scenes"][3]["result"], "fail");
  EXPECT_LT(judged["scenes"][3]["psnr"], kLeastPsnr);
  EXPECT_EQ(judged["scenes"].back()["result"], "pass");
}

TEST(Conformance, the_document_lists_all_scenes_and_mistakes) {
  const std::string text = read_text_file(test::source_path("docs/conformance.md"), 1 << 20);
  for (const KitScene& scene : kit_scenes())
    EXPECT_THAT(text, testing::HasSubstr(fmt::format("\n| `{}` | {} |\n", scene.name, scene.what)));
  for (const Mistake& mistake : mistakes())
    EXPECT_THAT(text,
                testing::HasSubstr(fmt::format("\n| `{}` | {} |\n", mistake.name, mistake.what)));
}

struct OfficialPicture {
  const char* scene;
  int camera;
};

class Official : public testing::TestWithParam<OfficialPicture> {};

INSTANTIATE_TEST_SUITE_P(Conformance, Official,
                         testing::Values(OfficialPicture{"plush", 0}, OfficialPicture{"plush", 32},
                                         OfficialPicture{"plush", 64},
                                         OfficialPicture{"plush_big", 0},
                                         OfficialPicture{"plush_big", 88}),
                         [](const auto& picture) {
                           return picture.param.scene + std::string("_camera") +
                                  std::to_string(picture.param.camera);
                         });

// The official rasterizer has not drawn the kit's scenes. Its pictures of a trained scene are
// compared instead, in the middle of the picture, where the doll is.
TEST_P(Official, pictures_are_drawn_best_without_mistakes) {
  const auto [name, index] = GetParam();
  const std::string file =
      std::string("golden/") + name + "_camera" + std::to_string(index) + "_3dgs.png";
  QS_NEEDS_SHARED(file);
  const Image official = read_image(test::shared_path(file));
  const Camera whole = read_cameras(test::shared_path("scenes/plush/cameras.json"))
                           .at(static_cast<std::size_t>(index));
  const GaussianCloud cloud =
      test::read_scene(test::shared_path(std::string("scenes/") + name + ".spz")).cloud;

  constexpr int kPart = 40;  // of the width and of the height
  const PixelBox box{760, 570, 760 + whole.width / kPart, 570 + whole.height / kPart};
  const PixelBox around{box.x0 - 40, box.y0 - 40, box.x1 + 40, box.y1 + 40};
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  RenderSettings settings;
  settings.mode = kReferenceMode;
  Outputs outputs;
  outputs.trace = true;
  outputs.color = false;
  outputs.region = around;
  const Trace& trace = renderer->render(whole, settings, outputs).trace;

  KitView view;
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  view.cloud.resize(trace.gaussians.size(), cloud.sh_degree);
  for (std::size_t i = 0; i < trace.gaussians.size(); ++i) {
    const std::size_t from = trace.gaussians[i];
    view.cloud.positions[i] = cloud.positions[from];
    view.cloud.log_scales[i] = cloud.log_scales[from];
    view.cloud.rotations[i] = cloud.rotations[from];
    view.cloud.opacity_logits[i] = cloud.opacity_logits[from];
    std::copy_n(cloud.sh.begin() + static_cast<std::ptrdiff_t>(from * coefficients), coefficients,
                view.cloud.sh.begin() + static_cast<std::ptrdiff_t>(i * coefficients));
  }
  view.camera = whole;
  view.camera.width = box.x1 - box.x0;
  view.camera.height = box.y1 - box.y0;
  view.camera.center_px -= glm::dvec2(box.x0, box.y0);
  Rules rules;
  rules.slope_limit = kPart;  // limit of the whole picture
  Image part(view.camera.width, view.camera.height, 3);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      for (int c = 0; c < 3; ++c) part.at(x, y, c) = official.at(box.x0 + x, box.y0 + y, c);
    }
  }
  const Picture8 picture = picture8(part);
  const Fit correct = fit_of(picture, picture8(draw_with(view, {}, rules)));
  EXPECT_TRUE(correct.matches()) << correct.psnr << " dB, " << correct.largest;
  for (const MistakeSet& set : sets_of_mistakes(1)) {
    const Fit wrong = fit_of(picture, picture8(draw_with(view, set, rules)));
    EXPECT_GE(wrong.squared_error, correct.squared_error) << names_of(set);
  }
}

}  // namespace
}  // namespace qs
