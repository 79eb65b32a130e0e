// SPDX-License-Identifier: MIT
//
// The colours of a network, drawn for each view, on the small model that PyTorch wrote.
#include "app/session/exact_color.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/session/session.h"
#include "app/support/run_program.h"
#include "base/error.h"
#include "raster/field/color_field.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/image_metrics.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/field_outputs.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

std::filesystem::path model() { return committed_corpus() / "valid/compact_small.npz"; }

Camera camera_at(const glm::dvec3& eye) { return look_at(eye, {0, 0, 0}, {0, -1, 0}, 1.0, 64, 48); }

const glm::dvec3 kEye(1, 2, -3), kOther(-3, 0.5, 1);

FrameOptions options_of(const std::filesystem::path& scene, NetworkUse network) {
  FrameOptions frame;
  frame.scene = scene;
  frame.backend = Backend::cpu;
  frame.threads = 2;
  frame.network = network;
  return frame;
}

TEST(ExactColor, clouds_have_the_outputs_of_the_network) {
  ThreadPool pool(2);
  const Scene scene = read_scene(model());
  const GaussianCloud seen = seen_from(kEye, scene.cloud, *scene.network, scene.axes, pool);
  EXPECT_EQ(seen.sh_degree, 0);
  EXPECT_EQ(seen.positions, scene.cloud.positions);
  EXPECT_EQ(seen.opacity_logits, scene.cloud.opacity_logits);
  ASSERT_EQ(seen.sh.size(), seen.size());
  const ColorField& field = *scene.network->field;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const glm::dvec3 mean(seen.positions[i]);
    const glm::dvec3 expected =
        test::network_output(field, test::grid_features(field, mean), glm::normalize(mean - kEye));
    EXPECT_LT(glm::distance(glm::dvec3(seen.sh[i]), expected), 2e-4) << i;
  }
}

TEST(ExactColor, other_axes_give_the_same_colours) {
  ThreadPool pool(2);
  const Scene scene = read_scene(model());
  const GaussianCloud seen = seen_from(kEye, scene.cloud, *scene.network, scene.axes, pool);
  for (const char* axes : {"RUB", "RFU"}) {
    ReadOptions options;
    options.axes = axes;
    const Scene turned = read_scene(model(), options);
    ASSERT_NE(turned.cloud.positions[1], scene.cloud.positions[1]);
    // The turn of the axes, which also moves the eye.
    const auto turn = [&](const glm::dvec3& v) {
      return axes[1] == 'U' ? glm::dvec3(v.x, -v.y, -v.z) : glm::dvec3(v.x, -v.z, v.y);
    };
    ASSERT_LT(glm::distance(turn(glm::dvec3(scene.cloud.positions[1])),
                            glm::dvec3(turned.cloud.positions[1])),
              1e-6);
    const GaussianCloud same =
        seen_from(turn(kEye), turned.cloud, *turned.network, turned.axes, pool);
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_LT(glm::distance(same.sh[i], seen.sh[i]), 1e-5f) << axes << " " << i;
  }
}

TEST(ExactColor, every_view_is_drawn_with_its_own_colours) {
  Session fitted = open_session(options_of(model(), NetworkUse::never));
  Session exact = open_session(options_of(model(), NetworkUse::always));
  for (const glm::dvec3& eye : {kEye, kOther, kEye}) {
    const Camera camera = camera_at(eye);
    fitted.renderer->upload(
        seen_from(eye, exact.scene->cloud, *exact.scene->network, exact.scene->axes, *exact.pool),
        {});
    const Image expected = fitted.renderer->render(camera, fitted.settings).color;
    EXPECT_EQ(exact.renderer->render(camera, exact.settings).color.values, expected.values);
  }
}

