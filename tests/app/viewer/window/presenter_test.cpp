// SPDX-License-Identifier: MIT
// The window's display of a frame with fewer pixels than the window: Xvfb, software OpenGL.
#include "app/viewer/window/presenter.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "app/support/virtual_display.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/window/window.h"
#include "io/camera/cameras.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/shared.h"

namespace qs {
namespace {

/// Catmull-Rom's cubic interpolation in double precision.
double weight(double t) {
  t = std::abs(t);
  if (t < 1) return 1 - 2.5 * t * t + 1.5 * t * t * t;
  return t < 2 ? 2 - 4 * t + 2.5 * t * t - 0.5 * t * t * t : 0;
}

Image interpolated(const Image& image, int width, int height) {
  Image result(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) * image.width / width - 0.5;
      const double v = (y + 0.5) * image.height / height - 0.5;
      const int left = static_cast<int>(std::floor(u)), top = static_cast<int>(std::floor(v));
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = top - 1; j <= top + 2; ++j) {
          for (int i = left - 1; i <= left + 2; ++i)
            sum += weight(u - i) * weight(v - j) *
                   static_cast<double>(image.at(std::clamp(i, 0, image.width - 1),
                                                std::clamp(j, 0, image.height - 1), c));
        }
        result.at(x, y, c) = static_cast<float>(std::clamp(sum, 0.0, 1.0));
      }
    }
  }
  return result;
}

RenderedFrame frame_of(const Image& image) {
  RenderedFrame frame;
  frame.width = image.width;
  frame.height = image.height;
  for (std::size_t i = 0; i < image.values.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) frame.rgba.push_back(to_8bit(image.values[i + c]));
    frame.rgba.push_back(255);
  }
  return frame;
}

TEST(Presenter, enlarges_a_reduced_frame_closer_to_the_full_one_than_linear_interpolation_does) {
  const test::VirtualDisplay display("1280x720x24");
  if (!display.runs()) GTEST_SKIP() << "Xvfb is not installed";
  const Window window({1280, 720});
  EXPECT_EQ(suitable_enlarging(), Enlarging::linear) << "Xvfb has no GPU";

  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(test::read_scene(test::source_path("assets/plush.ply")).cloud, {});
  const Camera camera =
      read_cameras(test::source_path("assets/cameras.json")).front().resized(1280, 720);
  const Image full = renderer->render(camera).color;
  for (const int divisor : {2, 3}) {
    const RenderSettings settings = reduced(RenderSettings(), divisor);
    const Image small = renderer->render(camera.reduced(divisor), settings).color;
    const auto shown = [&](Enlarging enlarging) {
      Presenter presenter(enlarging);
      presenter.show(frame_of(small), nullptr);
      presenter.draw({1280, 720}, {0, 0, 1280, 720}, Split(), HeatStyle());
      return Presenter::grab(1280, 720);
    };
    const Image cubic = shown(Enlarging::cubic);
    EXPECT_GE(psnr_8bit(cubic, full), psnr_8bit(shown(Enlarging::linear), full) + 0.7) << divisor;
    // Apart from 8-bit texels and from the corners that the shader leaves out.
    if (divisor == 3) {
      EXPECT_GE(psnr_8bit(cubic, interpolated(small, 1280, 720)), 50);
    }
  }
}

TEST(Presenter, shows_a_frame_of_the_window_s_size_bit_for_bit) {
  const test::VirtualDisplay display("1280x720x24");
  if (!display.runs()) GTEST_SKIP() << "Xvfb is not installed";
  const Window window({320, 240});
  Image image(320, 240, 3);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(i * 7919 % 256) / 255.0f;
  Presenter presenter(Enlarging::cubic);
  presenter.show(frame_of(image), nullptr);
  presenter.draw({320, 240}, {0, 0, 320, 240}, Split(), HeatStyle());
  EXPECT_EQ(Presenter::grab(320, 240).values, image.values);
}

TEST(Presenter, shows_a_reduced_frame_alone_as_beside_itself) {
  const test::VirtualDisplay display("1280x720x24");
  if (!display.runs()) GTEST_SKIP() << "Xvfb is not installed";
  const Window window({320, 240});
  Image image(107, 80, 3);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(i * 7919 % 256) / 255.0f;
  const auto shown = [&](const RenderedFrame& frame) {
    Presenter presenter(Enlarging::linear);
    presenter.show(frame, nullptr);
    presenter.draw({320, 240}, {0, 0, 320, 240}, Split(), HeatStyle());
    return Presenter::grab(320, 240).values;
  };
  RenderedFrame beside = frame_of(image);
  beside.other = beside.rgba;
  EXPECT_EQ(shown(beside), shown(frame_of(image)));
}

}  // namespace
}  // namespace qs
