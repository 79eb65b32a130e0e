// SPDX-License-Identifier: MIT
//
// The interface of the OpenImageIO module, a shared library that image_file.cpp loads with dlopen
// when a format needs it. The interface is plain C: no exception, C++ type or ownership of memory
// crosses it. On failure functions return 0 and set `message` to a clause without the file's name.
// Every change here must change kOiioModuleVersion; the loader refuses other versions.
#pragma once

namespace qs {

inline constexpr int kOiioModuleVersion = 2;
inline constexpr const char* kOiioModuleFile = "quadsplat_oiio.so";
inline constexpr const char* kOiioModuleEntry = "quadsplat_oiio_module";

struct OiioMessage {
  char text[400];
};

/// A picture; `values` is height * width * channels, owned by the program.
struct OiioPicture {
  int width, height, channels;
  float* values;
  const char* channel;  ///< name of the only channel that write() uses; null: the default name
};

/// Metadata entry.
struct OiioText {
  const char* key;
  const char* value;
};

struct OiioModule {
  int version;
  /// Opens `path` and fills `picture` except for the values. Returns 0 if it is not a readable
  /// picture.
  void* (*open)(const char* path, OiioPicture* picture, OiioMessage* message);
  /// Reads the pixels into picture->values.
  int (*read)(void* handle, OiioPicture* picture, OiioMessage* message);
  void (*close)(void* handle);
  /// Stores floats if the format supports them, else 8 bits by to_8bit().
  int (*write)(const char* path, const OiioPicture* picture, const OiioText* texts, int text_count,
               OiioMessage* message);
};

}  // namespace qs

/// The module's one symbol.
extern "C" const qs::OiioModule* quadsplat_oiio_module();
