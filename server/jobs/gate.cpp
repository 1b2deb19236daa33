// Gate: memory that the daemon shares with its worker.
#include "server/jobs/gate.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "render/tile_gate.h"

namespace alder::jobs {
namespace {

static_assert(std::atomic<int>::is_always_lock_free, "it is shared between processes");

std::atomic<int>* map_counter(int fd) {
    void* const p = mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    return p == MAP_FAILED ? nullptr : static_cast<std::atomic<int>*>(p);   // a fresh file is zeros: the counter's beginning
}

}  // namespace

Gate::Gate() {
    const int fd = memfd_create("alder-gate", MFD_CLOEXEC);
    if (fd < 0) return;
    // Far from the numbers that a worker's own descriptors are moved to.
    if (ftruncate(fd, sizeof(std::atomic<int>)) == 0) fd_ = fcntl(fd, F_DUPFD_CLOEXEC, 16);
    ::close(fd);
    if (fd_ >= 0) held_ = map_counter(fd_);
}

Gate::~Gate() {
    if (held_) munmap(held_, sizeof(std::atomic<int>));
    if (fd_ >= 0) ::close(fd_);
}

Gate::Hold::Hold(Gate* gate) : gate_(gate && gate->held_ ? gate : nullptr) {
    if (gate_) gate_->held_->fetch_add(1);
}
Gate::Hold::~Hold() {
    if (gate_) gate_->held_->fetch_sub(1);
}

void use_gate(int descriptor) { set_tile_gate(map_counter(descriptor)); }

}  // namespace alder::jobs
