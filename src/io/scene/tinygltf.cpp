// SPDX-License-Identifier: MIT
//
// tinygltf.h with its implementation, which needs <fstream> without including it, and would include
// nlohmann's JSON with its symbols hidden from our own uses.
#include <fstream>

#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "io/scene/tinygltf.h"
