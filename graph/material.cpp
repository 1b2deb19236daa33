#include "graph/material.h"

#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <map>
#include <unordered_map>

#include "graph/code.h"
#include "graph/digest.h"
#include "graph/json_text.h"
#include "nodes/resource_faults.h"

namespace alder {
namespace {

double seconds_since(std::chrono::steady_clock::time_point t) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count(); }

/// Building recurses along the graph. Long graphs get a stack of their own (address space only until touched).
constexpr size_t kInlineNodes = 48;
constexpr size_t kStackBytes = size_t{512} << 20;
void on_large_stack(const std::function<void()>& work) {
    struct Job {
        const std::function<void()>* work;
        std::exception_ptr error;
    } job{&work, nullptr};
    pthread_attr_t attr;
    pthread_attr_init(&attr);
    pthread_attr_setstacksize(&attr, kStackBytes);
    pthread_t thread;
    const auto entry = [](void* p) -> void* {
        auto* j = static_cast<Job*>(p);
        try {
            (*j->work)();
        } catch (...) {
            j->error = std::current_exception();
        }
        return nullptr;
    };
    if (pthread_create(&thread, &attr, entry, &job) != 0) {
        pthread_attr_destroy(&attr);
        throw std::bad_alloc();
    }
    pthread_attr_destroy(&attr);
    pthread_join(thread, nullptr);
    if (job.error) std::rethrow_exception(job.error);
}

class MaterialImpl final : public Material, public std::enable_shared_from_this<MaterialImpl> {
  public:
    MaterialImpl(std::shared_ptr<const Document> document, std::shared_ptr<const nlohmann::json> json, MaterialOptions options)
        : document_(std::move(document)), base_json_(std::move(json)), options_(std::move(options)) {}

    std::shared_ptr<const Program> program(const ProgramRequest& request, Diagnostics& d) const override {
        {
            std::lock_guard lock(mutex_);
            for (const auto& [r, p] : programs_)
                if (r == request) return p;
        }
        auto p = compile(request, d);
        if (!p) return nullptr;
        std::lock_guard lock(mutex_);
        for (const auto& [r, other] : programs_)
            if (r == request) return other;
        programs_.emplace_back(request, p);
        return p;
    }

    std::shared_ptr<const Material> with_param(const std::string& pointer, const nlohmann::json& value, Diagnostics& d) const override {
        // "/nodes/NAME/params/PARAM"
        std::vector<std::string> parts;
        for (size_t i = 0; i < pointer.size();) {
            const size_t next = std::min(pointer.find('/', i + 1), pointer.size());
            std::string raw = pointer.substr(i + 1, next - i - 1), token;
            for (size_t k = 0; k < raw.size(); ++k) {
                if (raw[k] == '~' && k + 1 < raw.size()) token += raw[++k] == '1' ? '/' : '~';
                else token += raw[k];
            }
            parts.push_back(token);
            i = next;
        }
        if (document_->upgraded && parts.size() == 4 && parts[0] == "nodes" && parts[2] == "params") {
            nlohmann::json j = document();  // the user's names mean what they mean in the document as written
            if (j["nodes"].contains(parts[1])) {
                j["nodes"][parts[1]]["params"][parts[3]] = value;
                return build_material(j, options_, d);
            }
        }
        if (parts.size() > 4 && parts[parts.size() - 2] == "params") return with_inner_param(parts, value, d);
        const int node = parts.size() == 4 && parts[0] == "nodes" && parts[2] == "params" ? document_->node_index(parts[1]) : -1;
        const int param = node < 0 ? -1 : document_->nodes[node]->type->param_index(parts[3]);
        if (param < 0) {
            std::vector<std::string> names;
            const std::string found = parts.size() == 4 ? parts[node < 0 ? 1 : 3] : pointer;
            if (node < 0)
                for (const auto& n : document_->nodes) names.push_back(n->name);
            else
                for (const auto& p : document_->nodes[node]->type->params) names.push_back(p.name);
            d.errors.push_back({options_.pointer_prefix + pointer, node < 0 ? "unknown-name" : "unknown-parameter", found,
                                node < 0 ? "/nodes/NAME/params/PARAM of this graph" : "a parameter of " + document_->nodes[node]->type->name,
                                nearest_name(found, names)});
            return nullptr;
        }
        const Param& p = document_->nodes[node]->type->params[param];
        const bool structural = value.is_object() || is_static(p.type) || !p.takes_links || p.type == Type::Bool || p.type == Type::Closure ||
                                document_->nodes[node]->params[param].kind == DocValue::Link ||
                                document_->nodes[node]->params[param].kind == DocValue::Attribute ||
                                (p.has_default_global && document_->nodes[node]->params[param].kind == DocValue::Default);
        if (structural) {
            nlohmann::json j = document();
            j["nodes"][parts[1]]["params"][parts[3]] = value;
            return build_material(j, options_, d);
        }
        DocValue v;
        if (!read_constant(p, value, options_.pointer_prefix + pointer, options_, v, d)) return nullptr;
        auto document = std::make_shared<Document>(*document_);
        auto changed = std::make_shared<DocNode>(*document->nodes[node]);
        changed->params[param] = v;
        check_node(*changed, options_.pointer_prefix + "/nodes/" + pointer_token(parts[1]), d);
        if (!d.ok()) return nullptr;
        document->nodes[node] = changed;
        document->digest.clear();
        auto m = std::make_shared<MaterialImpl>(document, base_json_, options_);
        m->edits_ = edits_;
        m->inherit_files(*this);
        m->edits_.emplace_back(nlohmann::json::json_pointer("/nodes/" + pointer_token(parts[1]) + "/params/" + pointer_token(parts[3])), value);
        if (m->edits_.size() > 256) {  // keep the chain short: write the edits into a document of its own
            m->base_json_ = std::make_shared<nlohmann::json>(m->document());
            m->edits_.clear();
        }
        carry_over(*m, node, param);
        return m;
    }

