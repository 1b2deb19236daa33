// alCache: hands its input on. alshaders specification, section 3.
// The original keeps the last colour per thread; a graph here is evaluated once a point anyway, and no state is kept.
#include "graph/lowering.h"
#include "nodes/schema.h"

namespace alder {

static void lower_cache(Lowering& l, int) { l.result(l.input(0)); }

ALDER_NODE {
    using namespace param;
    NodeType n;
    n.name = "alCache";
    n.system = System::AlShaders;
    n.category = "utility";
    n.summary = "hands the connected network on";
    n.help = "In the original it remembers the last colour of the network; here every network is evaluated once a point anyway.";
    n.params = {color("input", 0, 0, 0).doc("network to hand on")};
    n.outputs = {{"out", Type::Color}};
    n.lower = lower_cache;
    return n;
}
}  // namespace alder
