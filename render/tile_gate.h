// Tile gate: lets a process that renders in the background stand aside before each tile while something more urgent runs
// elsewhere on the machine. Nobody waits where none is set.
#pragma once
#include <atomic>

namespace alder {

/// While `*held` is not 0, tiles wait, though never longer than a second each, so that nothing starves. It outlives all renders;
/// null opens the gate for good.
void set_tile_gate(const std::atomic<int>* held);
/// What a renderer calls before a tile.
void pass_tile_gate();

}  // namespace alder
