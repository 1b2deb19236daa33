// Schema: what a node is, as data. One NodeType per node, declared in the node's own file beside its kernel and registered
// there; validation, the compiler, /v1/nodes, documentation and clients read nothing else.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/lobe.h"

namespace alder {

enum class System : uint8_t { Cycles, AlShaders };

enum class Type : uint8_t {
    Float,    ///< 1 channel
    Int,      ///< 1 channel (an integer held in a float lane)
    Bool,     ///< 1 channel (0 or 1)
    Color,    ///< 3 channels, linear Rec.709; a fourth number in a constant (Blender's alpha) is accepted and dropped
    Vector,   ///< 3 channels; alShaders' point and vector too
    Closure,  ///< no channels
    // Known at compile time, take no link:
    Enum,
    String,
    Image,   ///< {"file"|"asset", "colorspace", "alpha_mode", ...} or a plain string
    Ramp,    ///< Blender's color_ramp structure
    Curve,   ///< Blender's curve mapping structure
    Matrix,  ///< 16 numbers
    Json,    ///< any other structure
};
constexpr int channels(Type t) { return t == Type::Color || t == Type::Vector ? 3 : t <= Type::Bool ? 1 : 0; }
inline bool is_static(Type t) { return t >= Type::Enum; }
const char* type_name(Type t);

/// Shading globals: what the renderer (or an evaluation request) knows at a shading point. World space unless said.
enum class Global : uint8_t {
    P,               ///< position
    N,               ///< shading normal, turned towards the viewer on back faces (Cycles' sd->N)
    Ng,              ///< geometric normal, turned likewise
    I,               ///< unit direction towards the viewer
    Po,              ///< position, object space
    NormalObject,    ///< interpolated vertex normal, object space, not normalised, not turned; zero where not known (NormalMap)
    Ns,              ///< shading normal without bump, not turned (alShaders)
    Uv,              ///< u, v, 0 of the active UV map
    Generated,       ///< Blender's generated coordinates
    Dpdu, Dpdv,      ///< position derivatives by u, v
    Dpdx, Dpdy,      ///< position change per pixel step in x, y
    Duvdx, Duvdy,    ///< uv change per pixel step
    Dpodx, Dpody,    ///< object-space position change per pixel step
    Dgendx, Dgendy,  ///< generated-coordinate change per pixel step
    Tangent,         ///< of closures' unlinked Tangent: around the object's Z axis, world space
    TangentSign,     ///< 1 channel
    TangentObject,   ///< the same tangent as stored: object space
    Direction,       ///< world graphs: direction of the ray (away from the camera)
    Window,          ///< raster position 0..1, 0..1, 0
    Reflection,      ///< -
    ObjectToWorldX, ObjectToWorldY, ObjectToWorldZ, ObjectToWorldT,  ///< columns of the object matrix
    WorldToObjectX, WorldToObjectY, WorldToObjectZ, WorldToObjectT,  ///< columns of its inverse
    WorldToCameraX, WorldToCameraY, WorldToCameraZ, WorldToCameraT,  ///< columns; camera looks along +Z (Cycles' convention)
    ObjectLocation,
    Ld, Rd, Ro,      ///< alShaders: light direction, ray direction (towards the surface), ray origin
    Nf, Ngf,         ///< alShaders: N, Ng turned towards the viewer
    Nu,              ///< alShaders' N: smooth normal as modelled, not turned
    Ngu,             ///< alShaders' Ng: not turned
    ObjectColor,
    FibreTangent,    ///< along the fibre of a curve, from root to tip, unit length; on a mesh dPdu's direction
    FibreNormal,     ///< curves that carry normals: the normal, world space; zero where not known
    // 1 channel each from here
    Backfacing, RayLength, RayDepth, DiffuseDepth, GlossyDepth, TransmissionDepth, TransparentDepth,
    IsCameraRay, IsShadowRay, IsDiffuseRay, IsGlossyRay, IsSingularRay, IsReflectionRay, IsTransmissionRay, IsVolumeRay,
    FaceIndex, FootprintArea, ObjectIndex, MaterialIndex, ObjectRandom, IslandRandom, Pointiness,
    BarycentricU, BarycentricV, Time, PixelFootprint, PreviousAlpha,
    IsStrand,        ///< 1 on a curve
    FibreOffset,     ///< where the fibre is seen, across its width: -1 and 1 are the edges; the sign is that of Chiang et al.'s h
    FibreCoverage,   ///< half a pixel's width over the fibre's radius; 1 or more: seen from afar, and on rays not from the camera
    FibreRandom,     ///< random number of the curve, 0..1
    EdgeDistance,    ///< distance to the nearest edge of the triangle, world space; 0 where not known (Wireframe)
    kCount
};
int channels(Global g);
/// The name used in evaluation requests ("P", "uv", "ray_length"); nullptr where none exists.
const char* global_name(Global g);
bool global_from_name(std::string_view name, Global& out);

struct Item {
    std::string name;   ///< identifier in documents
    std::string label;  ///< for people
    std::string cycles; ///< Cycles' own spelling, accepted as alias
};

/// One parameter: a socket, a property or a parameter of the catalogues; they share one flat name space per node.
struct Param {
    std::string name;
    Type type = Type::Float;
    std::array<double, 16> number{};  ///< default of numeric types (Matrix: all 16)
    std::string text;                 ///< default of Enum and String; JSON text for Image, Ramp, Curve, Json
    std::vector<Item> items;
    double min = -1e38, max = 1e38;        ///< hard limits; a constant outside is an error only where `hard` is set
    double soft_min = 0, soft_max = 1;
    bool hard = false;
    bool link_only = false;       ///< only a link has an effect, a constant is ignored (alShaders)
    bool takes_links = true;
    bool has_default_global = false;  ///< unlinked: reads `default_global` and not the constant (Blender's hidden Vector, Normal)
    Global default_global = Global::P;
    std::string label, group, help;
    std::vector<std::string> aliases;
    uint64_t only_lobes = ~uint64_t{0};  ///< closure nodes: bits of the lobes (in lobes() order) that read this parameter

