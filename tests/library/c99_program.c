/* SPDX-License-Identifier: MIT
 * A C99 program of the library: opens a scene, draws it twice and checks the results. Its argument
 * is the bundled scene. Both headers of the interface can be included together. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "quadsplat/plugin.h"
#include "quadsplat/quadsplat.h"

static char message[QS_MESSAGE_BYTES];

static void expect(int condition, const char* what) {
  if (condition) return;
  fprintf(stderr, "%s (%s)\n", what, message);
  exit(1);
}

int main(int argc, char** argv) {
  QsContext* context = NULL;
  QsSceneHandle* scene = NULL;
  QsCameras* cameras = NULL;
  QsSceneFacts facts = {0};
  QsCamera camera = {0};
  QsCounts counts = {0};
  QsPicture picture = {0};
  QsSettings settings = QS_SETTINGS;
  QsConversion conversion = QS_CONVERSION;
  QsRules rules = QS_RULES;
  QsAdam adam = QS_ADAM;
  QsModeCounts modes[32];
  uint64_t count = 0, i;
  const char* text = NULL;
  const char* name = NULL;
  enum { width = 60, height = 40 };
  static float first[width * height * 3], second[width * height * 3];

  expect(argc == 2, "usage: c99_program SCENE");
  expect(qs_version(&text) == QS_LIBRARY_VERSION && strlen(text) > 0, "qs_version");
  expect(conversion.size == 64 && conversion.sh_degree == 3, "QS_CONVERSION");
  expect(adam.size == 496 && adam.beta2 == 0.999, "QS_ADAM");
  expect(rules.size == 120 && rules.sh_degree == 3 && rules.alpha_max == 0.99, "QS_RULES");
  expect(qs_context_open(QS_BACKEND_CPU, QS_FIRST_GPU, 1, &context, message) == QS_OK, "open");
  expect(qs_context_backend(context) == QS_BACKEND_CPU, "backend");
  expect(qs_scene_load(context, argv[1], NULL, &scene, message) == QS_OK, "load");
  facts.size = sizeof(facts);
  expect(qs_scene_facts(scene, &facts, message) == QS_OK && facts.gaussians > 1000, "facts");
  expect(qs_cameras_open(facts.cameras_path, &cameras, &count, message) == QS_OK, "cameras");
  camera.size = sizeof(camera);
  expect(count == 97 && qs_cameras_get(cameras, 96, &camera, &name, message) == QS_OK &&
             strlen(name) > 0,
         "the last camera");
  expect(qs_cameras_get(cameras, 97, &camera, NULL, message) == QS_USAGE, "no such camera");
  expect(qs_camera_resize(&camera, width, height, message) == QS_OK, "resize");

  counts.size = sizeof(counts);
  picture.size = sizeof(picture);
  picture.counts = &counts;
  picture.color.data = first;
  picture.color.sizes[0] = height;
  picture.color.sizes[1] = width;
  picture.color.sizes[2] = 3;
  picture.color.strides[0] = width * 3;
  picture.color.strides[1] = 3;
  picture.color.strides[2] = 1;
  picture.color.dimensions = 3;
  expect(qs_render(scene, &camera, 1, NULL, &picture, message) == QS_OK, "render");
  picture.color.data = second;
  expect(qs_render(scene, &camera, 1, &settings, &picture, message) == QS_OK, "render again");
  expect(memcmp(first, second, sizeof(first)) == 0, "QS_SETTINGS are not the usual settings");
  expect(counts.tile_pairs > 0 && counts.tile_columns == 4 && counts.tile_rows == 3, "counts");

  for (i = 0; i < 32; ++i) modes[i].size = sizeof(modes[i]);
  expect(qs_count_modes(scene, &camera, NULL, modes, 32, &count, message) == QS_OK, "modes");
  for (i = 0; i < count && strcmp(modes[i].name, "quadbox") != 0; ++i) continue;
  expect(i < count && modes[i].tile_pairs == counts.tile_pairs, "the pairs of quadbox");

  qs_scene_close(scene);
  expect(qs_scene_load(context, "no_such_file", NULL, &scene, message) == QS_INPUT &&
             scene == NULL && strstr(message, "no_such_file") != NULL,
         "a missing file");
  qs_cameras_close(cameras);
  qs_context_close(context);
  return 0;
}
