// Schemas of documents and answers, for /v1/openapi.json. tests/server/openapi_test.py holds real answers against them.
#include "nodes/schema.h"
#include "server/errors.h"
#include "server/openapi.h"

namespace alder {
namespace {

using nlohmann::json;

constexpr const char* kSchemas = R"json({
"Diagnostic": {"type": "object", "required": ["pointer", "code"], "properties": {
    "pointer": {"type": "string", "description": "JSON Pointer (RFC 6901) into the request"}, "code": {"type": "string"}, "found": {"type": "string"},
    "expected": {"type": "string"}, "suggest": {"type": "string"}, "path": {"type": "array", "items": {"type": "string"}}}},
"Digest": {"type": "string", "pattern": "^sha256:[0-9a-f]{64}$"},
"Number": {"description": "JSON has no numbers that are not finite: they are strings", "anyOf": [{"type": "number"}, {"enum": ["nan", "inf", "-inf"]}]},
"Numbers": {"anyOf": [{"$ref": "#/components/schemas/Number"}, {"type": "array", "items": {"$ref": "#/components/schemas/Number"}}]},
"Version": {"type": "object", "required": ["name", "version", "build", "api", "isa", "nodes"], "properties": {
    "name": {"const": "alderd"}, "version": {"type": "string"}, "build": {"type": "string"}, "api": {"const": "v1"}, "isa": {"type": "string"}, "nodes": {"type": "integer"}}},
"Ready": {"type": "object", "required": ["ready", "checks"], "properties": {
    "ready": {"type": "boolean"}, "checks": {"type": "object", "additionalProperties": {"type": "boolean"}}}},
"Param": {"type": "object", "required": ["name", "type", "links"], "properties": {
    "name": {"type": "string"}, "type": {"type": "string"}, "links": {"type": "boolean"}, "min": {"type": "number"}, "max": {"type": "number"},
    "soft_min": {"type": "number"}, "soft_max": {"type": "number"}, "label": {"type": "string"}, "group": {"type": "string"}, "help": {"type": "string"},
    "enum": {"type": "array", "items": {"type": "object", "required": ["name", "label"]}}, "aliases": {"type": "array", "items": {"type": "string"}}}},
"Node": {"type": "object", "required": ["name", "system", "category", "summary", "closure"], "properties": {
    "name": {"type": "string"}, "system": {"enum": ["cycles", "alshaders"]}, "category": {"type": "string"}, "summary": {"type": "string"}, "closure": {"type": "boolean"},
    "help": {"type": "string"}, "aliases": {"type": "array", "items": {"type": "string"}}, "params": {"type": "array", "items": {"$ref": "#/components/schemas/Param"}},
    "outputs": {"type": "array", "items": {"type": "object", "required": ["name", "type"]}}}},
"NodeList": {"type": "object", "required": ["items", "next"], "properties": {
    "items": {"type": "array", "items": {"$ref": "#/components/schemas/Node"}}, "next": {"type": ["string", "null"]}}},
"EvaluateRequest": {"type": "object", "required": ["graph"], "properties": {
    "graph": {"$ref": "#/components/schemas/Graph"},
    "points": {"description": "count, and fields by name: one value for all points or a list of count", "type": "object",
        "properties": {"count": {"type": "integer", "minimum": 1}}},
    "outputs": {"type": "array", "items": {"type": "string"}, "description": "NODE.OUTPUT, or NODE where it has one"},
    "closure": {"description": "output, wo, and wi or sample or both", "type": ["object", "null"]},
    "precision": {"type": "string", "enum": ["float", "double"]}, "stats": {"type": "boolean"}, "lenient": {"type": "boolean"}, "strict": {"type": "boolean"}}},
"Evaluation": {"type": "object", "required": ["outputs"], "properties": {
    "outputs": {"type": "object", "additionalProperties": {"type": "array"}}, "closure": {"type": "object"}, "stats": {"type": "object"},
    "warnings": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}}}},
"GraphReport": {"type": "object", "required": ["ok", "errors", "warnings"], "properties": {
    "ok": {"type": "boolean"}, "errors": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}},
    "warnings": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}}, "compiled": {"type": ["object", "null"]}}},
"RenderStats": {"type": "object", "required": ["samples", "complete", "rays"], "properties": {
    "samples": {"type": "integer"}, "complete": {"type": "boolean"}, "estimated_error": {"type": ["number", "null"]},
    "rays": {"type": "object", "additionalProperties": {"type": "integer"}}, "skipped": {"type": "array", "items": {"type": "string"}}}},
"PreviewReport": {"type": "object", "required": ["width", "height", "layers", "stats", "timings", "warnings"], "properties": {
    "width": {"type": "integer"}, "height": {"type": "integer"}, "layers": {"type": "array", "items": {"type": "string"}},
    "stats": {"$ref": "#/components/schemas/RenderStats"}, "timings": {"type": "object", "additionalProperties": {"type": "number"}},
    "warnings": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}}}},
