/* SPDX-License-Identifier: MIT
 *
 * libquadsplat: reads scenes of 3D Gaussians, renders and counts views of them, differentiates
 * their pictures, has the parts of a trainer, converts scenes and compares pictures. It gives the
 * same bytes as the program quadsplat. This is the whole interface, version 1; it is C99 and C++.
 * docs/library.md has a first program.
 *
 * Conventions
 * - Structs have the layout of the C compiler on 64-bit Linux; the offset of every member is given.
 *   A struct whose first member is `size` may grow at its end. The caller sets `size` to
 *   sizeof(the struct) and every other member, unused members to 0. A library that is newer than
 *   the caller takes its members as 0; an older library refuses members that it does not know
 *   unless they are 0. The elements of an array of such structs all have the size of the first.
 * - Functions that return int32_t return QS_OK or another QS_... code of the first group below.
 *   Then `message`, which has QS_MESSAGE_BYTES bytes or is null, holds one sentence. After QS_OK it
 *   is empty. No exception leaves the library, and it neither prints nor ends the process.
 * - Text is UTF-8 and ends with a 0. A pointer that the library returns is never null unless it
 *   says so.
 * - World and view axes are x right, y down, z forward, as in INRIA's .ply files and COLMAP.
 * - Pixel i has its centre at coordinate i. Software that puts it at i + 0.5, such as COLMAP and
 *   gsplat, adds 0.5 to center_px.
 * - Colours are in the space in which the model was trained, nominally 0..1, and are not clamped.
 *   8-bit values are floor(255 * clamp(x, 0, 1) + 0.5).
 * - One thread at a time uses a context and the scenes in it. It need not be the thread that opened
 *   them. Different contexts are independent. A process that was forked opens its own contexts.
 */
#ifndef QUADSPLAT_QUADSPLAT_H
#define QUADSPLAT_QUADSPLAT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The number in the library's name, libquadsplat.so.1. It grows when a program that was built for
 * an earlier number would no longer work. New functions and new members do not change it. */
#define QS_LIBRARY_VERSION 1

#define QS_LIBRARY_FUNCTION __attribute__((visibility("default")))

/* Results, with the meaning of the program's exit codes. */
#define QS_OK 0
#define QS_USAGE 1     /* an argument is wrong */
#define QS_INPUT 2     /* a file is missing, damaged or of the wrong kind, or cannot be written */
#define QS_DEVICE 3    /* no usable device, or not enough memory */
#define QS_CANCELLED 4 /* qs_stop() was called, or a callback ended the call */

/* Size of the buffer for a message. */
#define QS_MESSAGE_BYTES 256

/* ---- arrays ---------------------------------------------------------------------------------- */

/* Element types. */
#define QS_FLOAT32 0u
#define QS_FLOAT64 1u
#define QS_UINT8 2u
#define QS_INT32 3u
#define QS_UINT32 4u
#define QS_INT64 5u
#define QS_UINT64 6u

/* The memory that holds an array. qs_scene_wrap(), qs_render(), qs_compare(), the differentiable
 * rasterizer and the parts of a trainer take QS_MEMORY_CUDA, but qs_ssim() and qs_ssim_backward();
 * every other function refuses it. */
#define QS_MEMORY_HOST 0u
#define QS_MEMORY_CUDA 1u /* of the primary context of `device` */

/* An array, or a view of one. An array of 0 dimensions is absent. Element (i, j, ..) is at
 * data + i * strides[0] + j * strides[1] + .., counted in elements. Strides may be negative, and in
 * arrays that the library reads they may be 0. `data` is aligned to its elements, and may be null
 * if a size is 0. The library never frees `data`. This struct does not grow. 88 bytes. */
typedef struct QsArray {
  void* data;          /*  0 */
  int64_t sizes[4];    /*  8: elements along each dimension */
  int64_t strides[4];  /* 40: elements from an index to the next */
  uint32_t dimensions; /* 72: 0..4 */
  uint32_t type;       /* 76: QS_FLOAT32, ... */
  uint32_t memory;     /* 80: QS_MEMORY_... */
  int32_t device;      /* 84: CUDA's number of the device; 0 for QS_MEMORY_HOST */
} QsArray;

/* An absent array, to initialise a QsArray. */
#define QS_ABSENT \
  { 0, {0, 0, 0, 0}, {0, 0, 0, 0}, 0, 0, 0, 0 }

/* ---- the library and the machine ------------------------------------------------------------- */

/* QS_LIBRARY_VERSION of the library. If `text` is not null, *text becomes the version of quadsplat
 * and its commit, "0.1.0 (1a2b3c)", valid for ever. */
QS_LIBRARY_FUNCTION int32_t qs_version(const char** text);

/* A GPU. 416 bytes. */
typedef struct QsGpu {
  uint32_t size;        /*   0 */
  int32_t major, minor; /*   4, 8: compute capability */
  uint32_t reserved;    /*  12 */
  uint64_t total_bytes; /*  16 */
  uint64_t free_bytes;  /*  24 */
  char name[128];       /*  32 */
  char problem[256];    /* 160: the reason why it cannot be used, a clause; empty: it can */
} QsGpu;

/* The devices of this machine. 304 bytes. */
typedef struct QsReport {
  uint32_t size;          /*  0 */
  uint32_t gpus;          /*  4: number of GPUs, in the order of CUDA's numbers */
  uint32_t threads;       /*  8: hardware threads */
  int32_t first_gpu;      /* 12: the first GPU that can be used; -1: none */
  char driver[16];        /* 16: newest CUDA version that the driver supports; empty: none */
  char runtime[16];       /* 32: CUDA version of this library; empty: built without CUDA */
  char cuda_problem[256]; /* 48: the reason why no GPU can be used, a sentence; empty: one can */
} QsReport;

/* Fills the report and the first `capacity` elements of `gpus`, which may be null for a capacity of
 * 0. It asks the driver at every call, and opens CUDA's context on every GPU. */
QS_LIBRARY_FUNCTION int32_t qs_report(QsReport* report, QsGpu* gpus, uint64_t capacity,
                                      char* message);

/* A culling mode. 32 bytes. */
typedef struct QsMode {
  uint32_t size;        /*  0 */
  uint32_t is_peer;     /*  4: 1: from another paper, and not counted by qs_count_modes() */
  uint32_t is_lossless; /*  8: 1: lists every tile with a pixel of alpha >= 1/255 */
  uint32_t keeps_faint; /* 12: 1: also lists Gaussians of opacity <= 1/255 */
  const char* name;     /* 16: for QsSettings.cull, valid for ever */
  const char* summary;  /* 24: one clause, valid for ever */
} QsMode;

/* Fills *mode with the mode of a number and *count, which may be null, with the number of modes.
 * Mode 0 is "reference", which computes in double precision on the CPU and takes seconds. QS_USAGE
 * for a number from *count on. */
QS_LIBRARY_FUNCTION int32_t qs_mode(uint32_t number, QsMode* mode, uint32_t* count, char* message);

/* ---- contexts -------------------------------------------------------------------------------- */

typedef struct QsContext QsContext;

#define QS_BACKEND_AUTO 0u /* CUDA where it works, else the CPU */
#define QS_BACKEND_CPU 1u
#define QS_BACKEND_CUDA 2u

#define QS_FIRST_GPU (-1)

/* Opens a context: a backend, a GPU and threads of the CPU. `device` is CUDA's number or
 * QS_FIRST_GPU, the first that works; backend CPU ignores it. `threads` counts the calling thread:
 * 1 starts no thread, 0 means one per hardware thread, at most 1024. Results do not depend on their
 * number. */
