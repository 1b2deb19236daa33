#include "graph/digest.h"

#include <openssl/evp.h>

namespace alder {

std::string sha256_hex(std::string_view bytes) {
    unsigned char md[EVP_MAX_MD_SIZE];
    unsigned int n = 0;
    EVP_Digest(bytes.data(), bytes.size(), md, &n, EVP_sha256(), nullptr);
    static const char* kHex = "0123456789abcdef";
    std::string s;
    s.reserve(2 * n);
    for (unsigned int i = 0; i < n; ++i) {
        s += kHex[md[i] >> 4];
        s += kHex[md[i] & 15];
    }
    return s;
}

std::string content_digest(const nlohmann::json& document) {
    return sha256_hex(document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace alder