"Asset": {"type": "object", "required": ["digest", "size"], "properties": {"digest": {"$ref": "#/components/schemas/Digest"}, "size": {"type": "integer"}}},
"Missing": {"type": "object", "required": ["missing"], "properties": {"missing": {"type": "array", "items": {"$ref": "#/components/schemas/Digest"}}}},
"Upload": {"type": "object", "required": ["id", "digest", "size", "offset", "complete"], "properties": {
    "id": {"type": "string", "pattern": "^upl_[0-9a-z]{26}$"}, "digest": {"$ref": "#/components/schemas/Digest"}, "size": {"type": "integer"},
    "offset": {"type": "integer"}, "complete": {"type": "boolean"}}},
"SceneDocument": {"description": "docs/scene-document.md; binary members are asset digests", "type": "object", "required": ["alder_scene"], "properties": {
    "alder_scene": {"type": "integer", "minimum": 1, "maximum": 1}}},
"Scene": {"type": "object", "required": ["id", "revision", "etag", "materials", "cameras", "resolution", "samples", "statistics", "assets", "warnings"], "properties": {
    "id": {"type": "string", "pattern": "^scn_[0-9a-z]{26}$"}, "revision": {"type": "integer"}, "etag": {"type": "string"},
    "materials": {"type": "array", "items": {"type": "string"}}, "cameras": {"type": "array", "items": {"type": "string"}},
    "resolution": {"type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 2}, "samples": {"type": "integer"},
    "statistics": {"type": "object", "additionalProperties": {"type": "integer"}}, "assets": {"type": "array", "items": {"$ref": "#/components/schemas/Digest"}},
    "warnings": {"type": "array", "items": {"type": "string"}}, "container": {"$ref": "#/components/schemas/Digest"}, "document": {"type": "object"}}},
"Reused": {"description": "what of the scene before the edit is in use still", "type": "object", "properties": {
    "geometry": {"type": "boolean"}, "meshes": {"type": "integer"}, "meshes_built": {"type": "integer"}, "lights": {"type": "boolean"}, "world": {"type": "boolean"},
    "materials": {"type": "integer"}, "materials_compiled": {"type": "integer"}}},
"Edit": {"type": "object", "required": ["changed", "rebuild", "warnings"], "properties": {
    "changed": {"type": "array", "items": {"type": "string"}}, "rebuild": {"enum": ["none", "shading", "lights", "instances", "geometry"]},
    "reused": {"$ref": "#/components/schemas/Reused"}, "remixed": {"type": "boolean"},
    "scene": {"type": "object", "required": ["revision", "etag"]}, "render": {"$ref": "#/components/schemas/Live"},
    "warnings": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}}}},
"Output": {"type": "object", "required": ["file", "frame", "bytes", "digest", "layers", "complete"], "properties": {
    "file": {"type": "string"}, "frame": {"type": "integer"}, "bytes": {"type": "integer"}, "digest": {"$ref": "#/components/schemas/Digest"},
    "layers": {"type": "array", "items": {"type": "string"}}, "complete": {"type": "boolean"}}},
"Job": {"type": "object", "required": ["id", "state", "reason", "etag", "attempt", "priority", "scene", "progress", "timings", "created", "started", "ended", "outputs", "links"], "properties": {
    "id": {"type": "string", "pattern": "^rnd_[0-9a-z]{26}$"}, "state": {"enum": ["queued", "preparing", "rendering", "writing", "paused", "succeeded", "failed", "cancelled"]},
    "reason": {"type": ["string", "null"]}, "etag": {"type": "string"}, "attempt": {"type": "integer"}, "priority": {"type": "integer"},
    "scene": {"type": "object", "required": ["id", "revision"]},
    "progress": {"type": "object", "properties": {"fraction": {"type": "number"}, "samples": {"type": "integer"}, "estimated_error": {"type": ["number", "null"]}, "eta": {"type": ["number", "null"]}}},
    "timings": {"type": "object", "additionalProperties": {"type": "number"}},
    "created": {"type": "string", "format": "date-time"}, "started": {"type": ["string", "null"]}, "ended": {"type": ["string", "null"]}, "retain": {"type": "number"},
    "expired": {"type": "boolean"}, "warnings": {"type": "array", "items": {"type": "string"}}, "labels": {"type": "object", "additionalProperties": {"type": "string"}},
    "outputs": {"type": "array", "items": {"$ref": "#/components/schemas/Output"}}, "links": {"type": "object", "additionalProperties": {"type": "string"}},
    "problem": {"type": "object"}, "stats": {"type": ["object", "null"]}}},