QS_LIBRARY_FUNCTION int32_t qs_context_open(uint32_t backend, int32_t device, int32_t threads,
                                            QsContext** context, char* message);

/* Closes the context. Scenes that are still open can only be closed afterwards. Null is allowed. In
 * a forked process it leaves the memory of the context allocated. */
QS_LIBRARY_FUNCTION void qs_context_close(QsContext* context);

/* The backend that a context chose, QS_BACKEND_CPU or QS_BACKEND_CUDA; 0 for null. */
QS_LIBRARY_FUNCTION uint32_t qs_context_backend(const QsContext* context);

/* Sets the cudaStream_t of the GPU's arrays in functions that have no member `stream`, until it is
 * set again. Null, as at the beginning: CUDA's default stream. */
QS_LIBRARY_FUNCTION int32_t qs_context_stream(QsContext* context, void* stream, char* message);

/* Any thread may call it while a call with this context or its scenes runs: that call returns
 * QS_CANCELLED soon, or finishes. Without such a call it does nothing. */
QS_LIBRARY_FUNCTION void qs_stop(QsContext* context);

/* ---- scenes ---------------------------------------------------------------------------------- */

typedef struct QsSceneHandle QsSceneHandle;

/* Reads a scene of any format that the program reads, or the highest iteration of a model folder.
 * `axes` overrides the axes that the file declares, "RDF", "RUB", ...; null or empty: trust the
 * file. Gaussians with NaN or infinite values are left out, and QsSceneFacts.warnings says so.
 * After an error *scene is null. */
QS_LIBRARY_FUNCTION int32_t qs_scene_load(QsContext* context, const char* path, const char* axes,
                                          QsSceneHandle** scene, char* message);

#define QS_COLORS_SH 0u  /* coefficients of spherical harmonics, DC first */
#define QS_COLORS_RGB 1u /* colours without view dependence; below 0 they are drawn as 0 */

/* N Gaussians in the memory of the caller, of type QS_FLOAT32 or QS_FLOAT64. All arrays are in host
 * memory, or all are in the memory of the context's GPU. 552 bytes. */
typedef struct QsGaussians {
  uint32_t size;         /*   0 */
  uint32_t is_activated; /*   4: 0: scales are natural logarithms and opacities are logits, as in
                                 files; 1: scales are standard deviations, opacities are 0..1 */
  uint32_t colors_are;   /*   8: QS_COLORS_... */
  uint32_t antialiased;  /*  12: 1: trained with Mip-Splatting's opacity compensation */
  QsArray means;         /*  16: N x 3, world */
  QsArray scales;        /* 104: N x 3 */
  QsArray rotations;     /* 192: N x 4, quaternions w x y z of any length but 0 */
  QsArray opacities;     /* 280: N */
  QsArray colors;        /* 368: SH: N x K x RGB, K = 1, 4, 9 or 16; RGB: N x 3 */
  QsArray rest;          /* 456: absent, or the SH but DC, N x (K - 1) x RGB; then colors has the DC
                                 alone, N x 1 x RGB */
  void* stream;          /* 544: of arrays on a GPU: the cudaStream_t in which they are ready; null:
                                 CUDA's default stream */
} QsGaussians;

/* Opens a scene of the caller's Gaussians, 0 or more. The values are copied: the arrays may change
 * or be freed when the function returns. Arrays on a GPU are copied to the host. Activated values
 * become float32 logarithms and logits, so their pictures differ from pictures of those by rounding
 * alone. Gaussians with NaN or infinite values, negative standard deviations, opacities outside of
 * 0..1 or a rotation of length 0 are not drawn; the other Gaussians keep their numbers. After an
 * error *scene is null. */
QS_LIBRARY_FUNCTION int32_t qs_scene_wrap(QsContext* context, const QsGaussians* gaussians,
                                          QsSceneHandle** scene, char* message);

/* The facts of a scene. 112 bytes. Pointers are valid until the scene is closed; texts are empty
 * where nothing is known. */
typedef struct QsSceneFacts {
  uint32_t size;             /*   0 */
  int32_t sh_degree;         /*   4: 0..3 */
  uint64_t gaussians;        /*   8: numbers that Gaussians have, 0 .. gaussians - 1 */
  uint64_t not_drawn;        /*  16: of them, for NaN, infinite or impossible values */
  uint64_t file_bytes;       /*  24: of all files that were read */
  float low[3], high[3];     /*  32, 44: box of the centres, world */
  uint32_t antialiased;      /*  56: 1: trained with opacity compensation */
  uint32_t white_background; /*  60: 1: the model's cfg_args ask for a white background */
  const char* path;          /*  64: the file that was read */
  const char* format;        /*  72: "ply, binary little endian" */
  const char* axes;          /*  80: of the file; the scene's are always RDF */
  const char* vertical_axis; /*  88: as the file declares it: "y", "-z", ... */
  const char* cameras_path;  /*  96: the file of cameras beside the scene, for qs_cameras_open() */
  const char* warnings;      /* 104: sentences about the file, a line each */
} QsSceneFacts;

QS_LIBRARY_FUNCTION int32_t qs_scene_facts(const QsSceneHandle* scene, QsSceneFacts* facts,
                                           char* message);

/* Copies the Gaussians of a scene into arrays of the caller, the opposite of qs_scene_wrap(). N is
 * QsSceneFacts.gaussians, and row i has the Gaussian of number i. Rows of Gaussians that are not
 * drawn are NaN in every array. All arrays are optional, but `rest` needs `colors`. colors_are is
 * QS_COLORS_SH, with any K up to the scene's: the first K coefficients. Rotations have length 1.
 * Standard deviations and opacities of 0..1 are computed in double precision and rounded.
 * Logarithms and logits are the scene's own values. `antialiased` is 0, because QsSceneFacts has
 * it. The arrays are in host memory, and nothing goes to a GPU. After an error they are unchanged.
 */
QS_LIBRARY_FUNCTION int32_t qs_scene_gaussians(QsSceneHandle* scene, const QsGaussians* gaussians,
                                               char* message);

/* Null is allowed. */
QS_LIBRARY_FUNCTION void qs_scene_close(QsSceneHandle* scene);

#define QS_ALL_SH_DEGREES 3

/* The form in which qs_convert() writes a scene; QS_CONVERSION has the usual values. 64 bytes. */
typedef struct QsConversion {
  uint32_t size;         /*  0 */
  uint32_t overwrite;    /*  4: 1: an existing file is replaced; never the file of the scene */
  int32_t sh_degree;     /*  8: highest degree that is written, 0..3 */
  uint32_t reserved;     /* 12 */
  uint64_t keep_largest; /* 16: writes this number of Gaussians with the largest opacity times area;
                                0: all */
  const char* format;    /* 24: name of the format; null or empty: by the file's ending */
  float crop_low[3];     /* 32: a box of the world; Gaussians with their centre outside are left */
  float crop_high[3];    /* 44: out; low <= high; all six 0: no box */
  uint32_t drops_floaters; /* 56: 1: leaves out floaters, as --drop-floaters */
  uint32_t reserved2;      /* 60 */
} QsConversion;

#define QS_CONVERSION \
  { sizeof(QsConversion), 0, QS_ALL_SH_DEGREES, 0, 0, 0, {0, 0, 0}, {0, 0, 0}, 0, 0 }

/* Writes the scene: .ply, .compressed.ply, .spz, .splat, .glb. The file appears whole or not at
 * all. `conversion` may be null. */
