// Writes nodes/surface/tables/ggx_energy.cpp: generate_energy_tables > nodes/surface/tables/ggx_energy.cpp (minutes).
#include <cstdio>
#include <cstring>
#include <functional>
#include <thread>

#include "tests/tools/energy_quadrature.h"

namespace {
using namespace alder::energy;

void write(const char* name, const char* comment, int count, const std::function<double(int)>& value) {
    std::vector<double> v(count);
    std::vector<std::thread> threads;
    const int workers = std::max(1u, std::thread::hardware_concurrency());
    for (int w = 0; w < workers; ++w)
        threads.emplace_back([&, w] {
            for (int i = w; i < count; i += workers) v[i] = value(i);
        });
    for (std::thread& t : threads) t.join();
    std::printf("/// %s\nextern const float %s[%d] = {", comment, name, count);
    for (int i = 0; i < count; ++i) {
        char text[32];
        std::snprintf(text, sizeof text, "%.7g", v[i]);
        std::printf("%s%s%s,", i % 8 ? " " : "\n    ", text, std::strpbrk(text, ".e") ? "f" : "");
    }
    std::printf("\n};\n\n");
    std::fflush(stdout);
}
}  // namespace

int main() {
    const int fine = 400, coarse = 160, mus = 24;
    std::printf(
        "// Energy tables of GGX, by quadrature. Written by tests/tools/generate_energy_tables.cpp; definitions there and in\n"
        "// nodes/surface/energy-inl.h. Layout: roughness runs fastest, then the viewer's cosine, then z = F0^(1/4).\n"
        "#include \"nodes/surface/tables/tables.h\"\n\nnamespace alder {\n\n");
    const auto rough = [](int i, int n) { return axis_node(i % n, n); };
    write("kGgxE", "Albedo with F = 1: 32 x 32.", 32 * 32,
          [&](int i) { return ggx_albedo(rough(i, 32), axis_node(i / 32, 32), fine); });
    write("kGgxEavg", "Its average over the hemisphere: 32.", 32, [&](int i) {
        return hemispherical(mus, [&](double mu) { return ggx_albedo(rough(i, 32), mu, coarse); });
    });
    for (const bool inside : {false, true}) {
        write(inside ? "kGgxGlassInsideE" : "kGgxGlassE", inside ? "Glass seen from inside: 16 x 16 x 16." : "Glass: 16 x 16 x 16.",
              16 * 16 * 16, [&](int i) {
                  const int z = i / 256;
                  return z == 0 ? 1.0
                                : ggx_glass_albedo(rough(i, 16), axis_node(i / 16 % 16, 16), ior_of(z / 15.0), inside, fine);
              });
        write(inside ? "kGgxGlassInsideEavg" : "kGgxGlassEavg", "Its average over the hemisphere: 16 x 16.", 16 * 16, [&](int i) {
            const int z = i / 16;
            return z == 0 ? 1.0 : hemispherical(mus, [&](double mu) {
                return ggx_glass_albedo(rough(i, 16), mu, ior_of(z / 15.0), inside, coarse);
            });
        });
    }
    write("kGgxFresnelRise", "Mean rise of the Fresnel curve over visible normals: 16 x 16 x 16.", 16 * 16 * 16, [&](int i) {
        const int z = i / 256;
        return z == 0 ? 0.0 : ggx_fresnel_rise(rough(i, 16), axis_node(i / 16 % 16, 16), ior_of(z / 15.0), fine);
    });
    std::printf("}  // namespace alder\n");
}