    // Builder style, so that a schema reads as a table.
    Param& range(double lo, double hi) { soft_min = lo; soft_max = hi; return *this; }
    Param& limit(double lo, double hi) { min = lo; max = hi; return *this; }
    Param& doc(std::string h) { help = std::move(h); return *this; }
    Param& in(std::string g) { group = std::move(g); return *this; }
    Param& alias(std::string a) { aliases.push_back(std::move(a)); return *this; }
    Param& unlinked(Global g) { has_default_global = true; default_global = g; return *this; }
    Param& linked_only() { link_only = true; return *this; }
    Param& no_link() { takes_links = false; return *this; }
    Param& lobes(uint64_t bits) { only_lobes = bits; return *this; }
};
namespace param {
Param f(std::string name, double def = 0);
Param i(std::string name, int def = 0);
Param b(std::string name, bool def = false);
Param color(std::string name, double r, double g, double b);
Param vector(std::string name, double x, double y, double z);
Param closure(std::string name);
/// First argument of items is not special: the default is named.
Param choice(std::string name, std::vector<Item> items, std::string def);
Param choice(std::string name, std::initializer_list<const char*> items, std::string def);
Param string(std::string name, std::string def = "");
Param image(std::string name);
Param ramp(std::string name);
Param curve(std::string name);
Param matrix(std::string name);
Param json(std::string name, std::string def = "null");
}  // namespace param

struct Output {
    std::string name;
    Type type = Type::Float;
    std::vector<std::string> aliases = {};
};

/// Tables and resources prepared at compile time from static parameters (baked ramps, images). Immutable.
struct Prepared {
    virtual ~Prepared() = default;
};

/// Compile-time values of one node instance. Indexed by parameter index.
struct Statics {
    const struct NodeType* type = nullptr;
    std::vector<int> enums;             ///< Enum: item index; Bool constants 0/1; else 0
    std::vector<std::string> text;      ///< String; JSON text of structures
    std::vector<bool> linked;           ///< whether a link (or attribute) feeds the parameter
    std::vector<LobeSpec> lobes;        ///< closure nodes: the static lobe set
    std::vector<int> lobe_offset;       ///< first output channel of each lobe
    std::shared_ptr<const Prepared> prepared;
    /// Numeric parameters: constant and 0 in every channel; constant and 1; unlinked and at the default. lobes() and uses() may
    /// rely on them: a constant that moves across one of these is a change of structure. Short or empty = not known.
    std::vector<bool> zero, one, at_default;
    std::vector<char>* asked = nullptr;  ///< while compiling: parameters for which one of these was looked at
    int e(int param) const { return enums[param]; }
    bool is_zero(int param) const { return fact(zero, param); }
    bool is_one(int param) const { return fact(one, param); }
    bool is_default(int param) const { return fact(at_default, param); }

