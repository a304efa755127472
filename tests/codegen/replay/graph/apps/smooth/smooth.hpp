// Smooths one axis of all samples since the activation before.
#pragma once

#include "smooth_ports.hpp"

namespace stator::apps::smooth {

class Smooth {
  public:
    void step(SmoothPorts& ports) {
        uint32_t seen = 0;
        for (; ports.accel.next(); ++seen) value_ += kGain * (ports.accel->xyz[0] - value_);
        ports.smooth.publish([&] {
            return Reading{.value = value_ + ports.gyro->xyz[2],
                           .seen = seen,
                           .lost = ports.accel.lost() + 1000 * ports.gyro.lost()};
        });
    }

  private:
    static constexpr float kGain = 0.125F;
    float value_ = 0.0F;
};

}  // namespace stator::apps::smooth
