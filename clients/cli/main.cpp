// alder: evaluates, checks, previews and renders graphs and scenes on this machine.
#include <cstdio>
#include <exception>
#include <new>

#include "clients/cli/common.h"

int main(int argc, char** argv) {
    using namespace alder::cli;
    CLI::App app{"alder: evaluates, checks, previews and renders shader graphs and scenes"};
    app.set_version_flag("--version", "alder " ALDER_VERSION);
    app.require_subcommand(1);
    std::vector<std::pair<CLI::App*, Run>> commands;
    for (const auto add : {add_eval, add_render, add_preview, add_merge, add_diff, add_ci, add_bench, add_validate, add_graph, add_nodes,
                           add_jobs, add_show, add_wait, add_cancel, add_logs, add_fetch, add_completion}) {
        Run run = add(app);
        commands.emplace_back(app.get_subcommands({}).back(), std::move(run));
    }
    try {
        app.parse(argc, argv);
        for (const auto& [command, run] : commands)
            if (command->parsed()) return run();
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e);   // --help, --version
        std::fprintf(stderr, "alder: %s\n", e.what());
        return kWrong;
    } catch (const Failure& failure) {
        return failure.status;
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "alder: out of memory\n");
        return kMachineFailed;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "alder: %s\n", e.what());
        return kMachineFailed;
    }
    return kDone;
}
