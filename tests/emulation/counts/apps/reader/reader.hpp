// A reader below the publisher.
#pragma once

#include "reader_ports.hpp"

namespace stator {

class Reader {
  public:
    void step(ReaderPorts& /*ports*/) {}
};

}  // namespace stator
