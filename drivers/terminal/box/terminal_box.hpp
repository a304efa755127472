// Passes requests of terminals on to the graph, and the answers back.
#pragma once

#include <cstdint>

#include "stator/parameter_box.hpp"
#include "terminal_ports.hpp"

namespace stator::drivers::terminal::box {

// Where the link is served, the board makes the box known there. A request without an answer ends
// after a while.
class TerminalBox {
  public:
    struct Device {
        ParameterBox box;
    };

    explicit TerminalBox(Device& device) : device_(device) {}
    void step(TerminalPorts& ports);

  private:
    static constexpr uint64_t kAnswerTime_us = 1'000'000;

    Device& device_;
    uint64_t until_us_ = 0;
    uint8_t tag_ = 0;
    bool is_waiting_ = false;
};

}  // namespace stator::drivers::terminal::box
