// The .alder container: reading and writing ZIP archives (PKWARE APPNOTE 6.3.10, sections 4.3 and 4.5.3).
#include "render/import/container.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace alder {
namespace {

constexpr uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50, kEnd64 = 0x06064b50, kLocator64 = 0x07064b50;
constexpr size_t kLocalBytes = 30, kCentralBytes = 46, kEndBytes = 22, kEnd64Bytes = 56, kLocator64Bytes = 20;

template <class T>
T get(const uint8_t* p) {
    T x;
    std::memcpy(&x, p, sizeof(T));
    return x;
}
template <class T>
void put(std::vector<uint8_t>& out, T x) {
    const auto* p = reinterpret_cast<const uint8_t*>(&x);
    out.insert(out.end(), p, p + sizeof(T));
}

/// zlib takes 32-bit lengths.
uint32_t checksum(std::span<const uint8_t> bytes) {
    uLong crc = crc32(0, nullptr, 0);
    for (size_t at = 0; at < bytes.size();) {
        const size_t n = std::min<size_t>(bytes.size() - at, size_t(1) << 30);
        crc = crc32(crc, bytes.data() + at, uInt(n));
        at += n;
    }
    return uint32_t(crc);
}

/// Raw deflate into exactly `out`. False where the data is broken, or more or less than that.
bool inflate_into(std::span<const uint8_t> packed, std::span<uint8_t> out) {
    z_stream z{};
    if (inflateInit2(&z, -15) != Z_OK) return false;
    size_t in_at = 0, out_at = 0;
    int status = Z_OK;
    while (status == Z_OK) {
        const size_t in_n = std::min<size_t>(packed.size() - in_at, size_t(1) << 30);
        uint8_t spare = 0;   // room for one byte too many, so that an over-long stream shows
        const bool full = out_at == out.size();
        const size_t out_n = full ? 1 : std::min<size_t>(out.size() - out_at, size_t(1) << 30);
        z.next_in = const_cast<Bytef*>(packed.data() + in_at);
        z.avail_in = uInt(in_n);
        z.next_out = full ? &spare : out.data() + out_at;
        z.avail_out = uInt(out_n);
        status = inflate(&z, Z_NO_FLUSH);
        in_at += in_n - z.avail_in;
        if (full && z.avail_out == 0) status = Z_DATA_ERROR;
        if (!full) out_at += out_n - z.avail_out;
        if (status == Z_OK && in_n == z.avail_in && out_n == z.avail_out) status = Z_BUF_ERROR;
    }
    inflateEnd(&z);
    return status == Z_STREAM_END && out_at == out.size();
}

}  // namespace

Container::~Container() {
    if (fd_ >= 0) ::close(fd_);
}

std::shared_ptr<const Container> Container::open(const std::string& path, std::string& error, const ContainerLimits& limits) {
    std::shared_ptr<Container> c(new Container);
    c->fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat st {};
    if (c->fd_ < 0 || ::fstat(c->fd_, &st) != 0 || !S_ISREG(st.st_mode)) {
        error = path + ": cannot read: " + (c->fd_ < 0 ? std::strerror(errno) : "not a file");
        return nullptr;
    }
    c->file_bytes_ = uint64_t(st.st_size);
    if (c->read_directory(limits, error)) return c;
    error = path + ": " + error;
    return nullptr;
}

std::shared_ptr<const Container> Container::from_memory(std::vector<uint8_t> bytes, std::string& error, const ContainerLimits& limits) {
    std::shared_ptr<Container> c(new Container);
    c->memory_ = std::move(bytes);
    c->file_bytes_ = c->memory_.size();
    return c->read_directory(limits, error) ? c : nullptr;
}

