// The head of an HTTP/1.1 request, parsed strictly.
#include "server/http/head.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace alder::http {
namespace {

/// tchar of RFC 9110, section 5.6.2.
bool is_token_char(unsigned char c) {
    if (c >= '0' && c <= '9') return true;
    if ((c | 0x20) >= 'a' && (c | 0x20) <= 'z') return true;
    return std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string_view::npos;
}
bool is_token(std::string_view s) { return !s.empty() && std::all_of(s.begin(), s.end(), is_token_char); }

std::string lower(std::string_view s) {
    std::string out(s);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
    return out;
}
std::string_view trim(std::string_view s) {
    while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
    while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
    return s;
}
Fault malformed(std::string detail) { return {"malformed-request", std::move(detail)}; }

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::optional<Fault> parse_target(Head& head) {
    std::string_view target = head.target;
    if (target == "*") return head.method == "OPTIONS" ? std::nullopt : std::optional(malformed("the target '*' is for OPTIONS only"));
    for (const std::string_view scheme : {"http://", "https://"})
        if (target.substr(0, scheme.size()) == scheme) {   // absolute form: its authority replaces Host (RFC 9112, 3.2.2)
            target.remove_prefix(scheme.size());
            const size_t slash = target.find_first_of("/?");
            head.host = std::string(target.substr(0, slash));
            target = slash == std::string_view::npos || target[slash] == '?' ? std::string_view("/") : target.substr(slash);
            break;
        }
    if (target.empty() || target[0] != '/') return malformed("the target must begin with '/'");
    if (target.find('#') != std::string_view::npos) return malformed("the target has a fragment");
    const size_t mark = target.find('?');
    std::string_view path = target.substr(1, mark == std::string_view::npos ? mark : mark - 1);
    std::string_view query = mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);

    while (!path.empty()) {
        const size_t slash = path.find('/');
        std::string segment;
        if (!percent_decode(path.substr(0, slash), false, segment)) return malformed("the path has a broken percent escape");
        if (segment == "." || segment == "..") return malformed("the path has a dot segment");
        head.segments.push_back(std::move(segment));
        if (slash == std::string_view::npos) break;
        path.remove_prefix(slash + 1);
        if (path.empty()) head.segments.emplace_back();   // "/v1/" is not "/v1"
    }
    while (!query.empty()) {
        const size_t amp = query.find('&');
        const std::string_view pair = query.substr(0, amp);
        const size_t equals = pair.find('=');
        std::string name, value;
        if (!percent_decode(pair.substr(0, equals), true, name) ||
            (equals != std::string_view::npos && !percent_decode(pair.substr(equals + 1), true, value)))
            return malformed("the query has a broken percent escape");
        if (!pair.empty()) head.query.emplace_back(std::move(name), std::move(value));
        if (amp == std::string_view::npos) break;
        query.remove_prefix(amp + 1);
    }
    return std::nullopt;
}

std::optional<Fault> parse_framing(Head& head) {
    bool close = false, keep = false;
    for (const auto& [name, value] : head.headers) {
        if (name == "content-length") {
            uint64_t length = 0;
            const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), length);
            if (value.empty() || error != std::errc() || end != value.data() + value.size())
                return malformed("Content-Length is not a number");
            if (head.content_length) return malformed("Content-Length is given twice");
            head.content_length = length;
        } else if (name == "transfer-encoding") {
            if (lower(value) != "chunked" || head.chunked) return malformed("the only Transfer-Encoding known is 'chunked', once");
            head.chunked = true;
        } else if (name == "expect") {
            if (lower(value) != "100-continue") return malformed("the only Expect known is '100-continue'");
            head.expects_continue = true;
        } else if (name == "connection") {
            const std::string options = lower(value);
            close = close || options.find("close") != std::string::npos;
            keep = keep || options.find("keep-alive") != std::string::npos;
        }
    }
    if (head.chunked && head.content_length) return malformed("both Content-Length and Transfer-Encoding are given");
    if (head.method == "HEAD" && head.has_body()) return malformed("HEAD has a body");
    if (head.chunked && head.http_1_0) return malformed("HTTP/1.0 has no Transfer-Encoding");
    head.keep_alive = head.http_1_0 ? keep && !close : !close;
    if (head.http_1_0) head.expects_continue = false;
    return std::nullopt;
}

}  // namespace

const std::string* Head::header(std::string_view name) const {
    for (const auto& [n, v] : headers)
        if (n == name) return &v;
    return nullptr;
}

void Response::set(std::string name, std::string value) {
    for (auto& [n, v] : headers)
        if (n == name) {
            v = std::move(value);
            return;
        }
    headers.emplace_back(std::move(name), std::move(value));
}
Response Response::text(int status, std::string body, std::string type) {
    Response r;
    r.status = status;
    r.body = std::move(body);
    r.set("Content-Type", std::move(type));
    return r;
}

