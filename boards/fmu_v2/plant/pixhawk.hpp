// What a Pixhawk's chip has around it: parts on its board, motors, motion capture, and the
// simulated vehicle, which all move with the chip's clock.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>

#include "chip/chip.hpp"
#include "parts/mpu6000.hpp"
#include "sensors.hpp"
#include "world/options.hpp"
#include "world/world.hpp"

namespace stator::plant {

class Pixhawk {
  public:
    // `truth`: gets the true flight; none: no file.
    Pixhawk(chip::Chip& chip, const world::Options& options, std::FILE* truth);

    bool is_over() const { return is_over_; }
    const world::World& world() const { return world_; }
    const chip::Mpu6000& imu() const { return imu_; }
    bool truth_is_whole() const { return truth_is_whole_; }

  private:
    void step();
    void apply_faults();
    chip::Mpu6000::Motion motion() const;
    void send_mocap();
    void pulse(unsigned output, uint64_t high_ns);
    void record_truth();

    static constexpr float kStopped = std::numeric_limits<float>::quiet_NaN();

    chip::Chip& chip_;
    world::World world_;
    board::Sensors sensors_;
    board::Samples samples_{};
    chip::Mpu6000 imu_;
    world::Controls controls_;
    uint8_t mocap_messages_ = 0;
    uint64_t duration_us_;
    std::FILE* truth_;
    bool truth_is_whole_;
    bool is_over_ = false;
};

}  // namespace stator::plant
