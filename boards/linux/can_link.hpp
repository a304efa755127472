// The CAN bus of a run: the interface that the graph's device gets, and a second socket on it for
// the simulated parts.
#pragma once

#include "stator/dronecan/frame.hpp"

namespace stator::board {

// False after one line that says why the bus cannot be used.
[[nodiscard]] bool is_can_interface(const char* interface);

// The simulated parts' place on the bus. One thread.
class CanLink {
  public:
    CanLink() = default;
    ~CanLink();
    CanLink(const CanLink&) = delete;
    CanLink& operator=(const CanLink&) = delete;

    [[nodiscard]] bool open(const char* interface);
    bool is_open() const { return socket_ >= 0; }
    void send(const dronecan::Frame& frame) const;
    // False: none waits.
    [[nodiscard]] bool receive(dronecan::Frame& frame) const;

  private:
    int socket_ = -1;
};

}  // namespace stator::board