"Live": {"type": "object", "required": ["id", "mode", "state", "reason", "etag", "revision", "resolution", "aovs", "layers", "light_groups", "progress", "links"], "properties": {
    "id": {"type": "string", "pattern": "^rnd_[0-9a-z]{26}$"}, "mode": {"const": "live"}, "state": {"enum": ["rendering", "paused", "failed", "cancelled"]},
    "reason": {"type": ["string", "null"]}, "etag": {"type": "string"}, "revision": {"type": "string"}, "resolution": {"type": "array", "items": {"type": "integer"}},
    "aovs": {"type": "array", "items": {"type": "string"}}, "layers": {"type": "array", "items": {"type": "string"}},
    "light_groups": {"type": "object", "additionalProperties": {"type": "object", "required": ["lights", "weight"]}}, "progress": {"type": "object"},
    "readers": {"type": "integer"}, "links": {"type": "object", "additionalProperties": {"type": "string"}}, "scene": {"type": "object"}, "stage": {"type": "string"},
    "warnings": {"type": "array", "items": {"$ref": "#/components/schemas/Diagnostic"}}}},
"Render": {"anyOf": [{"$ref": "#/components/schemas/Job"}, {"$ref": "#/components/schemas/Live"}]},
"RenderList": {"type": "object", "required": ["items", "next"], "properties": {
    "items": {"type": "array", "items": {"$ref": "#/components/schemas/Job"}}, "next": {"type": ["string", "null"]}}},
"OutputList": {"type": "object", "required": ["items", "next"], "properties": {
    "items": {"type": "array", "items": {"$ref": "#/components/schemas/Output"}}, "next": {"type": ["string", "null"]}}},
"Stats": {"anyOf": [{"$ref": "#/components/schemas/RenderStats"}, {"type": "object", "required": ["id", "state", "attempt", "timings", "stats"]}]},
"ExplainedNode": {"type": "object", "required": ["type", "inputs", "outputs"], "properties": {
    "type": {"type": "string"}, "inputs": {"type": "object"}, "outputs": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/Numbers"}}}},
"Pixel": {"type": "object", "required": ["x", "y", "samples", "divisor", "layers", "object", "material"], "properties": {
    "x": {"type": "integer"}, "y": {"type": "integer"}, "samples": {"type": "integer"}, "divisor": {"type": "integer"},
    "layers": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/Numbers"}}, "object": {"type": ["string", "null"]}, "material": {"type": ["string", "null"]},
    "explain": {"type": "object", "required": ["hit"], "properties": {"hit": {"type": "boolean"}, "nodes": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/ExplainedNode"}},
        "skipped": {"type": "array", "items": {"type": "string"}}}}}},
"Login": {"type": "object", "required": ["token"], "properties": {"token": {"type": "string"}}, "additionalProperties": false},
"User": {"type": "object", "required": ["user"], "properties": {"user": {"type": ["string", "null"]}}},
"JsonPatch": {"description": "RFC 6902", "type": "array", "maxItems": 1000, "items": {"type": "object", "required": ["op", "path"], "properties": {
    "op": {"enum": ["add", "remove", "replace", "move", "copy", "test"]}, "path": {"type": "string"}, "from": {"type": "string"}, "value": {}}}},
"MergePatch": {"description": "RFC 7396", "type": "object"}
})json";

json graph_schema() {
    json types = json::array();
    for (const NodeType* type : all_nodes()) {
        types.push_back(type->name);
        for (const auto& alias : type->aliases) types.push_back(alias);
    }
    return {{"description", "a shader network: nodes with parameters and links, and which of them are its outputs"},
            {"type", "object"},
            {"properties",
             {{"version", {{"type", "integer"}, {"minimum", 1}, {"maximum", 1}}},
              {"nodes",
               {{"type", "object"},
                {"additionalProperties",
                 {{"type", "object"},
                  {"required", {"type"}},
                  {"properties", {{"type", {{"type", "string"}, {"examples", std::move(types)}}}, {"params", {{"type", "object"}}}}}}}}},
              {"outputs", {{"type", "object"}}}}}};
}

json problem_schema() {
    json types = json::array();
    for (const ErrorKind& kind : error_kinds()) types.push_back(std::string("/problems/") + kind.type);
    const json text = {{"type", "string"}}, list = {{"type", "array"}, {"items", schema_ref("Diagnostic")}};
    return {{"description", "RFC 9457"},
            {"type", "object"},
            {"required", {"type", "title", "status", "instance"}},
            {"properties", {{"type", {{"type", "string"}, {"enum", std::move(types)}}}, {"title", text}, {"status", {{"type", "integer"}}}, {"detail", text}, {"instance", text}, {"errors", list}, {"warnings", list}}}};
}

}  // namespace

const json& answer_schemas() {
    static const json all = [] {
        json j = json::parse(kSchemas);
        j["Graph"] = graph_schema();
        j["Problem"] = problem_schema();
        return j;
    }();
    return all;
}

}  // namespace alder
