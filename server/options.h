// Options of the daemon: flags, ALDER_* environment variables, defaults.
#pragma once
#include <string>
#include <vector>

#include "server/http/message.h"

namespace alder {

struct ServiceOptions {
    std::string listen = "127.0.0.1:7420";
    std::string data;                          ///< folder of assets and scenes; empty = default_data_folder()
    std::string token_file;
    std::string tls_cert, tls_key;             ///< PEM files; empty = plain HTTP
    std::string port_file;                     ///< written with "HOST:PORT" once listening
    std::vector<std::string> asset_roots;      ///< folders below which documents may name files
    std::vector<std::string> allowed_origins;
    std::string log_level = "info";
    int threads = 0;                           ///< of rendering; 0 = all processors
    int64_t queue = 64;                        ///< requests that may wait for the engine, per kind
    int64_t cache_mib = 256;                   ///< finished previews kept in memory
    int64_t texture_mib = 4096;                ///< pixels of textures held in memory
    std::string color_configuration;           ///< OpenColorIO's; empty: $OCIO
    double asset_ttl = 86400;                  ///< seconds that assets are kept which nothing refers to
    int64_t store_gib = 0;                     ///< of all assets; 0 = what the disk holds
    int64_t asset_gib = 4;                     ///< the largest asset
    int64_t renders_queued = 10000;            ///< renders that may wait or be paused
    double retain_seconds = 7 * 86400;         ///< how long results are kept unless the request says otherwise
    double max_render_seconds = 0;             ///< of one attempt; 0 = no limit
    double checkpoint_seconds = 30;            ///< the least time between checkpoints of a running render
    double checkpoint_fraction = 0.1;          ///< ... and the least part of its samples
    int64_t worker_memory_mib = 0;             ///< of the process that renders; 0 = 80 % of what the machine has
    std::string worker_program;                ///< what is started with --worker; empty = this program
    double stop_seconds = 8;                   ///< how long running requests may go on after SIGTERM
    http::Limits limits;
};

std::string default_data_folder();

/// Fills `options` from the command line and environment. Returns an exit status, or -1 to go on.
int parse_options(int argc, char** argv, ServiceOptions& options);

}  // namespace alder
