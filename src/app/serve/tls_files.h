// SPDX-License-Identifier: MIT
//
// The files with which the server encrypts its connections, in PEM format.
#pragma once

#include <filesystem>

namespace qs {

/// Both may be the same file.
struct TlsFiles {
  std::filesystem::path certificate;  ///< a chain, the server's first
  std::filesystem::path key;          ///< of the server's certificate, without a password
};

}  // namespace qs
