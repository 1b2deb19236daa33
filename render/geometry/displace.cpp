// True displacement: programs run at the vertices as they stand; normals follow from the moved triangles.
#include "render/geometry/displace.h"

#include <algorithm>
#include <map>

#include "render/geometry/mesh_build.h"
#include "render/inputs.h"
#include "render/sampling.h"

namespace alder {
namespace {

/// Cycles' normals after displacement: those of the triangles around a vertex count alike, whatever their size.
std::vector<Vec3f> even_normals(std::span<const Vec3f> positions, std::span<const std::array<uint32_t, 3>> triangles) {
    std::vector<Vec3f> sum(positions.size(), Vec3f(0.f));
    for (const auto& t : triangles) {
        const Vec3f n = safe_normalize(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
        if (!is_finite(n)) continue;
        for (const uint32_t v : t) sum[v] += n;
    }
    for (Vec3f& n : sum) {
        n = safe_normalize(n);
        if (is_black(n) || !is_finite(n)) n = Vec3f(0, 0, 1);
    }
    return sum;
}

class Displacer {
  public:
    Displacer(const Scene& scene, const EvalContext& context, Diagnostics& d)
        : scene_(scene), context_(context), d_(d), surfaces_(scene.meshes, scene.instances),
          camera_(scene.camera, scene.settings.width, scene.settings.height) {
        for (const SceneMaterial& m : scene.materials) pass_index_.push_back(m.pass_index);
    }

    std::shared_ptr<const Mesh> displaced(uint32_t instance) {
        const Mesh& mesh = surfaces_.mesh_of(instance);
        const std::vector<Vec3f> offsets = offsets_of(instance, mesh);
        auto out = std::make_shared<Mesh>(mesh);
        const bool flat = !mesh.smooth.empty() && std::none_of(mesh.smooth.begin(), mesh.smooth.end(), [](uint8_t s) { return s != 0; });
        for (size_t i = 0; i < offsets.size(); ++i) out->positions[i] += offsets[i];
        out->corner_normals.clear();
        out->tangents.clear();
        out->tangent_signs.clear();
        out->vertex_normals = flat ? std::vector<Vec3f>{} : even_normals(out->positions, mesh.triangles);
        out->motion_normals.clear();
        for (int step = 0; step < mesh.motion_steps; ++step) {
            const auto positions = std::span(out->motion_positions).subspan(static_cast<size_t>(step) * offsets.size(), offsets.size());
            for (size_t i = 0; i < offsets.size(); ++i) positions[i] += offsets[i];
            if (flat) continue;
            const std::vector<Vec3f> normals = even_normals(positions, mesh.triangles);
            out->motion_normals.insert(out->motion_normals.end(), normals.begin(), normals.end());
        }
        return out;
    }

  private:
    struct DisplacementProgram {
        std::shared_ptr<const Program> program;
        std::unique_ptr<InputPlan> plan;
    };
    /// Null where the material leaves vertices where they are.
    const DisplacementProgram* program_of(uint32_t material) {
        const auto [i, is_new] = programs_.try_emplace(material);
        if (is_new && displaces(scene_.materials[material])) {
            ProgramRequest request;
            request.displacement = true;
            Diagnostics own;
            i->second.program = scene_.materials[material].graph->program(request, own);
            for (Diagnostic& e : own.errors) e.pointer = "/materials/" + scene_.materials[material].name + e.pointer, d_.errors.push_back(std::move(e));
            if (i->second.program) i->second.plan = std::make_unique<InputPlan>(*i->second.program, surfaces_);
        }
        return i->second.program ? &i->second : nullptr;
    }

    /// By vertex, in object space. A vertex of several triangles is moved by the first.
    std::vector<Vec3f> offsets_of(uint32_t instance, const Mesh& mesh) {
        std::vector<Vec3f> offsets(mesh.positions.size(), Vec3f(0.f));
        std::vector<bool> done(mesh.positions.size(), false);
        std::map<uint32_t, std::vector<std::pair<uint32_t, ShadingPoint>>> by_material;
        const Vec3f corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = mesh.triangles[t][k];
                if (done[v]) continue;
                done[v] = true;
                const uint32_t material = surfaces_.material(instance, t);
                if (!program_of(material)) continue;
                // Looked at from outside: the side of the normal decides nothing else.
                const auto p = surfaces_.world_triangle(instance, t);
                by_material[material].emplace_back(v, surfaces_.point(instance, t, corners[k].x, corners[k].y, -safe_normalize(cross(p[1] - p[0], p[2] - p[0])), 0));
            }
        Executor<float> executor(context_);
        for (const auto& [material, points] : by_material) run(*program_of(material), instance, points, executor, offsets);
        return offsets;
    }

    void run(const DisplacementProgram& d, uint32_t instance, const std::vector<std::pair<uint32_t, ShadingPoint>>& vertices, Executor<float>& executor,
             std::vector<Vec3f>& offsets) {
        const Transform to_object = surfaces_.frame(instance).world_to_object;
        const InputScene inputs{&surfaces_, &camera_, pass_index_};
        const RayHistory history{.kinds = 0};
        const size_t batch = d.program->batch();
        InputGather gather;
        const ProgramOutput& output = d.program->outputs().back();
        for (size_t first = 0; first < vertices.size(); first += batch) {
            const size_t n = std::min(batch, vertices.size() - first);
            std::vector<ShadingPoint> points;
            for (size_t i = 0; i < n; ++i) points.push_back(vertices[first + i].second);
            const std::vector<const RayHistory*> histories(n, &history);
            executor.run(*d.program, static_cast<uint32_t>(n), gather.gather(*d.plan, inputs, points, histories.data()));
            for (size_t i = 0; i < n; ++i) {
                Vec3f offset;
                for (int c = 0; c < 3; ++c) {
                    const Channel<float> channel = executor.channel(output.register_first + c);
                    offset[c] = channel.p[i * channel.stride];
                }
                offset = to_object.vector(offset);
                if (is_finite(offset)) offsets[vertices[first + i].first] = offset;
            }
        }
    }

    const Scene& scene_;
    const EvalContext& context_;
    Diagnostics& d_;
    Surfaces surfaces_;
    CameraModel camera_;
    std::vector<int> pass_index_;
    std::map<uint32_t, DisplacementProgram> programs_;
};

}  // namespace

bool displaces(const SceneMaterial& m) { return m.displacement != Displacement::Bump && m.graph && m.graph->has_displacement(); }

void displace(const Scene& scene, const EvalContext& context, std::vector<std::shared_ptr<const Mesh>>& meshes, std::vector<Instance>& instances, Diagnostics& d) {
    std::unique_ptr<Displacer> displacer;
    std::map<std::pair<uint32_t, std::vector<uint32_t>>, uint32_t> moved;
    for (uint32_t i = 0; i < instances.size(); ++i) {
        Instance& instance = instances[i];
        if (meshes[instance.mesh]->shape != Shape::Triangles) continue;
        if (std::none_of(instance.materials.begin(), instance.materials.end(), [&](uint32_t m) { return displaces(scene.materials[m]); })) continue;
        const auto [at, is_new] = moved.try_emplace({instance.mesh, instance.materials}, static_cast<uint32_t>(meshes.size()));
        if (is_new) {
            if (!displacer) displacer = std::make_unique<Displacer>(scene, context, d);
            meshes.push_back(displacer->displaced(i));
        }
        instance.mesh = at->second;
    }
}

}  // namespace alder