  private:
    bool fact(const std::vector<bool>& facts, int param) const {
        if (asked) (*asked)[param] = 1;
        return static_cast<size_t>(param) < facts.size() && facts[param];
    }
};

/// One channel of an operand: stride 1 = one value a point, stride 0 = the same for all (then at least 16 copies lie at p).
template <class R>
struct Channel {
    const R* p = nullptr;
    uint32_t stride = 0;
};

/// What kernels may use besides their operands. Owned by whoever executes the program.
struct EvalContext {
    class ImageStore* images = nullptr;
};

/// One execution of one op. Buffers hold n values, padded to whole registers (kPadding) and readable up to there.
template <class R>
struct OpCall {
    const Channel<R>* in;   ///< channels of the dynamic parameters in schema order, then of NodeType::globals
    R* const* out;          ///< channels of the outputs in schema order (closure nodes: of the lobes); null = not wanted
    const Statics* statics;
    const EvalContext* context;
    uint32_t n;
};
inline constexpr uint32_t kPadding = 16;

using KernelF = void (*)(const OpCall<float>&);
using KernelD = void (*)(const OpCall<double>&);
struct Kernel {
    KernelF lanes = nullptr;   ///< SIMD, dispatched to the chosen instruction set
    KernelF scalar = nullptr;  ///< the same source over float
    KernelD f64 = nullptr;     ///< the same source over double
};

/// When an input need not be evaluated. The compiler groups what only such an input needs into a guarded region.
struct LazyRule {
    enum When : uint8_t {
        NeededIfNonZero,   ///< needed where selector != 0
        NeededIfPositive,  ///< needed where selector > 0
        NeededIfBelowOne,  ///< needed where selector < 1
        NeededIfIndex,     ///< needed where alSwitch's rule picks `index` (selector = mix, second = threshold)
    };
    int param;      ///< the input guarded
    int selector;   ///< parameter whose value decides
    When when;
    int index = 0;
    int second = -1;
};

class Lowering;  // graph/lowering.h: what custom lowering may do

struct NodeType {
    std::string name;
    System system = System::Cycles;
    std::string category;
    std::string summary;  ///< one sentence, in the user's words
    std::string help;     ///< further documentation, sources
    std::vector<std::string> aliases;
    std::vector<Param> params;
    std::vector<Output> outputs;
    std::vector<Global> globals;  ///< read by the kernel, appended after the parameters' channels
    Kernel kernel;
    /// Closure nodes: AOV names that carry a parameter's value ("id_1" -> id1), blended like the closure itself.
    std::vector<std::pair<std::string, int>> closure_aovs;
    float cost_ns = 1;            ///< a point, AVX2, order of magnitude: decides whether a lazy region pays
    bool foldable = true;         ///< false where the result depends on more than operands and statics (textures)

    /// Whether a parameter has any effect given the statics (unavailable sockets, switched-off features). Optional.
    bool (*uses)(const Statics&, int param) = nullptr;
    /// The same for globals[index]; what is not used reads as zero. Optional.
    bool (*uses_global)(const Statics&, int index) = nullptr;
    /// Bakes tables, opens images. Appends to `errors` what is wrong. Optional. Must not throw.
    std::shared_ptr<const Prepared> (*prepare)(const Statics&, std::vector<std::string>& errors) = nullptr;
    /// Lazy inputs given the statics. Optional.
    std::vector<LazyRule> (*lazy)(const Statics&) = nullptr;
    /// Custom lowering of one output to IR values (aliases of globals, pass-through, Bump, closure mixing). Optional.
    void (*lower)(Lowering&, int output) = nullptr;
    /// Closure nodes: the lobes the kernel emits given the statics, in the order of its output channels.
    std::vector<LobeSpec> (*lobes)(const Statics&) = nullptr;
    /// Refuses what is declared but not there yet: one sentence per fault ("sssMix: subsurface scattering is not available").
    /// `constant(param)` is the constant's first three numbers, or null where the parameter is linked. Optional.
    void (*check)(const Statics&, const std::vector<const double*>& constant, std::vector<std::string>& errors) = nullptr;

    bool is_closure() const { return lobes != nullptr || (!outputs.empty() && outputs[0].type == Type::Closure); }
    int param_index(std::string_view name) const;   ///< -1 if unknown; accepts aliases
    int output_index(std::string_view name) const;  ///< -1 if unknown; accepts aliases
    int channel_of(int param) const;                ///< first channel of a dynamic parameter in OpCall::in
    int channel_of_global(int index) const;
};

/// All registered nodes, sorted by name. Built on first use; thread safe; lives for the process.
std::span<const NodeType* const> all_nodes();
/// By name or alias; null if unknown.
const NodeType* find_node(std::string_view name);
/// Nearest name by edit distance among candidates; empty where none is near.
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

struct NodeRegistration {
    explicit NodeRegistration(NodeType (*make)());
};
#define ALDER_NODE_CONCAT2(a, b) a##b
#define ALDER_NODE_CONCAT(a, b) ALDER_NODE_CONCAT2(a, b)
/// At namespace scope in the node's file: ALDER_NODE { NodeType n; ...; return n; }
#define ALDER_NODE                                                                                       \
    static NodeType ALDER_NODE_CONCAT(make_node_, __LINE__)();                                           \
    static const NodeRegistration ALDER_NODE_CONCAT(register_node_, __LINE__)(ALDER_NODE_CONCAT(make_node_, __LINE__)); \
    static NodeType ALDER_NODE_CONCAT(make_node_, __LINE__)()

}  // namespace alder
