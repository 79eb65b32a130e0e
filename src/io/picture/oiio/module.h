// SPDX-License-Identifier: MIT
//
// The interface of the OpenImageIO module, a shared library that the program loads with dlopen when
// the first picture in a format of its own is read or written (image_module.cpp). Plain C at the
// border: no exception, no C++ type and no memory ownership crosses it. Functions return 0 when
// something failed and leave a clause without the file's name in `message`. kOiioModuleVersion
// changes with every change here; the loader refuses another one.
#pragma once

namespace qs {

inline constexpr int kOiioModuleVersion = 1;
inline constexpr const char* kOiioModuleFile = "quadsplat_oiio.so";
inline constexpr const char* kOiioModuleEntry = "quadsplat_oiio_module";

struct OiioMessage {
  char text[400];
};

/// A picture as it crosses the border; `values` is height * width * channels, owned by the program.
struct OiioPicture {
  int width, height, channels;
  float* values;
};

/// Metadata entry.
struct OiioText {
  const char* key;
  const char* value;
};

struct OiioModule {
  int version;
  /// Opens `path`, fills all of `picture` but the values; 0 when it is not a readable picture.
  void* (*open)(const char* path, OiioPicture* picture, OiioMessage* message);
  /// Reads the pixels into picture->values.
  int (*read)(void* handle, OiioPicture* picture, OiioMessage* message);
  void (*close)(void* handle);
  /// Floats stay floats where the format has them, else they become 8-bit by to_8bit().
  int (*write)(const char* path, const OiioPicture* picture, const OiioText* texts, int text_count,
               OiioMessage* message);
};

}  // namespace qs

/// The module's one symbol.
extern "C" const qs::OiioModule* quadsplat_oiio_module();
