// An event of a device that can activate a node: raised by the board, or by a file descriptor.
#pragma once

#include <sys/epoll.h>

#include <atomic>
#include <cstdint>

#include "stator/task.hpp"

namespace stator {

class Line {
  public:
    // --- for boards and drivers ---

    // Notes the line with the clock and pends its task. False: refused, as too early. One thread at
    // a time.
    bool raise();

    // True once the task has served what was raised: nothing reads the device, so that the thread
    // that raises the line may write it.
    bool is_served() const;

    // From here on the line is raised while `fd` is ready for `events`, or broken: once, and again
    // after each activation of its task, so that a driver may read as much at a time as it likes.
    // An event that is refused as too early comes again when `min_interarrival` has passed. A
    // broken descriptor raises at most every 10 ms. Needs the descriptor to be non-blocking; one
    // descriptor has one line (two lines of a socket: `dup`). False: the kind of `fd` cannot be
    // waited for, such as a regular file's. Any thread, also before `start`.
    [[nodiscard]] bool watch(int fd, uint32_t events = EPOLLIN);
    // No longer, so that the descriptor may be closed.
    void unwatch();

    // --- for the executor ---

    void connect(LineState& state, const Pend& pend, uint32_t min_interarrival_us) {
        state_ = &state;
        pend_ = pend;
        min_interarrival_us_ = min_interarrival_us;
    }
    // After the task's activation, in its thread.
    void finish_activation();

  private:
    friend class LineThread;
    bool arm(int operation);

    LineState* state_ = nullptr;
    Pend pend_{};
    uint32_t min_interarrival_us_ = 0;
    std::atomic<uint32_t> served_{0};
    std::atomic<int> fd_{-1};
    std::atomic<uint32_t> events_{0};
    std::atomic<bool> is_held_{false};  // to be armed again later, by the thread of lines
    uint64_t held_until_us_ = 0;        // of that thread
};

}  // namespace stator
