// The worker process: renders jobs for the daemon.
//
// One thread reads messages, one renders. What it may use is limited before anything is loaded: the processor by nice, so that
// interactive work in the daemon goes first at every instruction, not only at tile borders; memory by RLIMIT_DATA, so that too
// much of it is std::bad_alloc here instead of the kernel's choice of a victim.
#include "server/jobs/worker.h"

#include <execinfo.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <cstring>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "nodes/texture/image_store.h"
#include "server/jobs/channel.h"
#include "server/jobs/gate.h"
#include "server/jobs/render_job.h"
#include "server/log.h"

namespace alder::jobs {
namespace {

/// The backtrace goes to stderr, which the daemon keeps in the render's log.
void on_crash(int signal) {
    static constexpr char kText[] = "alder-worker crashed; backtrace:\n";
    (void)!::write(2, kText, sizeof kText - 1);
    void* frames[64];
    backtrace_symbols_fd(frames, backtrace(frames, 64), 2);
    std::signal(signal, SIG_DFL);
    raise(signal);
}

void limit_process(const nlohmann::json& setup) {
    setpriority(PRIO_PROCESS, 0, setup.value("priority", 19));
    if (const uint64_t bytes = setup.value("memory_bytes", uint64_t{0})) {
        const rlimit limit{bytes, bytes};
        setrlimit(RLIMIT_DATA, &limit);
    }
    for (const int s : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
        struct sigaction action {};
        action.sa_handler = on_crash;
        action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
        sigaction(s, &action, nullptr);
    }
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);   // a write beyond the limit is an error, not the end
    void* frame[1];
    backtrace(frame, 1);   // loads what it needs now: there is no allocating in a handler
}

class WorkerProcess {
  public:
    WorkerProcess(int fd) : channel_(fd) {}

    int run() {
        nlohmann::json message;
        if (channel_.receive(message, true) != Channel::Got::Message || message.value("do", "") != "setup") return 2;
        start_log(message.value("log_level", "info"));
        limit_process(message);
        if (message.value("gate", false)) use_gate(kGateDescriptor);
        data_ = message.at("data").get<std::string>();
        ImageStore::shared().set_budget(message.value("texture_mib", size_t{4096}) << 20);
        set_color_configuration(message.value("color_configuration", ""));
        set_image_fault_listener([](const std::string& fault) { log_event("warn", "texture broken", {{"file", fault}}); });
        assets_ = std::make_unique<AssetStore>(data_ + "/assets", false);
        engine_ = std::make_unique<Engine>(*assets_, message.value("asset_roots", std::vector<std::string>{}), message.value("threads", 0));
        scenes_ = std::make_unique<SceneStore>(data_ + "/scenes");
        context_ = std::make_unique<WorkerContext>(WorkerContext{data_, *assets_, *engine_, *scenes_, message.value("checkpoint_seconds", 30.0),
                                                                 message.value("checkpoint_fraction", 0.1),
                                                                 [this](const nlohmann::json& m) { return channel_.send(m); }});
        std::thread([this] { render_all(); }).detach();
        channel_.send({{"is", "ready"}, {"pid", getpid()}});
        while (channel_.receive(message, true) == Channel::Got::Message) take(message);
        // The daemon is gone or wants this to end: whatever is worth keeping is on disk already.
        _exit(0);
    }

  private:
    void take(const nlohmann::json& message) {
        const std::string verb = message.value("do", "");
        const std::lock_guard lock(mutex_);
        if (verb == "render") {
            next_.push_back(std::make_shared<RenderJob>(*context_, message));
            wake_.notify_one();
            return;
        }
        const std::string id = message.value("id", "");
        for (const auto& job : next_) act(*job, id, verb, message);
        if (current_) act(*current_, id, verb, message);
    }
    static void act(RenderJob& job, const std::string& id, const std::string& verb, const nlohmann::json& message) {
        if (job.id() != id) return;
        if (verb == "stop") job.stop(message.value("how", "cancel"));
        if (verb == "snapshot") job.want_snapshot(message.value("ticket", int64_t{0}));
    }

    void render_all() {
        for (;;) {
            {
                std::unique_lock lock(mutex_);
                current_.reset();
                wake_.wait(lock, [&] { return !next_.empty(); });
                current_ = next_.front();
                next_.pop_front();
            }
            try {
                current_->run();
            } catch (const std::bad_alloc&) {
                channel_.send({{"is", "failed"}, {"id", current_->id()}, {"type", "out-of-memory"}, {"detail", "the render needs more memory than the worker may have"}, {"errors", nlohmann::json::array()}});
                _exit(0);   // a fresh process has the memory back
            } catch (const std::exception& e) {
                log_event("error", "render failed", {{"render", current_->id()}, {"what", e.what()}});
                channel_.send({{"is", "failed"}, {"id", current_->id()}, {"type", "internal"}, {"detail", "the render failed inside; the log has the details"}, {"errors", nlohmann::json::array()}});
            }
        }
    }

    Channel channel_;
    std::string data_;
    std::unique_ptr<AssetStore> assets_;
    std::unique_ptr<Engine> engine_;
    std::unique_ptr<SceneStore> scenes_;
    std::unique_ptr<WorkerContext> context_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::shared_ptr<RenderJob>> next_;
    std::shared_ptr<RenderJob> current_;
};

}  // namespace

int worker_main(int fd) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);   // never outlives the daemon, not even stopped in a debugger
    prctl(PR_SET_NAME, "alder-worker");
    static WorkerProcess process(fd);   // threads use it until _exit()
    return process.run();
}

}  // namespace alder::jobs