bool is_utf8(std::string_view s) {
    for (size_t i = 0; i < s.size();) {
        const auto byte = [&](size_t k) { return k < s.size() ? static_cast<unsigned char>(s[k]) : 0u; };
        const unsigned a = byte(i);
        if (a < 0x80) {
            ++i;
            continue;
        }
        const int extra = a >= 0xC2 && a <= 0xDF ? 1 : a >= 0xE0 && a <= 0xEF ? 2 : a >= 0xF0 && a <= 0xF4 ? 3 : 0;
        if (!extra) return false;
        for (int k = 1; k <= extra; ++k)
            if ((byte(i + k) & 0xC0) != 0x80) return false;
        const unsigned b = byte(i + 1);   // no overlong forms, surrogates or code points beyond U+10FFFF
        if ((a == 0xE0 && b < 0xA0) || (a == 0xED && b > 0x9F) || (a == 0xF0 && b < 0x90) || (a == 0xF4 && b > 0x8F)) return false;
        i += extra + 1;
    }
    return true;
}

bool percent_decode(std::string_view text, bool plus_is_space, std::string& out) {
    out.clear();
    for (size_t i = 0; i < text.size(); ++i) {
        unsigned char c = static_cast<unsigned char>(text[i]);
        if (c == '%') {
            if (i + 2 >= text.size()) return false;
            const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
            if (high < 0 || low < 0) return false;
            c = static_cast<unsigned char>(high * 16 + low);
            i += 2;
        } else if (c == '+' && plus_is_space) {
            c = ' ';
        }
        if (c < 0x20 || c == 0x7F) return false;
        out.push_back(static_cast<char>(c));
    }
    return is_utf8(out);
}

HeadProgress head_progress(std::string_view bytes, const Limits& limits) {
    const size_t line_end = bytes.find("\r\n");
    if (line_end == std::string_view::npos ? bytes.size() > limits.request_line_bytes : line_end > limits.request_line_bytes)
        return {0, Fault{"uri-too-long", fmt::format("the request line is longer than {} bytes", limits.request_line_bytes)}};
    if (line_end == std::string_view::npos) return {};
    const size_t end = bytes.find("\r\n\r\n", line_end);
    const size_t header_bytes = (end == std::string_view::npos ? bytes.size() : end) - line_end;
    if (header_bytes > limits.header_bytes)
        return {0, Fault{"headers-too-large", fmt::format("the headers are longer than {} bytes", limits.header_bytes)}};
    return {end == std::string_view::npos ? 0 : end + 4, std::nullopt};
}

std::optional<Fault> parse_head(std::string_view bytes, const Limits& limits, Head& head) {
    for (size_t i = 0; i < bytes.size(); ++i)
        if (bytes[i] == '\n' && (i == 0 || bytes[i - 1] != '\r')) return malformed("a line ends in a bare line feed");
    const size_t line_end = bytes.find("\r\n");
    if (line_end == std::string_view::npos) return malformed("the request line does not end");
    const std::string_view line = bytes.substr(0, line_end);
    const size_t first = line.find(' '), last = line.rfind(' ');
    if (first == std::string_view::npos || first == last) return malformed("the request line is not METHOD TARGET VERSION");
    head.method = std::string(line.substr(0, first));
    head.target = std::string(line.substr(first + 1, last - first - 1));
    const std::string_view version = line.substr(last + 1);
    if (!is_token(head.method) || head.method.size() > 32) return malformed("the method is not a token");
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return malformed("the version is neither HTTP/1.1 nor HTTP/1.0");
    head.http_1_0 = version == "HTTP/1.0";
    for (const char c : head.target)
        if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7F) return malformed("the target has a space or a control character");

    size_t host_count = 0;
    for (size_t at = line_end + 2; at + 2 < bytes.size() || bytes.substr(at) != "\r\n";) {
        const size_t end = bytes.find("\r\n", at);
        if (end == std::string_view::npos || end == at) break;
        const std::string_view field = bytes.substr(at, end - at);
        const size_t colon = field.find(':');
        if (field[0] == ' ' || field[0] == '\t') return malformed("a header is folded over two lines");
        if (colon == std::string_view::npos || !is_token(field.substr(0, colon))) return malformed("a header is not NAME: VALUE");
        const std::string_view value = trim(field.substr(colon + 1));
        for (const char c : value)
            if ((static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F)
                return malformed("a header value has a control character");
        if (head.headers.size() == limits.header_fields)
            return Fault{"headers-too-large", fmt::format("there are more than {} header fields", limits.header_fields)};
        head.headers.emplace_back(lower(field.substr(0, colon)), std::string(value));
        if (head.headers.back().first == "host") {
            ++host_count;
            head.host = std::string(value);
        }
        at = end + 2;
    }
    if (host_count > 1) return malformed("Host is given twice");
    if (host_count == 0 && !head.http_1_0) return malformed("Host is missing");
    if (auto fault = parse_target(head)) return fault;
    return parse_framing(head);
}

}  // namespace alder::http
