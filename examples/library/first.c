/* SPDX-License-Identifier: MIT
 * Draws the first camera of a scene in 800 x 600 pixels: first_c SCENE OUT.ppm */
#include <quadsplat/quadsplat.h>
#include <stdio.h>
#include <stdlib.h>

enum { width = 800, height = 600 };
static unsigned char pixels[height][width][3];
static char message[QS_MESSAGE_BYTES];

static void check(int32_t result) {
  if (result == QS_OK) return;
  fprintf(stderr, "%s\n", message);
  exit(result);
}

int main(int argc, char** argv) {
  QsContext* context;
  QsSceneHandle* scene;
  QsCameras* cameras;
  uint64_t count;
  QsSceneFacts facts = {sizeof(facts)};
  QsCamera camera = {sizeof(camera)};
  QsPicture picture = {sizeof(picture)};
  if (argc != 3) return QS_USAGE;
  check(qs_context_open(QS_BACKEND_AUTO, QS_FIRST_GPU, 0, &context, message));
  check(qs_scene_load(context, argv[1], NULL, &scene, message));
  check(qs_scene_facts(scene, &facts, message));
  check(qs_cameras_open(facts.cameras_path, &cameras, &count, message));
  check(qs_cameras_get(cameras, 0, &camera, NULL, message));
  check(qs_camera_resize(&camera, width, height, message));
  picture.color = (QsArray){pixels, {height, width, 3}, {width * 3, 3, 1}, 3, QS_UINT8, QS_MEMORY_HOST, 0};
  check(qs_render(scene, &camera, 1, NULL, &picture, message));
  FILE* file = fopen(argv[2], "wb");
  if (file == NULL) return QS_INPUT;
  fprintf(file, "P6 %d %d 255\n", width, height);
  fwrite(pixels, sizeof(pixels), 1, file);
  fclose(file);
  qs_cameras_close(cameras);
  qs_scene_close(scene);
  qs_context_close(context);
  return 0;
}
