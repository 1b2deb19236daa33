// SHA-256 while streaming, and the names of assets made of it.
#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "graph/digest.h"   // sha256_hex(): of what is in memory

namespace alder {

class Sha256 {
  public:
    Sha256();
    ~Sha256();
    Sha256(const Sha256&) = delete;
    Sha256& operator=(const Sha256&) = delete;
    void update(std::string_view bytes);
    /// 64 lower-case hexadecimal digits; call once.
    std::string hex();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};
/// A digest of hexadecimal digits as Content-Digest has it (RFC 9530): sha-256=:BASE64:
std::string digest_header(const std::string& hex);
bool is_sha256_hex(std::string_view text);
/// The hexadecimal part of "sha256:HEX"; empty where it is not one.
std::string digest_hex(std::string_view name);

}  // namespace alder
