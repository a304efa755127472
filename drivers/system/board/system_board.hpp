// The machine: a request to restart is handed to the board, once the answer is out and while the
// vehicle is disarmed.
#pragma once

#include <cstdint>

#include "system_ports.hpp"

namespace stator::drivers::system::board {

class SystemBoard {
  public:
    struct Device {
        // The board puts its function here, which may return; without one nothing restarts.
        void (*restart)() = nullptr;
        bool restarts = false;  // it was called
    };
    static constexpr uint64_t kAnswerTime_us = 500'000;

    explicit SystemBoard(Device& device) : device_(device) {}
    void step(SystemPorts& ports);

  private:
    Device& device_;
    uint64_t asked_us_ = 0;
    bool is_asked_ = false;
};

}  // namespace stator::drivers::system::board
