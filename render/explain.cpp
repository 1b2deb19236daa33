// Explain: what each node of a material makes of one pixel.
#include "render/explain.h"

#include <cmath>

#include "graph/report.h"
#include "render/prepared_scene.h"
#include "render/scene_query.h"

namespace alder {
namespace {

using nlohmann::json;

json number(float v) {
    if (std::isnan(v)) return "nan";
    if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
    return v;
}
json numbers(Vec3f v) { return {number(v.x), number(v.y), number(v.z)}; }

/// Runs programs at one point.
class OnePoint {
  public:
    OnePoint(const PreparedScene& scene, const CameraModel& camera, const ShadingPoint& point, const RayHistory& history)
        : scene_(scene), query_(*scene.surfaces), inputs_{scene.surfaces.get(), &camera, scene.material_pass_index}, point_(point), history_(&history),
          executor_(scene.workers->context()) {}

    void run(const Program& program, const InputPlan& plan) {
        const SceneQueryScope scope(&query_);
        executor_.run(program, 1, gather_.gather(plan, inputs_, {&point_, 1}, &history_));
    }
    float value(int reg) const { return executor_.channel(reg).p[0]; }
    json value(const ProgramOutput& o) const {
        if (channels(o.type) == 1) return number(value(o.register_first));
        json list = json::array();
        for (int c = 0; c < channels(o.type); ++c) list.push_back(number(value(o.register_first + c)));
        return list;
    }
    const PreparedScene& scene() const { return scene_; }

  private:
    const PreparedScene& scene_;
    SurfaceQuery query_;
    InputScene inputs_;
    ShadingPoint point_;
    const RayHistory* history_;
    Executor<float> executor_;
    InputGather gather_;
};

/// Values of all outputs that are numbers, by "NODE.OUTPUT". Those that cannot be asked for (within groups) are left out.
std::map<std::string, json> output_values(OnePoint& at, const Material& material, const json& nodes) {
    std::vector<std::string> names;
    for (const auto& [name, node] : nodes.items()) {
        const NodeType* const type = node.is_object() && node.contains("type") && node["type"].is_string() ? find_node(node["type"].get<std::string>()) : nullptr;
        if (!type) continue;
        for (const Output& o : type->outputs)
            if (o.type != Type::Closure) names.push_back(name + "." + o.name);
    }
    std::map<std::string, json> values;
    const auto take = [&](const std::vector<std::string>& wanted) {
        Diagnostics d;
        const auto program = wanted.empty() ? nullptr : material.program({.outputs = wanted}, d);
        if (!program) return false;
        at.run(*program, InputPlan(*program, *at.scene().surfaces));
        for (size_t i = 0; i < program->outputs().size() && i < wanted.size(); ++i) values[wanted[i]] = at.value(program->outputs()[i]);
        return true;
    };
    if (!take(names))
        for (const std::string& name : names) take({name});
    return values;
}

/// A link with the value that came through it; anything else as it stands in the document.
json input_value(const json& value, const json& nodes, const std::map<std::string, json>& outputs) {
    if (!value.is_object() || !value.contains("node") || !value["node"].is_string()) return value;
    const std::string node = value["node"];
    std::string output = value.contains("output") && value["output"].is_string() ? value["output"].get<std::string>() : "";
    if (output.empty() && nodes.contains(node) && nodes[node].contains("type"))
        if (const NodeType* type = find_node(nodes[node]["type"].get<std::string>()); type && !type->outputs.empty()) output = type->outputs[0].name;
    json row = {{"from", node + "." + output}};
    if (const auto it = outputs.find(node + "." + output); it != outputs.end()) row["value"] = it->second;
    if (value.contains("component")) row["component"] = value["component"];
    return row;
}

json closures_of(OnePoint& at, const SceneProgram& surface) {
    json list = json::array();
    at.run(*surface.program, surface.plan);
    for (const ProgramLobe& lobe : surface.program->lobes()) {
        const Vec3f weight(at.value(lobe.register_first), at.value(lobe.register_first + 1), at.value(lobe.register_first + 2));
        if (weight.x == 0 && weight.y == 0 && weight.z == 0) continue;
        list.push_back({{"node", lobe.node}, {"closure", closure_name(lobe.spec)}, {"weight", numbers(weight)}});
    }
    return list;
}

}  // namespace

json explain_pixel(const PreparedScene& scene, int width, int height, int x, int y) {
    const CameraModel camera(scene.scene->camera, width, height);
    const CameraRay seen = camera.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 0.5f, 0.5f, 0.5f);
    RayHistory history;
    history.origin = seen.origin;
    history.direction = seen.direction;
    Hit hit;
    const Surfaces& surfaces = *scene.surfaces;
    if (seen.length < 0 || !surfaces.accel().intersect({seen.origin, seen.direction, 0, seen.length, history.time}, kVisibleCamera, hit)) return {{"hit", false}};
    ShadingPoint point = surfaces.point(hit.instance, hit.triangle, hit.u, hit.v, seen.direction, hit.t, history.time);
    point.footprint = seen.footprint + seen.spread * hit.t;
    const MaterialPrograms& programs = *scene.materials[surfaces.material(hit.instance, hit.triangle)];
    json answer = {{"hit", true},
                   {"object", surfaces.instances()[hit.instance].name},
                   {"material", programs.material.name},
                   {"primitive", hit.triangle},
                   {"P", numbers(point.p)},
                   {"N", numbers(point.n)},
                   {"distance", number(point.distance)},
                   {"backfacing", point.backfacing},
                   {"nodes", json::object()},
                   {"closures", json::array()},
                   {"skipped", json::array()}};
    if (!programs.material.graph) return answer;
    const json& document = programs.material.graph->document();
    const json nodes = document.is_object() ? document.value("nodes", json::object()) : json::object();
    OnePoint at(scene, camera, point, history);
    const auto values = output_values(at, *programs.material.graph, nodes);
    for (const auto& [name, node] : nodes.items()) {
        json row = {{"type", node.value("type", "")}, {"inputs", json::object()}, {"outputs", json::object()}};
        if (node.contains("params") && node["params"].is_object())
            for (const auto& [param, value] : node["params"].items()) row["inputs"][param] = input_value(value, nodes, values);
        for (auto it = values.lower_bound(name + "."); it != values.end() && it->first.rfind(name + ".", 0) == 0; ++it) row["outputs"][it->first.substr(name.size() + 1)] = it->second;
        answer["nodes"][name] = std::move(row);
    }
    if (programs.surface) {
        answer["closures"] = closures_of(at, *programs.surface);
        answer["skipped"] = programs.surface->program->stats().skipped;
    }
    return answer;
}

}  // namespace alder
