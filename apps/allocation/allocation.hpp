// Control allocation: rate_control's torque and thrust in, one command for each motor out.
#pragma once

#include "allocation_ports.hpp"
#include "rotors.hpp"

namespace stator::apps::allocation {

// Runs with every torque setpoint, and with every status so that a disarmed vehicle stops whatever
// else is silent. The motors stop (not a number) unless the status says armed, and
// if the rotors of the parameters cannot steer. Disarmed, a test may turn one of them: it counts
// for kTest_us, so it ends where the commander falls silent. A thrust that is absent, or a
// component that is not a number, reads as zero.
class Allocation {
  public:
    void step(AllocationPorts& ports);

  private:
    void test_motor(const AllocationPorts& ports, std::span<float> control) const;

    Rotors rotors_;
    bool is_armed_ = false;
    uint64_t torque_us_ = 0;
    unsigned count_ = 0;  // 0: the rotors cannot steer
};

}  // namespace stator::apps::allocation
