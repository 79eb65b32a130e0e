// SPDX-License-Identifier: MIT
#include "app/serve/tls_context.h"

#ifdef QUADSPLAT_TLS
#include <cstddef>
#include <string>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509err.h>

#include "io/bytes/json_text.h"
#endif

#include "raster/base/fail.h"

namespace qs {

#ifndef QUADSPLAT_TLS

TlsContext make_tls_context(const TlsFiles&) {
  fail(ErrorKind::device,
       "serve: --certificate: this program was built without OpenSSL: install libssl-dev and build "
       "it again");
}

#else

namespace {

namespace ssl = boost::asio::ssl;
using boost::system::error_code;

constexpr std::size_t kMostBytes = 1 << 20;  ///< of a file

std::string pem_of(const char* option, const std::filesystem::path& path) {
  try {
    return read_text_file(path, kMostBytes);
  } catch (const Error& error) {
    fail("serve: {} {}", option, error.what());
  }
}

bool has_block(const std::string& pem, const char* kind) {
  const std::size_t begin = pem.find("-----BEGIN ");
  return begin != pem.npos && pem.find(kind, begin) != pem.npos;
}

void use_certificate(ssl::context& context, const std::filesystem::path& path) {
  const std::string pem = pem_of("--certificate", path);
  if (!has_block(pem, "CERTIFICATE-----"))
    fail("serve: --certificate {}: has no certificate in PEM format", path.string());
  error_code error;
  context.use_certificate_chain(boost::asio::buffer(pem), error);
  if (error)
    fail("serve: --certificate {}: OpenSSL refuses it: {}", path.string(), error.message());
}

void use_key(ssl::context& context, const TlsFiles& files) {
  const std::string path = files.key.string(), pem = pem_of("--key", files.key);
  if (!has_block(pem, "PRIVATE KEY-----"))
    fail("serve: --key {}: has no private key in PEM format", path);
  bool is_encrypted = false;
  context.set_password_callback([&](std::size_t, ssl::context::password_purpose) {
    is_encrypted = true;
    return std::string();
  });
  error_code error;
  context.use_private_key(boost::asio::buffer(pem), ssl::context::pem, error);
  if (is_encrypted)
    fail("serve: --key {0}: has a password; remove it: openssl pkey -in {0} -out NEW.pem", path);
  const bool is_mismatch =
      ERR_GET_REASON(static_cast<unsigned long>(error.value())) == X509_R_KEY_VALUES_MISMATCH ||
      (!error && SSL_CTX_check_private_key(context.native_handle()) != 1);
  if (is_mismatch) fail("serve: --key {}: is not the key of {}", path, files.certificate.string());
  if (error) fail("serve: --key {}: OpenSSL refuses it: {}", path, error.message());
}

}  // namespace

TlsContext make_tls_context(const TlsFiles& files) {
  ssl::context context(ssl::context::tls_server);
  SSL_CTX* const handle = context.native_handle();
  SSL_CTX_set_min_proto_version(handle, TLS1_2_VERSION);
  SSL_CTX_set_options(handle, SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_mode(handle, SSL_MODE_RELEASE_BUFFERS);  // of connections at rest
  SSL_CTX_set_session_cache_mode(handle, SSL_SESS_CACHE_OFF);
  use_certificate(context, files.certificate);
  use_key(context, files);
  ERR_clear_error();  // an old error would end the first connection
  return context;
}

#endif

}  // namespace qs