QS_LIBRARY_FUNCTION int32_t qs_convert(QsSceneHandle* scene, const char* path,
                                       const QsConversion* conversion, char* message);

/* ---- cameras --------------------------------------------------------------------------------- */

/* A camera: a pinhole camera, or one of another model, through whose lens qs_render() draws. Every
 * other function takes pinhole cameras alone. 320 bytes. */
typedef struct QsCamera {
  uint32_t size;              /*   0 */
  int32_t width, height;      /*   4, 8: pixels, 1..65535 */
  uint32_t reserved;          /*  12 */
  double view_from_world[12]; /*  16: 3 x 4, row by row: rotation | translation */
  double focal_px[2];         /* 112: x, y, > 0; 0 with a model */
  double center_px[2];        /* 128: principal point, see Conventions; 0 with a model */
  double near_depth;          /* 144: Gaussians with view z <= near_depth are not drawn; usually
                                      0.2, at least 0. Of a model with faces, see QsPicture, the
                                      distance from the eye counts */
  char model[32]; /* 152: empty: a pinhole camera; or the name of a camera model of COLMAP, as
                          "OPENCV_FISHEYE", or "ORTHOGRAPHIC" */
  double parameters[16]; /* 184: of the model, in the order and the units of COLMAP, which puts the
                                 centre of pixel i at i + 0.5; the others are 0. EQUIRECTANGULAR has
                                 the picture's sides, and ORTHOGRAPHIC its height in units of the
                                 world */
  uint32_t parameter_count; /* 312: of the model; 0 of a pinhole camera */
  uint32_t reserved2;       /* 316 */
} QsCamera;

typedef struct QsCameras QsCameras;

/* Reads the cameras of a cameras.json, a transforms.json, or a folder or file of COLMAP. A lens
 * that distorts gives the pinhole camera of its undistorted photograph, and a lens too wide for one
 * gives a camera of 96 degrees that looks ahead. After an error *cameras is null. */
QS_LIBRARY_FUNCTION int32_t qs_cameras_open(const char* path, QsCameras** cameras, uint64_t* count,
                                            char* message);

/* Fills *camera. If `name` is not null, *name becomes the name of the photograph, valid until
 * qs_cameras_close(). */
QS_LIBRARY_FUNCTION int32_t qs_cameras_get(const QsCameras* cameras, uint64_t number,
                                           QsCamera* camera, const char** name, char* message);

/* As qs_cameras_get(), with the lens that took the photograph: a camera with a model, of the
 * photograph's size and the lens's pose. A camera without distortion stays a pinhole camera. */
QS_LIBRARY_FUNCTION int32_t qs_cameras_lens(const QsCameras* cameras, uint64_t number,
                                            QsCamera* camera, const char** name, char* message);

/* Null is allowed. */
QS_LIBRARY_FUNCTION void qs_cameras_close(QsCameras* cameras);

/* Gives the camera another size in pixels. The vertical field of view stays, as with the program's
 * option --size. Every model but EQUIRECTANGULAR takes any size. */
QS_LIBRARY_FUNCTION int32_t qs_camera_resize(QsCamera* camera, int32_t width, int32_t height,
                                             char* message);

/* ---- pictures -------------------------------------------------------------------------------- */

#define QS_PIPELINE_FAST 0u
#define QS_PIPELINE_CLASSIC 1u /* follows the published 3DGS code; plain C++ on the CPU */

#define QS_ANTIALIASED_AS_TRAINED 0u
#define QS_ANTIALIASED_ON 1u
#define QS_ANTIALIASED_OFF 2u

/* Everything that a frame depends on besides scene and camera; QS_SETTINGS has the usual values.
 * 56 bytes. */
typedef struct QsSettings {
  uint32_t size;        /*  0 */
  uint32_t pipeline;    /*  4: QS_PIPELINE_...; both draw the same pictures within rounding */
  const char* cull;     /*  8: name of a culling mode; null: "quadbox" */
  float background[3];  /* 16: RGB, finite, weighted by the remaining transmittance */
  float splat_scale;    /* 28: factor on every standard deviation, 1e-6..1e6 */
  double dilation_px2;  /* 32: added to both variances of a projected Gaussian, 0..1e6 */
  int32_t sh_degree;    /* 40: highest degree that is evaluated, 0..3 */
  uint32_t antialiased; /* 44: QS_ANTIALIASED_... */
  int32_t tile_px;      /* 48: side of a tile: 16; on the CPU also 8 or 32 */
  uint32_t reserved;    /* 52 */
} QsSettings;

#define QS_SETTINGS                                                                \
  {                                                                                \
    sizeof(QsSettings), QS_PIPELINE_FAST, 0, {0, 0, 0}, 1, 0.3, QS_ALL_SH_DEGREES, \
        QS_ANTIALIASED_AS_TRAINED, 16, 0                                           \
  }

/* The indices of QsCounts.stage_ms. */
#define QS_STAGE_PREPROCESS 0 /* projecting, culling, colours */
#define QS_STAGE_BIN 1        /* listing (Gaussian, tile) pairs */
#define QS_STAGE_SORT 2
#define QS_STAGE_BLEND 3

/* The numbers of a frame. 120 bytes. */
typedef struct QsCounts {
  uint32_t size;                /*   0 */
  uint32_t pipeline;            /*   4: that drew the frame: `classic` also draws views and tiles
                                        that `fast` cannot draw */
  int32_t tile_columns;         /*   8 */
  int32_t tile_rows;            /*  12 */
  int32_t tile_px;              /*  16: side of a tile */
  int32_t threads;              /*  20: of the CPU; 0 on a GPU */
  uint64_t gaussians;           /*  24: that can be drawn */
  uint64_t visible;             /*  32: Gaussians with at least one tile */
  uint64_t tile_pairs;          /*  40: (Gaussian, tile) pairs listed */
  uint64_t max_pairs_in_a_tile; /*  48 */
  uint64_t sort_bytes;          /*  56: of the keys and values that were sorted */
  uint64_t used_pairs;          /*  64: pairs that a pixel blended; 0 unless `used` was requested,
                                        and in mode reference */
  double frame_ms;    /*  72: from the camera to the picture in the memory of the backend */
  double stage_ms[4]; /*  80: QS_STAGE_...; on a GPU 0 */
  double reserved;    /* 112 */
} QsCounts;

/* The results of a view that the caller asks for. Absent arrays are not computed. Any strides are
 * allowed: with sizes height, width, 3, the strides width * 3, 3, 1 store RGB values interleaved
 * and width, 1, width * height store them in planes. Integers are stored in any integer type of 32
 * or 64 bits. `color`, `alpha`, `depth` and `median_depth` may all be in the memory of the
 * context's GPU; then they are not copied through the host. Cameras with a model but ORTHOGRAPHIC
 * are drawn by up to 24 pinhole pictures, the faces: depths are distances from the eye, counts are
 * sums over the faces, and `evaluated`, `pairs` and `used` must be absent. 640 bytes. */
