/* SPDX-License-Identifier: MIT
 * Draws the first camera of a scene: first_c SCENE OUT.ppm */
#include <stdio.h>
#include <stdlib.h>

#include <quadsplat/quadsplat.h>

static char message[QS_MESSAGE_BYTES];

static void check(int32_t result) {
  if (result == QS_OK) return;
  fprintf(stderr, "%s\n", message);
  exit(result);
}

int main(int argc, char** argv) {
  if (argc != 3) return QS_USAGE;
  QsContext* context;
  QsSceneHandle* scene;
  QsSceneFacts facts = {sizeof(facts)};
  QsCameras* cameras;
  uint64_t count;
  QsCamera camera = {sizeof(camera)};
  check(qs_context_open(QS_BACKEND_AUTO, QS_FIRST_GPU, 0, &context, message));
  check(qs_scene_load(context, argv[1], NULL, &scene, message));
  check(qs_scene_facts(scene, &facts, message));
  check(qs_cameras_open(facts.cameras_path, &cameras, &count, message));
  check(qs_cameras_get(cameras, 0, &camera, NULL, message));

  const int64_t width = camera.width, height = camera.height;
  unsigned char* pixels = malloc((size_t)(width * height * 3));
  QsCounts counts = {sizeof(counts)};
  QsPicture picture = {sizeof(picture)};
  picture.color = (QsArray){pixels, {height, width, 3}, {width * 3, 3, 1}, 3, QS_UINT8, QS_MEMORY_HOST, 0};
  picture.counts = &counts;
  check(qs_render(scene, &camera, 1, NULL, &picture, message));
  printf("%llu of %llu Gaussians are visible, %llu tile pairs\n", (unsigned long long)counts.visible,
         (unsigned long long)counts.gaussians, (unsigned long long)counts.tile_pairs);

  FILE* file = fopen(argv[2], "wb");
  if (file == NULL) return QS_INPUT;
  fprintf(file, "P6\n%d %d\n255\n", (int)width, (int)height);
  fwrite(pixels, 3, (size_t)(width * height), file);
  fclose(file);
  free(pixels);
  qs_cameras_close(cameras);
  qs_scene_close(scene);
  qs_context_close(context);
  return 0;
}
