// Tile gate: lets a process that renders in the background stand aside before each tile.
#include "render/tile_gate.h"

#include <chrono>
#include <thread>

namespace alder {
namespace {

std::atomic<const std::atomic<int>*> gate{nullptr};
constexpr auto kLook = std::chrono::microseconds(500), kMost = std::chrono::microseconds(1'000'000);

}  // namespace

void set_tile_gate(const std::atomic<int>* held) { gate = held; }

void pass_tile_gate() {
    const std::atomic<int>* const held = gate;
    if (!held) return;
    for (auto waited = kLook * 0; held->load(std::memory_order_relaxed) > 0 && waited < kMost; waited += kLook) std::this_thread::sleep_for(kLook);
}

}  // namespace alder
