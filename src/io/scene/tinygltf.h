// SPDX-License-Identifier: MIT
//
// tinygltf, a library of one header, without its access to files and pictures. Include this instead
// of <tiny_gltf.h>: the choices must be the same everywhere. tinygltf.cpp compiles it, so that
// sanitizers and fuzzers see into it.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>  // IWYU pragma: export
