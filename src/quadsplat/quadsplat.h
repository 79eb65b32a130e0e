/* SPDX-License-Identifier: MIT
 *
 * libquadsplat: reads scenes of 3D Gaussians, renders and counts views of them, converts scenes and
 * compares pictures. It gives the same bytes as the program quadsplat. This is the whole interface,
 * version 1; it is C99 and C++. docs/library.md has a first program.
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
#define QS_CANCELLED 4 /* qs_stop() was called */

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

/* The memory that holds an array. Every function refuses QS_MEMORY_CUDA so far. */
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
  const char* name;     /* 16: for QsSettings.mode, valid for ever */
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

/* N Gaussians in the memory of the caller, of type QS_FLOAT32 or QS_FLOAT64. 544 bytes. */
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
} QsGaussians;

/* Opens a scene of the caller's Gaussians, 0 or more. The values are copied: the arrays may change
 * or be freed when the function returns. Activated values become float32 logarithms and logits, so
 * their pictures differ from pictures of those by rounding alone. Gaussians with NaN or infinite
 * values, negative standard deviations, opacities outside of 0..1 or a rotation of length 0 are not
 * drawn; the other Gaussians keep their numbers. After an error *scene is null. */
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

/* Null is allowed. */
QS_LIBRARY_FUNCTION void qs_scene_close(QsSceneHandle* scene);

#define QS_ALL_SH_DEGREES 3

/* The form in which qs_convert() writes a scene; QS_CONVERSION has the usual values. 32 bytes. */
typedef struct QsConversion {
  uint32_t size;         /*  0 */
  uint32_t overwrite;    /*  4: 1: an existing file is replaced; never the file of the scene */
  int32_t sh_degree;     /*  8: highest degree that is written, 0..3 */
  uint32_t reserved;     /* 12 */
  uint64_t keep_largest; /* 16: writes this number of Gaussians with the largest opacity times area;
                                0: all */
  const char* format;    /* 24: name of the format; null or empty: by the file's ending */
} QsConversion;

#define QS_CONVERSION \
  { sizeof(QsConversion), 0, QS_ALL_SH_DEGREES, 0, 0, 0 }

/* Writes the scene: .ply, .compressed.ply, .spz, .splat, .glb. The file appears whole or not at
 * all. `conversion` may be null. */
QS_LIBRARY_FUNCTION int32_t qs_convert(QsSceneHandle* scene, const char* path,
                                       const QsConversion* conversion, char* message);

/* ---- cameras --------------------------------------------------------------------------------- */

/* A pinhole camera. 152 bytes. */
typedef struct QsCamera {
  uint32_t size;              /*   0 */
  int32_t width, height;      /*   4, 8: pixels, 1..65535 */
  uint32_t reserved;          /*  12 */
  double view_from_world[12]; /*  16: 3 x 4, row by row: rotation | translation */
  double focal_px[2];         /* 112: x, y, > 0 */
  double center_px[2];        /* 128: principal point, see Conventions */
  double near_depth;          /* 144: Gaussians with view z <= near_depth are not drawn; usually
                                      0.2, at least 0 */
} QsCamera;

typedef struct QsCameras QsCameras;

/* Reads the cameras of a cameras.json, a transforms.json, or a folder or file of COLMAP. After an
 * error *cameras is null. */
QS_LIBRARY_FUNCTION int32_t qs_cameras_open(const char* path, QsCameras** cameras, uint64_t* count,
                                            char* message);

/* Fills *camera. If `name` is not null, *name becomes the name of the photograph, valid until
 * qs_cameras_close(). */
QS_LIBRARY_FUNCTION int32_t qs_cameras_get(const QsCameras* cameras, uint64_t number,
                                           QsCamera* camera, const char** name, char* message);

/* Null is allowed. */
QS_LIBRARY_FUNCTION void qs_cameras_close(QsCameras* cameras);

/* Gives the camera another size in pixels. The vertical field of view stays, as with the program's
 * option --size. */
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
  const char* mode;     /*  8: name of a culling mode; null: "quadbox" */
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
 * or 64 bits. 632 bytes. */
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

#define QS_METRIC_PSNR 1u      /* dB of the values; infinity if they are equal */
#define QS_METRIC_PSNR_8BIT 2u /* dB of the values rounded to 8 bits */
#define QS_METRIC_SSIM 4u      /* window of 11 x 11 pixels, sigma 1.5 */
#define QS_METRIC_FLIP 8u      /* mean of LDR-FLIP at 67.02 pixels per degree */

#define QS_BORDER_ZEROS 0u /* of SSIM: every pixel counts; values outside are 0 */
#define QS_BORDER_CROP 1u  /* of SSIM: pixels whose window is inside; both sides >= 11 pixels */

/* The metrics of two pictures. 144 bytes. */
typedef struct QsComparison {
  uint32_t size;        /*   0 */
  uint32_t metrics;     /*   4: in: sum of QS_METRIC_... */
  uint32_t ssim_border; /*   8: in: QS_BORDER_... */
  uint32_t reserved;    /*  12 */
  QsArray mask;         /*  16: in: absent, or height x width, QS_UINT8: PSNR and SSIM leave out
                                pixels of value 0; PSNR of 8 bits and FLIP refuse a mask */
  double psnr;          /* 104: out, as the next three: 0 unless asked for */
  double psnr_8bit;     /* 112 */
  double ssim;          /* 120 */
  double flip;          /* 128 */
  double reserved2;     /* 136 */
} QsComparison;

/* Compares two pictures of height x width x 3, QS_FLOAT32, QS_FLOAT64 or QS_UINT8 (as value / 255).
 * Values are clamped to 0..1, and NaN counts as 0. `a` is the reference. */
QS_LIBRARY_FUNCTION int32_t qs_compare(QsContext* context, const QsArray* a, const QsArray* b,
                                       QsComparison* comparison, char* message);

#ifdef __cplusplus
}
#endif

#endif /* QUADSPLAT_QUADSPLAT_H */
