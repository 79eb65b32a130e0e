// SPDX-License-Identifier: MIT
//
// Draws one Gaussian with a plugin, using only quadsplat/plugin.h, and compares some pixels with
// values that are computed here: draw_with_plugin LIBRARY. Exit code 1 if they differ.
#include <cmath>
#include <cstdio>
#include <vector>

#include <dlfcn.h>

#include "quadsplat/plugin.h"

namespace {

constexpr int kWidth = 33, kHeight = 25;
constexpr float kSigma = 0.5f, kDepth = 4, kOpacity = 0.75f, kFocal = 20, kDilation = 0.3f;
constexpr float kColor[] = {0.9f, 0.5f, 0.1f}, kBackground[] = {0.1f, 0.2f, 0.3f};

int fail(const char* what) {
  std::printf("%s\n", what);
  return 1;
}

// A round Gaussian in the middle of the picture, `dx` pixels beside its centre.
float expected(int channel, float dx) {
  const float variance = std::pow(kFocal * kSigma / kDepth, 2.0f) + kDilation;
  const float alpha = kOpacity * std::exp(-0.5f * dx * dx / variance);
  return alpha * kColor[channel] + (1 - alpha) * kBackground[channel];
}

}  // namespace

int main(int count, char** words) {
  void* const library = count == 2 ? dlopen(words[1], RTLD_NOW) : nullptr;
  if (library == nullptr) return fail("the library cannot be loaded");
  const auto find = reinterpret_cast<const QsPlugin* (*)()>(dlsym(library, "qs_plugin"));
  const QsPlugin* const plugin = find == nullptr ? nullptr : find();
  if (plugin == nullptr || plugin->version != QS_PLUGIN_VERSION || plugin->memory != QS_MEMORY_HOST)
    return fail("it is no plugin of this version for host memory");

  const float position[] = {0, 0, kDepth}, rotation[] = {1, 0, 0, 0};
  const float log_scale = std::log(kSigma), log_scales[] = {log_scale, log_scale, log_scale};
  const float logit = std::log(kOpacity / (1 - kOpacity)), variance = kSigma * kSigma;
  const float covariance[] = {variance, 0, 0, variance, 0, variance};
  float sh[3];
  for (int c = 0; c < 3; ++c) sh[c] = (kColor[c] - 0.5f) / 0.28209479f;
  QsScene scene = {};
  scene.count = 1;
  scene.threads = 1;
  scene.positions = position;
  scene.log_scales = log_scales;
  scene.rotations = rotation;
  scene.opacity_logits = &logit;
  scene.sh = sh;
  scene.covariances = covariance;
  scene.opacities = &kOpacity;

  QsView view = {};
  view.view_from_world[0] = view.view_from_world[5] = view.view_from_world[10] = 1;
  view.focal_px[0] = view.focal_px[1] = kFocal;
  view.center_px[0] = (kWidth - 1) / 2;
  view.center_px[1] = (kHeight - 1) / 2;
  view.near_depth = 0.2;
  view.dilation_px2 = kDilation;
  for (int c = 0; c < 3; ++c) view.background[c] = kBackground[c];
  view.splat_scale = 1;
  view.width = kWidth;
  view.height = kHeight;

  std::vector<float> image(3 * kWidth * kHeight, NAN);
  QsFrame frame = {};
  frame.image = image.data();
  char message[QS_MESSAGE_BYTES] = {};
  void* renderer = nullptr;
  if (plugin->open(&scene, &renderer, message) != 0) return fail(message);
  const int code = plugin->render(renderer, &view, &frame, message);
  plugin->close(renderer);
  if (code != 0) return fail(message);

  const int middle = kHeight / 2 * kWidth + kWidth / 2, pixels = kWidth * kHeight;
  for (const int dx : {0, 3, 12}) {
    for (int c = 0; c < 3; ++c) {
      const bool planes = plugin->image_layout == QS_IMAGE_CHW;
      const float value = image[planes ? c * pixels + middle + dx : 3 * (middle + dx) + c];
      const float wanted = expected(c, static_cast<float>(dx));
      if (!(std::abs(value - wanted) < 1.5f / 255)) {
        std::printf("%s draws %g instead of %g\n", plugin->name, value, wanted);
        return 1;
      }
    }
  }
  std::printf("%s draws a Gaussian as expected\n", plugin->name);
}
