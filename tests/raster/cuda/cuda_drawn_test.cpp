// SPDX-License-Identifier: MIT
// Renderer::set_drawn() of the CUDA backend: frames of a set of the Gaussians are frames of a cloud
// of these Gaussians alone, bit for bit.
#include "support/drawn.h"
#include "support/mode_pairs.h"

namespace qs {
namespace {

class CudaDrawn : public test::PipelineTest {
 protected:
  static void expect_rest(Renderer& renderer, const GaussianCloud& cloud,
                          const test::DrawnSet& drawn, const Camera& camera,
                          const RenderSettings& settings) {
    SCOPED_TRACE(drawn.name + ", " + mode_name(settings.mode));
    const Outputs outputs = test::all_outputs(settings.mode);
    const auto rest = renderer_of(Backend::cuda, select(cloud, drawn.set.numbers()));
    test::expect_frame_of_rest(renderer.render(camera, settings, outputs),
                               rest->render(camera, settings, outputs), drawn.set);
  }
};

INSTANTIATE_TEST_SUITE_P(Pipelines, CudaDrawn, test::kPipelines, test::name_of_pipeline);

TEST_P(CudaDrawn, frames_of_a_set_are_frames_of_the_rest) {
  for (const std::size_t size : {1u, 31u, 33u, 256u, 257u, 1500u}) {
    SCOPED_TRACE(size);
    const GaussianCloud cloud = test::random_cloud(size, 1, 5);
    const auto renderer = renderer_of(Backend::cuda, cloud);
    for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
      renderer->set_drawn(drawn.set);
      expect_rest(*renderer, cloud, drawn, test::front_camera(96, 64), settings_of_pipeline());
    }
  }
}

TEST_P(CudaDrawn, frames_of_a_set_are_frames_of_the_rest_in_every_mode) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 2, 5);
  const auto renderer = renderer_of(Backend::cuda, cloud);
  const std::vector<test::DrawnSet> sets = test::drawn_sets(cloud);
  RenderSettings settings = settings_of_pipeline();
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
    const test::DrawnSet& drawn = sets[static_cast<std::size_t>(settings.mode) % sets.size()];
    renderer->set_drawn(drawn.set);
    expect_rest(*renderer, cloud, drawn, test::front_camera(96, 64), settings);
  }
}

TEST_P(CudaDrawn, both_orders_of_the_scene_have_the_set_and_no_set_draws_all_again) {
  const GaussianCloud cloud = test::random_cloud(1500, 1, 6);
  const Camera camera = test::front_camera(96, 64);
  const auto renderer = renderer_of(Backend::cuda, cloud);
  RenderSettings other;
  other.pipeline = GetParam() == Pipeline::fast ? Pipeline::classic : Pipeline::fast;
  const std::vector<test::DrawnSet> sets = test::drawn_sets(cloud);
  for (const std::size_t number : {5, 8}) {  // the other order is uploaded after the first set
    renderer->set_drawn(sets[number].set);
    expect_rest(*renderer, cloud, sets[number], camera, settings_of_pipeline());
    expect_rest(*renderer, cloud, sets[number], camera, other);
  }
  const Outputs outputs = test::all_outputs(default_mode());
  const auto whole = renderer_of(Backend::cuda, cloud);
  const Frame expected = whole->render(camera, settings_of_pipeline(), outputs);
  const GaussianSet all = GaussianSet(cloud.size()).complement();
  renderer->set_drawn(GaussianSet());
  test::expect_frame_of_rest(renderer->render(camera, settings_of_pipeline(), outputs), expected,
                             all);
  renderer->set_drawn(sets[1].set);
  renderer->upload(cloud, {});  // an upload draws all
  test::expect_frame_of_rest(renderer->render(camera, settings_of_pipeline(), outputs), expected,
                             all);
}

TEST_P(CudaDrawn, frames_of_changed_gaussians_are_frames_of_the_cloud_uploaded_again) {
  const Camera camera = test::front_camera(96, 64);
  const Outputs outputs = test::all_outputs(default_mode());
  RenderSettings other_order;
  other_order.pipeline = GetParam() == Pipeline::fast ? Pipeline::classic : Pipeline::fast;
  for (const std::size_t size : {1u, 257u, 1000u})
    for (const bool halves : {false, true})
      for (const int degree : {0, 2}) {
        SCOPED_TRACE(std::to_string(size) + (halves ? " halves " : " floats ") +
                     std::to_string(degree));
        const auto cloud = std::make_shared<GaussianCloud>(
            test::with_halves(test::random_cloud(size, degree, 11)));
        GaussianCloud other = test::surrounding_cloud(size, degree, 12);
        if (halves) other = test::with_halves(std::move(other));
        const auto gpu = make_renderer(Backend::cuda, test::pool());
        gpu->upload(cloud, {});
        for (const std::size_t step : {7, 1, 300}) {
          gpu->render(camera, step == 7 ? settings_of_pipeline() : other_order);
          gpu->update(test::replace_every(step, other, *cloud));
          const auto again = renderer_of(Backend::cuda, *cloud);
          const GaussianSet odd =
              GaussianSet::where(size, test::pool(), [](std::size_t i) { return i % 2 == 1; });
          for (const GaussianSet& drawn : {GaussianSet(size).complement(), odd}) {
            gpu->set_drawn(drawn);
            again->set_drawn(drawn);
            const Frame frame = gpu->render(camera, settings_of_pipeline(), outputs);
            test::expect_frame_of_rest(frame,
                                       again->render(camera, settings_of_pipeline(), outputs),
                                       GaussianSet(size).complement());
          }
        }
      }
}

TEST_P(CudaDrawn, sets_are_drawn_as_on_the_cpu) {
  const GaussianCloud cloud = test::surrounding_cloud(1500, 1, 8);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  const Camera camera = test::front_camera(161, 117);
  for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
    cpu->set_drawn(drawn.set);
    gpu->set_drawn(drawn.set);
    Outputs outputs = test::decisions();
    outputs.mode_pairs = outputs.color = true;
    const Frame& frame = gpu->render(camera, settings_of_pipeline(), outputs);
    const Frame& expected = cpu->render(camera, settings_of_pipeline(), outputs);
    test::expect_equal_decisions(frame, expected);
    EXPECT_EQ(frame.mode_pairs, expected.mode_pairs);
    test::expect_same_image(frame.color, expected.color);
  }
}

TEST_P(CudaDrawn, hidden_parts_of_a_view_with_slabs_may_be_left_out) {
  const GaussianCloud cloud = test::scattered_cloud(
      4000, 96, [](std::size_t i) { return 2 + static_cast<double>(i) / 500; });
  setenv("QUADSPLAT_SLABS", "2", 1);
  const auto cpu = renderer_of(Backend::cpu, cloud), gpu = renderer_of(Backend::cuda, cloud);
  unsetenv("QUADSPLAT_SLABS");
  RenderSettings settings = settings_of_pipeline();
  settings.occlusion = true;
  for (const test::DrawnSet& drawn : test::drawn_sets(cloud)) {
    cpu->set_drawn(drawn.set);
    gpu->set_drawn(drawn.set);
    test::expect_same_image(gpu->render(test::front_camera(96, 96), settings).color,
                            cpu->render(test::front_camera(96, 96), settings).color);
  }
}

}  // namespace
}  // namespace qs
