// TLS for the daemon's door.
#include "server/http/tls.h"

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <new>

namespace alder::http {
namespace {

/// The reason of the error raised last, for a sentence.
std::string reason() {
    const unsigned long code = ERR_peek_last_error();
    const char* const text = code ? ERR_reason_error_string(code) : nullptr;
    ERR_clear_error();
    return text ? text : "unknown reason";
}

}  // namespace

void Tls::Free::operator()(ssl_ctx_st* c) const { SSL_CTX_free(c); }

std::string Tls::load(const std::string& certificate, const std::string& key) {
    std::unique_ptr<ssl_ctx_st, Free> c(SSL_CTX_new(TLS_server_method()));
    if (!c) return "TLS cannot be started: " + reason();
    SSL_CTX_set_min_proto_version(c.get(), TLS1_2_VERSION);
    SSL_CTX_set_options(c.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
    SSL_CTX_set_mode(c.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
    if (SSL_CTX_use_certificate_chain_file(c.get(), certificate.c_str()) != 1) return "the certificate '" + certificate + "' cannot be used: " + reason();
    if (SSL_CTX_use_PrivateKey_file(c.get(), key.c_str(), SSL_FILETYPE_PEM) != 1) return "the key '" + key + "' cannot be used: " + reason();
    if (SSL_CTX_check_private_key(c.get()) != 1) return "the key '" + key + "' is not that of the certificate '" + certificate + "'";
    context_ = std::move(c);
    return {};
}

Tls::Session::Session(const Tls& tls, int fd) : ssl_(SSL_new(tls.context_.get())) {
    if (!ssl_ || SSL_set_fd(ssl_, fd) != 1) throw std::bad_alloc();
    SSL_set_accept_state(ssl_);
}
Tls::Session::~Session() { SSL_free(ssl_); }

Tls::Session::Want Tls::Session::result(int code) {
    switch (SSL_get_error(ssl_, code)) {
        case SSL_ERROR_NONE: return Want::Done;
        case SSL_ERROR_WANT_READ: return Want::Read;
        case SSL_ERROR_WANT_WRITE: return Want::Write;
        case SSL_ERROR_ZERO_RETURN: return Want::Closed;
        default: return Want::Failed;
    }
}

Tls::Session::Want Tls::Session::handshake() {
    ERR_clear_error();
    return result(SSL_do_handshake(ssl_));
}
Tls::Session::Want Tls::Session::read(char* data, size_t size, size_t& got) {
    ERR_clear_error();
    got = 0;
    return result(SSL_read_ex(ssl_, data, size, &got));
}
Tls::Session::Want Tls::Session::write(const char* data, size_t size, size_t& sent) {
    ERR_clear_error();
    sent = 0;
    return result(SSL_write_ex(ssl_, data, size, &sent));
}
void Tls::Session::shut_down() {
    ERR_clear_error();
    if (SSL_is_init_finished(ssl_)) SSL_shutdown(ssl_);
}

}  // namespace alder::http
