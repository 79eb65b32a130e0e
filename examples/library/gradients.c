/* SPDX-License-Identifier: MIT
 * Moves a Gaussian by gradient descent until it draws the same picture as another. */
#include <quadsplat/quadsplat.h>
#include <stdio.h>
#include <stdlib.h>

enum { width = 64, height = 48 };
typedef float Picture[height][width];
static float mean[3] = {0.5f, 0.2f, 4}, scale[3] = {0.4f, 0.3f, 0.4f}, rotation[4] = {1, 0, 0, 0};
static float opacity = 0.8f, value = 1, by_mean[3];
static Picture wanted, picture, by_picture;
static void* blocks[3];
static int count;
static char message[QS_MESSAGE_BYTES];

static void check(int32_t result) {
  if (result == QS_OK) return;
  fprintf(stderr, "%s\n", message);
  exit(result);
}

static void* allocate(void* user, uint64_t bytes, uint32_t kind) {
  (void)user, (void)kind;
  return count < 3 ? blocks[count++] = malloc(bytes) : NULL;
}

/* A row of numbers for the only Gaussian. */
static QsArray row(float* data, int64_t numbers) {
  return (QsArray){data, {1, numbers}, {numbers, 1}, 2, QS_FLOAT32, QS_MEMORY_HOST, 0};
}

static QsBlended pictures(Picture data) {
  QsBlended result = {sizeof(result)};
  result.color = (QsArray){data, {height, width, 1}, {width, 1, 1}, 3, QS_FLOAT32, QS_MEMORY_HOST, 0};
  return result;
}

int main(void) {
  QsContext* context;
  QsInputs in = {sizeof(in)};
  QsCamera camera = {sizeof(camera), width, height};
  QsMemory memory = {sizeof(memory), 0, NULL, allocate};
  QsBlended drawn = pictures(wanted), by_drawn = pictures(by_picture);
  QsInputGradients by_in = {sizeof(by_in)};
  in.means = row(mean, 3);
  in.scales = row(scale, 3);
  in.rotations = row(rotation, 4);
  in.opacities = (QsArray){&opacity, {1}, {1}, 1, QS_FLOAT32, QS_MEMORY_HOST, 0};
  in.channels = row(&value, 1);
  by_in.means = row(by_mean, 3);
  for (int axis = 0; axis < 3; ++axis) camera.view_from_world[5 * axis] = 1;
  camera.focal_px[0] = camera.focal_px[1] = 60;
  camera.center_px[0] = 31.5;
  camera.center_px[1] = 23.5;
  camera.near_depth = 0.2;
  check(qs_context_open(QS_BACKEND_CPU, 0, 0, &context, message));
  for (int step = 0; step <= 200; ++step) {
    QsStageFrame frame = {sizeof(frame)};
    check(qs_forward(context, &in, &camera, NULL, &memory, NULL, &drawn, &frame, message));
    if (step == 0) {
      mean[0] = mean[1] = 0; /* the first picture is the wanted one */
      drawn = pictures(picture);
    } else {
      /* The loss is the sum of (picture - wanted)^2. */
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) by_picture[y][x] = 2 * (picture[y][x] - wanted[y][x]);
      check(qs_backward(context, &in, &camera, NULL, &frame, &by_drawn, NULL, &by_in, message));
      for (int axis = 0; axis < 3; ++axis) mean[axis] -= 0.001f * by_mean[axis];
    }
    while (count > 0) free(blocks[--count]);
  }
  printf("%.3f %.3f %.3f\n", mean[0], mean[1], mean[2]);
  qs_context_close(context);
  return 0;
}