TEST(ExactColor, a_set_of_gaussians_stays_from_eye_to_eye) {
  Session session = open_session(options_of(model(), NetworkUse::always));
  Session rest = open_session(options_of(model(), NetworkUse::always));
  const std::size_t size = session.scene->cloud.size();
  const GaussianSet even =
      GaussianSet::where(size, *session.pool, [](std::size_t i) { return i % 2 == 0; });
  rest.renderer->upload(select(rest.scene->cloud, even.numbers()), {});
  session.renderer->set_drawn(even);  // before the first eye
  for (const glm::dvec3& eye : {kEye, kOther, kEye})
    EXPECT_EQ(session.renderer->render(camera_at(eye)).color.values,
              rest.renderer->render(camera_at(eye)).color.values);
  session.renderer->set_drawn(GaussianSet());
  EXPECT_EQ(session.renderer->render(camera_at(kEye)).stats.gaussians, size);
}

TEST(ExactColor, fitted_colours_are_close_to_the_networks) {
  Session fitted = open_session(options_of(model(), NetworkUse::never));
  Session exact = open_session(options_of(model(), NetworkUse::always));
  const Camera camera = camera_at({0.2, -0.3, -2.5});
  const Image a = fitted.renderer->render(camera, fitted.settings).color;
  const Image b = exact.renderer->render(camera, exact.settings).color;
  EXPECT_NE(a.values, b.values);
  const double decibels = psnr(a, b, *exact.pool);
  EXPECT_GT(decibels, 40);
  EXPECT_LT(decibels, 80);
}

TEST(ExactColor, references_alone_can_have_the_networks_colours) {
  Session both = open_session(options_of(model(), NetworkUse::reference));
  Session exact = open_session(options_of(model(), NetworkUse::always));
  Session fitted = open_session(options_of(model(), NetworkUse::never));
  const Camera camera = camera_at(kEye);
  EXPECT_EQ(both.renderer->render(camera, both.settings).color.values,
            fitted.renderer->render(camera, fitted.settings).color.values);
  const Image reference = reference_image(both, camera);
  EXPECT_EQ(reference.values, reference_image(exact, camera).values);
  EXPECT_NE(reference.values, reference_image(fitted, camera).values);
}

TEST(ExactColor, scenes_without_a_network_are_refused_where_it_is_needed) {
  const TemporaryFolder folder;
  write_scene(random_cloud(20, 1, 3), folder / "a.ply");
  for (const NetworkUse use : {NetworkUse::always, NetworkUse::reference}) {
    EXPECT_EQ(error_of([&] { open_session(options_of(folder / "a.ply", use)); }, folder.path()),
              "--exact-color: a.ply has no network of colours; only models of Compact-3DGS have "
              "one");
  }
  EXPECT_NO_THROW(open_session(options_of(folder / "a.ply", NetworkUse::if_any)));
}

TEST(ExactColor, commands_open_convert_and_compare_such_models) {
  const TemporaryFolder folder;
  const std::string scene = model().string(), ply = (folder / "a.ply").string();
  const auto run = [&](std::vector<std::string> arguments, bool draws) {
    if (draws)
      arguments.insert(arguments.end(), {"--backend", "cpu", "--size", "48x32", "--exact-color"});
    const ProgramRun result = run_quadsplat(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  EXPECT_THAT(run({"info", scene}, false), HasSubstr("SH fit"));
  run({"convert", scene, ply}, false);
  EXPECT_EQ(read_scene(folder / "a.ply").cloud.sh, read_scene(model()).cloud.sh);
  run({"render", scene, "--output", (folder / "a.png").string()}, true);
  EXPECT_THAT(run({"compare", scene, ply}, true), HasSubstr("PSNR"));
  EXPECT_THAT(
      run({"bench", scene, "--psnr", "--frames", "1", "--warmup", "0", "--cull", "quadbox"}, true),
      HasSubstr("quadbox"));
  const ProgramRun neither = run_quadsplat({"compare", ply, ply, "--exact-color"});
  EXPECT_EQ(neither.exit_code, 1);
  EXPECT_THAT(neither.err, HasSubstr("--exact-color: neither "));
  const ProgramRun alone = run_quadsplat({"bench", scene, "--exact-color"});
  EXPECT_EQ(alone.exit_code, 1);
  EXPECT_THAT(alone.err, HasSubstr("bench: --exact-color needs --psnr or --plugin"));
}

}  // namespace
}  // namespace qs::test
