// SPDX-License-Identifier: MIT
// Compiled alone: a library of others, without optimisation.
//
// The implementation of tinygltf. It needs <fstream> without including it; nlohmann's JSON is
// included first because tinygltf would include it with hidden symbols.
#include <fstream>

#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "io/scene/gltf/tinygltf.h"