typedef struct QsPicture {
  uint32_t size;        /*   0 */
  uint32_t reserved;    /*   4 */
  QsArray color;        /*   8: height x width x 3: RGB, QS_FLOAT32 or QS_UINT8 */
  QsArray alpha;        /*  96: height x width: 1 - transmittance, 0..1, QS_FLOAT32 or QS_UINT8 */
  QsArray depth;        /* 184: height x width: mean view z of the Gaussians by weight, units of the
                                scene, 0 where alpha is 0, QS_FLOAT32 */
  QsArray median_depth; /* 272: height x width: view z of the first Gaussian with a transmittance
                                <= 1/2 behind it, 0 where none has it, QS_FLOAT32 */
  QsArray evaluated;    /* 360: height x width: list entries up to where the pixel stopped */
  QsArray pairs;        /* 448: tile_rows x tile_columns: pairs listed */
  QsArray used;         /* 536: tile_rows x tile_columns: pairs that a pixel blended */
  QsCounts* counts;     /* 624: null: not wanted */
  void* stream; /* 632: of arrays on a GPU: the cudaStream_t of earlier work with them; null:
                        CUDA's default stream. The results are there when qs_render()
                        returns */
} QsPicture;

/* Renders `views` views of the scene, 0 or more: camera i into picture i. `settings` may be null.
 * The scene is uploaded by the first call. After an error pictures may be incomplete. */
QS_LIBRARY_FUNCTION int32_t qs_render(QsSceneHandle* scene, const QsCamera* cameras, uint64_t views,
                                      const QsSettings* settings, const QsPicture* pictures,
                                      char* message);

/* The decisions of a frame, as views of the library's memory (QS_MEMORY_HOST) that are valid until
 * the next call with this scene. V visible Gaussians in the order of their numbers, T tiles row by
 * row, P pairs. In mode reference a single list has all Gaussians. 816 bytes. */
typedef struct QsLists {
  uint32_t size;        /*   0 */
  int32_t tile_px;      /*   4: side of a tile */
  int32_t tile_columns; /*   8 */
  int32_t tile_rows;    /*  12 */
  QsArray gaussians;    /*  16: V: number of the Gaussian, QS_UINT32 */
  QsArray depths;       /* 104: V: view z, QS_FLOAT32, as the next four */
  QsArray means_px;     /* 192: V x 2: pixels */
  QsArray covariances;  /* 280: V x 3: xx xy yy, px^2, dilated */
  QsArray conics;       /* 368: V x 3: a b c, the inverse of the covariance */
  QsArray opacities;    /* 456: V: at the centre, with compensation, QS_FLOAT32 */
  QsArray colors;       /* 544: V x 3: RGB as seen by the camera, QS_FLOAT32 */
  QsArray tile_begin;   /* 632: T + 1: the list of tile t is listed[tile_begin[t]] up to
                                listed[tile_begin[t + 1]], without its end, QS_UINT64 */
  QsArray listed;       /* 720: P: numbers of Gaussians, front to back, QS_UINT32 */
  uint64_t reserved;    /* 808 */
} QsLists;

QS_LIBRARY_FUNCTION int32_t qs_lists(QsSceneHandle* scene, const QsCamera* camera,
                                     const QsSettings* settings, QsLists* lists, char* message);

/* The size of a view's frame in a culling mode. 32 bytes. */
typedef struct QsModeCounts {
  uint32_t size;       /*  0 */
  uint32_t mode;       /*  4: number of the mode, for qs_mode() */
  const char* name;    /*  8: of the mode, valid for ever */
  uint64_t tile_pairs; /* 16 */
  uint64_t visible;    /* 24 */
} QsModeCounts;

/* Counts the pairs of a view in every mode but mode reference and those of other papers, without
 * drawing it. It fills the first `capacity` elements of `counts`, and *count, which may be null,
 * with the number of these modes. The mode of the settings does not matter. */
QS_LIBRARY_FUNCTION int32_t qs_count_modes(QsSceneHandle* scene, const QsCamera* camera,
                                           const QsSettings* settings, QsModeCounts* counts,
                                           uint64_t capacity, uint64_t* count, char* message);

/* ---- selecting and measuring ----------------------------------------------------------------- */

/* Carries out the steps of `edits`, the text of a file of edits (docs/formats.md, section Edits),
 * and stores the selected Gaussians at the end, and those that are neither hidden nor removed, as 0
 * or 1 in arrays of N of QS_UINT8; each may be null. N is QsSceneFacts.gaussians. The scene stays
 * as it is: `scale` and `level` do nothing, and the hash of the edited file is not compared.
 * Gaussians that are not drawn are in no array. QS_INPUT for edits that do not fit. */
QS_LIBRARY_FUNCTION int32_t qs_select(QsSceneHandle* scene, const char* edits,
                                      const QsArray* selected, const QsArray* left, char* message);

/* The point of the surface that a pixel shows: where half of its light is stopped. All values are
 * NaN if more than half of the light passes. 80 bytes; it does not grow. */
typedef struct QsSurfacePoint {
  double position[3];  /*  0: world */
  double direction[3]; /* 24: from the eye, a unit vector */
  double distance;     /* 48: from the eye, world units, as the next */
  double along;        /* 56: standard deviation along the ray */
  double across;       /* 64: and across it */
  double to_next;      /* 72: standard deviation of the distance to the next pixel's point */
} QsSurfacePoint;

/* Measures the points of `count` pixels x, y of a view, counted from the top left. QS_USAGE for a
 * pixel outside of the picture. */
QS_LIBRARY_FUNCTION int32_t qs_measure(QsSceneHandle* scene, const QsCamera* camera,
                                       const QsSettings* settings, const int32_t* pixels,
                                       uint64_t count, QsSurfacePoint* points, char* message);

/* ---- files of pictures ----------------------------------------------------------------------- */

typedef struct QsPictureFile QsPictureFile;

/* Reads a picture of any format that the program reads. *values becomes a view of height x width x
 * channels, 1 to 4, QS_FLOAT32, integers scaled to 0..1, valid until qs_picture_close(). After an
 * error *picture is null. */
QS_LIBRARY_FUNCTION int32_t qs_picture_open(const char* path, QsPictureFile** picture,
                                            QsArray* values, char* message);

/* Null is allowed. */
QS_LIBRARY_FUNCTION void qs_picture_close(QsPictureFile* picture);

/* Writes height x width, or height x width x 1 to 4 values, QS_FLOAT32 or QS_UINT8. The name's
 * ending chooses the format: .png and .ppm store 8 bits of 0..1, .pfm and .npy store floats. A
 * missing module for other formats is QS_DEVICE. The file appears whole or not at all. A file that
 * exists is replaced if `overwrite` is 1, or if quadsplat wrote it as a picture. */
QS_LIBRARY_FUNCTION int32_t qs_picture_save(const QsArray* values, const char* path,
                                            uint32_t overwrite, char* message);

/* ---- comparing pictures ---------------------------------------------------------------------- */

#define QS_METRIC_PSNR 1u         /* dB of the values; infinity if they are equal */
#define QS_METRIC_PSNR_8BIT 2u    /* dB of the values rounded to 8 bits */
#define QS_METRIC_SSIM 4u         /* window of 11 x 11 pixels, sigma 1.5 */
#define QS_METRIC_FLIP 8u         /* mean of LDR-FLIP at 67.02 pixels per degree */
#define QS_METRIC_LPIPS 16u       /* LPIPS of values of -1..1, for which its network was made */
#define QS_METRIC_LPIPS_PAPER 32u /* LPIPS of values of 0..1, as the scripts of 3DGS compute it */

#define QS_BORDER_ZEROS 0u /* of SSIM: every pixel counts; values outside are 0 */
#define QS_BORDER_CROP 1u  /* of SSIM: pixels whose window is inside; both sides >= 11 pixels */

