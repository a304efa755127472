// Control allocation of an aeroplane: fw_rate's torque and thrust in, servos and motors out.
#pragma once

#include "fw_allocation_ports.hpp"
#include "surfaces.hpp"

namespace stator::apps::fw_allocation {

// Runs with every torque setpoint, and with every status so that a disarmed vehicle stops its
// motors (not a number) though the rest is silent. Thrust is that along x of B, the same for each
// propeller. A component that is not a number, or a thrust that is absent, reads as zero.
class FwAllocation {
  public:
    void step(FwAllocationPorts& ports);

  private:
    Surfaces surfaces_;
    unsigned motor_count_ = 0;
    bool is_armed_ = false;
    uint64_t torque_us_ = 0;
};

}  // namespace stator::apps::fw_allocation
