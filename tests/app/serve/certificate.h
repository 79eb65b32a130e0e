// SPDX-License-Identifier: MIT
//
// Certificates for localhost, made when a test needs them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

namespace qs::test {

using PrivateKey = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

inline PrivateKey make_private_key() { return {EVP_EC_gen("P-256"), &EVP_PKEY_free}; }

/// Of BIO_s_mem().
inline std::string text_of(BIO* bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio, &bytes);
  std::string text(bytes, static_cast<std::size_t>(size));
  BIO_free(bio);
  return text;
}

/// With a password if there is one.
inline std::string pem_of_key(EVP_PKEY* key, std::string password = "") {
  BIO* const bio = BIO_new(BIO_s_mem());
  PEM_write_bio_PrivateKey(bio, key, password.empty() ? nullptr : EVP_aes_256_cbc(),
                           reinterpret_cast<unsigned char*>(password.data()),
                           static_cast<int>(password.size()), nullptr, nullptr);
  return text_of(bio);
}

/// When a certificate is valid, in seconds from now.
struct ValidTime {
  long begin = -3600, end = 3600;
};

/// Signed by its own key.
inline std::string pem_of_certificate(EVP_PKEY* key, ValidTime valid = {}) {
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(), &X509_free);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), valid.begin);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), valid.end);
  X509_set_pubkey(certificate.get(), key);
  X509_NAME* const name = X509_get_subject_name(certificate.get());
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
  X509_set_issuer_name(certificate.get(), name);
  X509_sign(certificate.get(), key, EVP_sha256());
  BIO* const bio = BIO_new(BIO_s_mem());
  PEM_write_bio_X509(bio, certificate.get());
  return text_of(bio);
}

}  // namespace qs::test
