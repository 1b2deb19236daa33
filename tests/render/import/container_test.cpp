// Containers: what is written is read back and by other ZIP tools; broken archives are errors, never crashes.
#include "render/import/container.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <filesystem>
#include <fstream>

namespace alder {
namespace {

std::string scratch(const std::string& name) {
    const std::filesystem::path dir = std::filesystem::path(ALDER_BINARY_DIR) / "test_scratch" / "container";
    std::filesystem::create_directories(dir);
    return (dir / name).string();
}
std::vector<uint8_t> bytes_of(const std::string& s) { return {s.begin(), s.end()}; }
std::vector<uint8_t> file_bytes(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string write_sample(const std::string& name) {
    const std::string path = scratch(name);
    ContainerWriter w(path);
    EXPECT_TRUE(w.add("scene.json", bytes_of("{\"alder_scene\": 1}")));
    EXPECT_TRUE(w.add("images/ü.png", std::vector<uint8_t>(5000, 7)));
    EXPECT_TRUE(w.add("empty", {}));
    EXPECT_TRUE(w.commit()) << w.error();
    return path;
}

TEST(Container, members_come_back_from_file_and_memory) {
    const std::string path = write_sample("a.alder");
    std::string error;
    for (const auto& c : {Container::open(path, error), Container::from_memory(file_bytes(path), error)}) {
        ASSERT_TRUE(c) << error;
        EXPECT_EQ(c->names(), (std::vector<std::string>{"empty", "images/ü.png", "scene.json"}));
        std::vector<uint8_t> bytes;
        ASSERT_TRUE(c->read("images/ü.png", bytes, error)) << error;
        EXPECT_EQ(bytes, std::vector<uint8_t>(5000, 7));
        ASSERT_TRUE(c->read("empty", bytes, error));
        EXPECT_TRUE(bytes.empty());
        EXPECT_FALSE(c->read("nope", bytes, error));
        EXPECT_NE(error.find("nope"), std::string::npos);
    }
    EXPECT_EQ(file_bytes(path), file_bytes(write_sample("b.alder"))) << "same members, same bytes";
}

TEST(Container, deflated_members_of_other_tools_are_read) {
    // python3 -c "import zipfile; z = zipfile.ZipFile('x', 'w', 8); z.writestr('a', 'hello ' * 20)"
    static const unsigned char kZip[] = {
        0x50, 0x4b, 0x03, 0x04, 0x14, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x21, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x78, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x61};
    const std::string text = [] {
        std::string s;
        for (int i = 0; i < 20; ++i) s += "hello ";
        return s;
    }();
    // The stream itself is made here, so that the test does not depend on one version of zlib.
    std::vector<uint8_t> packed(200);
    z_stream z{};
    ASSERT_EQ(deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    z.avail_in = uInt(text.size());
    z.next_out = packed.data();
    z.avail_out = uInt(packed.size());
    ASSERT_EQ(deflate(&z, Z_FINISH), Z_STREAM_END);
    packed.resize(z.total_out);
    deflateEnd(&z);
    const uint32_t crc = uint32_t(crc32(0, reinterpret_cast<const Bytef*>(text.data()), uInt(text.size())));
    const auto build = [&](uint32_t size, uint32_t sum) {
        std::vector<uint8_t> file(kZip, kZip + sizeof(kZip));
        const auto put32 = [](std::vector<uint8_t>& v, size_t at, uint32_t x) {
            for (int i = 0; i < 4; ++i) v[at + size_t(i)] = uint8_t(x >> (8 * i));
        };
        put32(file, 14, sum);
        put32(file, 18, uint32_t(packed.size()));
        put32(file, 22, size);
        file.insert(file.end(), packed.begin(), packed.end());
        const uint32_t start = uint32_t(file.size());
        std::vector<uint8_t> central(46);
        put32(central, 0, 0x02014b50);
        central[10] = 8;
        put32(central, 16, sum);
        put32(central, 20, uint32_t(packed.size()));
        put32(central, 24, size);
        central[28] = 1;
        central.push_back('a');
        file.insert(file.end(), central.begin(), central.end());
        std::vector<uint8_t> end(22);
        put32(end, 0, 0x06054b50);
        end[8] = end[10] = 1;
        put32(end, 12, uint32_t(central.size()));
        put32(end, 16, start);
        file.insert(file.end(), end.begin(), end.end());
        return file;
    };
    std::string error;
    std::vector<uint8_t> bytes;
    const auto c = Container::from_memory(build(120, crc), error);
    ASSERT_TRUE(c) << error;
    ASSERT_TRUE(c->read("a", bytes, error)) << error;
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), text);
    // A size too small, too large, or another checksum.
    for (const auto& [size, sum] : {std::pair{119u, crc}, {121u, crc}, {120u, crc ^ 1}}) {
        const auto wrong = Container::from_memory(build(size, sum), error);
        ASSERT_TRUE(wrong) << error;
        EXPECT_FALSE(wrong->read("a", bytes, error)) << size;
    }
    // A promise to unpack to a gigabyte is refused before anything is allocated.
    EXPECT_FALSE(Container::from_memory(build(1u << 30, crc), error));
    EXPECT_NE(error.find("unpack"), std::string::npos) << error;
}

TEST(Container, every_truncation_and_many_changes_are_survived) {
    const std::vector<uint8_t> whole = file_bytes(write_sample("fuzz.alder"));
    std::string error;
    for (size_t n = 0; n < whole.size(); n += n < whole.size() - 400 ? 97 : 1) {
        EXPECT_FALSE(Container::from_memory({whole.begin(), whole.begin() + std::ptrdiff_t(n)}, error)) << n;
    }
    uint32_t random = 7;
    for (int i = 0; i < 3000; ++i) {
        std::vector<uint8_t> bad = whole;
        for (int k = 0; k < 3; ++k) {
            random = random * 1664525u + 1013904223u;
            bad[bad.size() - 1 - (random >> 8) % 330] = uint8_t(random >> 24);   // the directory
        }
        if (const auto c = Container::from_memory(bad, error)) {
            std::vector<uint8_t> bytes;
            for (const std::string& name : c->names()) (void)c->read(name, bytes, error);
        }
    }
    EXPECT_FALSE(Container::open(scratch("not_there"), error));
    EXPECT_FALSE(Container::open("/dev", error));
}

TEST(Container, a_name_is_used_once) {
    ContainerWriter w(scratch("twice.alder"));
    EXPECT_TRUE(w.add("a", bytes_of("1")));
    EXPECT_FALSE(w.add("a", bytes_of("2")));
    EXPECT_NE(w.error().find("\"a\""), std::string::npos);
    EXPECT_FALSE(w.commit());
    EXPECT_FALSE(std::filesystem::exists(scratch("twice.alder")));
}

}  // namespace
}  // namespace alder