/* The metrics of two pictures. 168 bytes. */
typedef struct QsComparison {
  uint32_t size;        /*   0 */
  uint32_t metrics;     /*   4: in: sum of QS_METRIC_... */
  uint32_t ssim_border; /*   8: in: QS_BORDER_... */
  uint32_t reserved;    /*  12 */
  QsArray mask;         /*  16: in: absent, or height x width, QS_UINT8: PSNR and SSIM leave out
                                pixels of value 0; the other metrics refuse a mask */
  double psnr;          /* 104: out, as the next three: 0 unless asked for */
  double psnr_8bit;     /* 112 */
  double ssim;          /* 120 */
  double flip;          /* 128 */
  double reserved2;     /* 136 */
  double lpips;         /* 144: out, as the next: 0 unless asked for */
  double lpips_paper;   /* 152 */
  const char* lpips_weights; /* 160: in: the .safetensors file that scripts/lpips_weights makes; its
                                     network decides the smallest side of the pictures */
} QsComparison;

/* Compares two pictures of height x width x 3, QS_FLOAT32, QS_FLOAT64 or QS_UINT8 (as value / 255).
 * Values are clamped to 0..1, and NaN counts as 0. `a` is the reference. Both pictures and the mask
 * are in the same memory. With the GPU of the context PSNR and SSIM are computed there, in the
 * stream of qs_context_stream(), and the call waits: PSNR and SSIM equal the CPU's but for the
 * order of sums in double precision, and PSNR of 8 bits is equal. The other metrics copy both
 * pictures to the host. */
QS_LIBRARY_FUNCTION int32_t qs_compare(QsContext* context, const QsArray* a, const QsArray* b,
                                       QsComparison* comparison, char* message);

/* ---- gradients ------------------------------------------------------------------------------- */

/* A differentiable rasterizer in two passes:
 *
 *   QsInputs --qs_project--> QsBoundary --qs_blend--> QsBlended
 *
 * and back, from derivatives of a number L by the pictures to its derivatives by all inputs:
 *
 *   QsInputGradients <--qs_project_backward-- QsBoundaryGradients <--qs_blend_backward-- QsBlended
 *
 * qs_forward() and qs_backward() are both passes in one call, with the same values. All real arrays
 * of a call have the type of QsInputs.means, QS_FLOAT32, or QS_FLOAT64 to check gradients; the
 * lists are decided in single precision for both. An array that is absent is not given or not
 * wanted; all elements of wanted arrays are written. Sums are in a fixed order, so results do not
 * depend on the number of threads and are the same at every call. Gaussians with a number that is
 * not finite are not drawn, and their gradients are 0.
 *
 * The functions run where QsInputs.means is. If it is in host memory, so are all arrays, and the
 * functions run on the CPU with the threads of the context, also if its backend is CUDA. If it is
 * in the memory of a GPU, that GPU is the context's, all arrays are QS_FLOAT32 in its memory, and
 * the work is enqueued in QsInputs.stream. Arrays whose size does not depend on N may be in either
 * memory: the background, the position, and the gradients by them and by the camera. The gradients
 * by camera and position may have either type. The host waits once in qs_project(), for the number
 * of pairs, and for each of these arrays that it reads from the GPU or that the GPU fills for it.
 */

/* The lifetime of memory that the library asks for. On the CPU temporary memory belongs to the
 * library, so QS_TEMPORARY is not asked for. On a GPU all of it is memory of that GPU, which work
 * in the stream may use until its lifetime ends. */
#define QS_HELD_PER_GAUSSIAN 0u /* as long as the frame: projected Gaussians */
#define QS_HELD_PER_PAIR 1u     /* as long as the frame: tile lists */
#define QS_HELD_PER_PIXEL 2u    /* as long as the frame: states of pixels */
#define QS_TEMPORARY 3u         /* until the call returns, and the work in its stream is done */

/* The memory of frames. 24 bytes. */
typedef struct QsMemory {
  uint32_t size;     /*  0 */
  uint32_t reserved; /*  4 */
  void* user;        /*  8: handed to allocate() */
  /* 16: returns `bytes` bytes, aligned to 16, of any content; null: not enough memory, and the call
   * returns QS_DEVICE. It runs in the thread that called the library. It must neither use the
   * context nor throw. */
  void* (*allocate)(void* user, uint64_t bytes, uint32_t kind);
} QsMemory;

/* N Gaussians with activated values, C channels and K coefficients. 904 bytes. */
typedef struct QsInputs {
  uint32_t size;       /*   0 */
  uint32_t reserved;   /*   4 */
  QsArray means;       /*   8: N x 3, world */
  QsArray scales;      /*  96: N x 3, standard deviations */
  QsArray rotations;   /* 184: N x 4, quaternions w x y z */
  QsArray covariances; /* 272: N x 6: xx xy xz yy yz zz, in place of scales and rotations */
  QsArray opacities;   /* 360: N; sensible values are 0..1 */
  QsArray sh;          /* 448: N x K x RGB, K = 1, 4, 9 or 16, DC first; then C = 3 */
  QsArray sh_rest;    /* 536: absent, or the SH but DC, N x (K - 1) x RGB; then sh is N x 1 x RGB */
  QsArray channels;   /* 624: N x C in place of sh, C = 1..32; any values */
  QsArray background; /* 712: C; absent: 0 */
  QsArray position;   /* 800: 3, the point from which colours are seen, world; absent: the
                              camera's. QS_FLOAT32 or QS_FLOAT64 */
  void* stream;       /* 888: on a GPU: the cudaStream_t in which arrays are ready and results are
                              used; null: CUDA's default stream. Ignored on the CPU, as the next */
  const QsMemory* temporary; /* 896: on a GPU: asked for QS_TEMPORARY; null: the library allocates
                                     that itself, in the order of the stream */
} QsInputs;

/* The published code whose formula gives the radii. */
#define QS_RADII_INRIA 0u      /* ceil(3 sigma) of the longer axis; 0 if `3dgs` lists no tile */
#define QS_RADII_GSPLAT_1_4 1u /* gsplat until 1.4: the same, but 0 outside of the picture */
#define QS_RADII_GSPLAT_1_5 2u /* gsplat since 1.5: per axis, shorter for faint Gaussians */

/* The rules in which differentiable rasterizers differ; QS_RULES has the rules of quadsplat's
 * trainer. The near plane belongs to the camera. 120 bytes. */
typedef struct QsRules {
  uint32_t size;       /*   0 */
  int32_t sh_degree;   /*   4: highest degree that is evaluated, 0..3 */
  const char* cull;    /*   8: name of a culling mode but "reference"; null: "quadbox" */
  double far_depth;    /*  16: Gaussians with view z above it are not drawn; 0: no far plane */
  double dilation_px2; /*  24: added to both variances of a projected Gaussian, >= 0 */
  double splat_scale;  /*  32: factor on every standard deviation, > 0 */
  double compensation_floor; /*  40: lower bound of the ratio of determinants in the compensation
                                     of opacities, 0..1 */
  double alpha_max;          /*  48: alpha is clamped to this, > 0 and < 1 */
  double radius_clip_px;     /*  56: Gaussians whose radii are at most this are not drawn, >= 0 */
  double slope_low[2];       /*  64: bounds of x/z and y/z in the Jacobian of the projection; */
  double slope_high[2];      /*  80: all four 0: 1.3 times the half field of view, to both sides */
  uint32_t antialiased;      /*  96: 1: opacities are compensated for the dilation */
  uint32_t keeps_rotation_length; /* 100: 1: quaternions are not normalised */
  uint32_t zero_color_passes;     /* 104: 1: colours that are exactly 0 pass their gradient on */
  uint32_t alpha_max_blocks;      /* 108: 1: a clamped alpha has gradient 0 */
  uint32_t stops_at_equal;        /* 112: 1: a pixel also stops in front of a Gaussian that would
                                          push its transmittance to exactly 1e-4 */
  uint32_t radius_rule;           /* 116: QS_RADII_... */
} QsRules;

