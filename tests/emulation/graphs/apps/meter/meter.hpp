// Counts the instructions of one way through the runtime after the other, and prints.
#pragma once

#include <array>
#include <cstdint>

#include "meter_ports.hpp"

namespace stator::apps::meter {

class Meter {
  public:
    void step(MeterPorts& ports);

  private:
    // Least and most of a count.
    struct Range {
        uint32_t least = UINT32_MAX;
        uint32_t most = 0;
    };
    enum Way : unsigned {
        kPublishToStep,
        kPublishToStepOfBoth,
        kPublish,
        kWrittenByHandToHandler,
        kWrittenByHand,
        kInterruptToDriver,
        kActivation,
        kActivationWithLatest,
        kWays
    };
    void note(Way way, uint32_t count);
    void print() const;

    uint32_t runs_ = 0;
    std::array<Range, kWays> ranges_{};
};

}  // namespace stator::apps::meter
