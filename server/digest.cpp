// SHA-256 by OpenSSL.
#include "server/digest.h"

#include <algorithm>
#include <new>

#include <openssl/evp.h>

namespace alder {

struct Sha256::Impl {
    EVP_MD_CTX* context = EVP_MD_CTX_new();
    ~Impl() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : impl_(std::make_unique<Impl>()) {
    if (!impl_->context || EVP_DigestInit_ex(impl_->context, EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
}
Sha256::~Sha256() = default;
void Sha256::update(std::string_view bytes) { EVP_DigestUpdate(impl_->context, bytes.data(), bytes.size()); }
std::string Sha256::hex() {
    unsigned char raw[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    EVP_DigestFinal_ex(impl_->context, raw, &size);
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    for (unsigned i = 0; i < size; ++i) {
        out.push_back(kDigits[raw[i] >> 4]);
        out.push_back(kDigits[raw[i] & 15]);
    }
    return out;
}

std::string digest_header(const std::string& hex) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string raw, out;
    for (size_t i = 0; i < hex.size(); i += 2) raw.push_back(static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    for (size_t i = 0; i < raw.size(); i += 3) {
        unsigned bits = 0;
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < raw.size() ? static_cast<unsigned char>(raw[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) out.push_back(i + k <= raw.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=');
    }
    return "sha-256=:" + out + ":";
}

bool is_sha256_hex(std::string_view text) {
    return text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}
std::string digest_hex(std::string_view name) {
    constexpr std::string_view kPrefix = "sha256:";
    if (name.substr(0, kPrefix.size()) != kPrefix) return {};
    name.remove_prefix(kPrefix.size());
    return is_sha256_hex(name) ? std::string(name) : std::string();
}

}  // namespace alder