    const nlohmann::json& document() const override {
        std::lock_guard lock(mutex_);
        return document_json();
    }
    bool has_surface() const override { return document_->outputs.surface.node >= 0; }
    bool has_displacement() const override { return document_->outputs.displacement.node >= 0; }
    bool has_volume() const override { return document_->outputs.volume.node >= 0; }
    std::vector<std::string> aov_names() const override {
        std::vector<std::string> names;
        for (const auto& [name, link] : document_->outputs.aovs) names.push_back(name);
        return names;
    }
    size_t node_count() const override { return document_->nodes.size(); }
    std::vector<Diagnostic> file_faults() const override {
        std::lock_guard lock(mutex_);
        std::vector<Diagnostic> faults;
        for (const auto& [pointer, fault] : unreadable_) faults.push_back(fault);
        for (const auto& [pointer, prepared] : resources_)
            for (const auto& f : dynamic_cast<const ResourceFaults&>(*prepared).late_faults())
                faults.push_back({pointer + "/params/" + f.parameter, "asset-unreadable", f.file + ": " + f.reason, "a file that can be read; it is rendered magenta", ""});
        return faults;
    }
    void inherit_files(const MaterialImpl& from) {
        std::lock_guard lock(from.mutex_);
        unreadable_ = from.unreadable_;
        resources_ = from.resources_;
    }
    void add_file_faults(const std::vector<Diagnostic>& warnings) {
        for (const Diagnostic& w : warnings)
            if (w.code == "asset-missing" || w.code == "asset-unreadable") unreadable_.try_emplace(w.pointer, w);
    }
    const std::string& digest() const override {
        std::lock_guard lock(mutex_);
        if (digest_.empty()) digest_ = document_->digest.empty() ? content_digest(document_json()) : document_->digest;
        return digest_;
    }

  private:
    /// A parameter of a node inside a group ("/groups/NAME/nodes/...", "/nodes/NAME/graph/nodes/..."): compiled again as a whole.
    std::shared_ptr<const Material> with_inner_param(const std::vector<std::string>& parts, const nlohmann::json& value, Diagnostics& d) const {
        nlohmann::json j = document();
        nlohmann::json* at = &j;
        for (size_t i = 0; i + 2 < parts.size(); ++i) {
            if (at->is_object() && at->contains(parts[i])) {
                at = &(*at)[parts[i]];
                continue;
            }
            std::vector<std::string> names;
            if (at->is_object())
                for (const auto& [name, inner] : at->items()) names.push_back(name);
            std::string pointer = options_.pointer_prefix;
            for (size_t k = 0; k <= i; ++k) pointer += "/" + pointer_token(parts[k]);
            d.errors.push_back({pointer, "unknown-name", parts[i], "a node of this graph", nearest_name(parts[i], names)});
            return nullptr;
        }
        if (at->is_object()) (*at)["params"][parts.back()] = value;
        return build_material(j, options_, d);
    }

    const nlohmann::json& document_json() const {
        if (edits_.empty()) return *base_json_;
        if (!edited_json_) {
            edited_json_ = std::make_unique<nlohmann::json>(*base_json_);
            for (const auto& [where, value] : edits_) (*edited_json_)[where] = value;
        }
        return *edited_json_;
    }

    std::shared_ptr<const ProgramImpl> compile(const ProgramRequest& request, Diagnostics& d) const {
        const auto start = std::chrono::steady_clock::now();
        Built built;
        const size_t errors = d.errors.size();
        const auto work = [&] { Builder(*document_, built, d, options_).build(request); };
        if (document_->expanded > kInlineNodes) on_large_stack(work);
        else work();
        say_once(d);
        {
            std::lock_guard lock(mutex_);
            for (auto& [pointer, prepared] : built.resources) resources_.try_emplace(pointer, prepared);
        }
        if (d.errors.size() > errors) return nullptr;
        IrValues values = built.ir.values;
        auto code = std::const_pointer_cast<Code>(generate_code(std::move(built)));
        code->stats.compile_seconds = seconds_since(start);
        return std::make_shared<ProgramImpl>(code, std::move(values));
    }