#define QS_RULES                                                                                   \
  {                                                                                                \
    sizeof(QsRules), QS_ALL_SH_DEGREES, 0, 0, 0.3, 1, 2.5e-5, 0.99, 0, {0, 0}, {0, 0}, 0, 0, 0, 0, \
        0, QS_RADII_INRIA                                                                          \
  }

/* A frame between its stages. It is the caller's: nothing is closed. The backward functions only
 * read it and its memory, so any number of frames may wait, a backward pass may run again, and each
 * call may have its own thread and context. A copy of the struct is the same frame; qs_blend() of a
 * copy leaves the first one as it was. The caller may move a block of memory and adjust its
 * pointer, and frees the blocks when no call reads the frame any more. 80 bytes. */
typedef struct QsStageFrame {
  uint32_t size;      /*  0 */
  uint32_t type;      /*  4: of the arrays, QS_FLOAT32 or QS_FLOAT64 */
  uint64_t gaussians; /*  8: N */
  uint64_t listed;    /* 16: Gaussians that a tile lists; 0 on a GPU, which does not count them */
  uint64_t pairs;     /* 24: listed (Gaussian, tile) pairs */
  int32_t width;      /* 32: pixels */
  int32_t height;     /* 36 */
  uint32_t channels;  /* 40: of the blended colours; 0 before qs_blend() */
  uint32_t has_depth; /* 44: 1: qs_blend() summed depths */
  void* per_gaussian; /* 48: blocks from QsMemory.allocate(), null if the frame is empty */
  void* per_pair;     /* 56 */
  void* per_pixel;    /* 64: null before qs_blend() */
  uint32_t memory;    /* 72: of the blocks, QS_MEMORY_... */
  int32_t device;     /* 76: CUDA's number of the device; 0 for QS_MEMORY_HOST */
} QsStageFrame;

/* A camera as trainers have it, in matrices of 32 or 64 bits in any memory, of any strides. 304
 * bytes. */
typedef struct QsMatrices {
  uint32_t size;      /*   0 */
  uint32_t is_clip;   /*   4: the form of `lens` */
  QsArray view;       /*   8: 4 x 4 or 3 x 4, world to view */
  QsArray lens;       /*  96: is_clip 0: 3 x 3, (fx 0 cx; 0 fy cy; 0 0 1), px, with the centre of
                              pixel i at i + 0.5. is_clip 1: 4 x 4, world to clip space, which is a
                              perspective projection after `view` */
  QsArray position;   /* 184: absent, or 3 */
  double half_fov[2]; /* 272: of is_clip 1: tangents of half the fields of view, x and y, > 0 */
  double* at;         /* 288: null, or out: the 3 numbers of `position` */
  void* stream;       /* 296: as of QsInputs */
} QsMatrices;

/* Sets the pose, focal length and principal point of *camera, whose size and near plane are given.
 * Waits for arrays on a GPU, once. Sentences name the member. */
QS_LIBRARY_FUNCTION int32_t qs_camera_of_matrices(QsContext* context, const QsMatrices* matrices,
                                                  QsCamera* camera, char* message);

/* The values that pixels read of a Gaussian, and its radii. Rows of Gaussians behind the near
 * plane, and of Gaussians that are degenerate, are 0; there are also rows of Gaussians that no tile
 * lists. 536 bytes. */
typedef struct QsBoundary {
  uint32_t size;     /*   0 */
  uint32_t corners;  /*   4: 1: in means_px the centre of pixel i is at i + 0.5, and rows of
                        Gaussians  with a radius of 0 are 0, as in gsplat */
  QsArray means_px;  /*   8: N x 2: pixels */
  QsArray conics;    /*  96: N x 3: a b c, the inverse of the dilated covariance, 1/px^2 */
  QsArray depths;    /* 184: N: view z */
  QsArray opacities; /* 272: N: at the centre, with compensation */
  QsArray colors;    /* 360: N x 3: RGB of the SH as seen by the camera; absent with channels */
  QsArray radii;     /* 448: N x 2: pixels along x and y by QsRules.radius_rule, QS_INT32; or N, for
                             rules with one radius */
} QsBoundary;

/* The pictures, or derivatives by them. 360 bytes. */
typedef struct QsBlended {
  uint32_t size;         /*   0 */
  uint32_t reserved;     /*   4 */
  QsArray color;         /*   8: height x width x C, over the background, not clamped */
  QsArray alpha;         /*  96: height x width: 1 - transmittance */
  QsArray depth;         /* 184: height x width: sum of view z by weight, which is alpha times the
                                 transmittance in front of it; not divided by alpha */
  QsArray inverse_depth; /* 272: height x width: the same sum of 1 / z */
} QsBlended;

/* Derivatives by the boundary, and by the inputs that only qs_blend() reads. 712 bytes. */
typedef struct QsBoundaryGradients {
  uint32_t size;       /*   0 */
  uint32_t ndc;        /*   4: 1: the written means_px and absolute_px are by normalised device
                               coordinates, -1..1 across the picture, as in INRIA's rasterizers;
                               then means_px may be N x 3, and the third is 0 */
  QsArray means_px;    /*   8: N x 2 */
  QsArray conics;      /*  96: N x 3; by b as one number */
  QsArray depths;      /* 184: N */
  QsArray opacities;   /* 272: N */
  QsArray colors;      /* 360: N x 3; absent with channels */
  QsArray channels;    /* 448: N x C; absent with sh. qs_project_backward() does not read this and
                               the next two */
  QsArray absolute_px; /* 536: N x 2: sums over pixels of the absolute values of the pixels' parts
                          of means_px, as AbsGS splits by */
  QsArray background;  /* 624: C */
} QsBoundaryGradients;

/* Derivatives by the inputs of qs_project(); for inputs that are not given they are absent. 800
 * bytes. */
typedef struct QsInputGradients {
  uint32_t size;           /*   0 */
  uint32_t reserved;       /*   4 */
  QsArray means;           /*   8: N x 3 */
  QsArray scales;          /*  96: N x 3 */
  QsArray rotations;       /* 184: N x 4 */
  QsArray covariances;     /* 272: N x 6; by xy, xz and yz counting both equal elements */
  QsArray opacities;       /* 360: N */
  QsArray sh;              /* 448: N x K x 3, or N x 1 x 3 with sh_rest */
  QsArray sh_rest;         /* 536: N x (K - 1) x 3 */
  QsArray view_from_world; /* 624: 3 x 4, of the camera, with a position that stays where it is.
                                   QS_FLOAT32 or QS_FLOAT64, as the next */
  QsArray position;        /* 712: 3, of the point from which colours are seen */
} QsInputGradients;

/* Projects the Gaussians and lists them in tiles. Fills *frame, with memory from `memory`, and all
 * wanted arrays of `boundary`, which may be null. `rules` may be null. After an error the frame is
 * empty. */
QS_LIBRARY_FUNCTION int32_t qs_project(QsContext* context, const QsInputs* inputs,
                                       const QsCamera* camera, const QsRules* rules,
                                       const QsMemory* memory, const QsBoundary* boundary,
                                       QsStageFrame* frame, char* message);

