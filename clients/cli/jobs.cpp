// alder jobs, show, wait, cancel, logs, fetch: renders that a daemon has, from the command line.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <httplib.h>

#include "clients/cli/common.h"
#include "graph/digest.h"

namespace alder::cli {
namespace {

constexpr int kTemporary = 75;   // worth another try: what farm wrappers look for
constexpr const char* kDefaultServer = "http://127.0.0.1:7420";

struct Options {
    std::string server, id, output, state;
    std::vector<std::string> labels;
    int limit = 100;
    double seconds = 0;
    bool json = false;
};

/// One daemon, spoken to with the token of ALDER_TOKEN_FILE where that is set.
class Remote {
  public:
    explicit Remote(const Options& o) : url_(o.server), client_(o.server) {
        if (!client_.is_valid()) fail(kWrong, fmt::format("'{}' is not an address as in {}", o.server, kDefaultServer));
        client_.set_connection_timeout(5);
        client_.set_read_timeout(70);
        if (const char* path = std::getenv("ALDER_TOKEN_FILE"); path && *path) {
            std::ifstream file(path);
            std::string token;
            if (!std::getline(file, token) || token.empty()) fail(kWrong, fmt::format("{}: has no token", path));
            client_.set_default_headers({{"Authorization", "Bearer " + token}});
        }
    }
    httplib::Response ask(const char* method, const std::string& path, const httplib::Headers& headers = {}) {
        httplib::Request request;
        request.method = method;
        request.path = path;
        request.headers = headers;
        const auto result = client_.send(request);
        if (!result) fail(kMachineFailed, fmt::format("{}: cannot be reached ({})", url_, httplib::to_string(result.error())));
        if (result->status < 400) return *result;
        const auto problem = nlohmann::json::parse(result->body, nullptr, false);
        std::string text = fmt::format("{} answers {}", url_, result->status);
        if (problem.is_object()) text = problem.value("title", text) + (problem.contains("detail") ? ": " + problem.value("detail", "") : "");
        const bool busy = result->status == 429 || result->status == 503;
        fail(busy ? kTemporary : result->status >= 500 ? static_cast<int>(kMachineFailed) : static_cast<int>(kWrong), text);
    }
    nlohmann::json json(const char* method, const std::string& path, const httplib::Headers& headers = {}) {
        auto j = nlohmann::json::parse(ask(method, path, headers).body, nullptr, false);
        if (!j.is_object()) fail(kMachineFailed, fmt::format("{}: the answer is not JSON", url_));
        return j;
    }
    /// Streams a body into a file of a temporary name; renamed when it is whole and its digest right.
    void download(const std::string& path, const std::string& to, const std::string& digest) {
        const std::string temporary = to + ".part";
        std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
        int status = 0;
        const auto result = client_.Get(path, [&](const httplib::Response& r) { return (status = r.status) == 200; },
                                        [&](const char* data, size_t size) { return static_cast<bool>(file.write(data, static_cast<std::streamsize>(size))); });
        file.close();
        std::string why;
        if (!result || status != 200) why = status && status != 200 ? fmt::format("the daemon answers {}", status) : "the transfer was cut short";
        else if (!file) why = "cannot be written";
        else if (std::ifstream in(temporary, std::ios::binary); "sha256:" + sha256_hex(std::string(std::istreambuf_iterator<char>(in), {})) != digest) why = "arrived with another digest";
        std::error_code code;
        if (why.empty()) std::filesystem::rename(temporary, to, code);
        if (code) why = code.message();
        if (why.empty()) return;
        std::filesystem::remove(temporary, code);
        fail(kMachineFailed, fmt::format("{}: {}", to, why));
    }