    /// Every program opens the same files: what could not be read is said once.
    void say_once(Diagnostics& d) const {
        std::lock_guard lock(mutex_);
        std::erase_if(d.warnings, [&](const Diagnostic& w) { return w.code == "asset-unreadable" && !unreadable_.try_emplace(w.pointer, w).second; });
    }

    /// Programs of this material that hold for `to` as well, which differs in one constant.
    void carry_over(const MaterialImpl& to, int node, int param) const {
        const Statics before = make_statics(*document_->nodes[node]), after = make_statics(*to.document_->nodes[node]);
        const bool facts_changed = before.zero != after.zero || before.one != after.one || before.at_default != after.at_default;
        std::lock_guard lock(mutex_);
        std::lock_guard lock_to(to.mutex_);
        for (const auto& [r, p] : programs_) {
            if (facts_changed && p->code().asked.count({node, param})) continue;  // lobes() or uses() may answer differently
            if (auto q = p->with_constant(node, param, to.document_->nodes[node]->params[param].number)) to.programs_.emplace_back(r, q);
        }
    }

    std::shared_ptr<const Document> document_;
    std::shared_ptr<const nlohmann::json> base_json_;
    std::vector<std::pair<nlohmann::json::json_pointer, nlohmann::json>> edits_;
    MaterialOptions options_;
    mutable std::mutex mutex_;
    mutable std::vector<std::pair<ProgramRequest, std::shared_ptr<const ProgramImpl>>> programs_;
    mutable std::unique_ptr<nlohmann::json> edited_json_;
    mutable std::map<std::string, Diagnostic> unreadable_;
    mutable std::map<std::string, std::shared_ptr<const Prepared>> resources_;   ///< with files behind them, by the node's pointer
    mutable std::string digest_;
};

}  // namespace

std::shared_ptr<const Material> build_material(const nlohmann::json& json, const MaterialOptions& options, Diagnostics& d) {
    const size_t before = d.warnings.size();
    auto document = read_document(json, options, d);
    if (!document) return nullptr;
    auto m = std::make_shared<MaterialImpl>(document, std::make_shared<nlohmann::json>(json), options);
    m->add_file_faults({d.warnings.begin() + static_cast<std::ptrdiff_t>(before), d.warnings.end()});
    // Compile what a render needs at once: faults in ramps and images show here, before the first ray.
    ProgramRequest request;
    request.surface = LobeFilter::Surface;
    request.aovs = m->aov_names();
    if (m->has_surface() || !request.aovs.empty())
        if (!m->program(request, d)) return nullptr;
    if (m->has_volume() && !m->program({.volume = true}, d)) return nullptr;
    return m;
}

struct MaterialCache::Impl {
    struct Entry {
        std::string key;
        std::shared_ptr<const Material> material;
    };
    mutable std::mutex mutex;
    std::list<Entry> entries;
    std::unordered_map<std::string, std::list<Entry>::iterator> by_key;
    size_t max_entries;
    Counters counters;
};

MaterialCache::MaterialCache(size_t max_entries) : impl_(std::make_unique<Impl>()) { impl_->max_entries = max_entries; }
MaterialCache::~MaterialCache() = default;

std::shared_ptr<const Material> MaterialCache::get(const nlohmann::json& document, const MaterialOptions& options, Diagnostics& d) {
    std::string key = content_digest(document);
    key += options.lenient ? "L" : "S";
    if (options.strict) key += "!";
    {
        std::lock_guard lock(impl_->mutex);
        if (const auto it = impl_->by_key.find(key); it != impl_->by_key.end()) {
            impl_->entries.splice(impl_->entries.begin(), impl_->entries, it->second);
            ++impl_->counters.hits;
            return it->second->material;
        }
        ++impl_->counters.misses;
    }
    auto m = build_material(document, options, d);
    // Warnings must be given again each time: only clean materials are kept.
    if (!m || !d.warnings.empty()) return m;
    std::lock_guard lock(impl_->mutex);
    if (impl_->by_key.count(key)) return m;
    impl_->entries.push_front({key, m});
    impl_->by_key[key] = impl_->entries.begin();
    while (impl_->entries.size() > impl_->max_entries) {
        impl_->by_key.erase(impl_->entries.back().key);
        impl_->entries.pop_back();
    }
    return m;
}

MaterialCache::Counters MaterialCache::counters() const {
    std::lock_guard lock(impl_->mutex);
    Counters c = impl_->counters;
    c.entries = impl_->entries.size();
    return c;
}

}  // namespace alder
