// Gate: memory that the daemon shares with its worker: how many pictures are being made that somebody waits for. While there are
// any, the worker starts no tile (render/tile_gate.h).
#pragma once
#include <atomic>

namespace alder::jobs {

class Gate {
  public:
    Gate();
    ~Gate();
    Gate(const Gate&) = delete;
    Gate& operator=(const Gate&) = delete;
    /// For the worker, which has it as kGateDescriptor; -1 where the system gave none.
    int descriptor() const { return fd_; }

    /// Holds the worker's tiles while it lives. null: nothing to hold.
    class Hold {
      public:
        explicit Hold(Gate* gate);
        ~Hold();
        Hold(const Hold&) = delete;
        Hold& operator=(const Hold&) = delete;

      private:
        Gate* gate_;
    };

  private:
    int fd_ = -1;
    std::atomic<int>* held_ = nullptr;
};

inline constexpr int kGateDescriptor = 4;
/// In the worker: its renders pass the gate from now on.
void use_gate(int descriptor);

}  // namespace alder::jobs
