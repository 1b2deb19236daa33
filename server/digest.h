// SHA-256, whole and while streaming: the names of assets and the tags of cached answers.
#pragma once
#include <memory>
#include <string>
#include <string_view>

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
std::string sha256_hex(std::string_view bytes);
bool is_sha256_hex(std::string_view text);
/// The hexadecimal part of "sha256:HEX"; empty where it is not one.
std::string digest_hex(std::string_view name);

}  // namespace alder
