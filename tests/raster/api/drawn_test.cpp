// SPDX-License-Identifier: MIT
// Renderer::set_drawn() of the CPU backend: frames of a set of the Gaussians are frames of a cloud
// of these Gaussians alone, bit for bit.
#include "support/drawn.h"

#include "io/camera/lens_views.h"
#include "raster/lens/lens_renderer.h"
#include "support/error_of.h"
#include "support/mode_pairs.h"
#include "support/pool.h"

namespace qs {
namespace {

std::unique_ptr<Renderer> uploaded(const GaussianCloud& cloud, int threads = 2) {
  auto renderer = make_renderer(Backend::cpu, test::pool(threads));
  renderer->upload(cloud, {});
  return renderer;
}

void expect_rest(Renderer& renderer, const GaussianCloud& cloud, const test::DrawnSet& drawn,
                 const Camera& camera, const RenderSettings& settings) {
  SCOPED_TRACE(drawn.name + ", " + mode_name(settings.mode) + " " +
               kPipelineNames[static_cast<int>(settings.pipeline)]);
  const Outputs outputs = test::all_outputs(settings.mode);
  const auto rest = uploaded(select(cloud, drawn.set.numbers()));
  test::expect_frame_of_rest(renderer.render(camera, settings, outputs),
                             rest->render(camera, settings, outputs), drawn.set);
}

TEST(Drawn, frames_of_a_set_are_frames_of_the_rest_in_every_mode_and_pipeline) {
  const GaussianCloud cloud = test::random_cloud(3000, 2, 5);
  const auto renderer = uploaded(cloud);
  for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
    renderer->set_drawn(drawn.set);
    RenderSettings settings;
    for (settings.mode = kReferenceMode; settings.mode <= mode_count(); ++settings.mode)
      for (settings.pipeline = Pipeline::classic;; settings.pipeline = Pipeline::fast) {
        expect_rest(*renderer, cloud, drawn, test::front_camera(96, 64), settings);
        if (settings.pipeline == Pipeline::fast || settings.mode == kReferenceMode) break;
      }
  }
}

TEST(Drawn, frames_are_those_of_the_rest_for_every_size_of_scene_and_every_setting) {
  for (const std::size_t size : {1u, 63u, 64u, 65u, 255u, 256u, 257u, 513u, 2000u}) {
    SCOPED_TRACE(size);
    const GaussianCloud cloud = test::surrounding_cloud(size, 3, 9);
    const auto renderer = uploaded(cloud);
    RenderSettings plain, other, solid, small_tiles;
    other.antialiased = true;
    other.splat_scale = 0.6f;
    solid.style = DrawStyle::points;
    small_tiles.tile_px = 8;
    for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
      renderer->set_drawn(drawn.set);
      for (const RenderSettings& settings : {plain, other, solid, small_tiles})
        expect_rest(*renderer, cloud, drawn, test::front_camera(161, 117), settings);
      const Camera face = test::with_projection(test::front_camera(64, 64), Projection::face);
      expect_rest(*renderer, cloud, drawn, face, plain);
    }
  }
}

TEST(Drawn, sets_follow_each_other_and_no_set_draws_all_again) {
  const GaussianCloud cloud = test::random_cloud(3000, 1, 6);
  const Camera camera = test::front_camera(96, 64);
  const Outputs outputs = test::all_outputs(default_mode());
  const auto renderer = uploaded(cloud), whole = uploaded(cloud);
  const Frame expected = whole->render(camera, {}, outputs);
  const GaussianSet all = GaussianSet(cloud.size()).complement();
  for (const int threads : {1, 2, 5}) {
    const auto own = uploaded(cloud, threads);
    for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
      own->set_drawn(drawn.set);
      expect_rest(*own, cloud, drawn, camera, {});
    }
    own->set_drawn(GaussianSet());
    test::expect_frame_of_rest(own->render(camera, {}, outputs), expected, all);
  }
  renderer->set_drawn(GaussianSet(cloud.size()));
  EXPECT_EQ(renderer->render(camera).stats.gaussians, 0u);
  renderer->upload(cloud, {});  // an upload draws all
  test::expect_frame_of_rest(renderer->render(camera, {}, outputs), expected, all);
}

TEST(Update, frames_of_changed_gaussians_are_frames_of_the_cloud_uploaded_again) {
  const Outputs outputs = test::all_outputs(default_mode());
  const Camera camera = test::front_camera(161, 117);
  for (const std::size_t size : {1u, 255u, 257u, 3000u})
    for (const bool halves : {false, true})
      for (const int degree : {0, 3}) {
        SCOPED_TRACE(std::to_string(size) + (halves ? " halves " : " floats ") +
                     std::to_string(degree));
        const auto cloud = std::make_shared<GaussianCloud>(
            test::with_halves(test::random_cloud(size, degree, 11)));
        GaussianCloud other = test::surrounding_cloud(size, degree, 12);
        if (halves) other = test::with_halves(std::move(other));
        const auto renderer = make_renderer(Backend::cpu, test::pool(2));
        renderer->upload(cloud, {});
        for (const std::size_t step : {7, 1, 300}) {
          renderer->render(camera, {}, outputs);  // activates the cloud for `classic` too
          renderer->update(test::replace_every(step, other, *cloud));
          const auto again = uploaded(*cloud);
          const GaussianSet odd =
              GaussianSet::where(size, test::pool(), [](std::size_t i) { return i % 2 == 1; });
          for (const GaussianSet& drawn : {GaussianSet(size).complement(), odd}) {
            renderer->set_drawn(drawn);
            again->set_drawn(drawn);
            RenderSettings settings;
            for (const Pipeline pipeline : {Pipeline::fast, Pipeline::classic}) {
              settings.pipeline = pipeline;
              Frame frame = renderer->render(camera, settings, outputs);
              test::expect_frame_of_rest(frame, again->render(camera, settings, outputs),
                                         GaussianSet(size).complement());
            }
          }
        }
      }
}

TEST(Drawn, lenses_draw_the_set_too) {
  const GaussianCloud cloud = test::surrounding_cloud(2000, 1, 7);
  const test::DrawnSet drawn = test::drawn_sets(cloud).back();
  const auto renderer = with_lenses(uploaded(cloud), test::pool());
  const auto rest = with_lenses(uploaded(select(cloud, drawn.set.numbers())), test::pool());
  renderer->set_drawn(drawn.set);
  const Camera camera = test::front_camera(96, 64);
  RenderSettings settings;
  settings.lens = std::make_shared<const LensView>(panorama_view(360));
  EXPECT_EQ(renderer->render(camera, settings).color.values,
            rest->render(camera, settings).color.values);
}

TEST(Drawn, renderers_without_sets_say_so) {
  struct Plain : Renderer {
    void upload(std::shared_ptr<const GaussianCloud>, const Progress&) override {}
    const Frame& render(const Camera&, const RenderSettings&, const Outputs&, const Target&,
                        std::stop_token) override {
      return frame;
    }
    Frame frame;
  } plain;
  EXPECT_EQ(test::error_of([&] { plain.set_drawn(GaussianSet(3)); }, ErrorKind::device),
            "the renderer cannot leave out Gaussians");
  EXPECT_EQ(test::error_of([&] { plain.update({}); }, ErrorKind::device),
            "the renderer cannot change single Gaussians");
}

}  // namespace
}  // namespace qs
