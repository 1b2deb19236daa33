// What the subcommands of `alder` share: reading documents, resolving files beside them, one line an error, exit statuses.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "graph/material.h"

namespace alder::cli {

enum Exit : int {
    kDone = 0,
    kCheckFailed = 1,     ///< a comparison or check failed
    kWrong = 2,           ///< the request, scene, graph or options are wrong
    kMachineFailed = 3,   ///< disk, memory
    kDeadline = 4,        ///< stopped by a deadline with a usable result that is marked incomplete
    kInterrupted = 130,
};

/// Ends the command with this status; the message, if any, has been printed.
struct Failure {
    int status;
};

/// "alder: SENTENCE" on stderr, then Failure.
[[noreturn]] void fail(int status, const std::string& sentence);
/// One line an error ("alder: FILE: /pointer: ..."), warnings too; Failure where there is an error.
void report(const std::string& file, const Diagnostics& d, bool quiet = false);

/// A file or "-" for standard input; fails where it cannot be read.
std::string read_text(const std::string& path);
nlohmann::json read_json_file(const std::string& path);
/// A graph document, or the graph of a request that has one under "graph".
nlohmann::json read_graph_file(const std::string& path);

/// {"file": NAME} and alShaders' file names beside the document (absolute names as they are); assets are the daemon's.
std::function<std::string(const nlohmann::json&, std::string&)> image_resolver(const std::string& document_path);

/// A file that load_scene() reads: the path itself, or, of an .ass file, the .alder that the importer makes of it. That one is
/// temporary and goes with the object.
class SceneFile {
  public:
    explicit SceneFile(const std::string& path);
    ~SceneFile();
    SceneFile(const SceneFile&) = delete;
    SceneFile& operator=(const SceneFile&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::string path_, folder_;
};

/// --texture-mib and --ocio, which act on the whole process.
void add_texture_options(CLI::App& command);

/// Writes all of it; a failure is the machine's.
void write_bytes(const std::string& path, const void* data, size_t bytes);

// One file each: options, then what runs. The callback's status is the program's.
using Run = std::function<int()>;
Run add_eval(CLI::App& app);
Run add_nodes(CLI::App& app);
Run add_validate(CLI::App& app);
Run add_render(CLI::App& app);
Run add_preview(CLI::App& app);
Run add_merge(CLI::App& app);
Run add_diff(CLI::App& app);
Run add_ci(CLI::App& app);
Run add_bench(CLI::App& app);
Run add_completion(CLI::App& app);
Run add_graph(CLI::App& app);
// jobs.cpp
Run add_jobs(CLI::App& app);
Run add_show(CLI::App& app);
Run add_wait(CLI::App& app);
Run add_cancel(CLI::App& app);
Run add_logs(CLI::App& app);
Run add_fetch(CLI::App& app);

}  // namespace alder::cli
