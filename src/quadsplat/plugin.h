/* SPDX-License-Identifier: MIT
 *
 * The binary interface between `quadsplat bench --plugin lib.so` and a renderer that it measures,
 * version 1. This is the only header that a plugin needs; it is C99 and C++.
 *
 * A plugin is a shared library that exports one function, qs_plugin(). quadsplat starts a process
 * of its own for every plugin, loads the library there and calls
 *   qs_plugin(), open(), render() for every frame, close()
 * from one thread. The process ends without close() if the plugin crashes, returns an error or does
 * not return in time.
 *
 * Conventions
 * - Structs have the layout of the C compiler on 64-bit Linux; the offset of every member is given.
 * - World and view axes are x right, y down, z forward, as in INRIA's .ply files and COLMAP.
 * - Pixel i has its centre at coordinate i. Software that puts it at i + 0.5, such as COLMAP and
 *   gsplat, adds 0.5 to center_px.
 * - Colours are in the space in which the model was trained, nominally 0..1, and are not clamped.
 * - Memory belongs to the side that allocated it. Pointers that quadsplat passes to open() are
 *   valid and their content constant until close() returns. Pointers that it passes to render() are
 *   valid until render() returns. `renderer` belongs to the plugin; close() frees it.
 * - The plugin may start threads. None may use quadsplat's memory after close().
 * - No C++ exception may leave a function.
 */
#ifndef QUADSPLAT_PLUGIN_H
#define QUADSPLAT_PLUGIN_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A plugin of any other version is refused. The number grows with every change of this file. */
#define QS_PLUGIN_VERSION 1u

/* Where the scene's arrays and the image are. */
#define QS_MEMORY_HOST 0u
/* CUDA device memory of the primary context of QsScene.device, which is current when quadsplat
 * calls the plugin. Pointers of the CUDA runtime and of the driver are interchangeable there. */
#define QS_MEMORY_CUDA 1u

/* The order of an image's values, float32, without padding. */
#define QS_IMAGE_HWC 0u /* image[(y * width + x) * 3 + channel], RGB */
#define QS_IMAGE_CHW 1u /* image[(channel * height + y) * width + x], RGB */

/* Size of the buffer for a plugin's message: UTF-8 text, one sentence, ends with a 0. */
#define QS_MESSAGE_BYTES 256

/* The indices of QsFrame.stage_ms. */
#define QS_STAGE_PREPROCESS 0 /* projecting, culling, colours */
#define QS_STAGE_BIN 1        /* listing (Gaussian, tile) pairs */
#define QS_STAGE_SORT 2
#define QS_STAGE_BLEND 3

/* A scene: arrays of `count` Gaussians, float32, row by row without padding, aligned to 64 bytes.
 * The trained parameters and the activated values describe the same Gaussians. Values are finite
 * except where stated. 80 bytes. */
typedef struct QsScene {
  uint64_t count;          /*  0 */
  int32_t sh_degree;       /*  8: of the array `sh`, 0..3 */
  int32_t device;          /* 12: CUDA's number of the device (bench --device) */
  int32_t threads;         /* 16: threads that the plugin may use on the CPU (bench --threads) */
  int32_t reserved;        /* 20: 0 */
  const float* positions;  /* 24: count x 3, world units */
  const float* log_scales; /* 32: count x 3, ln of the standard deviations; -inf is flat */
  const float* rotations;  /* 40: count x 4, unit quaternions w x y z */
  const float* opacity_logits; /* 48: count, +-inf allowed */
  const float* sh;             /* 56: count x (sh_degree + 1)^2 x RGB, DC first */
  const float* covariances; /* 64: count x 6, xx xy xz yy yz zz = R diag(s^2) R^T, world units^2 */
  const float* opacities;   /* 72: count, 0..1, the sigmoid of opacity_logits */
} QsScene;

/* Everything that a frame depends on besides the scene. A plugin that cannot honour a value returns
 * an error from render(). 176 bytes. */
typedef struct QsView {
  double view_from_world[12]; /*   0: 3 x 4, row by row: rotation | translation */
  double focal_px[2];         /*  96: x, y */
  double center_px[2];        /* 112: principal point, see Conventions */
  double near_depth;          /* 128: Gaussians with view z <= near_depth are not drawn */
  double dilation_px2;        /* 136: added to both variances of a projected Gaussian; 3DGS: 0.3 */
  float background[3];        /* 144: RGB, weighted by the remaining transmittance */
  float splat_scale;          /* 156: factor on every standard deviation; 1 is as trained */
  int32_t width, height;      /* 160, 164: pixels */
  int32_t sh_degree;          /* 168: highest degree to evaluate, at most that of the scene */
  int32_t antialiased;        /* 172: 1 = scale opacities as Mip-Splatting does, 0 = do not */
} QsView;

/* One frame: the plugin draws into `image` and fills the members marked "out". quadsplat sets those
 * to 0, which means "not measured". 64 bytes. */
typedef struct QsFrame {
  float* image;        /*  0: in: width * height * 3 values, every one must be written */
  int32_t mark_stages; /*  8: in: 1 = stage_ms is wanted, and may slow this frame */
  uint32_t visible;    /* 12: out: Gaussians that were drawn */
  uint64_t pairs;      /* 16: out: (Gaussian, tile) pairs listed */
  double frame_ms;     /* 24: out: from the view's arrival to the finished image in the plugin's own
                               memory (on its device), by the device's clock. Without the copy
                               into `image`, if the plugin needs one. 0 = quadsplat measures the
                               call with the host's clock, so render() must wait for the device */
  double stage_ms[4];  /* 32: out: QS_STAGE_... */
} QsFrame;

/* The plugin. 56 bytes. */
typedef struct QsPlugin {
  uint32_t version;        /*  0: QS_PLUGIN_VERSION; nothing else is read if it differs */
  uint32_t memory;         /*  4: QS_MEMORY_... of the scene's arrays and the image */
  uint32_t image_layout;   /*  8: QS_IMAGE_... */
  uint32_t reserved;       /* 12: 0 */
  const char* name;        /* 16: in tables: 1 to 32 letters, digits and - _ . + */
  const char* description; /* 24: below the tables: what it is, its version; at most 255 bytes */

  /* open() and render() return 0, or another number after writing the reason to `message`, which
   * has QS_MESSAGE_BYTES bytes. After an error of open() close() is not called. */
  int32_t (*open)(const QsScene* scene, void** renderer, char* message);                /* 32 */
  int32_t (*render)(void* renderer, const QsView* view, QsFrame* frame, char* message); /* 40 */
  void (*close)(void* renderer);                                                        /* 48 */
} QsPlugin;

/* The only symbol that quadsplat looks up. The result is valid until the process ends. */
__attribute__((visibility("default"))) const QsPlugin* qs_plugin(void);

#ifdef __cplusplus
}
#endif

#endif /* QUADSPLAT_PLUGIN_H */
