// Material: a graph document compiled to typed, hash-consed IR and, on demand, to Programs. Immutable and shared; thread safe.
//
//   auto m = build_material(json, options, diagnostics);       // validation: all faults at once
//   auto p = m->program({.surface = LobeFilter::Scatter});     // optimise for what is requested; cached in the material
//   Executor<float> x(context);  x.run(*p, n, inputs);         // batches of points
//   auto m2 = m->with_param("/nodes/s/params/ior", 1.3, d);    // one constant changed: shares everything that still holds
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/program.h"

namespace alder {

struct GraphLimits {
    size_t nodes = 10000, links = 40000;   ///< of one graph
    size_t depth = 32;                     ///< groups inside groups
    size_t expanded = 100000;              ///< nodes when every group is written out
};

/// How a reason of resolve_image ends where a file is simply not there: the image is magenta then, which is a warning.
inline constexpr std::string_view kNoSuchFile = "there is no such file";

struct MaterialOptions {
    bool lenient = false;          ///< unknown parameters warn instead of failing
    bool strict = false;           ///< files that are missing or broken are errors, not warnings
    std::string pointer_prefix;    ///< prepended to every JSON Pointer ("/graph", "/materials/body")
    GraphLimits limits;
    /// Turns {"file"|"asset": ...} or an alShaders file name into a readable path; empty + message where it may not be read.
    std::function<std::string(const nlohmann::json& image, std::string& error)> resolve_image;
};

/// Which lobes a surface program keeps. Camera and bounce rays: Scatter | Emission; shadow rays: Transparency.
enum class LobeFilter : uint8_t { None = 0, Scatter = 1, Emission = 2, Transparency = 4, Surface = 7, Shadow = 8 };
constexpr LobeFilter operator|(LobeFilter a, LobeFilter b) { return static_cast<LobeFilter>(static_cast<int>(a) | static_cast<int>(b)); }
constexpr bool has(LobeFilter a, LobeFilter b) { return (static_cast<int>(a) & static_cast<int>(b)) != 0; }

struct ProgramRequest {
    LobeFilter surface = LobeFilter::None;   ///< Transparency: Transparent and Holdout lobes; Shadow: as a shadow ray sees it
    bool displacement = false;
    bool volume = false;               ///< the lobes of the volume output, in place of a surface's
    std::vector<std::string> outputs;  ///< "NODE.OUTPUT" or "NODE"; order of Program::outputs
    std::vector<std::string> aovs;     ///< names of the graph's `aovs`, or of AOVs that closure nodes carry ("id_1")
    bool filter_textures = false;      ///< image lookups take the mip level that the pixel's footprint asks for
    bool fade_noise = false;           ///< octaves of noise that are too fine for the footprint fade to their mean
    bool operator==(const ProgramRequest&) const = default;
};

class Material {
  public:
    virtual ~Material() = default;
    /// Compiles (or finds) the program. Names unknown to the graph are faults in `d`; null then.
    virtual std::shared_ptr<const Program> program(const ProgramRequest& request, Diagnostics& d) const = 0;
    /// A material that differs in one constant: pointer as in diagnostics without prefix ("/nodes/NAME/params/PARAM").
    /// Programs whose guards still hold are carried over with new uniform values; the others are compiled again on demand.
    virtual std::shared_ptr<const Material> with_param(const std::string& pointer, const nlohmann::json& value, Diagnostics& d) const = 0;
    virtual const nlohmann::json& document() const = 0;
    virtual bool has_surface() const = 0;
    virtual bool has_displacement() const = 0;
    virtual bool has_volume() const = 0;
    virtual std::vector<std::string> aov_names() const = 0;   ///< the graph's own `aovs`
    virtual size_t node_count() const = 0;
    /// Files of its programs so far that are missing or broken, as they were warned of: for requests that will not have it.
    virtual std::vector<Diagnostic> file_faults() const = 0;
    /// Digest of the document's content (128 bit, hex): the cache key.
    virtual const std::string& digest() const = 0;
};

/// Null where the document has errors (all of them are in `d`).
std::shared_ptr<const Material> build_material(const nlohmann::json& document, const MaterialOptions& options, Diagnostics& d);

/// Process-wide cache of materials by content; least recently used beyond `bytes`. Thread safe.
class MaterialCache {
  public:
    std::shared_ptr<const Material> get(const nlohmann::json& document, const MaterialOptions& options, Diagnostics& d);
    struct Counters { uint64_t hits = 0, misses = 0, entries = 0; };
    Counters counters() const;
    MaterialCache(size_t max_entries = 256);
    ~MaterialCache();
  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace alder
