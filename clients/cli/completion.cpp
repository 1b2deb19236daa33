// alder completion: what the options say about themselves, for shells and for man.
#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "clients/cli/common.h"

namespace alder::cli {
namespace {

struct Options {
    std::string kind;
};

std::vector<const CLI::App*> subcommands(const CLI::App& app) {
    std::vector<const CLI::App*> all;
    for (const CLI::App* c : app.get_subcommands([](const CLI::App*) { return true; })) all.push_back(c);
    return all;
}

std::vector<std::string> switches(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options()) {
        for (const std::string& l : option->get_lnames()) names.push_back("--" + l);
        for (const std::string& s : option->get_snames()) names.push_back("-" + s);
    }
    return names;
}

std::string bash(const CLI::App& app) {
    std::string names, cases;
    for (const CLI::App* c : subcommands(app)) {
        names += (names.empty() ? "" : " ") + c->get_name();
        cases += fmt::format("        {}) words=\"{}\" ;;\n", c->get_name(), fmt::join(switches(*c), " "));
    }
    return "# bash: source <(alder completion bash)\n_alder() {\n    local word=${COMP_WORDS[COMP_CWORD]} words=\"\"\n"
           "    if ((COMP_CWORD == 1)); then\n        COMPREPLY=($(compgen -W \"" + names + " --help --version\" -- \"$word\"))\n        return\n    fi\n"
           "    case ${COMP_WORDS[1]} in\n" + cases + "    esac\n    if [[ $word == -* ]]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
           "    else\n        COMPREPLY=($(compgen -f -- \"$word\"))\n    fi\n}\ncomplete -o filenames -F _alder alder\n";
}

std::string quoted(std::string text) {
    for (size_t i = 0; (i = text.find('\'', i)) != std::string::npos; i += 4) text.replace(i, 1, "'\\''");
    return "'" + text + "'";
}

std::string zsh(const CLI::App& app) {
    std::string text = "#compdef alder\n# zsh: alder completion zsh > a folder of $fpath/_alder\n_alder() {\n  local -a commands\n  commands=(\n";
    for (const CLI::App* c : subcommands(app)) text += "    " + quoted(c->get_name() + ":" + c->get_description()) + "\n";
    text += "  )\n  if (( CURRENT == 2 )); then _describe command commands; return; fi\n  case $words[2] in\n";
    for (const CLI::App* c : subcommands(app)) {
        text += fmt::format("    {}) compadd -- {}; _files ;;\n", c->get_name(), fmt::join(switches(*c), " "));
    }
    return text + "  esac\n}\n_alder \"$@\"\n";
}

std::string fish(const CLI::App& app) {
    std::string text = "# fish: alder completion fish > ~/.config/fish/completions/alder.fish\n";
    for (const CLI::App* c : subcommands(app)) {
        text += fmt::format("complete -c alder -n __fish_use_subcommand -a {} -d {}\n", c->get_name(), quoted(c->get_description()));
        for (const CLI::Option* option : c->get_options())
            for (const std::string& l : option->get_lnames())
                text += fmt::format("complete -c alder -n '__fish_seen_subcommand_from {}' -l {} -d {}\n", c->get_name(), l, quoted(option->get_description()));
    }
    return text;
}

/// Text for troff: a line may not begin with a dot or an apostrophe, and - is a hyphen unless escaped.
std::string roff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\') out += "\\e";
        else if (c == '-') out += "\\-";
        else out += c;
    }
    if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out = "\\&" + out;
    return out;
}

std::string man(const CLI::App& app) {
    std::string text = fmt::format(".TH ALDER 1 \"\" \"alder {}\"\n.SH NAME\nalder \\- {}\n.SH SYNOPSIS\n.B alder\n.I COMMAND\n[options]\n.SH COMMANDS\n", ALDER_VERSION,
                                   roff("evaluates, checks, previews and renders shader graphs and scenes"));
    for (const CLI::App* c : subcommands(app)) {
        text += fmt::format(".SS \"alder {}\"\n{}\n", c->get_name(), roff(c->get_description()));
        for (const CLI::Option* option : c->get_options()) {
            std::string names;
            for (const std::string& s : option->get_snames()) names += (names.empty() ? "-" : ", -") + s;
            for (const std::string& l : option->get_lnames()) names += (names.empty() ? "--" : ", --") + l;
            if (names.empty()) names = option->get_name(true);
            text += fmt::format(".TP\n.B {}\n{}\n", roff(names), option->get_description().empty() ? "\\&" : roff(option->get_description()));
        }
    }
    text += ".SH EXIT STATUS\n";
    for (const auto& [status, meaning] : {std::pair{"0", "done; comparison within limits"}, {"1", "a comparison or check failed"}, {"2", "the request, scene, graph or options are wrong"},
                                          {"3", "the machine failed: disk, memory, crash"}, {"4", "stopped by a deadline with a usable result that is marked incomplete"},
                                          {"130", "interrupted; what was rendered is written and marked incomplete"}})
        text += fmt::format(".TP\n.B {}\n{}\n", status, roff(meaning));
    return text;
}

}  // namespace

Run add_completion(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = app.add_subcommand("completion", "completion for a shell, or the manual page");
    c->add_option("KIND", o->kind, "bash, zsh, fish or man")->required()->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
    return [o, &app] {
        const std::string text = o->kind == "bash" ? bash(app) : o->kind == "zsh" ? zsh(app) : o->kind == "fish" ? fish(app) : man(app);
        std::fwrite(text.data(), 1, text.size(), stdout);
        if (std::fflush(stdout) != 0 || std::ferror(stdout)) fail(kMachineFailed, "the text could not be written");
        return static_cast<int>(kDone);
    };
}

}  // namespace alder::cli
