// A CAN interface of Linux as a device of a graph.
#pragma once

#include "socket_port.hpp"

namespace stator::drivers::can::socketcan {

class CanSocketcan {
  public:
    using Device = SocketPort::Device;

    explicit CanSocketcan(Device& device) : driver_(SocketPort(device)) {}
    void step(CanPorts& ports) { driver_.step(ports); }

  private:
    CanDriver<SocketPort> driver_;
};

}  // namespace stator::drivers::can::socketcan
