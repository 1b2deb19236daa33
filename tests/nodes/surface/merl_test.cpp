// Files of measured reflectance: which are read, which cell a pair of directions has, and what is done about bad numbers.
#include "nodes/surface/merl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

namespace alder::testing {
namespace {

class File {
  public:
    File(const char* name, int32_t a, int32_t b, int32_t c, size_t numbers)
        : path_((std::filesystem::temp_directory_path() / (std::string("alder_merl_") + name + ".binary")).string()) {
        std::ofstream f(path_, std::ios::binary);
        const int32_t size[3] = {a, b, c};
        f.write(reinterpret_cast<const char*>(size), sizeof size);
        std::vector<double> v(numbers);
        for (size_t i = 0; i < numbers; ++i) v[i] = static_cast<double>(i % 1000);
        if (numbers > 5) {
            v[0] = -3;
            v[1] = std::numeric_limits<double>::quiet_NaN();
            v[2] = std::numeric_limits<double>::infinity();
        }
        f.write(reinterpret_cast<const char*>(v.data()), static_cast<std::streamsize>(numbers * sizeof(double)));
    }
    ~File() { std::filesystem::remove(path_); }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

TEST(Merl, reads_a_file_and_scales_its_channels) {
    constexpr size_t kCells = MerlTable::kCells;
    const File file("good", 90, 90, 180, 3 * kCells);
    std::string error;
    const auto table = read_merl(file.path(), error);
    ASSERT_TRUE(table) << error;
    ASSERT_EQ(table->values.size(), 3 * kCells);
    // Negative and non-finite values count as nothing.
    for (int cell = 0; cell < 3; ++cell) EXPECT_EQ(table->values[3 * cell], 0) << cell;
    const size_t cell = 123456;
    const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(table->values[3 * cell + c], static_cast<double>((c * kCells + cell) % 1000) * scale[c], 1e-6) << c;
    EXPECT_NEAR(table->below.back(), 1, 1e-9);
    for (const double b : table->band) EXPECT_GE(b, 0);
}

TEST(Merl, refuses_what_is_no_such_table) {
    std::string error;
    EXPECT_FALSE(read_merl("/nowhere/at/all.binary", error));
    EXPECT_NE(error.find("header"), std::string::npos) << error;
    // The same count of cells in other proportions, huge, negative.
    const int32_t sizes[][3] = {{180, 90, 90}, {0x7fffffff, 0x7fffffff, 0x7fffffff}, {-90, 90, -180}, {0, 0, 0}};
    for (const auto& s : sizes) {
        const File file("size", s[0], s[1], s[2], 10);
        EXPECT_FALSE(read_merl(file.path(), error));
        EXPECT_NE(error.find("90 x 90 x 180"), std::string::npos) << error;
    }
    const File file("short", 90, 90, 180, 1000);
    EXPECT_FALSE(read_merl(file.path(), error));
    EXPECT_NE(error.find("cut short"), std::string::npos) << error;
}

// alshaders specification, section 8: theta_h by the root, phi_d and phi_d + pi are one.
TEST(Merl, cells_by_angle) {
    const double pi = 3.14159265358979;
    EXPECT_EQ(MerlTable::cell(0, 0, 0), 0);
    EXPECT_EQ(MerlTable::cell(pi / 2 * 0.25 * 1.0001, 0, 0), 180 * 90 * 45);
    EXPECT_EQ(MerlTable::cell(0, pi / 4 * 1.0001, 0), 180 * 45);
    EXPECT_EQ(MerlTable::cell(0, 0, pi / 2 * 1.0001), 90);
    EXPECT_EQ(MerlTable::cell(0.3, 0.4, -0.5), MerlTable::cell(0.3, 0.4, pi - 0.5));
    EXPECT_EQ(MerlTable::cell(pi / 2, pi / 2, pi), MerlTable::kCells - 1);
    const double odd[] = {-1, 0, 1e30, -1e30, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
    for (const double a : odd)
        for (const double b : odd)
            for (const double c : odd) {
                const int cell = MerlTable::cell(a, b, c);
                EXPECT_TRUE(cell >= 0 && cell < MerlTable::kCells) << a << " " << b << " " << c;
            }
    for (int k = 0; k < 90; ++k) EXPECT_EQ(MerlTable::band_of((MerlTable::band_edge(k) + MerlTable::band_edge(k + 1)) / 2), k);
}

}  // namespace
}  // namespace alder::testing