/* Draws the frame of qs_project() for the same inputs, camera and rules. The wanted pictures are
 * written, and the state of the pixels goes to memory from `memory`. Depths are summed only if one
 * of both depths is wanted; only then does the frame have gradients of them. It may be called
 * again, with other channels or another background. */
QS_LIBRARY_FUNCTION int32_t qs_blend(QsContext* context, const QsInputs* inputs,
                                     const QsCamera* camera, const QsRules* rules,
                                     const QsMemory* memory, const QsBlended* pictures,
                                     QsStageFrame* frame, char* message);

/* qs_project() and qs_blend(). */
QS_LIBRARY_FUNCTION int32_t qs_forward(QsContext* context, const QsInputs* inputs,
                                       const QsCamera* camera, const QsRules* rules,
                                       const QsMemory* memory, const QsBoundary* boundary,
                                       const QsBlended* pictures, QsStageFrame* frame,
                                       char* message);

/* Writes, for each of the N Gaussians of a frame of qs_project(), how many pixels blend it and have
 * a transmittance above `behind` after it, at least 0 and below 1, into `counts` (N, QS_INT32).
 * With 0 all pixels that blend it count. Inputs, camera and rules have the values of the forward
 * call. Frames on a GPU have the counts of the CPU: pixels are composited with its rounding. */
QS_LIBRARY_FUNCTION int32_t qs_count_pixels(QsContext* context, const QsInputs* inputs,
                                            const QsCamera* camera, const QsRules* rules,
                                            const QsStageFrame* frame, double behind,
                                            const QsArray* counts, char* message);

/* Derivatives by the boundary. `by_pictures` are the derivatives by the pictures; strides may be 0.
 * Inputs, camera and rules have the values of the forward call. Frames of another number of
 * Gaussians, size, type or number of channels are refused. */
QS_LIBRARY_FUNCTION int32_t qs_blend_backward(QsContext* context, const QsInputs* inputs,
                                              const QsCamera* camera, const QsRules* rules,
                                              const QsStageFrame* frame,
                                              const QsBlended* by_pictures,
                                              const QsBoundaryGradients* by_boundary,
                                              char* message);

/* Derivatives by the inputs, from `by_boundary`. */
QS_LIBRARY_FUNCTION int32_t qs_project_backward(QsContext* context, const QsInputs* inputs,
                                                const QsCamera* camera, const QsRules* rules,
                                                const QsStageFrame* frame,
                                                const QsBoundaryGradients* by_boundary,
                                                const QsInputGradients* by_inputs, char* message);

/* qs_blend_backward() and qs_project_backward(). The wanted arrays of `by_boundary`, which may be
 * null, are written. */
QS_LIBRARY_FUNCTION int32_t qs_backward(QsContext* context, const QsInputs* inputs,
                                        const QsCamera* camera, const QsRules* rules,
                                        const QsStageFrame* frame, const QsBlended* by_pictures,
                                        const QsBoundaryGradients* by_boundary,
                                        const QsInputGradients* by_inputs, char* message);

/* ---- parts of a trainer ---------------------------------------------------------------------- */

/* The functions that quadsplat's trainer uses besides the rasterizer. They run where their arrays
 * are: on the CPU with the threads of the context, or on its GPU, where all real numbers are
 * QS_FLOAT32 unless stated, nothing waits unless stated, and the work is enqueued in a stream.
 * Results do not depend on the number of threads, and two runs on a GPU are equal. Arrays have any
 * strides. An array that is written may be one that is read, with the same strides. */

/* *mean becomes the mean structural similarity of the pictures a and b, batch x channels x height x
 * width, all 1 or more, both QS_FLOAT32 or both QS_FLOAT64. The window has 11 x 11 pixels and sigma
 * 1.5, the constants are 0.01^2 and 0.03^2. Values are not clamped. `border` is QS_BORDER_ZEROS
 * ("same") or QS_BORDER_CROP ("valid"), which leaves out 5 pixels at every side. NaN and infinite
 * values make the mean NaN. */
QS_LIBRARY_FUNCTION int32_t qs_ssim(QsContext* context, const QsArray* a, const QsArray* b,
                                    uint32_t border, double* mean, char* message);

/* Writes by_a, the derivatives of a number L by the values of a, from by_mean, its derivative by
 * the mean. by_a has the sizes and the type of a. */
QS_LIBRARY_FUNCTION int32_t qs_ssim_backward(QsContext* context, const QsArray* a, const QsArray* b,
                                             uint32_t border, double by_mean, const QsArray* by_a,
                                             char* message);

/* SSIM and absolute differences of two batches of pictures, for host memory or a GPU. Nothing waits
 * for the means. Members are those of qs_ssim(). 728 bytes. */
typedef struct QsSimilarity {
  uint32_t size;   /*   0 */
  uint32_t border; /*   4: QS_BORDER_...: of SSIM alone */
  QsArray a, b;    /*   8, 96 */
  QsArray ssim;    /* 184: out: 1 number: the mean SSIM */
  QsArray l1;      /* 272: absent, or out: 1 number: the mean of |a - b| */
  QsArray terms;   /* 360: absent, or 3 fields of a number per value, packed: out, and read by
                           qs_similarity_backward(). Without effect in host memory */
  QsArray by_ssim; /* 448: 1 number: the derivative of a number L by the mean SSIM */
  QsArray by_l1;   /* 536: absent, or 1 number: the derivative of L by the mean of |a - b| */
  QsArray by_a;    /* 624: out: the derivatives of L by the values of a; sizes of a */
  void* stream;    /* 712: as of QsAdam */
  const QsMemory* temporary; /* 720: memory of the call; null: the library's own */
} QsSimilarity;

/* Sets `ssim`, and `l1` and `terms` unless they are absent. */
QS_LIBRARY_FUNCTION int32_t qs_similarity(QsContext* context, const QsSimilarity* compared,
                                          char* message);

/* Sets `by_a`. A GPU needs `terms`. Equal values have no derivative of |a - b|. The derivatives on
 * a GPU have the bits of the CPU. */
QS_LIBRARY_FUNCTION int32_t qs_similarity_backward(QsContext* context, const QsSimilarity* compared,
                                                   char* message);

/* Writes, for each of N points (N x 3, QS_FLOAT32), the mean of the squared distances to its three
 * nearest neighbours into distances2 (N, QS_FLOAT32 or QS_FLOAT64). Points in the same place are
 * neighbours of distance 0. With two or three points it is the mean over the other points, and 0
 * for a single point. A point with a coordinate that is not finite gets NaN, and is no neighbour.
 * On a GPU it waits, and has the bits of the CPU. */
QS_LIBRARY_FUNCTION int32_t qs_neighbours(QsContext* context, const QsArray* points,
                                          const QsArray* distances2, char* message);

#define QS_MOST_COPIES 51

/* The opacity and the scales of the copies that take the place of a Gaussian, by equation 9 of
 * "3D Gaussian Splatting as Markov Chain Monte Carlo" (arXiv 2404.09591). N opacities of 0..1 and
 * N x 3 standard deviations, QS_FLOAT32 or QS_FLOAT64. `counts` has N integers of 32 or 64 bits:
 * the number of copies; below 1 counts as 1, which changes nothing, and above QS_MOST_COPIES as
 * that. The new opacities are not clamped. Gaussians stay as they are if their opacity is NaN or
 * outside of 0..1. The new arrays have the sizes and the types of the old ones. On a GPU the
 * results have the bits of the CPU within the rounding of pow(). */
