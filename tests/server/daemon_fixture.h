// A daemon in this process on a free loopback port, with a data folder of its own that goes when the test ends.
#pragma once
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "server/daemon.h"
#include "tests/server/raw_client.h"

namespace alder::test {

class DaemonTest : public ::testing::Test {
  protected:
    ServiceOptions options;
    std::unique_ptr<Daemon> daemon;
    std::string folder;

    DaemonTest() {
        static int number = 0;
        folder = ::testing::TempDir() + "alder_test_" + std::to_string(getpid()) + "_" + std::to_string(number++);
        options.listen = "127.0.0.1:0";
        options.data = folder;
        options.stop_seconds = 5;
    }
    ~DaemonTest() override {
        daemon.reset();
        std::filesystem::remove_all(folder);
    }
    void start() {
        daemon = std::make_unique<Daemon>(options);
        const auto error = daemon->start();
        ASSERT_FALSE(error.has_value()) << error->sentence;
    }
    Answer ask(const std::string& method, const std::string& target, const std::string& body = {}, const std::string& headers = {}) {
        return RawClient(daemon->port()).ask(method, target, body, headers);
    }
    Answer post(const std::string& target, const nlohmann::json& body, const std::string& headers = {}) {
        return ask("POST", target, body.dump(), "Content-Type: application/json\r\n" + headers);
    }
    static nlohmann::json json_of(const Answer& a) { return nlohmann::json::parse(a.body, nullptr, false); }
    static nlohmann::json errors_of(const Answer& a) { return json_of(a).value("errors", nlohmann::json::array()); }
    /// Status and last part of the problem's type: "422 graph-invalid".
    static std::string problem_of(const Answer& a) {
        const auto j = json_of(a);
        std::string type = j.is_object() ? j.value("type", "") : "";
        return std::to_string(a.status) + " " + type.substr(type.rfind('/') + 1);
    }
    static nlohmann::json remap_graph(double contrast = 1.5) {
        return {{"version", 1},
                {"nodes", {{"r", {{"type", "alRemapFloat"}, {"params", {{"input", {{"attribute", "x"}}}, {"RMPcontrast", contrast}}}}}}},
                {"outputs", {{"aovs", {{"wear", {{"node", "r"}}}}}}}};
    }
    static nlohmann::json surface_graph(double roughness = 0.3) {
        return {{"version", 1},
                {"nodes", {{"s", {{"type", "alSurface"}, {"params", {{"diffuseColor", {0.8, 0.3, 0.1}}, {"specular1Roughness", roughness}}}}}}},
                {"outputs", {{"surface", {{"node", "s"}}}}}};
    }
};

}  // namespace alder::test
