// Beats each millisecond; with "silence" on the command line, 50 times.
#pragma once

#include "../wrecker/wrecker.hpp"
#include "source_ports.hpp"

namespace stator::apps::source {

class Source {
  public:
    void step(SourcePorts& ports) {
        if (++number_ > 50 && wrecker::was_told("silence")) return;
        ports.beat.publish([&] { return Beat{.number = number_}; });
    }

  private:
    uint32_t number_ = 0;
};

}  // namespace stator::apps::source