QS_LIBRARY_FUNCTION int32_t qs_relocate(QsContext* context, const QsArray* opacities,
                                        const QsArray* scales, const QsArray* counts,
                                        const QsArray* new_opacities, const QsArray* new_scales,
                                        char* message);

/* The covariances R diag(s^2) R^T of N quaternions w x y z of any length (N x 4) and standard
 * deviations s (N x 3), QS_FLOAT32: N x 6, xx xy xz yy yz zz, or N x 3 x 3. */
QS_LIBRARY_FUNCTION int32_t qs_covariances(QsContext* context, const QsArray* rotations,
                                           const QsArray* scales, const QsArray* covariances,
                                           char* message);

/* The noise of MCMC on the means of N Gaussians (arXiv 2404.09591, section 3.2, as gsplat adds it):
 * a mean moves by covariance * normal * factor * sigmoid(-slope * (opacity - middle)). A move that
 * is not finite is left out. QS_FLOAT32; all arrays are in one memory. 480 bytes. */
typedef struct QsNoise {
  uint32_t size;          /*   0 */
  uint32_t reserved;      /*   4 */
  double factor;          /*   8: finite */
  double slope;           /*  16: finite; published: 100 */
  double middle;          /*  24: finite; published: 0.005 */
  QsArray means;          /*  32: N x 3, in and out */
  QsArray log_scales;     /* 120: N x 3, logarithms of standard deviations */
  QsArray rotations;      /* 208: N x 4, quaternions w x y z of any length */
  QsArray opacity_logits; /* 296: N */
  QsArray normals;        /* 384: N x 3, standard normal numbers */
  void* stream;           /* 472: as of QsAdam */
} QsNoise;

QS_LIBRARY_FUNCTION int32_t qs_noise(QsContext* context, const QsNoise* noise, char* message);

/* Adds a view to the sums from which density control decides: where both radii of Gaussian i are
 * above 0, lengths[i] grows by the length of (x gradients[i, 0], y gradients[i, 1]), and views[i]
 * by 1. `gradients` has N x 2 numbers, the derivatives by the centres; lengths and views have N;
 * all are QS_FLOAT32. `radii` has N x 2 numbers, QS_INT32. */
QS_LIBRARY_FUNCTION int32_t qs_add_view(QsContext* context, const QsArray* gradients,
                                        const QsArray* radii, double x, double y,
                                        const QsArray* lengths, const QsArray* views,
                                        char* message);

/* A step of Adam; QS_ADAM has the usual values, but no arrays. The first four arrays are QS_FLOAT32
 * and have the same sizes, N rows of any shape. All arrays are in host memory, or all are in the
 * memory of the context's GPU. 496 bytes. */
typedef struct QsAdam {
  uint32_t size;     /*   0 */
  uint32_t reserved; /*   4 */
  uint64_t step;     /*   8: number of this step, 1, 2, ..., which corrects the moments' start at 0;
                             0: no correction */
  double rate;       /*  16: learning rate, finite */
  double beta1;      /*  24: decay of the first moment, at least 0 and below 1 */
  double beta2;      /*  32: decay of the second moment, likewise */
  double epsilon;    /*  40: added to the root of the second moment, finite, at least 0 */
  QsArray values;    /*  48: in and out */
  QsArray gradients; /* 136: NaN and infinite gradients count as 0 */
  QsArray first;     /* 224: in and out: moments of the gradients */
  QsArray second;    /* 312: in and out: moments of their squares */
  QsArray visible;   /* 400: absent, or N, QS_UINT8: rows of value 0 stay as they are, with their
                             moments */
  void* stream; /* 488: of arrays on a GPU: the cudaStream_t in which the step is enqueued; null:
                        CUDA's default stream */
} QsAdam;

#define QS_ADAM                                                                             \
  {                                                                                         \
    sizeof(QsAdam), 0, 0, 0, 0.9, 0.999, 1e-15, QS_ABSENT, QS_ABSENT, QS_ABSENT, QS_ABSENT, \
        QS_ABSENT, 0                                                                        \
  }

/* Takes the step. A value whose move is not finite stays. On a GPU the host does not wait, and the
 * results have the bits of the CPU. */
QS_LIBRARY_FUNCTION int32_t qs_adam(QsContext* context, const QsAdam* adam, char* message);

/* The steps of several arrays in one place and stream; on a GPU 8 of them are in a launch. Nothing
 * changes unless all are right. */
QS_LIBRARY_FUNCTION int32_t qs_adam_all(QsContext* context, const QsAdam* steps, uint64_t count,
                                        char* message);

/* ---- training -------------------------------------------------------------------------------- */

/* An option of `quadsplat train`. 16 bytes; it does not grow. */
typedef struct QsOption {
  const char* name;  /*  0: "iterations", or "--iterations"; "_" stands for "-" */
  const char* value; /*  8: the text of the command line; of an option without a value: "on", "off"
                            or null, which is "on" */
} QsOption;

/* The state of a run. 80 bytes. */
typedef struct QsTrainingState {
  uint32_t size;        /*  0 */
  int32_t iteration;    /*  4: iterations that are done; 0 before the first */
  int32_t iterations;   /*  8: at the end */
  int32_t evaluated;    /* 12: the iteration of the last evaluation; 0: none yet */
  uint64_t gaussians;   /* 16 */
  double loss;          /* 24: of the last iteration; 0 before the first */
  double seconds;       /* 32: of all iterations, also of earlier runs, without evaluations */
  double test_psnr;     /* 40: dB on the test views, NaN before an evaluation, as the next */
  double test_ssim;     /* 48 */
  double guard_psnr;    /* 56: dB on the views that the option "guard" reserves, NaN without */
  int32_t guarded;      /* 64: the iteration of that measurement; 0: none yet */
  int32_t growth_ended; /* 68: the iteration after which the guard ended growth; 0: it did not */
  uint64_t reserved;    /* 72 */
} QsTrainingState;

/* A training run. Both callbacks run in the thread that called qs_train(). They must neither use
 * the context, except by qs_stop(), nor throw. 64 bytes. */
typedef struct QsTraining {
  uint32_t size;           /*  0 */
  uint32_t reserved;       /*  4 */
  const char* data;        /*  8: the data set: a folder of COLMAP, or one with a transforms.json or
                                  cameras.json */
  const char* model;       /* 16: the folder of the trained model, new or empty */
  const QsOption* options; /* 24: may be null for a count of 0 */
  uint64_t option_count;   /* 32 */
  void* user;              /* 40: handed to the callbacks */
  /* 48: null, or called before the first iteration, after every iteration and after the last
   * evaluation. Another result than 0 ends the run. */
  int32_t (*progress)(void* user, const QsTrainingState* state);
  /* 56: null, or called with each sentence that the program would print, without a line break. */
  void (*text)(void* user, const char* sentence);
} QsTraining;

/* Trains a model as `quadsplat train` does, to the same bytes of its Gaussians, on the backend, the
 * device and the threads of the context. The options have the names, values and defaults of the
 * program, but backend, device, threads and those of the window. The folder is that of the program
 * without train.html and the plots. A run that progress() or qs_stop() ends is saved, returns
 * QS_CANCELLED within an iteration and the time of saving, and continues with the option "resume".
 * Photographs that are being read are not saved. *state, which may be null, is filled at the end,
 * also of a cancelled run. Sentences name the options of the program. */
QS_LIBRARY_FUNCTION int32_t qs_train(QsContext* context, const QsTraining* training,
                                     QsTrainingState* state, char* message);

#ifdef __cplusplus
}
#endif

#endif /* QUADSPLAT_QUADSPLAT_H */
