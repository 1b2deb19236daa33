// What alSurface's constants decide before any point is shaded: its lobes, the parameters they need, and what is refused.
#pragma once
#include "nodes/schema.h"

namespace alder::al_surface {

std::vector<LobeSpec> lobes(const Statics& s);
bool uses(const Statics& s, int param);
void set_only_lobes(NodeType& n);
void check(const Statics& s, const std::vector<const double*>& constant, std::vector<std::string>& errors);
/// Parameter shown by an item of `debug` (not "off").
int debug_param(int item);

}  // namespace alder::al_surface
