// The IMU of a simulated board: publishes what the board measured.
#pragma once

#include "imu_ports.hpp"
#include "imu_sim_sample.hpp"

namespace stator::drivers::imu::sim {

class ImuSim {
  public:
    // The registers of the part. The board writes a sample, then raises data_ready; the next
    // sample overwrites one that has not been read.
    using Device = ImuSimSample;

    explicit ImuSim(Device& device) : device_(device) {}
    void step(ImuPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::imu::sim
