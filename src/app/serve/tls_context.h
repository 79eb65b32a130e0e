// SPDX-License-Identifier: MIT
//
// The certificate and the key with which the server encrypts its connections: TLS 1.2 or newer, by
// OpenSSL.
#pragma once

#ifdef QUADSPLAT_TLS
#include <utility>  // Asio 1.74 uses std::exchange without it

#include <boost/asio/ssl/context.hpp>
#endif

#include <string>

#include "app/serve/server.h"

namespace qs {

#ifdef QUADSPLAT_TLS
using TlsContext = boost::asio::ssl::context;
#else
struct TlsContext {};
#endif

/// Throws Error(input) if a file cannot be read, is damaged, or does not belong to the other, and
/// Error(device) if this program was built without OpenSSL. `command`: that messages name.
TlsContext make_tls_context(const TlsFiles& files, const std::string& command);

/// "has expired on 2026-05-01" or "is not valid before 2026-05-01", of the server's certificate and
/// now, in UTC; "" if it is valid.
std::string certificate_problem(const TlsContext& context);

}  // namespace qs
