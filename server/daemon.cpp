// Daemon: the service behind its door, from checked options to a clean stop.
#include "server/daemon.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "server/log.h"

namespace alder {

Daemon::Daemon(const ServiceOptions& options) : options_(options) {}

Daemon::~Daemon() {
    stop();
    if (warmer_.joinable()) warmer_.join();
    {
        const std::lock_guard lock(cleaner_mutex_);
        cleaner_ends_ = true;
        cleaner_wake_.notify_all();
    }
    if (cleaner_.joinable()) cleaner_.join();
    door_.reset();      // its threads use the service
    service_.reset();
    if (lock_ >= 0) ::close(lock_);
}

std::optional<Daemon::StartError> Daemon::start() {
    namespace fs = std::filesystem;
    const auto wrong = [](std::string sentence) { return StartError{2, std::move(sentence)}; };
    const bool loopback = http::Door::is_loopback(options_.listen);
    if (!loopback && options_.token_file.empty())
        return wrong(fmt::format("{} is reachable from other machines: give --token-file, or listen on a loopback address", options_.listen));
    for (std::string& root : options_.asset_roots) {
        std::error_code code;
        const fs::path whole = fs::canonical(root, code);
        if (code || !fs::is_directory(whole)) return wrong(fmt::format("the asset root '{}' is not a folder", root));
        root = whole.string();
    }
    std::error_code code;
    fs::create_directories(options_.data, code);
    if (code) return StartError{3, fmt::format("cannot make the data folder {}: {}", options_.data, code.message())};
    lock_ = ::open((options_.data + "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (lock_ < 0) return StartError{3, fmt::format("cannot write to the data folder {}: {}", options_.data, std::strerror(errno))};
    if (flock(lock_, LOCK_EX | LOCK_NB) != 0) return wrong(fmt::format("the data folder {} is in use by another alderd", options_.data));

    service_ = std::make_unique<Service>(options_);
    if (!service_->assets.error().empty()) return StartError{3, service_->assets.error()};
    if (!service_->scenes.error().empty()) return StartError{3, service_->scenes.error()};
    if (const std::string error = service_->renders.start(); !error.empty()) return StartError{3, error};
    service_->access.check_host = loopback && options_.listen.rfind("unix:", 0) != 0;
    if (!options_.token_file.empty())
        if (const std::string error = service_->access.load_tokens(options_.token_file); !error.empty()) return wrong(error);

    Service* service = service_.get();
    door_ = std::make_unique<http::Door>(options_.limits, [service](http::Request& request) { return service->handle(request); });
    if (!options_.tls_cert.empty())
        if (const std::string error = door_->use_tls(options_.tls_cert, options_.tls_key); !error.empty()) return wrong(error);
    if (const std::string error = door_->listen(options_.listen); !error.empty()) return wrong(error);
    service_->metrics.gauge("alder_connections", [door = door_.get()] { return static_cast<double>(door->connections()); });
    // Before anyone can know of it: no request comes first in the log.
    log_event("info", "listening", {{"address", door_->address()}, {"port", door_->port()}, {"data", options_.data}, {"pid", getpid()}, {"version", ALDER_VERSION}});
    if (!options_.port_file.empty() && !write_durably(options_.port_file, door_->address() + "\n"))
        return StartError{3, fmt::format("cannot write {}", options_.port_file)};
    door_->start();
    cleaner_ = std::thread([this] { clean_assets(); });
    return std::nullopt;
}

void Daemon::clean_assets() {
    std::unique_lock lock(cleaner_mutex_);
    while (!cleaner_ends_) {
        lock.unlock();
        try {
            const uint64_t removed = service_->assets.collect(options_.asset_ttl, [this](const std::string& hex) {
                return !service_->scenes.user_of("sha256:" + hex).empty() || service_->renders.store().names("sha256:" + hex);
            });
            if (removed > 0) log_event("info", "assets removed", {{"bytes", removed}});
        } catch (const std::exception& e) {
            log_event("error", "assets cannot be cleaned", {{"what", e.what()}});
        }
        lock.lock();
        cleaner_wake_.wait_for(lock, std::chrono::duration<double>(std::clamp(options_.asset_ttl / 4, 0.2, 3600.0)), [&] { return cleaner_ends_; });
    }
}

void Daemon::warm_up() {
    service_->renders.warm_up();
    warmer_ = std::thread([this] {
        try {
            service_->engine.warm_up();
        } catch (const std::exception& e) {
            log_event("error", "warm-up failed", {{"what", e.what()}});
        } catch (const Problem& p) {
            log_event("error", "warm-up failed", {{"what", p.detail}});
        }
    });
}

bool Daemon::stop() {
    if (!service_ || !door_) return true;
    service_->draining = true;
    service_->live.stop();   // streams end
    const auto start = std::chrono::steady_clock::now();
    service_->renders.stop(options_.stop_seconds / 2);   // who waits for a render is answered now: it is on disk and goes on later
    return door_->stop(options_.stop_seconds - std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace alder
