// SPDX-License-Identifier: MIT
//
// tinygltf (header-only) without its access to files and images. Include this instead of
// <tiny_gltf.h>, because the options must be the same in every file. tinygltf.cpp compiles the
// implementation, so that it is covered by sanitizers and fuzzing.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>  // IWYU pragma: export