bool Container::read_at(uint64_t offset, void* to, size_t n) const {
    if (offset > file_bytes_ || n > file_bytes_ - offset) return false;
    if (fd_ < 0) {
        if (n > 0) std::memcpy(to, memory_.data() + offset, n);
        return true;
    }
    for (char* p = static_cast<char*>(to); n > 0;) {
        const ssize_t got = ::pread(fd_, p, n, off_t(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        p += got;
        offset += uint64_t(got);
        n -= size_t(got);
    }
    return true;
}

bool Container::read_directory(const ContainerLimits& limits, std::string& error) {
    // The end record is the last thing but for a comment of up to 65535 bytes.
    const size_t tail_bytes = size_t(std::min<uint64_t>(file_bytes_, kEndBytes + 65535));
    std::vector<uint8_t> tail(tail_bytes);
    size_t end = tail_bytes;
    if (read_at(file_bytes_ - tail_bytes, tail.data(), tail_bytes)) {
        for (size_t i = tail_bytes >= kEndBytes ? tail_bytes - kEndBytes + 1 : 0; i-- > 0;) {
            if (get<uint32_t>(&tail[i]) == kEnd) {
                end = i;
                break;
            }
        }
    }
    if (end == tail_bytes) {
        error = "not an .alder container (no ZIP directory)";
        return false;
    }
    uint64_t count = get<uint16_t>(&tail[end + 10]), bytes = get<uint32_t>(&tail[end + 12]), start = get<uint32_t>(&tail[end + 16]);
    if (end >= kLocator64Bytes && get<uint32_t>(&tail[end - kLocator64Bytes]) == kLocator64) {
        uint8_t record[kEnd64Bytes];
        if (!read_at(get<uint64_t>(&tail[end - kLocator64Bytes + 8]), record, kEnd64Bytes) || get<uint32_t>(record) != kEnd64) {
            error = "the ZIP64 end record is broken";
            return false;
        }
        count = get<uint64_t>(record + 32);
        bytes = get<uint64_t>(record + 40);
        start = get<uint64_t>(record + 48);
    }
    if (start > file_bytes_ || bytes > file_bytes_ - start || count > bytes / kCentralBytes || count > limits.members) {
        error = "the ZIP directory does not fit the file, or has more than " + std::to_string(limits.members) + " members";
        return false;
    }
    std::vector<uint8_t> directory(static_cast<size_t>(bytes));
    if (!read_at(start, directory.data(), directory.size())) {
        error = "the ZIP directory cannot be read";
        return false;
    }
    size_t at = 0;
    for (uint64_t i = 0; i < count; ++i) {
        size_t left = directory.size() - at, used = 0;
        if (!add_member(directory.data() + at, left, error, used)) return false;
        at += used;
    }
    uint64_t total = 0;
    for (const auto& [name, m] : members_) {
        if (m.size > limits.bytes || (total += m.size) > limits.bytes || total / limits.ratio > file_bytes_ + 4096) {
            error = "the members unpack to more than is accepted (" + std::to_string(limits.bytes) + " bytes, or " + std::to_string(limits.ratio) + " times the file)";
            return false;
        }
    }
    return true;
}

bool Container::add_member(const uint8_t* p, size_t& left, std::string& error, size_t& used) {
    error = "the ZIP directory is broken";
    if (left < kCentralBytes || get<uint32_t>(p) != kCentral) return false;
    const uint16_t flags = get<uint16_t>(p + 8), method = get<uint16_t>(p + 10);
    const size_t name_bytes = get<uint16_t>(p + 28), extra_bytes = get<uint16_t>(p + 30), comment_bytes = get<uint16_t>(p + 32);
    used = kCentralBytes + name_bytes + extra_bytes + comment_bytes;
    if (used > left) return false;
    const std::string name(reinterpret_cast<const char*>(p + kCentralBytes), name_bytes);
    Member m;
    m.crc = get<uint32_t>(p + 16);
    m.packed = get<uint32_t>(p + 20);
    m.size = get<uint32_t>(p + 24);
    m.header = get<uint32_t>(p + 42);
    m.deflated = method == 8;
    // ZIP64 extra field: 64-bit values for those of size, packed size and offset that are all ones above, in this order.
    for (const uint8_t *e = p + kCentralBytes + name_bytes, *end = e + extra_bytes; end - e >= 4;) {
        const size_t n = get<uint16_t>(e + 2);
        const uint8_t* value = e + 4;
        if (n > size_t(end - value)) return false;
        if (get<uint16_t>(e) == 1) {
            const uint8_t* stop = value + n;
            for (uint64_t* field : {&m.size, &m.packed, &m.header}) {
                if (*field != 0xffffffffu) continue;
                if (stop - value < 8) return false;
                *field = get<uint64_t>(value);
                value += 8;
            }
        }
        e += 4 + n;
    }
    if (m.header > file_bytes_ || m.packed > file_bytes_ - m.header) return false;
    error.clear();
    if (name.empty() || name.back() == '/') return true;   // a folder
    if ((flags & 1) != 0 || (method != 0 && method != 8)) {
        error = "member \"" + name + "\" is encrypted or packed by a method other than store and deflate";
        return false;
    }
    if (!m.deflated && m.packed != m.size) {
        error = "member \"" + name + "\" has two different sizes";
        return false;
    }
    if (!members_.emplace(name, m).second) {
        error = "two members are called \"" + name + "\"";
        return false;
    }
    return true;
}

uint64_t Container::size(std::string_view name) const {
    const auto i = members_.find(name);
    return i == members_.end() ? 0 : i->second.size;
}

std::vector<std::string> Container::names() const {
    std::vector<std::string> out;
    for (const auto& [name, m] : members_) out.push_back(name);
    return out;
}

bool Container::read(std::string_view name, std::vector<uint8_t>& bytes, std::string& error) const {
    const auto i = members_.find(name);
    if (i == members_.end()) {
        error = "the container has no member \"" + std::string(name) + "\"";
        return false;
    }
    const Member& m = i->second;
    error = "member \"" + i->first + "\" is broken";
    uint8_t local[kLocalBytes];
    if (!read_at(m.header, local, kLocalBytes) || get<uint32_t>(local) != kLocal) return false;
    const uint64_t start = m.header + kLocalBytes + get<uint16_t>(local + 26) + get<uint16_t>(local + 28);
    if (start > file_bytes_ || m.packed > file_bytes_ - start) return false;
    bytes.resize(size_t(m.size));
    if (m.deflated) {
        std::vector<uint8_t> packed(size_t(m.packed));
        if (!read_at(start, packed.data(), packed.size()) || !inflate_into(packed, bytes)) return false;
    } else if (!read_at(start, bytes.data(), bytes.size())) {
        return false;
    }
    if (checksum(bytes) != m.crc) return false;
    error.clear();
    return true;
}

bool ContainerWriter::add(const std::string& name, std::span<const uint8_t> bytes) {
    if (name.empty() || name.size() > 65535) {
        error_ = "a member needs a name of 1 to 65535 bytes";
        return false;
    }
    for (const Entry& e : entries_) {
        if (e.name == name) {
            error_ = "two members are called \"" + name + "\"";
            return false;
        }
    }
    const Entry e{name, file_.position(), bytes.size(), checksum(bytes)};
    const bool large = e.size >= 0xffffffffu;
    std::vector<uint8_t> h;
    put<uint32_t>(h, kLocal);
    put<uint16_t>(h, large ? 45 : 20);
    put<uint16_t>(h, 0x800);   // names are UTF-8
    put<uint16_t>(h, 0);       // stored
    put<uint32_t>(h, 0x00210000);   // 1 January 1980, 0:00
    put<uint32_t>(h, e.crc);
    put<uint32_t>(h, large ? 0xffffffffu : uint32_t(e.size));
    put<uint32_t>(h, large ? 0xffffffffu : uint32_t(e.size));
    put<uint16_t>(h, uint16_t(name.size()));
    put<uint16_t>(h, large ? 20 : 0);
    h.insert(h.end(), name.begin(), name.end());
    if (large) {
        put<uint16_t>(h, 1);
        put<uint16_t>(h, 16);
        put<uint64_t>(h, e.size);
        put<uint64_t>(h, e.size);
    }
    entries_.push_back(e);
    return file_.write(h.data(), h.size()) && file_.write(bytes.data(), bytes.size());
}

bool ContainerWriter::commit() {
    if (!error_.empty()) return false;
    const uint64_t start = file_.position();
    std::vector<uint8_t> d;
    for (const Entry& e : entries_) {
        const bool large = e.size >= 0xffffffffu || e.offset >= 0xffffffffu;
        put<uint32_t>(d, kCentral);
        put<uint16_t>(d, large ? 45 : 20);
        put<uint16_t>(d, large ? 45 : 20);
        put<uint16_t>(d, 0x800);
        put<uint16_t>(d, 0);
        put<uint32_t>(d, 0x00210000);
        put<uint32_t>(d, e.crc);
        put<uint32_t>(d, large ? 0xffffffffu : uint32_t(e.size));
        put<uint32_t>(d, large ? 0xffffffffu : uint32_t(e.size));
        put<uint16_t>(d, uint16_t(e.name.size()));
        put<uint16_t>(d, large ? 28 : 0);
        put<uint16_t>(d, 0);   // comment
        put<uint16_t>(d, 0);   // disk
        put<uint16_t>(d, 0);   // internal attributes
        put<uint32_t>(d, 0);   // external attributes
        put<uint32_t>(d, large ? 0xffffffffu : uint32_t(e.offset));
        d.insert(d.end(), e.name.begin(), e.name.end());
        if (large) {
            put<uint16_t>(d, 1);
            put<uint16_t>(d, 24);
            put<uint64_t>(d, e.size);
            put<uint64_t>(d, e.size);
            put<uint64_t>(d, e.offset);
        }
    }
    const uint64_t bytes = d.size(), count = entries_.size();
    if (count >= 0xffff || bytes >= 0xffffffffu || start >= 0xffffffffu) {
        put<uint32_t>(d, kEnd64);
        put<uint64_t>(d, kEnd64Bytes - 12);
        put<uint16_t>(d, 45);
        put<uint16_t>(d, 45);
        put<uint32_t>(d, 0);
        put<uint32_t>(d, 0);
        put<uint64_t>(d, count);
        put<uint64_t>(d, count);
        put<uint64_t>(d, bytes);
        put<uint64_t>(d, start);
        put<uint32_t>(d, kLocator64);
        put<uint32_t>(d, 0);
        put<uint64_t>(d, start + bytes);
        put<uint32_t>(d, 1);
    }
    put<uint32_t>(d, kEnd);
    put<uint32_t>(d, 0);
    put<uint16_t>(d, uint16_t(std::min<uint64_t>(count, 0xffff)));
    put<uint16_t>(d, uint16_t(std::min<uint64_t>(count, 0xffff)));
    put<uint32_t>(d, uint32_t(std::min<uint64_t>(bytes, 0xffffffffu)));
    put<uint32_t>(d, uint32_t(std::min<uint64_t>(start, 0xffffffffu)));
    put<uint16_t>(d, 0);
    return file_.write(d.data(), d.size()) && file_.commit();
}

}  // namespace alder