  private:
    std::string url_;
    httplib::Client client_;
};

std::string path_of(const Options& o) {
    if (o.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos) fail(kWrong, fmt::format("'{}' is not the id of a render", o.id));
    return "/v1/renders/" + o.id;
}

/// 0..9, a-z and what RFC 3986 leaves alone; the rest escaped.
std::string escaped(const std::string& text) {
    std::string out;
    for (const unsigned char c : text)
        if (std::isalnum(c) || c == '-' || c == '_' || c == '.' || c == '~') out.push_back(static_cast<char>(c));
        else out += fmt::format("%{:02X}", c);
    return out;
}

void print_line(const nlohmann::json& r) {
    const auto& progress = r["progress"];
    const std::string reason = r["reason"].is_string() ? " (" + r["reason"].get<std::string>() + ")" : "";
    std::string labels;
    for (const auto& [name, value] : r["labels"].items()) labels += fmt::format(" {}={}", name, value.get<std::string>());
    fmt::print("{}  {:10}  {:5.1f} %  {:>6} samples  priority {}{}{}\n", r.value("id", ""), r.value("state", "") + reason, progress.value("fraction", 0.0) * 100,
               progress.value("samples", 0), r.value("priority", 0), labels.empty() ? "" : " ", labels);
}

void print_whole(const nlohmann::json& r) {
    print_line(r);
    fmt::print("  created {}  started {}  ended {}  attempt {}\n", r["created"].is_string() ? r["created"].get<std::string>() : "-",
               r["started"].is_string() ? r["started"].get<std::string>() : "-", r["ended"].is_string() ? r["ended"].get<std::string>() : "-", r.value("attempt", 0));
    for (const auto& o : r["outputs"]) fmt::print("  {}  {} bytes  {}{}\n", o.value("file", ""), o.value("bytes", uint64_t{0}), o.value("digest", ""), o.value("complete", true) ? "" : "  incomplete");
    for (const auto& w : r["warnings"]) fmt::print("  warning: {}\n", w.is_string() ? w.get<std::string>() : w.dump());
    if (r.contains("problem")) fmt::print("  {}: {}\n", r["problem"].value("type", ""), r["problem"].value("detail", ""));
}

/// The exit status of `wait`.
int status_of(const nlohmann::json& r) {
    const std::string state = r.value("state", "");
    if (state == "succeeded") {
        for (const auto& o : r["outputs"])
            if (!o.value("complete", true)) return kDeadline;
        return kDone;
    }
    if (state == "cancelled") return kInterrupted;
    const std::string type = r.contains("problem") ? r["problem"].value("type", "") : "";
    return type.ends_with("-invalid") || type.ends_with("asset-unreadable") || type.ends_with("nonfinite") ? kWrong : kMachineFailed;
}

int run_jobs(const Options& o) {
    Remote remote(o);
    std::string query = fmt::format("/v1/renders?limit={}", std::min(o.limit, 1000));
    if (!o.state.empty()) query += "&state=" + o.state;
    for (const std::string& label : o.labels) {
        const size_t at = label.find('=');
        if (at == std::string::npos || at == 0) fail(kWrong, fmt::format("--label {}: NAME=VALUE", label));
        query += "&label." + escaped(label.substr(0, at)) + "=" + escaped(label.substr(at + 1));
    }
    const nlohmann::json page = remote.json("GET", query);
    if (o.json) fmt::print("{}\n", page.dump(1));
    else for (const auto& r : page["items"]) print_line(r);
    return kDone;
}

int run_show(const Options& o) {
    const nlohmann::json r = Remote(o).json("GET", path_of(o));
    if (o.json) fmt::print("{}\n", r.dump(1));
    else print_whole(r);
    return kDone;
}

int run_wait(const Options& o) {
    Remote remote(o);
    const auto start = std::chrono::steady_clock::now();
    nlohmann::json r = remote.json("GET", path_of(o));
    const auto ended = [](const nlohmann::json& j) { return j["state"] == "succeeded" || j["state"] == "failed" || j["state"] == "cancelled"; };
    while (!ended(r)) {
        double left = 30;
        if (o.seconds > 0) left = std::min(left, o.seconds - std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        if (left < 1) {
            std::fprintf(stderr, "alder: %s is %s\n", o.id.c_str(), r.value("state", "").c_str());
            return kTemporary;
        }
        const auto answer = remote.ask("GET", path_of(o), {{"If-None-Match", r.value("etag", "")}, {"Prefer", fmt::format("wait={}", static_cast<int>(left))}});
        if (answer.status == 200) r = nlohmann::json::parse(answer.body, nullptr, false);
        if (!r.is_object()) fail(kMachineFailed, "the answer is not JSON");
    }
    if (o.json) fmt::print("{}\n", r.dump(1));
    else print_whole(r);
    return status_of(r);
}

int run_cancel(const Options& o) {
    const nlohmann::json r = Remote(o).json("POST", path_of(o) + "/cancel");
    if (o.json) fmt::print("{}\n", r.dump(1));
    else print_line(r);
    return kDone;
}

int run_logs(const Options& o) {
    std::fputs(Remote(o).ask("GET", path_of(o) + "/log").body.c_str(), stdout);
    return kDone;
}

int run_fetch(const Options& o) {
    Remote remote(o);
    const nlohmann::json r = remote.json("GET", path_of(o));
    const auto& outputs = r["outputs"];
    if (outputs.empty()) fail(r["state"] == "succeeded" ? kWrong : kTemporary, fmt::format("{} is {}: there is no file", o.id, r.value("state", "")));
    const bool is_folder = o.output.empty() || std::filesystem::is_directory(o.output) || outputs.size() > 1;
    std::error_code code;
    if (is_folder && !o.output.empty()) std::filesystem::create_directories(o.output, code);
    for (const auto& output : outputs) {
        const std::string name = std::filesystem::path(output.value("file", "")).filename().string();
        const std::string to = is_folder ? (std::filesystem::path(o.output) / name).string() : o.output;
        remote.download(path_of(o) + "/outputs/" + escaped(name), to, output.value("digest", ""));
        fmt::print("{}\n", to);
    }
    return kDone;
}

CLI::App* command(CLI::App& app, const char* name, const char* help, const std::shared_ptr<Options>& o, bool of_one) {
    CLI::App* c = app.add_subcommand(name, help);
    if (of_one) c->add_option("ID", o->id, "rnd_...")->required();
    o->server = kDefaultServer;
    c->add_option("--server", o->server, "address of the daemon")->envname("ALDER_URL")->capture_default_str();
    c->add_flag("--json", o->json, "what the daemon answers, as it is");
    return c;
}

}  // namespace

Run add_jobs(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = command(app, "jobs", "renders of a daemon, newest first", o, false);
    c->add_option("--state", o->state, "only those")->check(CLI::IsMember({"queued", "preparing", "rendering", "writing", "paused", "succeeded", "failed", "cancelled"}));
    c->add_option("--label", o->labels, "NAME=VALUE; repeatable")->allow_extra_args(false);
    c->add_option("--limit", o->limit, "at most so many")->check(CLI::Range(1, 1000))->capture_default_str();
    return [o] { return run_jobs(*o); };
}
Run add_show(CLI::App& app) {
    auto o = std::make_shared<Options>();
    command(app, "show", "one render of a daemon", o, true);
    return [o] { return run_show(*o); };
}
Run add_wait(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = command(app, "wait", "until a render has ended; exits as alder render would have", o, true);
    c->add_option("--timeout", o->seconds, "seconds; then exit status 75")->check(CLI::Range(1.0, 1e9));
    return [o] { return run_wait(*o); };
}
Run add_cancel(CLI::App& app) {
    auto o = std::make_shared<Options>();
    command(app, "cancel", "stops a render for good", o, true);
    return [o] { return run_cancel(*o); };
}
Run add_logs(CLI::App& app) {
    auto o = std::make_shared<Options>();
    command(app, "logs", "the log of a render", o, true);
    return [o] { return run_logs(*o); };
}
Run add_fetch(CLI::App& app) {
    auto o = std::make_shared<Options>();
    CLI::App* c = command(app, "fetch", "the files of a render, digests checked", o, true);
    c->add_option("-o,--output", o->output, "file or folder; default: here, by their own names");
    return [o] { return run_fetch(*o); };
}

}  // namespace alder::cli
