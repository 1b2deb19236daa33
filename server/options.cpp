// Options of the daemon: a flag goes before an ALDER_* environment variable, that before the file of --config, that before the default.
#include "server/options.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>

#include <CLI/CLI.hpp>

namespace alder {

std::string default_data_folder() {
    if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data) return std::string(data) + "/alder";
    if (const char* home = std::getenv("HOME"); home && *home) return std::string(home) + "/.local/share/alder";
    return "/var/lib/alder";
}

namespace {

std::string trimmed(std::string text) {
    const auto end = text.find_last_not_of(" \t\r");
    text.erase(end == std::string::npos ? 0 : end + 1);
    text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
    return text;
}

/// Options of a file, for what neither flags nor the environment have said. Throws CLI::ParseError with the line's number.
void read_file(CLI::App& app, const std::string& path) {
    std::ifstream file(path);
    if (!file) throw CLI::FileError("the file of options '" + path + "' cannot be read");
    std::set<CLI::Option*> given, from_file;
    for (CLI::Option* o : app.get_options())
        if (o->count() > 0) given.insert(o);
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
        line = trimmed(line);
        if (line.empty() || line[0] == '#') continue;
        const size_t equals = line.find('=');
        const std::string name = trimmed(line.substr(0, equals));
        std::string value = equals == std::string::npos ? "" : trimmed(line.substr(equals + 1));
        if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
        CLI::Option* const option = name == "config" || name == "help" || name == "version" ? nullptr : app.get_option_no_throw("--" + name);
        if (!option || equals == std::string::npos) throw CLI::FileError(path + ":" + std::to_string(number) + ": expected NAME = VALUE, with a name of alderd --help");
        if (given.count(option)) continue;
        option->add_result(value);   // of a repeatable one, another
        from_file.insert(option);
    }
    for (CLI::Option* o : from_file) o->run_callback();
}

}  // namespace

int parse_options(int argc, char** argv, ServiceOptions& o) {
    CLI::App app{"alderd: renders graphs and scenes over HTTP"};
    app.get_formatter()->column_width(34);
    app.add_option("--listen", o.listen, "HOST:PORT, [IPV6]:PORT or unix:PATH; port 0 takes a free one")->envname("ALDER_LISTEN")->capture_default_str();
    app.add_option("--data", o.data, "folder of assets and scenes")->envname("ALDER_DATA");
    app.add_option("--threads", o.threads, "threads that render; 0 = all processors")->envname("ALDER_THREADS")->check(CLI::Range(0, 1024));
    app.add_option("--token-file", o.token_file, "lines NAME:SCOPES:SHA256-OF-TOKEN; needed to listen beyond loopback")->envname("ALDER_TOKEN_FILE");
    auto* const cert = app.add_option("--tls-cert", o.tls_cert, "PEM certificate with its chain: HTTPS instead of HTTP")->envname("ALDER_TLS_CERT");
    auto* const key = app.add_option("--tls-key", o.tls_key, "PEM key of the certificate")->envname("ALDER_TLS_KEY");
    cert->needs(key);
    key->needs(cert);
    app.add_option("--asset-root", o.asset_roots, "folder below which documents may name files; repeatable")->envname("ALDER_ASSET_ROOT");
    app.add_option("--allow-origin", o.allowed_origins, "web origin that may use this daemon; repeatable")->envname("ALDER_ALLOW_ORIGIN");
    app.add_option("--port-file", o.port_file, "write HOST:PORT here once listening")->envname("ALDER_PORT_FILE");
    app.add_option("--log-level", o.log_level, "debug, info, warn or error")->envname("ALDER_LOG_LEVEL")
        ->check(CLI::IsMember({"debug", "info", "warn", "error"}))->capture_default_str();
    app.add_option("--queue", o.queue, "requests that may wait for the engine, per kind")->envname("ALDER_QUEUE")->check(CLI::Range(0, 10000))->capture_default_str();
    app.add_option("--renders-queued", o.renders_queued, "renders that may wait")->envname("ALDER_RENDERS_QUEUED")->check(CLI::Range(1, 1000000))->capture_default_str();
    app.add_option("--retain", o.retain_seconds, "seconds that results are kept unless the request says otherwise")->envname("ALDER_RETAIN")->check(CLI::Range(0.0, 1e9))->capture_default_str();
    app.add_option("--max-render-seconds", o.max_render_seconds, "a render that takes longer fails; 0 = no limit")->envname("ALDER_MAX_RENDER_SECONDS")->check(CLI::Range(0.0, 1e9))->capture_default_str();
    app.add_option("--checkpoint-seconds", o.checkpoint_seconds, "least time between checkpoints of a render")->envname("ALDER_CHECKPOINT_SECONDS")->check(CLI::Range(0.0, 1e6))->capture_default_str();
    app.add_option("--worker-memory-mib", o.worker_memory_mib, "memory of the process that renders; 0 = 80 % of the machine's")->envname("ALDER_WORKER_MEMORY_MIB")->check(CLI::Range(0, 1 << 24))->capture_default_str();
    app.add_option("--cache-mib", o.cache_mib, "finished previews kept in memory")->envname("ALDER_CACHE_MIB")->check(CLI::Range(0, 1 << 20))->capture_default_str();
    app.add_option("--texture-mib", o.texture_mib, "textures held in memory, mip levels and tiles included")->envname("ALDER_TEXTURE_MIB")->check(CLI::Range(1, 1 << 24))->capture_default_str();
    app.add_option("--ocio", o.color_configuration, "OpenColorIO configuration with further colour spaces")->envname("OCIO");
    app.add_option("--max-body", o.limits.body_bytes, "bytes of a JSON body")->envname("ALDER_MAX_BODY")->check(CLI::Range(1024, 1 << 30))->capture_default_str();
    app.add_option("--max-scene", o.limits.scene_bytes, "bytes of a scene document")->envname("ALDER_MAX_SCENE")->check(CLI::Range(1024, 1 << 30))->capture_default_str();
    app.add_option("--max-asset-gib", o.asset_gib, "the largest asset")->envname("ALDER_MAX_ASSET_GIB")->check(CLI::Range(1, 1024))->capture_default_str();
    app.add_option("--asset-ttl", o.asset_ttl, "seconds that assets are kept which no scene or render refers to")->envname("ALDER_ASSET_TTL")->check(CLI::Range(0.0, 1e9))->capture_default_str();
    app.add_option("--store-gib", o.store_gib, "all assets together; 0 = what the disk holds")->envname("ALDER_STORE_GIB")->check(CLI::Range(0, 1 << 20))->capture_default_str();
    app.add_option("--max-connections", o.limits.connections, "connections open at once")->envname("ALDER_MAX_CONNECTIONS")->check(CLI::Range(1, 65536))->capture_default_str();
    std::string file;
    app.add_option("--config", file, "file of options: NAME = VALUE, a line each, names as here without the dashes")->envname("ALDER_CONFIG");
    app.set_version_flag("--version", "alderd " ALDER_VERSION);
    try {
        app.parse(argc, argv);
        if (!file.empty()) read_file(app, file);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e);
        std::fprintf(stderr, "alderd: %s\n", e.what());
        return 2;
    }
    if (o.data.empty()) o.data = default_data_folder();
    return -1;
}

}  // namespace alder
